"""Cables that stretch move as native cables do, at steps that do not depend on their stiffness."""

from itertools import product

import numpy as np
import pytest
from exudyn import OutputVariableType
from exudyn.beams import PointsAndSlopes2ANCFCable2D
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MassPoint,
    NodePoint,
    NodePointGround,
    ObjectANCFCable,
    ObjectANCFCable2D,
    SphericalJoint,
)
from scipy.optimize import brentq

from exudyn_inext import (
    AddPointMass,
    CableDrag,
    CableForces,
    CableShape,
    CreatePrescribedMotion,
    DivergenceError,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    InputError,
    RedundantConstraintError,
    SceneError,
    SetCableDrag,
    SolveEnsemble,
    SolveEquilibrium,
)
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import PINNED, SECTION, load_node, native_cable, solve_native

ROUND = 86643.0  # EA of the pendulum of the paper [N]
SOFT = 20.0  # EA of a bungee [N]
HEAVY = 0.4  # mass at its end [kg]
SCALED = {"stepSize": 2e-3, "massScaling": 0.3}


def stretching(stiffness=ROUND, **axial):
    return {"beamTemplate": InextensibleCable(**SECTION, axialStiffness=stiffness, **axial)}


@pytest.fixture
def tip_of(new_mbs, add_pendulum, add_sensor, solve):
    """(end_time, mass at the tip, arguments of the cable and the run) -> positions of the tip, report."""

    def move(end_time, mass=0.0, settings=SCALED, **cable):
        mbs = new_mbs()
        made = add_pendulum(mbs, **({"numberOfElements": 10} | cable))
        if mass:
            AddPointMass(mbs, made, 1.8, mass)
        tip = add_sensor(mbs, made["nodes"][-1])
        mbs.Assemble()
        report = solve(mbs, end_time, steps=round(end_time / 0.01), **settings)
        return np.asarray(mbs.GetSensorStoredData(tip))[:, 1:], report

    return move


@pytest.fixture
def native_tip(new_mbs, add_sensor):
    """The same of native cables."""

    def move(end_time, elements, stiffness, mass=0.0, dim=2, step=1e-3, **axial):
        mbs, section = new_mbs(), SECTION | {"useReducedOrderIntegration": 2} | axial
        nodes = native_cable(mbs, dim, elements, section, stiffness)["nodes"]
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for axis in range(dim):
            held = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=axis))
            mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, held]))
        if mass:
            point = mbs.AddNode(NodePoint(referenceCoordinates=[1.8, 0, 0]))
            mbs.AddObject(MassPoint(nodeNumber=point, mass=mass))
            ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (nodes[-1], point)]
            mbs.AddObject(SphericalJoint(markerNumbers=ends))
            load_node(mbs, point, [0, -9.81 * mass, 0])
        tip = add_sensor(mbs, nodes[-1])
        mbs.Assemble()
        solve_native(mbs, end_time, step)
        return np.asarray(mbs.GetSensorStoredData(tip))[:, 1:]

    return move


def distance(one, other):
    assert len(one) == len(other)
    return np.abs(one - other).max()


def test_a_stiff_pendulum_follows_the_native_one_more_closely_than_an_inextensible_one(tip_of, native_tip):
    native = native_tip(1.0, 32, ROUND)
    stretched = distance(tip_of(1.0, **stretching())[0], native)
    assert stretched < 3e-4
    assert stretched < distance(tip_of(1.0)[0], native)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_bungee_with_a_mass_follows_the_native_one(tip_of, native_tip, dim):
    native = native_tip(2.0, 20, SOFT, HEAVY, dim)
    pin = {"groundConstraintsStart": [True] * dim + [False] * dim, "dimension": dim}
    tip, report = tip_of(2.0, HEAVY, **stretching(SOFT), **pin)
    assert np.linalg.norm(native, axis=1).max() > 1.43 * 1.8
    assert distance(tip, native) < 1e-4
    assert max(report["drift"]["energyGain"], report["drift"]["energyLoss"]) < 1e-4


