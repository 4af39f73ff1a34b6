"""SolveEquilibrium among bodies, springs, joints, torques and contact, beside native twins."""

from itertools import pairwise, product

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    DistanceConstraint,
    LoadCoordinate,
    LoadForceVector,
    LoadTorqueVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodeGenericODE2,
    NodePointGround,
    ObjectANCFCable2D,
    ObjectGenericODE2,
    RevoluteJoint2D,
    SphericalJoint,
    SpringDamper,
    TorsionalSpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CableShape,
    CreateCompanionCables,
    CreateInextensibleCable,
    EquilibriumError,
    InextensibleCable,
    InputError,
    SceneError,
    SolveEquilibrium,
    SolveExplicit,
    StaticSettings,
)
from exudyn_inext.element.shape_functions import shape_functions
from exudyn_inext.exudyn_binding.static_solver import scene_at_rest, scene_of
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import either_cable
from tests.items.attach.contact import Circle, add_frictionless_contact, add_general_contact
from tests.random_scenes import SECTION, RandomScene

MASS, BENDING, AXIAL = 0.2, 0.05, 1e6  # per length [kg/m], [N m^2], of native cables [N]
SIZE = 1e-4  # of what a finer mesh and a stretch of 1e-6 may change [m]
ELEMENTS, FINER = 16, 4  # of each cable, and how many native ones lie in each


class Builder:
    """A scene of inextensible, or of native cables."""

    def __init__(self, native=False, dimension=3):
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.native, self.dimension = native, dimension
        self.gravity = [0, 0, -9.81] if dimension == 3 else [0, -9.81, 0]
        self.ground = self.mbs.CreateGround()
        self.cables = []

    def cable(self, start, end, elements=ELEMENTS, pinned=(), clamped=(), gravity=None):
        """Nodes of a straight cable; `pinned` and `clamped` name its ends, 'Start' and 'End'."""
        number = elements * (FINER if self.native else 1)
        line = {"positionStart": start, "positionEnd": end, "numberOfElements": number}
        line["gravity"] = self.gravity if gravity is None else gravity
        for name in ("Start", "End"):
            flags = [name in pinned or name in clamped] * self.dimension
            line[f"groundConstraints{name}"] = flags + [name in clamped] * self.dimension
        section = {"massPerLength": MASS, "bendingStiffness": BENDING}
        nodes, self.made = either_cable(self.mbs, self.native, self.dimension, section, AXIAL, **line)
        self.cables.append(nodes)
        return nodes

    def at(self, node):
        return self.mbs.AddMarker(MarkerNodePosition(nodeNumber=node))

    def on(self, body, local=(0.0, 0.0, 0.0), rigid=False):
        kind = MarkerBodyRigid if rigid else MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=body, localPosition=list(local)))

    def tie(self, *markers):
        axes = [1] * self.dimension + [0] * (3 - self.dimension)
        self.mbs.AddObject(SphericalJoint(markerNumbers=list(markers), constrainedAxes=axes))

    def body(self, position, node="EulerParameters"):
        kind = getattr(exudyn.NodeType, f"Rotation{node}")
        inertia = InertiaCuboid(400, [0.2, 0.15, 0.1])
        return self.mbs.CreateRigidBody(
            inertia=inertia, referencePosition=position, gravity=self.gravity, nodeType=kind
        )


def platform(b):
    """A body on three cables, pushed aside off its centre, and held by a spring."""
    body = b.body([0, 0, -1])
    for angle in (0.3, 2.3, 4.4):
        local = [0.1 * np.cos(angle), 0.1 * np.sin(angle), 0.0]
        nodes = b.cable([0.6 * np.cos(angle), 0.6 * np.sin(angle), 0.0], [*local[:2], -1.0], pinned=["Start"])
        b.tie(b.on(body, local), b.at(nodes[-1]))
    b.mbs.AddLoad(LoadForceVector(markerNumber=b.on(body, [0.0, 0.05, 0.0]), loadVector=[8.0, 3.0, 0.0]))
    b.mbs.CreateSpringDamper(
        itemNumbers=[b.ground, body], localPosition0=[1.0, 0.0, -1.2], referenceLength=0.5, stiffness=30
    )


def swing(b):
    """Mass points between cables, which meet in one of them, and a spring to the ground."""
    first = b.cable([0, 0, 0], [1, 0, 0], pinned=["Start"])
    second = b.cable([1, 0, 0], [1.7, 0.5, 0.2])
    third = b.cable([1, 0, 0], [1.2, -0.6, 0.1])
    points = [
        b.mbs.CreateMassPoint(mass=mass, referencePosition=place, gravity=b.gravity)
        for mass, place in ((0.3, [1, 0, 0]), (0.2, [1.2, -0.6, 0.1]))
    ]
    b.tie(b.at(first[-1]), b.at(second[0]))
    b.tie(b.at(third[0]), b.at(first[-1]))
    b.tie(b.on(points[0]), b.at(first[-1]))
    b.tie(b.on(points[1]), b.at(third[-1]))
    ends = [b.on(b.ground, [1.5, 0.4, 0.3]), b.at(second[-1])]
    b.mbs.AddObject(CartesianSpringDamper(markerNumbers=ends, stiffness=[50] * 3, damping=[0] * 3))


