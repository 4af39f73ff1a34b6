"""Steps of cables that touch a wheel only after the start: right at any step that is accepted."""

import re
import warnings
from dataclasses import replace
from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    DistanceConstraint,
    Force,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectRigidBody2D,
    RevoluteJoint2D,
)

from exudyn_inext import (
    CableShape,
    CreateCompanionCables,
    CreateInextensibleCable,
    InextensibleCable,
    StepSizeError,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import solve_native, trajectory
from tests.exudyn_binding.test_restart import restarting, state
from tests.items.attach.contact import (
    SEGMENTS,
    Circle,
    add_contact,
    add_frictionless_contact,
    add_general_contact,
)

RADIUS, SIDE, GRAVITY = 0.2, 0.3, [0, -9.81, 0]
SECTION = {"massPerLength": 0.1, "bendingStiffness": 2e-3}
AXIAL = 2e5  # stiffness of cables that stretch [N]
INERTIA, MASSES, GAP = 0.0077, (0.2, 0.35), 7e-4  # of the wheel [kg m^2]; at the ends [kg]; at the start [m]
CLOSED = -1e-4  # a gap at the start [m]
END = 0.2  # of the runs [s]
LIGHT = 0.01  # mass of a cable by length [kg/m]
Output = exudyn.OutputVariableType
STRIKES = pytest.mark.filterwarnings("ignore:.*vibrates along its axis faster than the steps resolve")


def above_the_wheel(elements, gap=GAP):
    """Positions and slopes (n, 2) of a cable that hangs down on both sides; its length [m]."""
    radius = RADIUS + gap
    length = np.pi * radius + 2 * SIDE
    s = np.linspace(0, length, elements + 1)
    angle = np.clip((s - SIDE) / radius, 0, np.pi)
    slopes = np.column_stack([np.sin(angle), np.cos(angle)])
    arc = radius * np.column_stack([-np.cos(angle), np.sin(angle)])
    return arc + (s - SIDE - radius * angle)[:, None] * slopes, slopes, length


def add_wheel(mbs, speed=0.0):
    """A wheel that turns about the origin, with a speed [rad/s] at first: its body, and its node."""
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[0, 0, 0], initialVelocities=[0, 0, speed]))
    wheel = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=1.0, inertia=INERTIA))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for axis in (0, 1):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    return wheel, node


def hang_masses(mbs, nodes):
    for mass, node in zip(MASSES, (nodes[0], nodes[-1]), strict=True):
        there = mbs.GetNodeParameter(node, "referenceCoordinates")[:2]
        body = mbs.CreateMassPoint(mass=mass, referencePosition=[*there, 0], gravity=GRAVITY, create2D=True)
        ends = MarkerBodyPosition(bodyNumber=body), MarkerNodePosition(nodeNumber=node)
        mbs.AddObject(RevoluteJoint2D(markerNumbers=[mbs.AddMarker(end) for end in ends]))


def add_native(mbs, positions, slopes, length):
    """The same cable of native elements: its nodes, and its elements."""
    nodes = [
        mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[*r, *slope]))
        for r, slope in zip(positions, slopes, strict=True)
    ]
    elements = [
        mbs.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=list(pair), length=length / (len(nodes) - 1), axialStiffness=AXIAL, **SECTION
            )
        )
        for pair in pairwise(nodes)
    ]
    for element in elements:
        weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=element))
        mbs.AddLoad(LoadMassProportional(markerNumber=weight, loadVector=GRAVITY))
    return nodes, elements


def surface(segment):
    """Of a segment of that length [m]."""
    return Circle(RADIUS, 5e5 * segment, 800.0 * segment, 0.577, friction_damping=4250.0 * segment)


def with_bristles(relaxation, damping=1.0):
    """Contact that sticks by springs, too, which relax within that time [s]; 0: none.

    damping: as a share of that of the surface [-].
    """

    def touch(mbs, elements, circle, body):
        penalty = damping * circle.friction_damping
        stiffness = penalty / relaxation if relaxation else 0.0
        changed = {"friction_damping": penalty, "friction_stiffness": stiffness}
        add_contact(mbs, elements, replace(circle, damping=damping * circle.damping, **changed), body)

    return touch