def test_axial_damping_is_that_of_native_cables(tip_of, native_tip):
    natives = [native_tip(1.0, 20, 2e3, 0.1, axialDamping=damping) for damping in (20.0, 0.0)]
    tip, report = tip_of(1.0, 0.1, **stretching(2e3, axialDamping=20.0))
    assert distance(tip, natives[0]) < 1e-4 < 0.1 * distance(*natives)
    assert max(report["drift"]["energyGain"], report["drift"]["energyLoss"]) < 1e-3


def test_the_step_limit_does_not_depend_on_the_stiffness(tip_of):
    limits = [
        tip_of(0.1, **stretching(stiffness))[1]["bounds"].stability_limit for stiffness in (20.0, 1e4, 1e7)
    ]
    assert limits == pytest.approx([tip_of(0.1)[1]["bounds"].stability_limit] * 3, rel=1e-6)


def test_states_tend_to_those_of_the_inextensible_cable(tip_of):
    inextensible = tip_of(1.0)[0]
    far = [distance(tip_of(1.0, **stretching(stiffness))[0], inextensible) for stiffness in (1e6, 1e7, 1e8)]
    assert far[0] < 2e-5
    np.testing.assert_allclose(far[:2], 10 * np.array(far[1:]), rtol=0.02)


def test_energy_has_no_trend_over_a_million_steps(mbs, add_pendulum, solve):
    add_pendulum(mbs, numberOfElements=4, **stretching(1e3))
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(2000.0, 100, 20.0), **SCALED)
    drift = report["drift"]
    assert report["steps"] == 1_000_000
    assert max(drift["energyGain"], drift["energyLoss"]) < 1e-3


def test_energy_has_no_trend_with_axial_waves_that_the_step_does_not_resolve(tip_of):
    drift = tip_of(40.0, **stretching(1e6))[1]["drift"]
    assert max(drift["energyGain"], drift["energyLoss"]) < 1e-4


def test_the_order_is_two(tip_of):
    def tip(step):
        settings = {"stepSize": step, "massScaling": 0.3}
        cable = stretching(50.0, axialDamping=2.0)
        return tip_of(0.6, 0.05, settings, numberOfElements=4, **cable)[0]

    finest = tip(3.125e-5)
    errors = [distance(tip(step), finest) for step in (1e-3, 5e-4, 2.5e-4)]
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 4.0, rtol=0.1)


def test_a_cable_may_be_pinned_straight_at_its_own_length(tip_of):
    pinned = {"groundConstraintsEnd": PINNED}
    with pytest.raises(RedundantConstraintError, match="give it its axialStiffness"):
        tip_of(0.1, **pinned)
    _, report = tip_of(1.0, **pinned, **stretching(1e4))
    assert max(report["drift"]["energyGain"], report["drift"]["energyLoss"]) < 1e-3


def test_a_clamp_may_leave_the_stretch_free(tip_of):
    clamps = ([True, True, False, True], [True] * 4, PINNED)
    tips = [tip_of(0.5, **stretching(), groundConstraintsStart=clamp)[0] for clamp in clamps]
    assert distance(tips[0], tips[1]) < 1e-5 < 1e-2 < distance(tips[0], tips[2])


@pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")
def test_a_cable_may_begin_stretched(new_mbs, add_cable, add_sensor, solve):
    stretched, elements = 1.1, 20
    places = np.linspace([0.0, 0.0], [1.8 * stretched, 0.0], elements + 1)
    slopes, lengths = np.tile([stretched, 0.0], (elements + 1, 1)), 1.8 / elements
    with pytest.raises(InputError, match="lengthReference='straight' this cable"):
        add_cable(new_mbs(), shape=CableShape(places, slopes, lengths), **stretching(1e3))
    shape = CableShape(places, slopes, lengths, lengthReference="straight")
    mbs, twin = new_mbs(), new_mbs()
    made = add_cable(mbs, shape=shape, **stretching(1e3), groundConstraintsStart=PINNED)
    native = native_cable(twin, 2, elements, SECTION | {"useReducedOrderIntegration": 2}, 1e3)["nodes"]
    for k, node in enumerate(native):
        apart = (stretched - 1.0) * np.array([1.8 * k / elements, 0.0, 1.0, 0.0])
        twin.SetNodeParameter(node, "initialCoordinates", list(apart))
    ground = twin.AddMarker(MarkerNodeCoordinate(nodeNumber=twin.AddNode(NodePointGround()), coordinate=0))
    for axis in range(2):
        held = twin.AddMarker(MarkerNodeCoordinate(nodeNumber=native[0], coordinate=axis))
        twin.AddObject(CoordinateConstraint(markerNumbers=[ground, held]))
    tips = [add_sensor(mbs, made["nodes"][-1]), add_sensor(twin, native[-1])]
    for system in (mbs, twin):
        system.Assemble()
    solve(mbs, 0.02, steps=100, stepSize=2e-5)
    solve_native(twin, 0.02, 2e-5)
    found, wanted = (one.GetSensorStoredData(tip) for one, tip in zip((mbs, twin), tips, strict=True))
    assert distance(found[-1], wanted[-1]) < 1e-3