def rod(b):
    """A body that turns by angles, on a cable, a rod and a spring."""
    body = b.body([0.5, 0.0, -0.5], node="Rxyz")
    nodes = b.cable([0, 0, 0], [0.4, 0.0, -0.5], pinned=["Start"])
    b.tie(b.at(nodes[-1]), b.on(body, [-0.1, 0, 0]))
    ends = [b.on(b.ground, [1.0, 0.2, 0.0]), b.on(body, [0.1, 0, 0])]
    length = float(np.linalg.norm([0.4, 0.2, 0.5]))
    b.mbs.AddObject(DistanceConstraint(markerNumbers=ends, distance=length))
    b.mbs.CreateSpringDamper(
        itemNumbers=[b.ground, body],
        localPosition0=[0.5, -1.0, -0.4],
        localPosition1=[0.0, -0.05, 0.05],
        referenceLength=0.4,
        stiffness=40,
    )


def planar_crank(b):
    """A planar body with an off-centre weight on the end of a clamped cable, and a torsional spring."""
    nodes = b.cable([0, 0, 0], [0.8, 0, 0], clamped=["Start"])
    body = b.mbs.CreateRigidBody(
        inertia=InertiaCuboid(200, [0.2, 0.1, 0.05]),
        referencePosition=[0.9, 0, 0],
        gravity=b.gravity,
        create2D=True,
    )
    b.mbs.AddObject(RevoluteJoint2D(markerNumbers=[b.at(nodes[-1]), b.on(body, [-0.1, 0.0, 0.0])]))
    pair = [b.on(b.ground, rigid=True), b.on(body, rigid=True)]
    b.mbs.AddObject(TorsionalSpringDamper(markerNumbers=pair, stiffness=0.4, offset=0.3))
    b.mbs.AddLoad(LoadTorqueVector(markerNumber=b.on(body, rigid=True), loadVector=[0, 0, 0.1]))


def moment(b):
    """A moment at the end of a planar cantilever under gravity."""
    nodes = b.cable([0, 0, 0], [1, 0, 0], clamped=["Start"])
    marker = b.mbs.AddMarker(MarkerNodeRigid(nodeNumber=nodes[-1]))
    b.mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 0.2]))


def halves(b):
    """One node of a cable follows another one by half."""
    nodes = b.cable([0, 0, 0], [1, 0, 0], pinned=["Start"])
    other = b.cable([0, -0.5, 0], [1, -0.5, 0], pinned=["Start"])
    pair = [b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n[-1], coordinate=0)) for n in (nodes, other)]
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=pair, factor1=0.5))
    b.mbs.AddLoad(LoadForceVector(markerNumber=b.at(other[-1]), loadVector=[4.0, 0.0, 0.0]))


def over_circles(b, length, elements, *circles):
    """A cantilever that lies on circles (x, y, radius), found by Exudyn's contact."""
    b.cable([0, 0, 0], [length, 0, 0], elements, clamped=["Start"])
    of_cable = b.made["elements"] if b.native else CreateCompanionCables(b.mbs, b.made)
    for x, y, radius in circles:
        ground = b.mbs.CreateGround(referencePosition=[x, y, 0])
        add_frictionless_contact(b.mbs, of_cable, Circle(radius, 2e3, 0.0, 0.0), ground)


def over_a_wheel(b, elements=24):
    over_circles(b, 1, elements, (0.6, -0.3, 0.1))


def over_two_wheels(b, elements):
    over_circles(b, 2, elements, (0.5, -0.15, 0.1), (1.3, -0.5, 0.3))


SCENES = {
    "platform": (platform, 3),
    "swing": (swing, 3),
    "rod": (rod, 3),
    "crank": (planar_crank, 2),
    "moment": (moment, 2),
    "halves": (halves, 2),
    "wheel": (over_a_wheel, 2),
}


TURNING = {"platform", "rod"}  # of which the native static solver diverges, whatever it starts from


def built(scene, native=False):
    build, dimension = SCENES[scene]
    builder = Builder(native, dimension)
    build(builder)
    builder.mbs.Assemble()
    return builder


def totals(mbs):
    """Coordinates with their reference values, node by node."""
    data, found = mbs.systemData, {}
    displacements = np.array(data.GetODE2Coordinates())
    for number in range(data.NumberOfNodes()):
        if len(own := data.GetNodeLTGODE2(number)):
            found[number] = displacements[own] + mbs.GetNode(number)["referenceCoordinates"]
    return found


def finer(nodes, state):
    """Coordinates of FINER times as many elements, by the shape functions."""
    found = [state[nodes[0]]]
    for left, right in pairwise(nodes):
        ends = np.array([state[left], state[right]]).reshape(4, -1)
        length = np.linalg.norm(ends[2] - ends[0])
        for x in np.arange(1, FINER + 1) / FINER:
            slope = (shape_functions(x + 1e-6, length) - shape_functions(x - 1e-6, length)) / (2e-6 * length)
            found.append(np.concatenate([shape_functions(x, length) @ ends, slope @ ends]))
    return found


def pairs_of_nodes(ours, native):
    """Nodes of both that stand for the same."""
    for own, theirs in zip(ours.cables, native.cables, strict=True):
        yield from zip(own, theirs[::FINER], strict=True)
    others = [sorted(set(totals(b.mbs)).difference(*b.cables)) for b in (ours, native)]
    yield from zip(*others, strict=True)


def begin_with(native, ours):
    """Let the native twin begin where ours is."""
    state, data = totals(ours.mbs), native.mbs.systemData
    places = {theirs: state[own] for own, theirs in pairs_of_nodes(ours, native)}
    for own, theirs in zip(ours.cables, native.cables, strict=True):
        places.update(zip(theirs, finer(own, state), strict=True))
    initial = np.array(data.GetODE2Coordinates(exudyn.ConfigurationType.Initial))
    for node, total in places.items():
        initial[data.GetNodeLTGODE2(node)] = total - native.mbs.GetNode(node)["referenceCoordinates"]
    data.SetODE2Coordinates(initial.tolist(), exudyn.ConfigurationType.Initial)


