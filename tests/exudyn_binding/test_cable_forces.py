"""CableForces and its sensor against closed forms of hanging, whirling and bent cables, and native ones."""

import math

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import CoordinateConstraint, MarkerNodeCoordinate, NodePointGround, SensorBody
from scipy.optimize import brentq

from exudyn_inext import (
    CableForces,
    CableShape,
    CreateCableForceSensor,
    InextensibleCable,
    InputError,
    SceneError,
    SolveEquilibrium,
)
from tests.exudyn_binding.items import SECTION, load_node, native_cable, solve_native, trajectory

PIN, CLAMP = [True, True, False, False], [True, True, True, True]
RHO, LENGTH, G = 0.0348, 1.8, 9.81
WEIGHT = RHO * G * LENGTH


def mean_times_length(forces, length=LENGTH):
    """Integral of the tension from the means of equal elements."""
    return forces["multiplierTension"].mean() * length


def integral(forces):
    """Of the tension over the points, by Simpson's rule."""
    x, n = forces["arcLength"], forces["tension"]
    return (n[0] + 4 * n[1:-1:2].sum() + 2 * n[2:-1:2].sum() + n[-1]) * (x[1] - x[0]) / 3


def add_hanging(mbs, add_cable, **changes):
    """A cable that hangs straight down from a pin."""
    return add_cable(mbs, **({"positionEnd": [0, -LENGTH, 0], "groundConstraintsStart": PIN} | changes))


@pytest.mark.parametrize("measure", ["secondDerivative", "product"])
def test_tension_of_a_hanging_cable_is_the_weight_below(mbs, add_cable, measure):
    template = InextensibleCable(RHO, 0.0866, curvatureMeasure=measure)
    cable = add_hanging(mbs, add_cable, beamTemplate=template)
    mbs.Assemble()
    forces = CableForces(mbs, cable)
    assert len(forces["arcLength"]) == 51
    np.testing.assert_allclose(forces["position"][:, 1], -forces["arcLength"], atol=1e-14)
    np.testing.assert_allclose(forces["tension"], RHO * G * (LENGTH - forces["arcLength"]), atol=1e-12)
    np.testing.assert_allclose(forces["shearForce"], 0.0, atol=1e-12)
    np.testing.assert_allclose(forces["bendingMoment"], 0.0, atol=1e-12)
    middles = LENGTH * (np.arange(5) + 0.5) / 5
    np.testing.assert_allclose(forces["multiplierTension"].mean(), WEIGHT / 2, rtol=1e-10)
    np.testing.assert_allclose(
        forces["multiplierTension"][1:-1], RHO * G * (LENGTH - middles[1:-1]), rtol=1e-2
    )


def test_tension_jumps_across_a_point_load_by_its_size(mbs, add_cable):
    cable = add_hanging(mbs, add_cable)
    load_node(mbs, cable["nodes"][2], [0.0, -3.0, 0.0])
    mbs.Assemble()
    x = np.array([0.1, 0.72, 0.72 + 1e-9, 1.7])
    expected = RHO * G * (LENGTH - x) + np.array([3.0, 3.0, 0.0, 0.0])
    np.testing.assert_allclose(CableForces(mbs, cable, x)["tension"], expected, atol=1e-7)


def test_tension_changes_its_sign_at_a_support_within(mbs, add_cable):
    """Above the support the cable stands on it, below it hangs."""
    cable = add_hanging(mbs, add_cable, groundConstraintsStart=None)
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for axis in range(2):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=cable["nodes"][2], coordinate=axis))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    mbs.Assemble()
    x = np.array([0.0, 0.3, 0.72, 0.72 + 1e-9, 1.2, LENGTH])
    expected = RHO * G * np.where(x <= 0.72, -x, LENGTH - x)
    np.testing.assert_allclose(CableForces(mbs, cable, x)["tension"], expected, atol=1e-7)