def test_a_closed_ring_stretches(new_mbs, add_cable, add_sensor, solve):
    motions = []
    for stiffness in (None, 1e5, 1e6):
        mbs = new_mbs()
        ring = {"shape": CableShape.Circle([0, 0], 0.5, 12), "groundConstraintsStart": PINNED}
        cable = add_cable(mbs, **ring, **stretching(stiffness))
        low = add_sensor(mbs, cable["nodes"][6])
        mbs.Assemble()
        solve(mbs, 0.5, steps=25, **SCALED)
        motions.append(np.asarray(mbs.GetSensorStoredData(low)))
    far = [distance(motion, motions[0]) for motion in motions[1:]]
    assert far[0] == pytest.approx(10 * far[1], rel=0.1)
    assert far[0] < 1e-4


def test_a_pretensioned_belt_around_four_pins_moves_as_a_native_one(new_mbs, add_cable, add_sensor, solve):
    """A closed ring that is 5 % too short for its pins; damped, so that it is taut at the end."""
    taut = {"referenceAxialStrain": -0.05, "axialDamping": 2.0, "bendingDamping": 2e-3}

    def points_and_slopes(elements):
        angle = np.linspace(0.0, 2.0 * np.pi, elements + 1)
        outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return 0.5 * outward, np.stack([-outward[:, 1], outward[:, 0]], axis=1)

    def hold(mbs, nodes):
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for node, axis in product(nodes[:: len(nodes) // 4][:4], (0, 1)):
            held = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
            mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, held]))
        tip = add_sensor(mbs, nodes[len(nodes) // 8])
        mbs.Assemble()
        return tip

    mbs, native = new_mbs(), new_mbs()
    own = add_cable(mbs, shape=CableShape.Circle([0, 0], 0.5, 24), **stretching(200.0, **taut))
    section = SECTION | taut | {"axialStiffness": 200.0, "useReducedOrderIntegration": 2}
    nodes, *_ = PointsAndSlopes2ANCFCable2D(
        native,
        ancfPointsSlopes=list(np.hstack(points_and_slopes(48))),
        elementLengths=[np.pi / 48] * 48,
        cableTemplate=ObjectANCFCable2D(**section),
        massProportionalLoad=[0, -9.81, 0],
        firstNodeIsLastNode=True,
    )
    sensors = hold(mbs, own["nodes"]), hold(native, nodes[:48])
    solve(mbs, 0.5, steps=50)
    solve_native(native, 0.5)
    found, expected = (
        np.asarray(m.GetSensorStoredData(n))[:, 1:] for m, n in zip((mbs, native), sensors, strict=True)
    )
    assert distance(found, expected) < 0.02 * np.ptp(expected, axis=0).max()


@pytest.mark.parametrize("integrator", ["Zhai", "RK4"])
def test_schemes_with_explicit_axial_forces_are_refused(tip_of, integrator):
    with pytest.raises(
        SceneError, match=f"'{integrator}' with axialStiffness of cable .*use integrator='RATTLE'"
    ):
        tip_of(0.1, settings={"integrator": integrator}, **stretching())


@pytest.mark.parametrize("template", [ObjectANCFCable2D, ObjectANCFCable])
def test_native_templates_bring_their_axial_stiffness_when_asked(tip_of, template):
    native = template(**SECTION, axialStiffness=2e3, axialDamping=3.0, referenceAxialStrain=1e-4)
    dim = 2 if template is ObjectANCFCable2D else 3
    pin = {"groundConstraintsStart": [True] * dim + [False] * dim}
    found, _ = tip_of(0.2, beamTemplate=native, extensible=True, **pin)
    own, _ = tip_of(0.2, **stretching(2e3, axialDamping=3.0, referenceAxialStrain=1e-4), **pin, dimension=dim)
    np.testing.assert_array_equal(found, own)


def test_bending_damping_in_space_is_that_of_native_cables(tip_of, native_tip):
    """In the plane, that of the arc that is free of stress is."""
    natives = [native_tip(1.0, 20, SOFT, HEAVY, 3, bendingDamping=damping) for damping in (0.02, 0.0)]
    pin = {"groundConstraintsStart": [True] * 3 + [False] * 3, "dimension": 3}
    tip, report = tip_of(1.0, HEAVY, **stretching(SOFT, bendingDamping=0.02), **pin)
    assert distance(tip, natives[0]) < 5e-4 < 0.05 * distance(*natives)
    assert max(report["drift"]["energyGain"], report["drift"]["energyLoss"]) < 3e-3


def test_natural_curvature_is_that_of_native_cables(tip_of, native_tip):
    natives = [native_tip(0.5, 32, 200.0, referenceCurvature=curvature) for curvature in (0.5, 0.0)]
    tip, _ = tip_of(0.5, **stretching(200.0, referenceCurvature=0.5), numberOfElements=16)
    assert distance(tip, natives[0]) < 0.01 * distance(*natives)


@pytest.mark.parametrize("stiffness", [None, 100.0])
def test_a_shape_may_be_free_of_stress(new_mbs, add_cable, add_sensor, solve, stiffness):
    """An arc, clamped, damped, under gravity: against native elements with strainIsRelativeToReference."""
    section = SECTION | {"strainIsRelativeToReference": 1.0, "bendingDamping": 1e-3}
    twin = {"useReducedOrderIntegration": 2}

    def curve(elements):
        angle = np.linspace(0.0, 1.5, elements + 1)
        points = np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1)
        return points, np.stack([np.cos(angle), np.sin(angle)], axis=1)

    mbs, native, clamp = new_mbs(), new_mbs(), {"groundConstraintsStart": [True] * 4}
    template = InextensibleCable(**section, axialStiffness=stiffness)
    shape = CableShape(*curve(12), elementLengths=1.5 / 12)
    tip = add_sensor(mbs, add_cable(mbs, shape=shape, beamTemplate=template, **clamp)["nodes"][-1])
    elements = ObjectANCFCable2D(**section, **twin, axialStiffness=stiffness or 1e4)
    nodes, *_ = PointsAndSlopes2ANCFCable2D(
        native,
        ancfPointsSlopes=list(np.hstack(curve(24))),
        elementLengths=[1.5 / 24] * 24,
        cableTemplate=elements,
        massProportionalLoad=[0, -9.81, 0],
        fixedConstraintsNode0=[1, 1, 1, 1],
        firstNodeIsLastNode=False,
    )
    far = add_sensor(native, nodes[-1])
    for system in (mbs, native):
        system.Assemble()
    solve(mbs, 0.5, steps=50)
    solve_native(native, 0.5)
    found, expected = (np.asarray(m.GetSensorStoredData(n))[:, 1:] for m, n in ((mbs, tip), (native, far)))
    assert distance(found, expected) < 2e-3 < 0.02 * np.ptp(expected, axis=0).max()


def test_shapes_that_are_curved_in_space_are_not_free_of_stress(mbs, add_cable):
    ring = CableShape.Circle([0, 0, 0], 0.5, 12, normal=[0, 1, 0])
    with pytest.raises(InputError, match=r"strainIsRelativeToReference = 1.0 .* curved, in 3D"):
        add_cable(mbs, shape=ring, beamTemplate=InextensibleCable(**SECTION, strainIsRelativeToReference=1.0))


def test_drag_acts_on_the_stretched_length(mbs, add_pendulum, solve):
    """In a flow along it, N' = -c u^2 (1 + N / EA), so that N = EA (exp(c u^2 (L - x) / EA) - 1)."""
    drag, stiffness = CableDrag(1.0, 0.5, 0.01, 2.0, flowVelocity=[10, 0, 0]), 5.0
    cable = add_pendulum(mbs, gravity=[0, 0, 0], **stretching(stiffness, axialDamping=1.0))
    SetCableDrag(mbs, cable, drag)
    mbs.Assemble()
    solve(mbs, 20.0, stepSize=2e-3, massScaling=0.3)
    forces = CableForces(mbs, cable, 7)
    force = 0.005 * 2.0 * np.pi * 0.5 * 100.0
    expected = stiffness * np.expm1(force * (1.8 - forces["arcLength"]) / stiffness)
    assert expected.max() > 0.5 * stiffness
    np.testing.assert_allclose(forces["tension"], expected, rtol=1e-3, atol=1e-3)


def test_an_adaptive_step_gives_the_motion_of_native_cables(tip_of, native_tip):
    tip, _ = tip_of(0.5, HEAVY, {"adaptiveStep": True}, **stretching(SOFT))
    assert distance(tip, native_tip(0.5, 20, SOFT, HEAVY)) < 1e-4


def test_a_weight_on_a_body_stretches_the_cable_by_hookes_law(mbs, add_pendulum):
    cable = add_pendulum(mbs, positionEnd=[0, -1.8, 0], **stretching(50.0))
    body = mbs.CreateMassPoint(
        referencePosition=[0, -1.8, 0], mass=HEAVY, gravity=[0, -9.81, 0], returnDict=True
    )
    numbers = (cable["nodes"][-1], body["nodeNumber"])
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=number)) for number in numbers]
    mbs.AddObject(SphericalJoint(markerNumbers=ends))
    mbs.Assemble()
    SolveEquilibrium(mbs)
    lower = mbs.GetNodeOutput(body["nodeNumber"], OutputVariableType.Displacement)[1]
    weight = 9.81 * (HEAVY + 0.5 * 1.8 * SECTION["massPerLength"])
    assert -lower == pytest.approx(1.8 * weight / 50.0, rel=1e-5)
    top = 9.81 * (HEAVY + 1.8 * SECTION["massPerLength"])
    assert CableForces(mbs, cable)["tension"][0] == pytest.approx(top, rel=1e-6)


