"""Bending damping and natural curvature: against native cables, closed forms, and at the stability limit."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import SensorNode

from exudyn_inext import CableShape, DivergenceError, InextensibleCable, SolveEquilibrium
from reference_models.model import quiet_settings
from tests.cables import arc
from tests.exudyn_binding.items import SECTION, native_cable, solve_native, trajectory

LINE = {"positionEnd": [1, 0, 0]}
DAMPED = SECTION | {"bendingDamping": 1e-3}
CURVED = DAMPED | {"referenceCurvature": 1.5}


@pytest.fixture
def tip_of(new_mbs, add_cable, add_sensor, solve):
    """(dim, section, elements) -> tip (m, 3) of a cantilever that is let go straight, ours or native."""

    def ours(dim, section, elements):
        mbs = new_mbs()
        template = InextensibleCable(**section)
        clamp = {"dimension": dim, "groundConstraintsStart": [True] * (2 * dim)}
        nodes = add_cable(mbs, beamTemplate=template, numberOfElements=elements, **LINE, **clamp)["nodes"]
        tip = add_sensor(mbs, nodes[-1])
        mbs.Assemble()
        solve(mbs, 1.0)
        return trajectory(mbs, tip)[:, 1:]

    def native(dim, section, elements):
        mbs = new_mbs()
        clamp = {"groundConstraintsStart": [True] * (2 * dim)}
        nodes = native_cable(mbs, dim, elements, section=section, **LINE, **clamp)["nodes"]
        tip = add_sensor(mbs, nodes[-1])
        mbs.Assemble()
        solve_native(mbs, 1.0)
        return trajectory(mbs, tip)[:, 1:]

    return {"ours": ours, "native": native}


@pytest.mark.parametrize(
    ("dim", "section"), [(2, DAMPED), (3, DAMPED), (2, CURVED)], ids=["plane", "space", "curved"]
)
def test_damped_vibration_is_that_of_a_native_cable(tip_of, dim, section):
    found = tip_of["ours"](dim, section, 8)
    expected = tip_of["native"](dim, section, 32)
    swing = np.ptp(expected[:, 1])
    np.testing.assert_allclose(found, expected, atol=5e-3 * swing)


@pytest.mark.parametrize("ratio", [0.02, 0.2])  # D / EI [s]
@pytest.mark.parametrize("sideways", [0.0, 0.3])
def test_strongly_damped_bending_in_space_is_that_of_a_native_cable(
    new_mbs, add_cable, solve, ratio, sideways
):
    """A weightless cantilever that is pushed in a plane, or to turn; it passes through straight shapes."""
    section = {"massPerLength": 0.1, "bendingStiffness": 1.0, "bendingDamping": ratio}
    arguments = {"gravity": [0, 0, 0], "groundConstraintsStart": [True] * 6, **LINE}

    def moved(mbs, nodes, run):
        for k, node in enumerate(nodes):
            x = k / 16
            push = [0, x**2, sideways * (x**3 - 0.8 * x**2), 0, 2 * x, sideways * (3 * x**2 - 1.6 * x)]
            mbs.SetNodeParameter(node, "initialVelocities", push)
        output = exudyn.OutputVariableType.Position
        tip = mbs.AddSensor(SensorNode(nodeNumber=nodes[-1], outputVariableType=output, storeInternal=True))
        mbs.Assemble()
        run(mbs)
        return trajectory(mbs, tip)[:, 1:]

    mbs, twin = new_mbs(), new_mbs()
    template = InextensibleCable(**section)
    cable = add_cable(mbs, beamTemplate=template, numberOfElements=16, dimension=3, **arguments)
    native = native_cable(
        twin, 3, 16, section=section, **{k: v for k, v in arguments.items() if k != "numberOfElements"}
    )
    found = moved(mbs, cable["nodes"], lambda m: solve(m, settings=quiet_settings(0.5, 1, 0.01)))
    expected = moved(twin, native["nodes"], lambda m: solve_native(m, 0.5, 2e-4))
    np.testing.assert_allclose(found, expected, atol=0.01 * np.ptp(expected[:, 1]))
    if sideways:
        np.testing.assert_allclose(found[:, 2], expected[:, 2], atol=0.01 * np.ptp(expected[:, 2]))


def test_damping_of_that_size_is_seen_in_the_vibration(tip_of):
    undamped, damped = (tip_of["native"](2, section, 24) for section in (SECTION, DAMPED))
    assert np.abs(undamped - damped).max() > 0.1 * np.ptp(damped[:, 1])


@pytest.mark.parametrize("natural", [1.5, -0.8])
def test_clamped_cable_rests_as_the_arc_of_its_natural_curvature(mbs, add_cable, coordinates, natural):
    template = InextensibleCable(**SECTION, referenceCurvature=natural)
    clamp = {"gravity": [0, 0, 0], "groundConstraintsStart": [True] * 4}
    nodes = add_cable(mbs, beamTemplate=template, numberOfElements=12, **LINE, **clamp)["nodes"]
    mbs.Assemble()
    SolveEquilibrium(mbs)
    exact = arc(1.0, 12, 1.0 / natural)
    np.testing.assert_allclose(coordinates(mbs, nodes)[:, 0], exact[:, 0], atol=1e-5)
    np.testing.assert_allclose(coordinates(mbs, nodes)[:, 1], exact[:, 1], atol=1e-4)


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
def test_reported_stability_limit_of_a_damped_cantilever_separates_growth_from_decay(
    new_mbs, add_cable, add_sensor, solve, integrator, without_smaller_steps
):
    """The fastest vibration is damped as much as 0.43 of the critical; RK4 takes the damping explicitly."""

    def run(factor, limit=None):
        mbs = new_mbs()
        nudged = np.zeros((5, 2))
        nudged[-1, 1] = 1e-6
        q = np.linspace(0.0, 1.0, 5)
        shape = CableShape(
            np.stack([q, 0 * q], 1), np.tile([1.0, 0.0], (5, 1)), velocities=nudged, elementLengths=0.25
        )
        template = InextensibleCable(**(SECTION | {"bendingDamping": 5e-5}))
        clamp = {"gravity": [0, 0, 0], "groundConstraintsStart": [True] * 4}
        nodes = add_cable(mbs, shape=shape, beamTemplate=template, **clamp)["nodes"]
        speed = add_sensor(mbs, nodes[-1], "Velocity")
        mbs.Assemble()
        if limit is None:
            plain = {"stabilizationRate": 1.0, "massScaling": 0.0}
            return solve(mbs, 1e-4, integrator=integrator, **plain)["bounds"]
        step = factor * limit
        settings = {"integrator": integrator, "stabilizationRate": 1.0, "allowUnstableStep": True}
        whole = quiet_settings(500 * step, 1, period=500 * step)
        assert solve(mbs, settings=whole, stepSize=step, **settings)["stepSize"] == pytest.approx(step)
        return np.abs(trajectory(mbs, speed)[-1, 1:]).max()

    bounds = run(1.0)
    assert bounds.largest_frequency * 5e-5 / SECTION["bendingStiffness"] > 0.4
    assert run(0.95, bounds.bending) < 2e-6
    with pytest.warns(UserWarning, match="stability limit"):
        try:
            grown = run(1.05, bounds.bending)
        except DivergenceError:
            grown = np.inf
    assert grown > 1e-3