@pytest.mark.parametrize("dim", [2, 3])
def test_tension_of_a_whirling_cable_is_a_parabola(mbs, add_cable, dim):
    rate = 4.0
    shape = CableShape.Line([0, 0, 0], [LENGTH, 0, 0], 6, velocityEnd=[0, rate * LENGTH, 0])
    held = {"gravity": [0, 0, 0], "groundConstraintsStart": [True] * dim + [False] * dim}
    cable = add_cable(mbs, shape=shape, dimension=dim, **held)
    mbs.Assemble()
    forces = CableForces(mbs, cable, 41)
    expected = 0.5 * RHO * rate**2 * (LENGTH**2 - forces["arcLength"] ** 2)
    np.testing.assert_allclose(forces["tension"], expected, atol=1e-11)
    assert mean_times_length(forces) == pytest.approx(RHO * rate**2 * LENGTH**3 / 3, rel=1e-9)


def test_tension_of_a_catenary_follows_the_cosh_law(mbs, add_cable):
    span = 1.2
    c = brentq(lambda c: 2.0 * c * np.sinh(0.5 * span / c) - LENGTH, 0.1, 10.0)
    s = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, 41) / c
    positions = np.stack([c * np.arcsinh(s), c * np.hypot(1.0, s)], axis=1)
    slopes = np.stack([np.ones(41), s], axis=1) / np.hypot(1.0, s)[:, None]
    template = InextensibleCable(RHO, 1e-6)
    shape = CableShape(positions, slopes, LENGTH / 40)
    cable = add_cable(
        mbs, shape=shape, beamTemplate=template, groundConstraintsStart=PIN, groundConstraintsEnd=PIN
    )
    mbs.Assemble()
    SolveEquilibrium(mbs)
    forces = CableForces(mbs, cable)
    x = forces["arcLength"] - 0.5 * LENGTH
    np.testing.assert_allclose(forces["tension"], RHO * G * np.hypot(c, x), rtol=1e-3)
    middle = np.abs(x) < 0.2
    moment = 1e-6 * c / (c**2 + x**2)
    np.testing.assert_allclose(forces["bendingMoment"][middle], moment[middle], rtol=0.1)


def bent_cantilever(mbs, add_cable, number, load, **template):
    section = InextensibleCable(RHO, 1.0, **template)
    line = {"positionEnd": [1, 0, 0], "numberOfElements": number, "gravity": [0, 0, 0]}
    cable = add_cable(mbs, beamTemplate=section, groundConstraintsStart=CLAMP, **line)
    load_node(mbs, cable["nodes"][-1], [*load, 0.0])
    mbs.Assemble()
    SolveEquilibrium(mbs)
    return CableForces(mbs, cable)


@pytest.mark.parametrize(
    "template", [{}, {"curvatureMeasure": "product"}, {"referenceCurvature": 0.8}], ids=str
)
def test_forces_of_a_bent_cantilever_balance_its_load(new_mbs, add_cable, template):
    """N t + Q is the load everywhere, and M its lever arm: the sign is that of a turn to the left."""
    load, errors = np.array([-0.5, 2.0]), []
    for number in (8, 16, 32):
        forces = bent_cantilever(new_mbs(), add_cable, number, load, **template)
        arm = forces["position"][-1] - forces["position"]
        moment = arm[:, 0] * load[1] - arm[:, 1] * load[0]
        assert moment.max() > 1.0
        errors.append(np.abs(forces["bendingMoment"] - moment).max())
        size = forces["tension"] ** 2 + (forces["shearForce"] ** 2).sum(axis=1)
        np.testing.assert_allclose(size, load @ load, rtol=1e-7)
    assert forces["tension"][0] == pytest.approx(load[0], abs=1e-6)
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > 1.6
    assert errors[-1] < 2e-3
    assert mean_times_length(forces, 1.0) == pytest.approx(integral(forces), abs=2e-3)
    ends = forces["tension"][::10]
    np.testing.assert_allclose(
        forces["multiplierTension"][3:-3], (0.5 * (ends[:-1] + ends[1:]))[3:-3], atol=5e-3
    )