@pytest.fixture
def build(new_mbs, add_sensor):
    """(elements, is native) -> system, sensors of the wheel's turn and of the right end."""

    def new(elements, native=False, touch=add_contact, gap=GAP, speed=0.0, extensible=False):
        mbs = new_mbs()
        positions, slopes, length = above_the_wheel(elements, gap)
        if native:
            nodes, bodies = add_native(mbs, positions, slopes, length)
        else:
            template = InextensibleCable(**SECTION, axialStiffness=AXIAL if extensible else None)
            line = {"shape": CableShape(positions, slopes), "beamTemplate": template, "gravity": GRAVITY}
            cable = CreateInextensibleCable(mbs, **line, extensible=extensible)
            nodes, bodies = cable["nodes"], CreateCompanionCables(mbs, cable)
        wheel, node = add_wheel(mbs, speed)
        hang_masses(mbs, nodes)
        touch(mbs, bodies, surface(length / elements / SEGMENTS), wheel)
        sensors = add_sensor(mbs, node, "Coordinates"), add_sensor(mbs, nodes[-1])
        mbs.Assemble()
        return mbs, sensors

    return new


def at_the_end(mbs, sensors):
    """Turn of the wheel [rad] and fall of the right end [m]."""
    turn, end = (trajectory(mbs, sensor) for sensor in sensors)
    return np.array([turn[-1, 3], end[-1, 2] - end[0, 2]])


@pytest.fixture
def native(build):
    """(elements, touch, step, gap, speed) -> the same by generalized-alpha."""

    def run(elements, touch=add_contact, step=2e-4, **start):
        mbs, sensors = build(elements, native=True, touch=touch, **start)
        settings = quiet_settings(END, round(END / step))
        settings.timeIntegration.newton.relativeTolerance = 1e-6
        settings.timeIntegration.discontinuous.ignoreMaxIterations = True
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
        with silence():
            mbs.SolveDynamic(settings)
        return at_the_end(mbs, sensors)

    return run


@pytest.mark.parametrize("elements", [16, 24])
def test_a_wheel_turns_as_a_native_one_at_any_step_that_is_accepted(build, native, solve, elements):
    expected = native(elements)
    assert expected[0] < -0.1
    limit = solve(build(elements)[0], 1e-3)["bounds"].stability_limit
    for massScaling in (0.0, 0.3):
        for share in (0.98, 0.5):
            mbs, sensors = build(elements)
            solve(mbs, END, stepSize=share * limit, massScaling=massScaling)
            np.testing.assert_allclose(at_the_end(mbs, sensors), expected, rtol=0.02)


@STRIKES
@pytest.mark.parametrize("extensible", [False, True])
@pytest.mark.parametrize("gap, damping", [(GAP, 1.0), (GAP, 20.0), (CLOSED, 1.0)])
def test_contact_does_not_bound_the_step_of_a_planar_cable(build, native, solve, gap, damping, extensible):
    """Dashpots let it decay by up to 160000 1/s, across the cable; steps are of order 2 all the same."""

    def touch(mbs, elements, circle, body):
        add_contact(mbs, elements, replace(circle, damping=damping * circle.damping), body)

    scene, found = {"touch": touch, "gap": gap}, []
    expected = native(16, **scene)
    for step in (None, 2e-5, 1e-5):
        mbs, sensors = build(16, extensible=extensible, **scene)
        report = solve(mbs, END, stepSize=step)
        found.append(at_the_end(mbs, sensors))
        assert report["bounds"].contact > 1e-3  # 2 d / k; explicit dashpots: 2.4e-5 s
    np.testing.assert_allclose(found[0], expected, rtol=0.02)
    np.testing.assert_allclose(found[0], found[2], rtol=5e-3)
    np.testing.assert_allclose(found[1], found[2], rtol=1e-3)