def twisted(node):
    """Report and place of a body on two cables that stretch, turned by a torque about the vertical axis."""
    b = Builder()
    body, rope = b.body([0, 0, -1], node), InextensibleCable(MASS, BENDING, axialStiffness=2e4)
    for x in (-0.1, 0.1):
        line = [x, 0, 0], [x, 0, -0.95], 8, rope, b.gravity
        nodes = CreateInextensibleCable(b.mbs, *line, [True] * 3 + [False] * 3, dimension=3)["nodes"]
        b.tie(b.at(nodes[-1]), b.on(body, [x, 0, 0.05]))
    b.mbs.AddLoad(LoadTorqueVector(markerNumber=b.on(body, rigid=True), loadVector=[0, 0, 0.03]))
    b.mbs.Assemble()
    report = SolveEquilibrium(b.mbs)
    return report, b.mbs.GetObjectOutputBody(body, exudyn.OutputVariableType.Position, [0.1, 0, 0])


def test_torques_on_bodies_leave_an_equilibrium_stable():
    """Where they act on Euler parameters, the Hessian is not symmetric; angles say the same."""
    (found, place), (by_angles, other) = twisted("EulerParameters"), twisted("Rxyz")
    assert found["smallestEigenvalue"] == pytest.approx(by_angles["smallestEigenvalue"], rel=0.01)
    np.testing.assert_allclose(place, other, atol=1e-7)
    assert place[1] > 0.02


@pytest.mark.parametrize("scene", sorted({*SCENES} - {"wheel"}))  # whose contacts are open there at first
def test_native_twins_stay_where_it_ends(scene):
    """By statics; where that does not converge, by a dynamic run from there."""
    ours, native = built(scene), built(scene, native=True)
    report = SolveEquilibrium(ours.mbs)
    assert report["success"] and report["iterations"] < 60
    found, before = totals(ours.mbs), totals(built(scene).mbs)
    assert max(np.abs(found[node] - at).max() for node, at in before.items()) > 0.02
    begin_with(native, ours)
    with silence():
        settings = quiet_settings(0.2, 200)
        settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        if scene in TURNING:
            settings.timeIntegration.generalizedAlpha.spectralRadius = 0.5
            native.mbs.SolveDynamic(settings)
        else:
            settings.staticSolver.newton.relativeTolerance = 1e-9
            settings.staticSolver.numberOfLoadSteps = 1
            native.mbs.SolveStatic(settings)
    expected = totals(native.mbs)
    for own, theirs in pairs_of_nodes(ours, native):
        dim = ours.dimension
        np.testing.assert_allclose(found[own][:dim], expected[theirs][:dim], atol=SIZE)


def test_the_hessian_of_a_step_takes_half_of_the_evaluations(monkeypatch):
    """It agrees with the one by central differences, which eigenvalues are found from."""
    mbs, hessians, numbers, calls = built("moment").mbs, [], [], []
    with scene_of(mbs, 0.0, "") as scene, scene_at_rest(mbs, scene, 0.0) as found:
        force = found.others.force
        monkeypatch.setattr(found.others, "force", lambda q: calls.append(q) or force(q))
        q, multipliers = found.start, np.zeros(len(found.potential.values(found.start)))
        for is_rough in (False, True):
            hessians.append(found.potential.hessian(q, multipliers, is_rough).toarray())
            numbers.append(len(calls))
    exact, rough = hessians
    assert numbers[1] - numbers[0] == numbers[0] // 2 + 1
    np.testing.assert_allclose(rough, exact, atol=1e-5 * np.abs(found.potential.of_others).max())
    assert np.abs(found.potential.of_others).max() > 0.1


@pytest.mark.parametrize("scene", SCENES)
def test_a_run_from_there_stays_at_rest(scene):
    builder = built(scene)
    SolveEquilibrium(builder.mbs)
    before = totals(builder.mbs)
    with silence():
        SolveExplicit(builder.mbs, quiet_settings(0.2, 2))
    after = totals(builder.mbs)
    assert max(np.abs(after[n] - at).max() for n, at in before.items()) < 1e-7


def with_steps_of_load(mbs):
    """Exudyn's static solver, whose contacts close little by little."""
    settings = quiet_settings(1.0, 1)
    static = settings.staticSolver
    static.adaptiveStep, static.numberOfLoadSteps = False, 40
    static.loadStepGeometric, static.loadStepGeometricRange = True, 5e3
    static.newton.relativeTolerance, static.newton.maxIterations = 1e-6, 40
    static.discontinuous.iterationTolerance, static.stabilizerODE2term = 1e-4, 2
    mbs.SolveStatic(settings)