@pytest.mark.parametrize("stiffness", [20.0, 1e7])
def test_the_limit_separates_growth_from_rest(
    new_mbs, add_cable, add_sensor, solve, without_smaller_steps, stiffness
):
    def speed(factor, limit=None):
        mbs, nudged = new_mbs(), np.zeros((6, 2))
        nudged[-1] = 1e-6
        line = np.linspace(0.0, 1.8, 6)
        points = np.stack([line, 0 * line], axis=1)
        shape = CableShape(points, np.tile([1.0, 0.0], (6, 1)), velocities=nudged, elementLengths=0.36)
        clamp = {"gravity": [0, 0, 0], "groundConstraintsStart": [True] * 4}
        tip = add_sensor(
            mbs, add_cable(mbs, shape=shape, **clamp, **stretching(stiffness))["nodes"][-1], "Velocity"
        )
        mbs.Assemble()
        if limit is None:
            return solve(mbs, 1e-4, massScaling=0.0)["bounds"].bending
        step = factor * limit
        whole = quiet_settings(1000 * step, 1, period=1000 * step)
        solve(mbs, settings=whole, stepSize=step, massScaling=0.0, allowUnstableStep=True)
        return np.abs(np.asarray(mbs.GetSensorStoredData(tip))[-1, 1:]).max()

    limit = speed(1.0)
    assert speed(0.97, limit) < 1e-5
    with pytest.warns(UserWarning, match="stability limit"):
        try:
            grown = speed(1.03, limit)
        except DivergenceError:
            grown = np.inf
    assert grown > 1e-3


