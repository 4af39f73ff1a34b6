"""The motion is that of the independent limit, of native cables, and independent of the frame."""

import dataclasses

import exudyn
import numpy as np
import pytest
from exudyn.beams import PointsAndSlopes2ANCFCable2D
from exudyn.itemInterface import ObjectANCFCable2D
from scipy.spatial.transform import Rotation

from exudyn_inext import CableShape, ExplicitSettings, InextensibleCable
from reference_models.conventional.model import build as build_native
from reference_models.conventional.settings import Implicit, simulation_settings
from reference_models.conventional.solve import solve as solve_native
from reference_models.data import reference_trajectory
from reference_models.inextensible import Inextensible, inextensible_case
from reference_models.model import silence
from reference_models.scenes import Clamp, load_scene

PENDULUM = load_scene("planar_pendulum")
SECTION = PENDULUM.cable.section
SOFT = InextensibleCable(SECTION.mass_per_length, 1e-3)


def errors(trajectory):
    """(largest, root mean square) distance of the tip to the reference [m]."""
    reference = reference_trajectory(PENDULUM)
    np.testing.assert_allclose(trajectory.times, reference.times, atol=1e-9)
    distance = np.linalg.norm(trajectory.positions - reference.positions, axis=1)
    return distance.max(), np.sqrt(np.mean(distance**2))


def run(model):
    case = inextensible_case(PENDULUM, model)
    return case, errors(case.prepare()())


INTEGRATORS = pytest.mark.parametrize("integrator", ["Zhai", "RATTLE"])


@INTEGRATORS
def test_pendulum_of_5_elements_at_the_rule_step_is_within_5_mm_of_the_limit(integrator):
    settings = ExplicitSettings(integrator, stepConstant=0.7, stabilizationRate=100.0, massScaling=0.0)
    case, (largest, rms) = run(Inextensible(5, settings))
    assert case.details["stepDecidedBy"] == "rule (37)"
    assert case.step_size == pytest.approx(2.5e-3, rel=1e-9)
    assert largest <= 5e-3
    assert rms <= 1.5e-3


@INTEGRATORS
def test_pendulum_of_10_elements_is_within_8_tenths_of_a_mm_of_the_limit(integrator):
    _, (largest, _) = run(Inextensible(10, ExplicitSettings(integrator, stepSize=6e-4)))
    assert largest <= 8e-4


def test_pendulum_with_the_product_measure_is_within_5_mm_of_the_limit_too():
    _, (largest, rms) = run(Inextensible(5, measure="product"))
    assert largest <= 5e-3
    assert rms <= 1.5e-3


@INTEGRATORS
def test_a_clamped_cable_moves_as_the_native_one(integrator):
    scene = dataclasses.replace(PENDULUM, supports=(Clamp(at=0.0),), end_time=0.4)
    native = solve_native(build_native(scene, 24), Implicit(1e-3)).positions
    model = Inextensible(12, ExplicitSettings(integrator))
    ours = inextensible_case(scene, model).prepare()().positions
    assert np.linalg.norm(native[-1] - native[0]) > 0.3
    assert np.linalg.norm(ours - native, axis=1).max() < 5e-4


def slack_arc(elements):
    """Nodes of a half circle of radius 0.5 m that hangs from two points."""
    phi = np.linspace(np.pi, 2 * np.pi, elements + 1)
    positions = 0.5 * np.column_stack([np.cos(phi), np.sin(phi)])
    return positions, np.column_stack([-np.sin(phi), np.cos(phi)])


def native_slack_cable(mbs, elements):
    positions, slopes = slack_arc(elements)
    template = ObjectANCFCable2D(
        massPerLength=SOFT.massPerLength,
        bendingStiffness=SOFT.bendingStiffness,
        axialStiffness=SECTION.axial_stiffness,
    )
    pin = [1, 1, 0, 0]
    created = PointsAndSlopes2ANCFCable2D(
        mbs,
        np.column_stack([positions, slopes]),
        [0.5 * np.pi / elements] * elements,
        template,
        massProportionalLoad=[0, -9.81, 0],
        fixedConstraintsNode0=pin,
        fixedConstraintsNode1=pin,
        firstNodeIsLastNode=False,
    )
    return created[0]


def test_a_slack_cable_between_two_pins_moves_as_the_native_one(new_mbs, add_cable, add_sensor, solve):
    """At the default step; it springs open from a half circle that is not its natural shape."""
    native, ours = new_mbs(), new_mbs()
    nodes = native_slack_cable(native, 32)
    positions, slopes = slack_arc(16)
    pin = [True, True, False, False]
    cable = add_cable(
        ours,
        shape=CableShape(positions, slopes),
        beamTemplate=SOFT,
        groundConstraintsStart=pin,
        groundConstraintsEnd=pin,
    )
    quarters = add_sensor(native, nodes[8]), add_sensor(ours, cable["nodes"][4])
    native.Assemble()
    ours.Assemble()
    with silence():
        native.SolveDynamic(simulation_settings(Implicit(1e-3), 0.3))
    solve(ours, 0.3)
    expected, found = (
        np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:]
        for mbs, sensor in zip((native, ours), quarters, strict=True)
    )
    assert np.ptp(expected[:, 0]) > 0.06
    assert np.linalg.norm(found - expected, axis=1).max() < 1.5e-3