@pytest.mark.parametrize("scene", [over_a_wheel, over_two_wheels])
def test_a_cable_comes_to_rest_on_circles_and_not_behind_them(scene):
    """A step of the search could jump over each of them; a native cable has steps of load."""
    ours, native = Builder(dimension=2), Builder(native=True, dimension=2)
    with silence():
        for builder in (ours, native):
            scene(builder, 32 // (FINER if builder.native else 1))
            builder.mbs.Assemble()
        SolveEquilibrium(ours.mbs)
        with_steps_of_load(native.mbs)
    found, expected = totals(ours.mbs), totals(native.mbs)
    for own, theirs in zip(ours.cables[0], native.cables[0], strict=True):
        np.testing.assert_allclose(found[own][:2], expected[theirs][:2], atol=5e-4)


@pytest.mark.parametrize(("stiffness", "offset"), [(200.0, -0.05), (200.0, -0.1), (400.0, -0.1)])
def test_a_support_that_is_moved_lets_a_cable_bulge_onto_a_circle(stiffness, offset):
    """The search ran into the contact, 500 times: its convex model knew nothing of its stiffness."""
    b = Builder(dimension=2)
    nodes = b.cable([0, 0, 0], [1, 0, 0], 32, pinned=["Start"])
    ground = b.mbs.CreateGround(referencePosition=[0.5, -0.25, 0])
    circle = Circle(0.2, stiffness, 0.0, 0.0)
    add_frictionless_contact(b.mbs, CreateCompanionCables(b.mbs, b.made), circle, ground)
    numbers = b.mbs.AddNode(NodePointGround()), nodes[-1]
    markers = [b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=0)) for n in numbers]
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=markers, offset=offset))
    b.mbs.Assemble()
    assert SolveEquilibrium(b.mbs)["iterations"] < 50
    rest = totals(b.mbs)
    assert rest[nodes[-1]][0] == pytest.approx(1.0 + offset, abs=1e-9)
    assert min(np.hypot(rest[node][0] - 0.5, rest[node][1] + 0.25) for node in nodes) < 0.2
    SolveExplicit(b.mbs, quiet_settings(0.2, 20))
    moved = totals(b.mbs)
    for node in nodes:
        np.testing.assert_allclose(moved[node], rest[node], atol=1e-7)


def test_a_cable_that_slides_off_a_wheel_has_no_rest():
    """The search follows it far; a step is not looked at in strides of the wheel's size for ever."""
    b = Builder(dimension=2)
    b.cable([0, 0, 0], [1, 0, 0], 24)
    elements = CreateCompanionCables(b.mbs, b.made)
    ground = b.mbs.CreateGround(referencePosition=[0.3, -0.011, 0])
    add_frictionless_contact(b.mbs, elements, Circle(0.01, 2e3, 0.0, 0.0), ground)
    b.mbs.Assemble()
    with pytest.raises(EquilibriumError, match=r"it runs away|no stable equilibrium within reach"):
        SolveEquilibrium(b.mbs)


def held_wheel(b):
    """A body in the plane, each of whose coordinates a constraint holds."""
    body = b.mbs.CreateRigidBody(
        inertia=InertiaCuboid(200, [0.2, 0.2, 0.05]), referencePosition=[0.6, -0.3, 0], create2D=True
    )
    ground = b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=b.mbs.AddNode(NodePointGround()), coordinate=0))
    node = b.mbs.GetObject(body)["nodeNumber"]
    for k in range(3):
        marker = b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
        b.mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    return body


def on_a_wheel(wheel, is_general):
    """Nodes at rest (n, 4) of a clamped cable that lies on the body that `wheel` makes."""
    b = Builder(dimension=2)
    body, nodes = wheel(b), b.cable([0, 0, 0], [1, 0, 0], 24, clamped=["Start"])
    elements, circle = CreateCompanionCables(b.mbs, b.made), Circle(0.1, 2e3, 0.0, 0.0)
    if is_general:
        add_general_contact(b.mbs, elements, circle, b.on(body, rigid=True))
    else:
        add_frictionless_contact(b.mbs, elements, circle, body)
    b.mbs.Assemble()
    SolveEquilibrium(b.mbs)
    found = totals(b.mbs)
    return np.array([found[node] for node in nodes])


@pytest.mark.parametrize("is_general", [False, True])
def test_a_cable_lies_on_a_held_body_as_on_ground(is_general):
    """By contact objects, and by Exudyn's GeneralContact, whose law is softer."""
    on_body = on_a_wheel(held_wheel, is_general)
    on_ground = on_a_wheel(lambda b: b.mbs.CreateGround(referencePosition=[0.6, -0.3, 0]), is_general)
    np.testing.assert_allclose(on_body, on_ground, atol=1e-6)
    distances = np.linalg.norm(on_body[:, :2] - [0.6, -0.3], axis=1)
    nearest = on_body[np.argmin(distances)]
    assert 0.08 < distances.min() < 0.11 and nearest[1] > -0.3


def test_what_falls_slowly_beside_a_taut_cable_comes_to_rest():
    """An upright pendulum, whose negative stiffness is a thousandth of what the tension is over the mass."""
    b = Builder(dimension=2)
    nodes = b.cable([0, 0, 0], [1, 0, 0], pinned=["Start"])
    b.mbs.AddLoad(LoadForceVector(markerNumber=b.at(nodes[-1]), loadVector=[1e4, 0, 0]))
    inertia = InertiaCuboid(200, [0.2, 0.1, 0.05])
    body = b.mbs.CreateRigidBody(
        inertia=inertia, referencePosition=[2.001, 0.5, 0], gravity=b.gravity, create2D=True
    )
    pair = [b.on(b.ground, [2, 0, 0]), b.on(body, [-0.001, -0.5, 0])]
    b.mbs.AddObject(RevoluteJoint2D(markerNumbers=pair))
    b.mbs.Assemble()
    report = SolveEquilibrium(b.mbs)
    place = b.mbs.GetObjectOutputBody(body, exudyn.OutputVariableType.Position)
    np.testing.assert_allclose(place[:2], [2, -np.hypot(0.5, 0.001)], atol=1e-4)
    assert report["iterations"] < 60