def test_stepper_and_ensemble_give_the_states_of_a_run(new_mbs, add_pendulum, solve):
    systems = [new_mbs() for _ in range(3)]
    for mbs in systems:
        add_pendulum(mbs, **stretching())
        mbs.Assemble()
    solve(systems[0], 0.1, steps=10, **SCALED)
    stepper = ExplicitStepper(systems[1], ExplicitSettings(**SCALED))
    stepper.Start()
    stepper.Step(50)
    stepper.WriteToSystem()
    expected = systems[0].systemData.GetODE2Coordinates()
    np.testing.assert_array_equal(systems[1].systemData.GetODE2Coordinates(), expected)
    result = SolveEnsemble(systems[2:], quiet_settings(0.1, 10), ExplicitSettings(**SCALED))
    np.testing.assert_array_equal(np.ravel(result["coordinates"][0][-1]), expected)
    systems.append(new_mbs())
    add_pendulum(systems[-1])
    systems[-1].Assemble()
    mixed = SolveEnsemble(systems[2:], quiet_settings(0.1, 10), ExplicitSettings(**SCALED))
    np.testing.assert_array_equal(np.ravel(mixed["coordinates"][0][-1]), expected)
    assert 1e-6 < np.abs(np.subtract(*mixed["coordinates"][:, -1])).max() < 0.1