@pytest.mark.parametrize("integrator", ["Zhai", "RATTLE"])
@pytest.mark.parametrize("measure", ["secondDerivative", "product"])
def test_scaled_mass_takes_larger_steps_at_the_same_accuracy(integrator, measure):
    settings = ExplicitSettings(integrator, stepSize=2.5e-3, massScaling=0.3)
    case, (largest, _) = run(Inextensible(8, settings, measure=measure))
    assert case.details["ruleStep"] < 0.5 * case.step_size
    assert largest <= 1.2e-3


def test_scaled_mass_keeps_the_accuracy_on_any_mesh():
    settings = ExplicitSettings(stepSize=2e-3, massScaling=0.3)
    assert run(Inextensible(100, settings))[1][0] <= 1.2e-3


def tip_motion(mbs, add_cable, add_sensor, solve, **changes):
    cable = add_cable(mbs, **changes)
    sensor = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    solve(mbs, 0.5)
    return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:]


def test_a_spatial_cable_in_planar_motion_is_the_planar_cable(new_mbs, add_cable, add_sensor, solve):
    planar = tip_motion(
        new_mbs(), add_cable, add_sensor, solve, groundConstraintsStart=[True, True, False, False]
    )
    pin = [True] * 3 + [False] * 3
    spatial = tip_motion(new_mbs(), add_cable, add_sensor, solve, groundConstraintsStart=pin, dimension=3)
    assert np.linalg.norm(planar[-1] - planar[0]) > 0.5
    np.testing.assert_allclose(spatial, planar, atol=1e-9)


def test_a_cable_in_another_frame_moves_alike_in_that_frame(new_mbs, add_cable, add_sensor, solve):
    rotation = Rotation.from_rotvec([0.4, -0.9, 1.3]).as_matrix()
    origin = np.array([3.0, -2.0, 1.0])
    pin = {"groundConstraintsStart": [True] * 3 + [False] * 3}
    velocity = np.array([0.0, 1.0, 2.0])  # out of the plane: a truly spatial motion
    end, gravity = np.array([1.8, 0.0, 0.0]), np.array([0.0, -9.81, 0.0])
    shape = CableShape.Line([0, 0, 0], end, 5, velocityEnd=velocity)
    turned_shape = CableShape.Line(origin, origin + rotation @ end, 5, velocityEnd=rotation @ velocity)
    plain = tip_motion(new_mbs(), add_cable, add_sensor, solve, shape=shape, gravity=gravity, **pin)
    turned = tip_motion(
        new_mbs(),
        add_cable,
        add_sensor,
        solve,
        shape=turned_shape,
        gravity=rotation @ gravity,
        **pin,
    )
    assert abs(plain[-1, 2]) > 0.3
    np.testing.assert_allclose(turned, origin + plain @ rotation.T, atol=1e-9)


def test_a_free_cable_under_gravity_falls_as_a_body(mbs, add_cable, add_sensor, solve):
    cable = add_cable(mbs)
    outputs = ("Position", "Velocity", "Acceleration")
    sensors = [add_sensor(mbs, cable["nodes"][2], name) for name in outputs]
    mbs.Assemble()
    solve(mbs, 0.2)
    position, velocity, acceleration = (mbs.GetSensorStoredData(s)[-1, 1:] for s in sensors)
    np.testing.assert_allclose(position, [0.72, -0.5 * 9.81 * 0.2**2, 0], atol=1e-12)
    np.testing.assert_allclose(velocity, [0, -9.81 * 0.2, 0], atol=1e-12)
    np.testing.assert_allclose(acceleration, [0, -9.81, 0], atol=1e-10)


@pytest.mark.parametrize("end", [0, -1])
def test_a_clamp_holds_position_and_slope_of_either_end(mbs, add_cable, solve, coordinates, end):
    name = {0: "groundConstraintsStart", -1: "groundConstraintsEnd"}[end]
    cable = add_cable(mbs, **{name: [True] * 4})
    mbs.Assemble()
    solve(mbs, 0.3)
    q = coordinates(mbs, cable["nodes"])
    np.testing.assert_array_equal(q[end], [[1.8 if end else 0.0, 0.0], [1.0, 0.0]])
    assert abs(q[-1 - end, 0, 1]) > 0.1
    assert mbs.systemData.GetTime(exudyn.ConfigurationType.Current) == pytest.approx(0.3)