def test_a_column_bows_as_little_as_a_stiff_spring_lets_it():
    """Straight it is unstable. Of the spring's force Euler's load is left: the tip sinks by s = e - N / k and
    bows by 4 sqrt(s) / pi."""
    b, stiffness, excess = Builder(dimension=2), 1e6, 5e-7
    nodes = b.cable([0, 0, 0], [1, 0, 0], clamped=["Start"], gravity=[0, 0, 0])
    pair = [b.on(b.ground, [1001, 0, 0]), b.at(nodes[-1])]
    spring = SpringDamper(markerNumbers=pair, stiffness=stiffness, referenceLength=1000 + excess)
    b.mbs.AddObject(spring)
    b.mbs.Assemble()
    SolveEquilibrium(b.mbs)
    sinks = excess - np.pi**2 * BENDING / 4 / stiffness
    bow = abs(b.mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Displacement)[1])
    np.testing.assert_allclose(bow, 4 * np.sqrt(sinks) / np.pi, rtol=0.01)


def test_a_moment_rolls_a_cantilever_up_to_a_circle():
    builder = Builder(dimension=2)
    nodes = builder.cable([0, 0, 0], [1, 0, 0], clamped=["Start"], gravity=[0, 0, 0])
    marker = builder.mbs.AddMarker(MarkerNodeRigid(nodeNumber=nodes[-1]))
    builder.mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 2.0 * np.pi * BENDING]))
    builder.mbs.Assemble()
    SolveEquilibrium(builder.mbs)
    found = totals(builder.mbs)
    np.testing.assert_allclose(found[nodes[-1]][:2], 0.0, atol=1e-4)
    np.testing.assert_allclose(found[nodes[8]][:2], [0.0, 1.0 / np.pi], atol=1e-4)


def hanging_ball():
    """A body that hangs by one point, free to turn about the vertical."""
    b = Builder()
    body = b.body([1.1, 0, 0])
    nodes = b.cable([0, 0, 0], [1, 0, 0], pinned=["Start"])
    b.tie(b.at(nodes[-1]), b.on(body, [-0.1, 0, 0]))
    return b, body


def test_what_is_free_to_turn_comes_to_rest_below():
    builder, body = hanging_ball()
    builder.mbs.Assemble()
    SolveEquilibrium(builder.mbs)
    position = builder.mbs.GetObjectOutputBody(body, exudyn.OutputVariableType.Position)
    np.testing.assert_allclose(position, [0, 0, -1.1], atol=1e-8)


def test_sensors_show_the_forces_of_joints():
    builder, body = hanging_ball()
    mbs = builder.mbs
    joints = [n for n in range(mbs.systemData.NumberOfObjects()) if "Joint" in mbs.GetObject(n)["objectType"]]
    mbs.Assemble()
    SolveEquilibrium(mbs)
    force = np.array(mbs.GetObjectOutput(joints[0], exudyn.OutputVariableType.Force))
    weight = 400 * 0.2 * 0.15 * 0.1 * 9.81
    np.testing.assert_allclose(np.linalg.norm(force), weight, rtol=1e-9)
    mass = mbs.GetObject(body)["mass"]
    np.testing.assert_allclose(mass * 9.81, weight)


def test_a_force_that_turns_with_the_end_and_makes_it_flutter_is_refused_at_once():
    """By the remedy it is found; a weak one has a rest, too."""

    def search(share, body_fixed=True):
        b = Builder(dimension=2)
        nodes = b.cable([0, 0, 0], [1, 0, 0], clamped=["Start"])
        end = b.mbs.AddMarker(MarkerNodeRigid(nodeNumber=nodes[-1]))
        force = [0.0, share * MASS * 9.81, 0.0]
        b.mbs.AddLoad(LoadForceVector(markerNumber=end, loadVector=force, bodyFixed=body_fixed))
        b.mbs.Assemble()
        return SolveEquilibrium(b.mbs)

    assert search(0.3)["smallestEigenvalue"] > 0.0
    with pytest.raises(EquilibriumError, match=r"vibrations grow .*put constant forces") as found:
        search(1.5)
    assert found.value.report["iterations"] < 60
    assert search(1.5, body_fixed=False)["success"]


def test_it_holds_after_a_new_assembly_and_an_equilibrium_needs_no_search():
    builder = built("platform")
    SolveEquilibrium(builder.mbs)
    before = totals(builder.mbs)
    builder.mbs.Assemble()
    assert SolveEquilibrium(builder.mbs)["iterations"] <= 2
    after = totals(builder.mbs)
    assert max(np.abs(after[n] - at).max() for n, at in before.items()) < 1e-9


@pytest.mark.parametrize("stretch", [{}, {"axialStiffness": 500.0}])
def test_a_ring_hangs_by_its_first_node_as_by_another_one(stretch):
    def lowest(first):
        """Place of the node opposite to the top; node `first` is at the right, on a spring."""
        turn = np.array([[0.0, -1.0], [1.0, 0.0]]) if first else np.eye(2)
        b = Builder(dimension=2)
        section = InextensibleCable(massPerLength=MASS, bendingStiffness=BENDING, **stretch)
        ring = CreateInextensibleCable(
            b.mbs,
            beamTemplate=section,
            shape=CableShape.Circle([0, 0], 0.5, 8),
            gravity=[*(turn.T @ [0, -9.81]), 0],
        )
        for node, anchor in ((first, [0.7, 0.6]), (first + 4, [-0.7, 0.6])):
            held = b.at(ring["nodes"][node % 8]), b.on(b.ground, [*(turn.T @ anchor), 0])
            b.mbs.AddObject(CartesianSpringDamper(markerNumbers=list(held), stiffness=[20, 20, 0]))
        b.mbs.Assemble()
        SolveEquilibrium(b.mbs)
        place = b.mbs.GetNodeOutput(ring["nodes"][(first + 6) % 8], exudyn.OutputVariableType.Position)
        return turn @ place[:2]

    np.testing.assert_allclose(lowest(0), lowest(6), atol=1e-8)