def test_among_bodies_the_step_limit_does_not_depend_on_it_and_the_motion_is_that_of_native_cables(
    new_mbs, add_pendulum, add_sensor, solve, native_tip
):
    def move(stiffness, end_time):
        mbs = new_mbs()
        cable = add_pendulum(mbs, numberOfElements=10, **stretching(stiffness))
        body = mbs.CreateMassPoint(
            referencePosition=[1.8, 0, 0], mass=HEAVY, gravity=[0, -9.81, 0], returnDict=True
        )
        numbers = (cable["nodes"][-1], body["nodeNumber"])
        ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=number)) for number in numbers]
        mbs.AddObject(SphericalJoint(markerNumbers=ends))
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        report = solve(mbs, end_time, steps=round(end_time / 0.01), stepSize=1e-3, massScaling=0.3)
        return np.asarray(mbs.GetSensorStoredData(tip))[:, 1:], report

    tip, report = move(SOFT, 1.0)
    assert distance(tip, native_tip(1.0, 20, SOFT, HEAVY)) < 1e-4
    assert "in one compiled call" in report["path"]
    limits = [move(stiffness, 0.01)[1]["bounds"].stability_limit for stiffness in (None, SOFT, 1e7)]
    assert limits == pytest.approx([limits[0]] * 3, rel=1e-3)


def test_an_elastic_catenary_has_irvines_sag_and_tension(mbs, add_cable):
    """H. M. Irvine, Cable Structures, MIT Press (1981), elastic catenary."""
    length, span, weight, stiffness = 10.0, 9.0, 2.0, 100.0
    template = InextensibleCable(weight / 9.81, 1e-4, axialStiffness=stiffness)
    line = {"positionEnd": [length, 0, 0], "numberOfElements": 30, "groundConstraintsStart": PINNED}
    cable = add_cable(mbs, beamTemplate=template, **line)
    CreatePrescribedMotion(mbs, cable["nodes"][-1], lambda t: [span, 0, 0])
    mbs.Assemble()
    q = SolveEquilibrium(mbs)["cables"][0]["coordinates"]
    forces = CableForces(mbs, cable)
    end = 0.5 * weight * length

    def excess(h):
        return h * length / stiffness + 2 * h / weight * np.arcsinh(end / h) - span

    horizontal = brentq(excess, 1e-3, 1e3)
    sag = end * length / (4 * stiffness) + (np.hypot(horizontal, end) - horizontal) / weight
    assert -q[:, 0, 1].min() == pytest.approx(sag, rel=1e-4)
    assert forces["tension"][0] == pytest.approx(np.hypot(horizontal, end), rel=1e-4)
    assert forces["tension"].min() == pytest.approx(horizontal, rel=1e-4)
    assert forces["multiplierTension"].min() == pytest.approx(horizontal, rel=2e-3)