@STRIKES
@pytest.mark.parametrize("extensible", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_step_resolves_that_segments_bounce_which_are_damped_weakly(
    build, native, solve, share, extensible
):
    """At sqrt(k / m), however stiff the cable is in bending.   share: of the critical damping."""
    critical, segment = [], []

    def touch(mbs, elements, circle, body):
        mass = SECTION["massPerLength"] * circle.stiffness / 5e5  # see `surface`
        critical.append(2.0 * np.sqrt(circle.stiffness * mass))
        segment.append((circle.stiffness, mass))
        add_contact(mbs, elements, replace(circle, damping=share * critical[0]), body)

    mbs, sensors = build(16, touch=touch, extensible=extensible)
    report = solve(mbs, END)
    stiffness, mass = segment[0]
    assert report["bounds"].contact == pytest.approx(2.0 * np.sqrt(mass / stiffness), rel=1e-4)
    assert report["stepSize"] <= 0.7 * report["bounds"].contact
    np.testing.assert_allclose(at_the_end(mbs, sensors), native(16, touch=touch), rtol=0.02)


@STRIKES
@pytest.mark.parametrize("extensible", [False, True])
@pytest.mark.parametrize("inertia, most", [(8e-4, 10_000), (1e-4, 60_000)])
def test_a_light_wheel_turns_as_a_native_one(build, native, solve, monkeypatch, inertia, most, extensible):
    """It has a third, or a 25th, of the mass of the cable on it; dashpots would need 4 and 0.5 us.

    most: steps; explicit contact takes 76 000 and 528 000.
    """
    monkeypatch.setattr("tests.items.attach.test_contact_steps.INERTIA", inertia)
    expected = native(16, step=5e-5)  # where it has converged
    mbs, sensors = build(16, extensible=extensible)
    assert solve(mbs, END)["steps"] < most
    np.testing.assert_allclose(at_the_end(mbs, sensors), expected, rtol=0.02)


@STRIKES
def test_contact_that_is_damped_implicitly_is_the_same_scene_after_a_load_was_changed(build, solve):
    """At the end of such a run, all items are compared with Exudyn's, where the damping is explicit."""
    turns = []
    for force in (0.0, 3.0):
        mbs, sensors = build(16, gap=CLOSED, extensible=True)
        end = MarkerNodePosition(nodeNumber=mbs.GetSensor(sensors[1])["nodeNumber"])
        load = mbs.AddLoad(Force(markerNumber=mbs.AddMarker(end), loadVector=[0.0, -1.0, 0.0]))
        mbs.Assemble()
        mbs.SetPreStepUserFunction(pulling(load, force))
        report = solve(mbs, 0.02, steps=4)
        assert "Exudyn evaluates them" not in report["path"]
        turns.append(at_the_end(mbs, sensors)[0])
    assert turns[1] < 1.5 * turns[0] < 0.0


def on_a_rod(build, touch, extensible):
    """A cable falls on a wheel that turns, one end on a rod: that joint is corrected."""
    mbs, sensors = build(16, touch=touch, speed=5.0, extensible=extensible)
    end = mbs.GetSensor(sensors[1])["nodeNumber"]
    x, y = mbs.GetNodeParameter(end, "referenceCoordinates")[:2]
    far = MarkerBodyPosition(bodyNumber=mbs.CreateGround(referencePosition=[x + 0.1, y, 0]))
    ends = [mbs.AddMarker(marker) for marker in (far, MarkerNodePosition(nodeNumber=end))]
    mbs.AddObject(DistanceConstraint(markerNumbers=ends, distance=0.1))
    mbs.Assemble()
    return mbs


def in_general_contact(mbs, elements, circle, wheel):
    add_general_contact(mbs, elements, circle, mbs.AddMarker(MarkerBodyRigid(bodyNumber=wheel)))


@STRIKES
@pytest.mark.parametrize(
    ("damping", "extensible"), [(20.0, False), (20.0, True), (50.0, False), (1000.0, False)]
)
def test_friction_of_a_general_contact_takes_a_light_wheel_along(
    build, solve, monkeypatch, damping, extensible
):
    """Its spin is explicit: where it sways, smaller steps begin anew. Its mass is a tenth of the cable's.

    damping: by length [N s/m^2].
    """
    monkeypatch.setattr("tests.items.attach.test_contact_steps.INERTIA", 3e-4)

    def touch(mbs, elements, circle, wheel):
        in_general_contact(mbs, elements, Circle(RADIUS, 5e5, damping, 0.6), wheel)

    found = []
    for step in (None, 2e-5):
        mbs, sensors = build(16, touch=touch, extensible=extensible)
        solve(mbs, END, stepSize=step)
        found.append(at_the_end(mbs, sensors))
    np.testing.assert_allclose(*found, rtol=0.01)


@pytest.mark.parametrize(
    ("touch", "step", "extensible"),
    [
        (add_contact, 2e-5, False),
        (add_contact, 2e-5, True),
        (in_general_contact, 2.5e-4, False),
        (in_general_contact, 2.5e-4, True),
    ],
)
def test_a_run_goes_on_from_its_file_bit_for_bit_while_a_wheel_rubs(
    build, solve, tmp_path, touch, step, extensible
):
    """What presses the cable is in the matrix by which the next step corrects joints."""
    whole, first, second = (on_a_rod(build, touch, extensible) for _ in range(3))
    solve(whole, 0.016, stepSize=step)
    for mbs, end in ((first, 0.012), (second, 0.016)):
        report = solve(mbs, settings=restarting(quiet_settings(end, 1), tmp_path), stepSize=step)
    assert report["resumedAt"] == 0.012
    np.testing.assert_array_equal(state(second), state(whole))


def momentum(mbs, nodes):
    """About the origin, of the wheel, the cable and the mass at its end [kg m^2/s]."""
    total = INERTIA * mbs.GetNodeOutput(nodes["wheel"], Output.AngularVelocity)[2]
    masses = np.full(len(nodes["cable"]), LIGHT * np.pi * RADIUS / (len(nodes["cable"]) - 1))
    masses[[0, -1]] *= 0.5
    moving = [*zip(masses, nodes["cable"], strict=True), (MASSES[0], nodes["mass"])]
    for mass, node in moving:
        (x, y, _), (u, v, _) = (
            mbs.GetNodeOutput(node, which) for which in (Output.Position, Output.Velocity)
        )
        total += mass * (x * v - y * u)
    return total


def spinning(new_mbs, touch, stiffness, speed=10.0):
    """A wheel spins, half a turn of a cable on it, of which one end is on the wheel: mbs, and its nodes.

    stiffness: EA of the cable [N], or None.
    """
    mbs = new_mbs()
    angle = np.linspace(0.0, np.pi, 13)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    along = np.column_stack([-out[:, 1], out[:, 0]])
    rates = {"velocities": speed * RADIUS * along, "slopeVelocities": -speed * out}
    section = InextensibleCable(massPerLength=LIGHT, bendingStiffness=2e-4, axialStiffness=stiffness)
    line = {"shape": CableShape(RADIUS * out, along, **rates), "beamTemplate": section}
    cable = CreateInextensibleCable(mbs, **line, extensible=stiffness is not None)
    wheel, node = add_wheel(mbs, speed)
    end = {"referencePosition": [-RADIUS, 0, 0], "initialVelocity": [0, -speed * RADIUS, 0]}
    body = mbs.CreateMassPoint(mass=MASSES[0], create2D=True, **end)
    on_wheel = MarkerBodyPosition(bodyNumber=wheel, localPosition=[RADIUS, 0, 0])
    pairs = (on_wheel, cable["nodes"][0]), (MarkerBodyPosition(bodyNumber=body), cable["nodes"][-1])
    for marker, end in pairs:
        ends = [mbs.AddMarker(one) for one in (marker, MarkerNodePosition(nodeNumber=end))]
        mbs.AddObject(RevoluteJoint2D(markerNumbers=ends))
    circle = Circle(0.999 * RADIUS, 1e5, 50.0, 0.3, friction_damping=100.0)
    touch(mbs, CreateCompanionCables(mbs, cable), circle, wheel)
    mbs.Assemble()
    nodes = {"wheel": node, "cable": cable["nodes"], "mass": mbs.GetObject(body)["nodeNumber"]}
    return mbs, nodes


@STRIKES
@pytest.mark.parametrize(
    ("touch", "stiffness"),
    [(add_contact, None), (add_contact, 2e4), (in_general_contact, None), (in_general_contact, 2e4)],
)
def test_a_wheel_and_the_cable_that_rubs_on_it_keep_their_momentum(new_mbs, solve, touch, stiffness):
    """What joints at the cable's ends do to it changes friction, which is implicit: the wheel feels that."""
    mbs, nodes = spinning(new_mbs, touch, stiffness)
    before = momentum(mbs, nodes)
    solve(mbs, END, stepSize=1e-4)
    assert momentum(mbs, nodes) == pytest.approx(before, rel=1e-4)


def pulling(load, force):
    """A pre-step function that sets a load [N]."""

    def pull(mbs, t):
        mbs.SetLoadParameter(load, "loadVector", [0.0, -force, 0.0])
        return True

    return pull


def test_a_step_that_explicit_friction_would_not_survive_is_refused_with_its_reason(build, solve):
    mbs, _ = build(16)
    says = (
        r"stepSize = 0.0001 s is above 6\.\d+e-05 s, .* contacts close: object \d+ .*ContactFrictionCircle.*"
        r"frictionVelocityPenalty = .* and 15 more .*: reduce the step below .*, or lower their "
        r"contactDamping and frictionVelocityPenalty\.$"
    )
    with pytest.raises(StepSizeError, match=says):
        solve(mbs, END, stepSize=1e-4, integrator="RK4")
    with pytest.warns(UserWarning, match=says):
        solve(mbs, 1e-3, stepSize=1e-4, integrator="RK4", allowUnstableStep=True)


def test_the_remedy_that_is_named_for_friction_works(build, solve):
    """A twentieth of the dashpots; the step that was refused is accepted."""
    mbs, _ = build(16, touch=with_bristles(0.0, 0.05))
    assert solve(mbs, 1e-3, stepSize=1e-4, integrator="RK4")["success"]


@pytest.mark.parametrize("gap", [GAP, CLOSED])
@pytest.mark.parametrize("relaxation", [0.0, 2e-5])
def test_a_wheel_turns_as_a_native_one_with_and_without_bristles(build, native, solve, gap, relaxation):
    """Warnings are errors: nothing is said of it either."""
    scene = {"touch": with_bristles(relaxation, 0.1), "gap": gap}
    expected = native(16, **scene)
    for step, massScaling in ((1e-4, 0.0), (5e-5, 0.3), (2e-5, 0.0)):
        mbs, sensors = build(16, **scene)
        solve(mbs, END, stepSize=step, massScaling=massScaling)
        np.testing.assert_allclose(at_the_end(mbs, sensors), expected, rtol=0.02)


def test_a_wheel_that_friction_drives_is_named(build, native, solve):
    """Bristles that relax more slowly than slip turns round: the motion is right by chance, at some steps."""
    expected = native(16, gap=CLOSED)
    says = (
        r"object \d+ '.*ContactFrictionCircleCable2D: frictionStiffness = .*, frictionVelocityPenalty = .* "
        r"and 15 more like it: .*% of the work of friction contradicts Coulomb's law \(limit 5%\): .*own "
        r"solvers, too: set frictionStiffness = 0, or lower frictionVelocityPenalty\.$"
    )
    named = []
    for step in (2.2e-5, 1.8e-5, 1.23e-5):
        mbs, sensors = build(16, touch=with_bristles(8.5e-3), gap=CLOSED)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            solve(mbs, END, stepSize=step)
        named.append(any(re.search(says, str(warning.message)) for warning in caught))
        assert named[-1] or at_the_end(mbs, sensors) == pytest.approx(expected, rel=0.02)
    assert any(named)


def test_contacts_that_close_in_slip_are_right_at_small_steps_or_named(build, solve):
    """In its first step a contact with bristles sticks, whatever its force is; without them it slips."""

    def turn(step, relaxation):
        mbs, sensors = build(16, touch=with_bristles(relaxation, 0.1), speed=10.0)
        solve(mbs, 0.05, stepSize=step)
        return at_the_end(mbs, sensors)[0]

    with pytest.warns(UserWarning, match=r"contradicts Coulomb's law.*: reduce stepSize, or set friction"):
        far = turn(7e-5, 2e-5)
    right = turn(7e-5, 0.0)
    assert turn(3e-6, 2e-5) == pytest.approx(right, rel=0.02)
    assert far != pytest.approx(right, rel=0.02)


def test_contact_without_friction_is_known_as_well(build, native, solve):
    expected = native(16, add_frictionless_contact)
    mbs, sensors = build(16, touch=add_frictionless_contact)
    bounds = solve(mbs, END)["bounds"]
    assert bounds.contact < bounds.bending
    found = at_the_end(mbs, sensors)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(expected[1], rel=0.02)
    mbs, sensors = build(16, touch=add_frictionless_contact)
    solve(mbs, END, stepSize=0.98 * bounds.stability_limit, massScaling=0.3)
    assert at_the_end(mbs, sensors)[1] == pytest.approx(expected[1], rel=0.02)


def general_contact(mbs, elements, wheel):
    circle = Circle(RADIUS, 2e3, 0.1, 0.3)
    add_general_contact(mbs, elements, circle, mbs.AddMarker(MarkerBodyRigid(bodyNumber=wheel)))


@pytest.fixture
def braked(new_mbs, add_sensor):
    """(is native) -> a turning wheel under a cable that lies on it: system, sensor of its turn."""

    def build(native):
        mbs = new_mbs()
        positions, slopes, length = above_the_wheel(12, gap=-1e-4)
        if native:
            _, bodies = add_native(mbs, positions, slopes, length)
        else:
            shape, template = CableShape(positions, slopes), InextensibleCable(**SECTION)
            cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=template, gravity=GRAVITY)
            bodies = CreateCompanionCables(mbs, cable)
        wheel, node = add_wheel(mbs, speed=10.0)
        general_contact(mbs, bodies, wheel)
        sensor = add_sensor(mbs, node, "Coordinates")
        mbs.Assemble()
        return mbs, sensor

    return build


def test_a_wheel_that_turns_already_does_not_bound_the_step_by_its_friction(braked, solve):
    mbs, sensor = braked(native=False)
    bounds = solve(mbs, 0.1, stepSize=1e-4)["bounds"]
    assert bounds.stability_limit > 1e-4
    twin, native_sensor = braked(native=True)
    solve_native(twin, 0.1, step=1e-4)
    found, expected = (trajectory(*pair)[-1, 3] - 1.0 for pair in ((mbs, sensor), (twin, native_sensor)))
    assert expected < -0.01  # friction brakes it
    assert found == pytest.approx(expected, rel=0.02)