def spinning_ring(number, rate, radius):
    ring = CableShape.Circle([0, 0], radius, number)
    turned = [np.stack([-x[:, 1], x[:, 0]], axis=1) for x in map(np.array, (ring.positions, ring.slopes))]
    return CableShape(
        positions=ring.positions,
        slopes=ring.slopes,
        elementLengths=ring.elementLengths,
        velocities=rate * turned[0],
        slopeVelocities=rate * turned[1],
        closed=True,
    )


@pytest.mark.parametrize("rate", [0.0, 3.0])
def test_rotating_ring_is_under_its_hoop_tension(new_mbs, add_cable, rate):
    radius, stiffness, errors = 0.5, 0.02, []
    for number in (8, 16, 32):
        mbs = new_mbs()
        template = InextensibleCable(RHO, stiffness)
        shape = spinning_ring(number, rate, radius)
        cable = add_cable(mbs, shape=shape, beamTemplate=template, gravity=[0, 0, 0])
        mbs.Assemble()
        forces = CableForces(mbs, cable)
        exact = RHO * (rate * radius) ** 2
        errors.append(np.abs(forces["multiplierTension"] - exact).max())
        np.testing.assert_allclose(forces["tension"], exact, atol=1e-3 * exact + 1e-12)
        np.testing.assert_allclose(
            forces["bendingMoment"], stiffness / radius, rtol=0.5 * (2 * np.pi / number) ** 2
        )
    assert errors[-1] < 1e-5
    assert np.log2(errors[0] / errors[-1]) > 6.0


def test_means_of_a_ring_that_is_pulled_apart_are_those_of_its_tension(mbs, add_cable):
    """Also beside its first node, where its two ends are joined and the tension jumps."""
    shape = CableShape.Circle([0, 0], 0.5, 24)
    cable = add_cable(mbs, shape=shape, gravity=[0, 0, 0])
    for node, sign in ((cable["nodes"][0], 1.0), (cable["nodes"][12], -1.0)):
        load_node(mbs, node, [0.6 * sign, 0.8 * sign, 0.0])
    mbs.Assemble()
    forces = CableForces(mbs, cable)
    means = forces["multiplierTension"]
    assert np.ptp(means) > 0.6
    np.testing.assert_allclose(means, forces["tension"][5::10], atol=6e-3)
    np.testing.assert_allclose(means[:12], means[12:], atol=1e-9)  # half a turn changes nothing


# ------------------------------------------------------------------- in motion


def test_free_end_of_a_damped_cable_in_motion_is_free_of_forces(mbs, add_cable, solve):
    template = InextensibleCable(RHO, 0.0866, bendingDamping=5e-3)
    cable = add_cable(mbs, beamTemplate=template, numberOfElements=8, groundConstraintsStart=CLAMP)
    mbs.Assemble()
    solve(mbs, 0.1)
    forces = CableForces(mbs, cable)
    assert np.abs(forces["shearForce"][0]).max() > 0.1
    assert np.abs(forces["shearForce"][-1]).max() < 1e-12
    assert abs(forces["tension"][-1]) < 1e-12