def test_a_string_that_is_given_less_length_than_its_supports_has_its_pretension(mbs, add_cable):
    taut = stretching(1e4, referenceAxialStrain=-0.01)
    cable = add_cable(
        mbs, gravity=[0, 0, 0], groundConstraintsEnd=PINNED, groundConstraintsStart=PINNED, **taut
    )
    mbs.Assemble()
    report = SolveEquilibrium(mbs)
    np.testing.assert_allclose(CableForces(mbs, cable)["tension"], 100.0, rtol=1e-9)
    exact = (np.pi / 1.8) ** 2 * (100.0 + SECTION["bendingStiffness"] * (np.pi / 1.8) ** 2)
    assert report["smallestEigenvalue"] == pytest.approx(exact / SECTION["massPerLength"], rel=1e-3)


def test_a_run_continues_from_its_restart_file_bit_for_bit(new_mbs, add_pendulum, solve, tmp_path):
    def state_at(end_time, name):
        mbs = new_mbs()
        add_pendulum(mbs, **stretching())
        mbs.Assemble()
        settings = quiet_settings(end_time, 10)
        restart = settings.solution.restart
        restart.name, restart.writePeriod = str(tmp_path / name), 0.05
        restart.write = restart.continueIfAvailable = True
        report = solve(mbs, settings=settings, **SCALED)
        data = mbs.systemData
        return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t()]), report

    whole, _ = state_at(0.2, "whole")
    state_at(0.1, "parts")
    continued, report = state_at(0.2, "parts")
    assert report["resumedAt"] == pytest.approx(0.1)
    np.testing.assert_array_equal(continued, whole)


def test_where_a_cable_is_too_soft_for_what_compresses_it_is_said(mbs, add_cable, solve):
    upright = {"positionEnd": [0, 1.8, 0], "groundConstraintsStart": [True] * 4}
    cable = add_cable(mbs, **upright, **stretching(3.0))
    AddPointMass(mbs, cable, 1.8, HEAVY)
    mbs.Assemble()
    with pytest.raises(
        DivergenceError, match=r"element between nodes . and . is compressed to .*axialStiffness"
    ):
        solve(mbs, 1.0, steps=100)


def test_a_flat_net_with_pinned_edges_moves(new_mbs, add_cable, solve):
    def net(stiffness):
        mbs, ends = new_mbs(), []
        for start in ([1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]):
            pin = {"groundConstraintsStart": [True] * 3 + [False] * 3, "dimension": 3}
            line = {"positionStart": start, "positionEnd": [0, 0, 0], "numberOfElements": 4}
            cable = add_cable(mbs, gravity=[0, 0, -9.81], **line, **pin, **stretching(stiffness))
            ends.append(cable["nodes"][-1])
        for other in ends[1:]:
            markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (ends[0], other)]
            mbs.AddObject(SphericalJoint(markerNumbers=markers))
        mbs.Assemble()
        return solve(mbs, 0.2, stepSize=1e-3, massScaling=0.3)["drift"]

    with pytest.raises(RedundantConstraintError, match="axialStiffness"):
        net(None)
    drift = net(1e5)
    assert max(drift["energyGain"], drift["energyLoss"]) < 1e-3


def test_a_support_bears_the_weight_of_a_stretched_cable(mbs, add_pendulum, add_sensor, solve):
    cable = add_pendulum(mbs, positionEnd=[0, -1.8, 0], groundConstraintsStart=None, **stretching(SOFT))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    holds = []
    for axis in range(2):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=cable["nodes"][0], coordinate=axis))
        holds.append(mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker])))
    AddPointMass(mbs, cable, 1.8, 0.1)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    weight = 9.81 * (0.1 + 1.8 * SECTION["massPerLength"])
    assert abs(mbs.GetObjectOutput(holds[1], OutputVariableType.Force)) == pytest.approx(weight, rel=1e-8)
    solve(mbs, 0.02, **SCALED)
    assert abs(mbs.GetObjectOutput(holds[1], OutputVariableType.Force)) == pytest.approx(weight, rel=1e-5)