def test_a_body_that_nothing_holds_is_named_and_nothing_changes():
    builder = Builder()
    builder.cable([0, 0, 0], [1, 0, 0], pinned=["Start"])
    body = builder.body([0, 0, 1])
    other = builder.body([0, 0, 2])
    builder.tie(builder.on(body), builder.on(other))
    builder.mbs.Assemble()
    before = totals(builder.mbs)
    with pytest.raises(SceneError, match=r"nothing connects object \d+ .*RigidBody.* to the ground"):
        SolveEquilibrium(builder.mbs)
    assert all((totals(builder.mbs)[n] == at).all() for n, at in before.items())


def hung():
    """A planar cable of 1 m and 0.2 kg that hangs from a pin; its last node."""
    b = Builder(dimension=2)
    return b, b.cable([0, 0, 0], [0, -1, 0], elements=4, pinned=["Start"])[-1]


def test_elements_that_share_nodes_hold_each_other():
    """A native cable of EA = 300 N below the cable: it stretches by rho g l^2 / (2 EA)."""
    b, tip = hung()
    below = GenerateBeamElementsAlongLine(
        b.mbs,
        [0, -1, 0],
        [0, -1.6, 0],
        3,
        ObjectANCFCable2D(massPerLength=0.5, bendingStiffness=0.02, axialStiffness=300),
        gravity=b.gravity,
    )
    b.tie(b.at(tip), b.at(below["nodes"][0]))
    b.mbs.Assemble()
    SolveEquilibrium(b.mbs)
    y = b.mbs.GetNodeOutput(below["nodes"][-1], exudyn.OutputVariableType.Position)[1]
    assert y == pytest.approx(-1.6 - 0.5 * 9.81 * 0.6**2 / 600, abs=1e-9)


def test_a_stiffness_without_mass_ties_a_point_to_a_cable():
    b, tip = hung()
    point = b.mbs.CreateMassPoint(
        mass=0.3, referencePosition=[0, -1.2, 0], gravity=b.gravity, returnDict=True
    )
    stiffness = np.zeros((7, 7))  # of the displacements of the tip, and those of the point
    for i, j in ((0, 4), (1, 5)):
        stiffness[np.ix_([i, j], [i, j])] = [[40, -40], [-40, 40]]
    b.mbs.AddObject(ObjectGenericODE2(nodeNumbers=[tip, point["nodeNumber"]], stiffnessMatrix=stiffness))
    b.mbs.Assemble()
    SolveEquilibrium(b.mbs)
    y = b.mbs.GetNodeOutput(point["nodeNumber"], exudyn.OutputVariableType.Position)[1]
    assert y == pytest.approx(-1.2 - 0.3 * 9.81 / 40, abs=1e-9)


def test_a_load_that_follows_the_state_balances_a_cable():
    """A spring across the tip, as a user function of a load; the chain of 4 elements bends little."""
    b, tip = hung()
    kind = exudyn.OutputVariableType.Position
    marker = b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=tip, coordinate=0))
    b.mbs.AddLoad(
        LoadCoordinate(
            markerNumber=marker,
            loadUserFunction=lambda mbs, t, load: 20 * (0.5 - mbs.GetNodeOutput(tip, kind)[0]),
        )
    )
    b.mbs.Assemble()
    report = SolveEquilibrium(b.mbs)
    x = b.mbs.GetNodeOutput(tip, kind)[0]
    twin, end = hung()
    twin.mbs.AddLoad(LoadForceVector(markerNumber=twin.at(end), loadVector=[20 * (0.5 - x), 0, 0]))
    twin.mbs.Assemble()
    SolveEquilibrium(twin.mbs)
    assert twin.mbs.GetNodeOutput(end, kind)[0] == pytest.approx(x, abs=1e-8)
    assert report["iterations"] < 50


def test_coordinates_of_all_kinds_hold_after_a_new_assembly():
    b, _ = hung()
    node = b.mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0],
            initialCoordinates=[0],
            initialCoordinates_t=[0],
            numberOfODE2Coordinates=1,
        )
    )
    b.mbs.AddObject(
        ObjectGenericODE2(
            nodeNumbers=[node], massMatrix=np.eye(1), stiffnessMatrix=50 * np.eye(1), forceVector=[5]
        )
    )
    b.mbs.Assemble()
    SolveEquilibrium(b.mbs)
    b.mbs.Assemble()
    initial = exudyn.ConfigurationType.Initial
    place = b.mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates, configuration=initial)
    assert float(np.ravel(place)[0]) == pytest.approx(0.1, abs=1e-9)


def test_a_body_that_runs_away_leaves_the_mbs_as_it_was():
    builder = Builder(dimension=2)
    nodes = builder.cable([0, 0, 0], [1, 0, 0], pinned=["Start"])
    point = builder.mbs.CreateMassPoint(mass=1.0, referencePosition=[2, 0, 0], gravity=builder.gravity)
    ends = [builder.at(nodes[-1]), builder.on(point)]
    builder.mbs.AddObject(CartesianSpringDamper(markerNumbers=ends, stiffness=[5, 0, 5], damping=[0] * 3))
    builder.mbs.Assemble()
    before = totals(builder.mbs)
    node = builder.mbs.GetObject(point)["nodeNumber"]
    said = rf"the scene: .*after .* iterations .* largest at node {node} .*axialStiffness"
    with pytest.raises(EquilibriumError, match=said) as refusal:
        SolveEquilibrium(builder.mbs)
    assert refusal.value.report["success"] is False
    assert all((totals(builder.mbs)[n] == at).all() for n, at in before.items())