def test_tension_in_motion_is_that_of_a_native_cable(new_mbs, add_pendulum, solve):
    end, elements, ours, native = 0.4, (1, 46, 73), new_mbs(), new_mbs()
    cable = add_pendulum(ours, numberOfElements=16)
    section = SECTION | {"axialDamping": 20.0}
    theirs = native_cable(native, 2, 96, section=section, groundConstraintsStart=PIN)
    sensors = [
        native.AddSensor(
            SensorBody(
                bodyNumber=theirs["elements"][element],
                localPosition=[0.5 * LENGTH / 96, 0, 0],
                storeInternal=True,
                outputVariableType=exudyn.OutputVariableType.ForceLocal,
            )
        )
        for element in elements
    ]
    points = (np.array(elements) + 0.5) * LENGTH / 96
    mine = [CreateCableForceSensor(ours, cable, x) for x in points]
    for mbs in (ours, native):
        mbs.Assemble()
    solve(ours, end)
    solve_native(native, end)
    for sensor, other in zip(mine, sensors, strict=True):
        found, expected = trajectory(ours, sensor), trajectory(native, other)
        assert expected[-1, 1] > 0.2 * WEIGHT
        np.testing.assert_allclose(found[:, 1], expected[:, 1], atol=2e-3 * WEIGHT)


def test_sensor_stores_what_the_function_returns(mbs, add_pendulum, solve):
    cable = add_pendulum(mbs)
    load = load_node(mbs, cable["nodes"][-1], [0.0, 0.0, 0.0])
    sensor = CreateCableForceSensor(mbs, cable, 0.5)
    mbs.Assemble()
    for end, force in ((0.1, 0.0), (0.25, -1.0)):  # a second run starts anew, under another load
        mbs.SetLoadParameter(load, "loadVector", [0.0, force, 0.0])
        solve(mbs, end)
        stored = trajectory(mbs, sensor)
        forces = CableForces(mbs, cable["elements"][0], [0.5])
        np.testing.assert_allclose(
            stored[-1], [end, forces["tension"][0], forces["bendingMoment"][0]], rtol=1e-9
        )
        assert np.ptp(stored[:, 1]) > 1e-3


def test_sensor_does_not_change_the_motion(twin, solve, coordinates):
    ends = []
    for observed in (False, True):
        scene = twin()
        if observed:
            CreateCableForceSensor(scene.mbs, scene.cable, 1.0)
            scene.mbs.Assemble()
        solve(scene.mbs, 0.2)
        ends.append(coordinates(scene.mbs, scene.cable["nodes"]))
    np.testing.assert_array_equal(ends[1], ends[0])


# ------------------------------------------------------------------- refusals

OFF = [-1e-3, 1.81, math.nan, "end", None]


@pytest.mark.parametrize("point", OFF)
def test_points_off_the_cable_are_refused(mbs, add_pendulum, contents, point):
    cable = add_pendulum(mbs)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(InputError, match=r"arcLength = .* is not on the cable: it runs from 0 to 1\.8"):
        CableForces(mbs, cable, [0.1, point])
    with pytest.raises(InputError, match="is not on the cable"):
        CreateCableForceSensor(mbs, cable, point)
    assert contents(mbs) == before


@pytest.mark.parametrize("points", [1, True, 2.5])
def test_a_number_of_points_is_at_least_two(mbs, add_pendulum, points):
    cable = add_pendulum(mbs)
    mbs.Assemble()
    with pytest.raises(InputError, match=r"must be points .* or how many, at least 2"):
        CableForces(mbs, cable, points)


@pytest.mark.parametrize(
    ("cable", "message"),
    [
        (99, "object 99 is no inextensible cable"),
        (1, "object 1 is no inextensible cable"),
        ("cable", "cable = 'cable': must be what CreateInextensibleCable returned"),
        ({"elements": []}, "must be what CreateInextensibleCable returned"),
        (None, "must be what CreateInextensibleCable returned"),
    ],
)
def test_what_is_no_cable_is_refused(mbs, add_pendulum, contents, cable, message):
    add_pendulum(mbs)  # its constraints are objects 1 and 2
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(InputError, match=message):
        CableForces(mbs, cable)
    with pytest.raises(InputError, match=message):
        CreateCableForceSensor(mbs, cable, 0.1)
    assert contents(mbs) == before


def test_a_system_that_is_not_assembled_has_no_forces(mbs, add_pendulum):
    cable = add_pendulum(mbs)
    with pytest.raises(SceneError, match="not assembled"):
        CableForces(mbs, cable)