def test_a_cable_that_joints_hold_straight_is_named():
    """One that hangs is as straight, but its tension holds it."""
    b = Builder(dimension=2)
    hanging = b.cable([0, 0, 0], [0, -1, 0], elements=4, pinned=["Start"])
    b.tie(b.at(hanging[-1]), b.on(b.mbs.CreateMassPoint(mass=1.0, referencePosition=[0, -1, 0])))
    nodes = b.cable([1, 0, 0], [2, 0, 0], elements=4)
    b.tie(b.at(nodes[0]), b.on(b.ground, [1, 0, 0]))
    b.tie(b.at(nodes[-1]), b.on(b.ground, [2, 0, 0]))
    b.mbs.Assemble()
    there = "|".join(map(str, nodes))
    said = rf"largest at node ({there}) .*\): cable .* is straight between what holds its ends, .*let it sag"
    with pytest.raises(EquilibriumError, match=said):
        SolveEquilibrium(b.mbs)


@pytest.mark.parametrize("stretch", [None, 1e4])
def test_joints_out_of_reach_are_refused_and_the_remedy_works(stretch):
    """Two ropes of 1 m hold a body between grounds that are 2.1 m apart."""
    b = Builder(dimension=2)
    body = b.on(b.mbs.CreateMassPoint(mass=1.0, referencePosition=[1, 0, 0], create2D=True))
    rope = InextensibleCable(MASS, BENDING, axialStiffness=stretch)
    for x in (0.0, 2.0):
        way = dict(positionStart=[x, 0, 0], positionEnd=[1, 0, 0], numberOfElements=4)
        nodes = CreateInextensibleCable(b.mbs, **way, beamTemplate=rope, gravity=b.gravity)["nodes"]
        b.tie(b.at(nodes[0]), b.on(b.ground, [1.05 * x, 0, 0]))
        b.tie(b.at(nodes[-1]), body)
    b.mbs.Assemble()
    if stretch:
        SolveEquilibrium(b.mbs)
        return
    said = (
        r"the constraints cannot be met \(violation [0-9.]+\): bring .* or give the cables their axialStiff"
    )
    with pytest.raises(EquilibriumError, match=said):
        SolveEquilibrium(b.mbs)


def test_load_steps_are_refused_among_bodies():
    builder = built("swing")
    with pytest.raises(InputError, match=r"loadSteps = 3: among bodies.*set it to 1"):
        SolveEquilibrium(builder.mbs, staticSettings=StaticSettings(loadSteps=3))
    SolveEquilibrium(builder.mbs, staticSettings=StaticSettings(loadSteps=1))


@pytest.mark.parametrize("seed", [61, 139])
def test_errors_of_differences_of_stiff_cables_are_no_instability(monkeypatch, seed):
    """Bodies in these scenes may turn without any force."""
    monkeypatch.setitem(SECTION, "bendingStiffness", 0.44)
    monkeypatch.setitem(SECTION, "axialStiffness", 2e7)
    mbs = RandomScene(seed).mbs
    mbs.Assemble()
    assert abs(SolveEquilibrium(mbs)["smallestEigenvalue"]) < 1e-2


def hung_sheet(template):
    """Crossing cables of 0.2 m, welded to one sheet that hangs by one cable, about which it may turn."""
    b = Builder()
    line = {"numberOfElements": 4, "beamTemplate": template, "gravity": b.gravity, "dimension": 3}
    grid = [0.0, 0.1, 0.2]

    def nodes(start, end, **others):
        return CreateInextensibleCable(b.mbs, start, end, **line, **others)["nodes"]

    down = [nodes([x, 0, 0], [x, 0, -0.2]) for x in grid]
    across = [nodes([0, 0, -z], [0.2, 0, -z]) for z in grid]
    for i, j in product(range(3), repeat=2):
        b.tie(b.at(down[i][2 * j]), b.at(across[j][2 * i]))
    hanger = nodes([0.1, 0, 0.3], [0.1, 0, 0], groundConstraintsStart=[True] * 3 + [False] * 3)
    b.tie(b.at(hanger[-1]), b.at(down[1][0]))
    b.mbs.Assemble()
    return b.mbs, across[0]


def test_round_off_of_a_stiff_sheet_that_is_free_to_turn_is_no_instability():
    mbs, top = hung_sheet(
        InextensibleCable(massPerLength=0.05, bendingStiffness=0.01, axialStiffness=1e6),
    )
    assert abs(SolveEquilibrium(mbs)["smallestEigenvalue"]) < 1.0  # g / L is 30
    ends = [mbs.GetNodeOutput(top[k], exudyn.OutputVariableType.Position) for k in (0, -1)]
    np.testing.assert_allclose(ends[0][2], ends[1][2], atol=1e-6)


def test_a_body_by_angles_that_is_free_to_turn_below_a_cable_comes_to_rest():
    """Round-off of the forces, over its small inertia, is no instability."""
    b = Builder()
    section = InextensibleCable(massPerLength=0.3, bendingStiffness=2.0)
    end = np.array([0.9, 0.3, -0.2])
    pin = {"groundConstraintsStart": [True] * 3 + [False] * 3, "dimension": 3}
    nodes = CreateInextensibleCable(b.mbs, [0, 0, 0], [*end], 8, section, [0.5, 3, -9.81], **pin)["nodes"]
    body = b.mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.05, 0.08, 0.06]),
        referencePosition=(end + np.array([0.05, 0.02, 0])).tolist(),
        gravity=b.gravity,
        nodeType=exudyn.NodeType.RotationRxyz,
    )
    b.tie(b.at(nodes[-1]), b.on(body, [-0.05, -0.02, 0]))
    ends = [b.at(nodes[4]), b.on(b.ground, [0.6, 0.4, 0.5])]
    b.mbs.AddObject(SpringDamper(markerNumbers=ends, stiffness=30, referenceLength=0.5))
    b.mbs.Assemble()
    assert abs(SolveEquilibrium(b.mbs)["smallestEigenvalue"]) < 1e-3
    joint = np.array(b.mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position))
    centre = b.mbs.GetObjectOutputBody(body, exudyn.OutputVariableType.Position)
    np.testing.assert_allclose(centre - joint, [0, 0, -np.hypot(0.05, 0.02)], atol=1e-6)


def test_a_run_of_a_body_that_hangs_where_its_angles_lock_is_refused_and_the_remedy_works():
    """Below a rope that began along x: it was advised to give the body a mass, which it had."""
    for node in ("Rxyz", "EulerParameters"):
        b = Builder()
        nodes = b.cable([0, 0, 0], [1, 0, 0], 4, pinned=["Start"])
        b.tie(b.at(nodes[-1]), b.on(b.body([1.1, 0, 0], node), [-0.1, 0, 0]))
        b.mbs.Assemble()
        SolveEquilibrium(b.mbs)
        if node == "Rxyz":
            with pytest.raises(SceneError, match=r"second angle is a right one.*RotationEulerParameters\."):
                SolveExplicit(b.mbs, quiet_settings(0.01, 10))
    assert SolveExplicit(b.mbs, quiet_settings(0.01, 10))["success"]


@pytest.mark.parametrize("stiffness", [1e9, 1e10])
def test_round_off_hides_no_inverted_pendulum(stiffness):
    """Nor does it hide the way out, along which a stiff cable may not stretch."""
    b = Builder()
    template = InextensibleCable(massPerLength=0.3, bendingStiffness=0.1, axialStiffness=stiffness)
    pin = {"groundConstraintsStart": [True] * 3 + [False] * 3, "dimension": 3}
    cable = CreateInextensibleCable(b.mbs, [0, 0, 0], [0, 0, 1], 8, template, b.gravity, **pin)
    b.mbs.Assemble()
    SolveEquilibrium(b.mbs)
    tip = b.mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position)
    np.testing.assert_allclose(tip, [0.0, 0.0, -1.0], atol=1e-6)


def test_a_scene_far_from_the_origin_comes_to_rest_as_beside_it():
    def lowest(place):
        b = Builder()
        nodes = b.cable(place, [*(np.add(place, [0.8, 0.5, -0.2]))], elements=4, pinned=["Start"])
        b.mbs.Assemble()
        SolveEquilibrium(b.mbs)
        return b.mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position) - place

    np.testing.assert_allclose(lowest([300.0, -500.0, 200.0]), lowest([0.0, 0.0, 0.0]), atol=1e-7)


def test_a_bridge_on_flexible_cables_comes_to_rest_as_on_stiffer_ones():
    def found(stiffness):
        mbs = exudyn.SystemContainer().AddSystem()
        share = np.linspace(0.0, 1.0, 13)
        places = np.stack([60.0 * share, 10.0 - 32.0 * share * (1.0 - share)], axis=1)
        slopes = np.stack([np.full(13, 60.0), 32.0 * (2.0 * share - 1.0)], axis=1)
        line = CableShape.Line([0, 0], [60, 0], 12)
        shapes = [CableShape(places, slopes / np.linalg.norm(slopes, axis=1)[:, None]), line]
        sections = [(30.0, stiffness, 3e8), (200.0, 5e7, 1e9)]
        nodes = []
        for shape, (mass, bending, axial) in zip(shapes, sections, strict=True):
            section = InextensibleCable(massPerLength=mass, bendingStiffness=bending, axialStiffness=axial)
            held = {f"groundConstraints{end}": [True, True, False, False] for end in ("Start", "End")}
            cable = CreateInextensibleCable(
                mbs, shape=shape, beamTemplate=section, gravity=[0, -9.81, 0], dimension=2, **held
            )
            nodes.append(cable["nodes"])
        for above, below, place in list(zip(*nodes, places, strict=True))[1:-1]:
            markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (above, below)]
            mbs.AddObject(SpringDamper(markerNumbers=markers, stiffness=5e6, referenceLength=place[1]))
        mbs.Assemble()
        report = SolveEquilibrium(mbs)
        outputs = [mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position) for node in nodes[0]]
        return report["iterations"], np.array(outputs)

    few, stiffer = found(3e4)
    iterations, flexible = found(1e2)
    assert iterations <= 3 * few
    np.testing.assert_allclose(flexible, stiffer, atol=2e-3)


def test_a_slope_that_is_held_by_too_many_joints_is_refused_and_the_remedy_works():
    def found(held):
        mbs = exudyn.SystemContainer().AddSystem()
        template = InextensibleCable(massPerLength=0.5, bendingStiffness=1.0)
        pin = {"groundConstraintsStart": [True, True, False, False], "dimension": 2}
        nodes = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 8, template, [0, -9.81, 0], **pin)["nodes"]
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for name, value in held.items():
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=2 + "xy".index(name)))
            mbs.AddObject(
                CoordinateConstraint(
                    name=name,
                    markerNumbers=[ground, marker],
                    offsetUserFunction=lambda mbs, t, item, offset, value=value: value * (1.0 + t),
                )
            )
        mbs.Assemble()
        return SolveEquilibrium(mbs, staticSettings=StaticSettings(maxIterations=30))

    with pytest.raises(EquilibriumError, match=r"'x' \(ConnectorCoordinate\), equation 0, .* remove joints"):
        found({"x": 0.0, "y": 0.0})
    assert found({"y": 0.0})["success"]
