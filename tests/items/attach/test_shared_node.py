"""Cables that share nodes: against uncut cables, joints, and native cables that share nodes."""

from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePoint2DSlope1,
    NodePointGround,
    NodePointSlope1,
    ObjectANCFCable,
    ObjectANCFCable2D,
    SphericalJoint,
)

from exudyn_inext import (
    AddMarkerOnCable,
    AttachToBody,
    CableForces,
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SolveEquilibrium,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import SECTION, hang

CABLE = InextensibleCable(**SECTION)
STRETCHING = InextensibleCable(**SECTION, axialStiffness=1e3, bendingDamping=2e-3)
DIMENSIONS = [2, 3]
GRAVITY = {2: [0, -9.81, 0], 3: [0, -7.0, -6.0]}
HALF, LENGTH, STEP = 4, 1.0, 5e-4  # elements and length of each half of the cut cable [m], step [s]
FINER = 2  # native elements in one of ours
_POSITION = exudyn.OutputVariableType.Position


def pin(dimension):
    return [True] * dimension + [False] * dimension


def straight(mbs, start, end, elements=HALF, dimension=2, **options):
    """A cable under gravity."""
    line = {"positionStart": start, "positionEnd": end, "numberOfElements": elements}
    gravity = GRAVITY.get(dimension, [0, 0, 0])
    arguments = {"beamTemplate": CABLE, "gravity": gravity, "dimension": dimension}
    return CreateInextensibleCable(mbs, **(line | arguments | options))


def pendulum(mbs, is_cut, dimension, section=CABLE, **options):
    """(cables, nodes) of a pendulum of 2 m, in one or two pieces.   options: of the second one."""
    first = {"groundConstraintsStart": pin(dimension), "dimension": dimension, "beamTemplate": section}
    options = {"beamTemplate": section} | options
    if not is_cut:
        cable = straight(mbs, [0, 0, 0], [2 * LENGTH, 0, 0], 2 * HALF, **first)
        return [cable], cable["nodes"]
    one = straight(mbs, [0, 0, 0], [LENGTH, 0, 0], **first)
    node = one["nodes"][-1]
    middle, end = [LENGTH, 0, 0], [2 * LENGTH, 0, 0]
    other = straight(mbs, middle, end, dimension=dimension, nodeNumberStart=node, **options)
    assert int(other["nodes"][0]) == int(node)
    return [one, other], [*one["nodes"], *other["nodes"][1:]]


def places(mbs, nodes):
    return np.array([mbs.GetNodeOutput(node, _POSITION) for node in nodes])


def coordinates_of(mbs, node):
    """(2 dim,) in total."""
    shown = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates)
    return np.add(shown, mbs.GetNodeParameter(node, "referenceCoordinates"))


def moved_whole_and_cut(new_mbs, solve, dimension, section=CABLE):
    """Places of the nodes of both pendulums after 1 s; report, cables and nodes of the one that is cut."""
    found = []
    for is_cut in (False, True):
        mbs = new_mbs()
        cables, nodes = pendulum(mbs, is_cut, dimension, section)
        mbs.Assemble()
        report = solve(mbs, 1.0, steps=100, stepSize=STEP, massScaling=0.3)
        found.append(places(mbs, nodes))
    return found, report, mbs, cables, nodes


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_a_cable_that_is_cut_at_a_shared_node_moves_as_the_uncut_one(new_mbs, solve, dimension):
    found, report, mbs, cables, nodes = moved_whole_and_cut(new_mbs, solve, dimension)
    assert "in one compiled call" in report["path"]
    np.testing.assert_allclose(found[1], found[0], atol=1e-10)
    own = mbs.GetObject(cables[1]["elements"][0])["nodeNumbers"][0]
    apart = coordinates_of(mbs, own) - coordinates_of(mbs, nodes[HALF])
    assert int(own) != int(nodes[HALF]) and np.abs(apart).max() < 1e-9
    assert found[0][-1][0] < -1.0  # it has swung through, and the slopes have turned round


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_so_does_one_that_stretches_and_is_damped(new_mbs, solve, dimension):
    found, *_ = moved_whole_and_cut(new_mbs, solve, dimension, STRETCHING)
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)
    assert found[0][-1][0] < -0.5


@pytest.mark.parametrize("integrator", ["RATTLE", "RK4", "Zhai"])
def test_exudyn_says_the_same_of_the_motion(new_mbs, solve, monkeypatch, integrator, by_exudyn):
    """A free branched cable that turns quickly in space."""
    found = []
    for _ in range(2):
        mbs = new_mbs()
        turn = np.cross([1.0, 2.0, 3.0], np.eye(3)).T
        trunk = CableShape.Line([0, 0, 0], [1, 0, 0], 2, velocityEnd=turn @ [1, 0, 0])
        trunk = CreateInextensibleCable(mbs, shape=trunk, beamTemplate=CABLE)
        for number in (2, 1):
            twig = CableShape.Line(
                [1, 0, 0], [1.0 + number, 0, 0], 2, turn @ [1, 0, 0], turn @ [1.0 + number, 0, 0]
            )
            CreateInextensibleCable(mbs, shape=twig, beamTemplate=CABLE, nodeNumberStart=trunk["nodes"][-1])
        mbs.Assemble()
        report = solve(mbs, 0.05, stepSize=2e-4, integrator=integrator)
        found.append(np.array(mbs.systemData.GetODE2Coordinates()))
        monkeypatch.undo()
    assert "in one compiled call" in report["path"]
    assert np.abs(found[1]).max() > 0.1
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_a_shared_position_is_a_spherical_joint(new_mbs, solve, dimension):
    """Three cables at an inner node of a fourth one."""
    found = []
    for is_shared in (True, False):
        mbs = new_mbs()
        cables, nodes = pendulum(mbs, False, dimension)
        middle = nodes[HALF]
        for end in ([1.5, -0.8, 0], [1.0, -1.0, 0]):
            options = {"nodeNumberStart": middle, "shareSlopeStart": False} if is_shared else {}
            cable = straight(mbs, [LENGTH, 0, 0], end, dimension=dimension, **options)
            assert int(cable["nodes"][0]) != int(middle)
            cables.append(cable)
            if not is_shared:
                pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (middle, cable["nodes"][0])]
                axes = [1, 1, dimension - 2]
                mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=axes))
        mbs.Assemble()
        report = solve(mbs, 0.3, stepSize=STEP)
        assert "in one compiled call" in report["path"]
        found.append(np.concatenate([places(mbs, cable["nodes"]) for cable in cables]))
    np.testing.assert_array_equal(*found)


def force(mbs, node, dimension):
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0.2, 0.3, 0.0]))


def support(*coordinates):
    def hold(mbs, node, dimension):
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for kind in coordinates:
            for k in range(kind * dimension, (kind + 1) * dimension):
                marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
                mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))

    return hold


def hanger(mbs, node, dimension):
    hang(mbs, node, [LENGTH, 0.5, 0.0], 0.5)


ACTIONS = {"force": force, "pin": support(0), "clamp": support(0, 1), "hanger": hanger}


CASES = [(action, dimension) for action in ACTIONS for dimension in DIMENSIONS]
CASES.remove(("hanger", 3))  # for the time that kernels take to compile


@pytest.mark.parametrize(("action", "dimension"), CASES)
def test_what_acts_on_a_shared_node_acts_once(new_mbs, solve, action, dimension):
    """On a cable of three pieces, two of which share a node of the first one, and on its uncut twin."""
    found = []
    for is_cut in (False, True):
        mbs = new_mbs()
        if is_cut:
            one = straight(mbs, [0, 0, 0], [LENGTH, 0, 0], dimension=dimension)
            node = one["nodes"][-1]
            options = {"dimension": dimension, "nodeNumberStart": node}
            other = straight(mbs, [LENGTH, 0, 0], [2 * LENGTH, 0, 0], **options)
            nodes = [*one["nodes"], *other["nodes"][1:]]
        else:
            nodes = straight(mbs, [0, 0, 0], [2 * LENGTH, 0, 0], 2 * HALF, dimension=dimension)["nodes"]
            node = nodes[HALF]
        side = {"dimension": dimension, "nodeNumberStart": node, "shareSlopeStart": False}
        twig = straight(mbs, [LENGTH, 0, 0], [LENGTH, -LENGTH, 0], **side)
        ACTIONS[action](mbs, node, dimension)
        mbs.Assemble()
        report = solve(mbs, 0.3, stepSize=STEP, massScaling=0.3)
        assert "in one compiled call" in report["path"]
        found.append(places(mbs, [*nodes, *twig["nodes"]]))
    assert np.ptp(found[0][:, 1]) > 0.5
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)


def tree(dimension, elements):
    """Positions and slopes of a trunk and two twigs that leave its end to either side, 1 and 0.8 m long."""
    x = np.linspace(0.0, 1.0, elements + 1)
    trunk = np.stack([x, 0.0 * x, 0.0 * x], axis=1), np.tile([1.0, 0.0, 0.0], (len(x), 1))
    angle = np.linspace(0.0, 0.8, elements + 1)
    twigs = []
    for side in (1.0, -1.0):
        out = np.array([0.0, side, 0.0] if dimension == 2 else [0.0, 0.6 * side, 0.8])
        sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
        twigs.append(
            ([1.0, 0, 0] + sine * [1.0, 0, 0] + (1 - cosine) * out, cosine * [1.0, 0, 0] + sine * out)
        )
    return [trunk, *twigs]


def native_elements(mbs, dimension, positions, slopes, length, first=None):
    """Nodes of native elements along a curve of that length [m], the first one of which may be given."""
    kind = NodePoint2DSlope1 if dimension == 2 else NodePointSlope1
    nodes = [] if first is None else [first]
    for q in np.concatenate([positions[:, :dimension], slopes[:, :dimension]], axis=1)[len(nodes) :]:
        nodes.append(mbs.AddNode(kind(referenceCoordinates=q.tolist())))
    element = ObjectANCFCable2D if dimension == 2 else ObjectANCFCable
    for pair in pairwise(nodes):
        own = length / (len(nodes) - 1)
        cable = element(nodeNumbers=list(pair), length=own, axialStiffness=8e4, **SECTION)
        marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=mbs.AddObject(cable)))
        mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=GRAVITY[dimension]))
    return nodes


def compare_with_native(mbs, ours, native, theirs, solve):
    """Motions over 0.3 s, line by line, of nodes with the same places at the start."""
    mbs.Assemble()
    native.Assemble()
    ours, theirs = np.concatenate(ours), np.concatenate([line[::FINER] for line in theirs])
    start = places(mbs, ours)
    np.testing.assert_allclose(places(native, theirs), start, atol=1e-12)
    report = solve(mbs, 0.3)
    assert "in one compiled call" in report["path"]
    settings = quiet_settings(0.3, 300)
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    with silence():
        native.SolveDynamic(settings)
    expected = places(native, theirs)
    np.testing.assert_allclose(places(mbs, ours), expected, atol=0.01 * np.abs(expected - start).max())


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_a_branched_cable_moves_as_native_elements_that_share_a_node(new_mbs, solve, dimension):
    mbs, native = new_mbs(), new_mbs()
    trunk, *twigs = tree(dimension, HALF)
    arguments = {"beamTemplate": CABLE, "gravity": GRAVITY[dimension], "dimension": dimension}
    pinned = {"groundConstraintsStart": pin(dimension)}
    ours = [CreateInextensibleCable(mbs, shape=CableShape(*trunk), **arguments, **pinned)["nodes"]]
    for twig in twigs:
        made = CreateInextensibleCable(mbs, shape=CableShape(*twig), nodeNumberStart=ours[0][-1], **arguments)
        ours.append(made["nodes"])
    trunk, *twigs = tree(dimension, FINER * HALF)
    theirs = [native_elements(native, dimension, *trunk, 1.0)]
    theirs += [native_elements(native, dimension, *twig, 0.8, first=theirs[0][-1]) for twig in twigs]
    support(0)(native, theirs[0][0], dimension)
    compare_with_native(mbs, ours, native, theirs, solve)


LINES = 3


def net(dimension):
    """(start, end) of all lines, those along x first."""
    along_x = [([0, -y, 0], [LINES - 1, -y, 0]) for y in range(LINES)]
    return along_x + [([x, 0, 0], [x, 1 - LINES, 0]) for x in range(LINES)]


def net_of_pieces(mbs, dimension):
    """Nodes of all lines, which are cut at each crossing; there, the pieces share positions only."""
    lines, at = [], {}
    for start, end in net(dimension):
        crossings = np.linspace(start, end, LINES)
        nodes = []
        for one, other in pairwise(crossings):
            options = {"shareSlopeEnd": False, "nodeNumberEnd": at.get(tuple(other))}
            if nodes:
                options["nodeNumberStart"] = nodes[-1]
            else:
                options |= {"nodeNumberStart": at.get(tuple(one)), "shareSlopeStart": False}
            if not lines and not nodes:
                options["groundConstraintsStart"] = pin(dimension)
            piece = straight(mbs, one, other, dimension=dimension, **options)["nodes"]
            nodes += piece[1:] if nodes else piece
        lines.append(nodes)
        for crossing, node in zip(crossings, nodes[::HALF], strict=True):
            at.setdefault(tuple(crossing), node)
    return lines


def native_net(mbs, dimension):
    lines, at = [], {}
    for start, end in net(dimension):
        positions = np.linspace(start, end, (LINES - 1) * FINER * HALF + 1)
        slopes = np.tile((np.array(end) - start) / (LINES - 1.0), (len(positions), 1))
        nodes = native_elements(mbs, dimension, positions, slopes, LINES - 1.0)
        lines.append(nodes)
        for crossing, node in zip(*(x[:: FINER * HALF] for x in (positions, nodes)), strict=True):
            other = at.setdefault(tuple(crossing), node)
            if other is not node:
                pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (other, node)]
                axes = [1, 1, dimension - 2]
                mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=axes))
    support(0)(mbs, lines[0][0], dimension)
    return lines


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_a_net_moves_as_native_elements_that_share_nodes(new_mbs, solve, dimension):
    mbs, native = new_mbs(), new_mbs()
    ours, theirs = net_of_pieces(mbs, dimension), native_net(native, dimension)
    compare_with_native(mbs, ours, native, theirs, solve)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_native_implicit_solvers_take_shared_nodes(new_mbs, dimension):
    found = []
    for is_cut in (False, True):
        mbs = new_mbs()
        straight_to = {"enforcement": "algebraic", "dimension": dimension}
        one = straight(mbs, [0, 0, 0], [(2 - is_cut) * LENGTH, 0, 0], (2 - is_cut) * HALF, **straight_to)
        nodes = one["nodes"]
        if is_cut:
            options = straight_to | {"nodeNumberStart": nodes[-1]}
            nodes = [*nodes, *straight(mbs, [LENGTH, 0, 0], [2 * LENGTH, 0, 0], **options)["nodes"][1:]]
        support(0)(mbs, nodes[HALF], dimension)
        mbs.Assemble()
        settings = quiet_settings(0.1, 100)
        settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        settings.timeIntegration.newton.useModifiedNewton = True
        with silence():
            mbs.SolveDynamic(settings)
        found.append(places(mbs, nodes))
    assert np.ptp(found[0][:, 1]) > 0.02
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_what_else_a_cable_takes_does_not_see_the_cut(new_mbs, solve, dimension):
    """Equilibrium, section forces, forces in a stepper, markers, and velocities of its nodes."""
    found = []
    for is_cut in (False, True):
        mbs = new_mbs()
        cables, nodes = pendulum(mbs, is_cut, dimension)
        last, along = cables[-1], LENGTH if is_cut else 0.0
        marker = AddMarkerOnCable(mbs, last, 1.3 * LENGTH - along)
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0.1, 0, 0]))
        mbs.Assemble()
        SolveEquilibrium(mbs)
        rest = places(mbs, nodes)
        for node in nodes:
            q = np.add(
                *(mbs.GetNodeParameter(node, f"{name}Coordinates") for name in ("reference", "initial"))
            )
            spin = np.zeros((2, dimension))
            spin[:, 0], spin[:, 1] = -2.0 * q[1::dimension], 2.0 * q[::dimension]
            mbs.SetNodeParameter(node, "initialVelocities", spin.ravel().tolist())
        mbs.Assemble()
        solve(mbs, 0.1, stepSize=STEP)
        forces = CableForces(mbs, last, LENGTH * np.array([1.1, 1.5, 2.0]) - along)
        moved = places(mbs, nodes)
        stepper = ExplicitStepper(mbs, ExplicitSettings(stepSize=STEP))
        stepper.Start()
        stepper.SetNodeForce(nodes[HALF], [0.5, 0.0, 0.0])
        stepper.Step(100)
        stepper.WriteToSystem()
        section = np.stack([forces[name] for name in ("tension", "bendingMoment", "arcLength")], axis=1)
        section[:, 2] += along
        found.append(np.concatenate([rest, moved, places(mbs, nodes), section]))
    assert np.abs(rest - moved).max() > 0.1
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)


@pytest.mark.parametrize("share_slope", [False, True])
def test_both_ends_of_a_cable_may_share_one_node(new_mbs, solve, share_slope):
    """A sling at the end of a pendulum keeps its length."""
    mbs = new_mbs()
    _, nodes = pendulum(mbs, False, 2)
    angle = np.linspace(-0.5 * np.pi, 1.5 * np.pi, 13)[:, None]
    sling = CableShape(
        [2 * LENGTH, 0.3, 0] + 0.3 * (np.cos(angle) * [1, 0, 0] + np.sin(angle) * [0, 1, 0]),
        -np.sin(angle) * [1, 0, 0] + np.cos(angle) * [0, 1, 0],
    )
    ends = {"nodeNumberStart": nodes[-1], "nodeNumberEnd": nodes[-1]}
    ends |= {"shareSlopeStart": share_slope, "shareSlopeEnd": share_slope}
    cable = CreateInextensibleCable(mbs, shape=sling, beamTemplate=CABLE, gravity=GRAVITY[2], **ends)
    mbs.Assemble()
    report = solve(mbs, 0.2)
    assert "in one compiled call" in report["path"]
    own = mbs.GetObject(cable["elements"][0])["nodeNumbers"]
    node, start, end = (coordinates_of(mbs, node) for node in (nodes[-1], own[0], own[-1]))
    count = 4 if share_slope else 2
    assert np.abs([node - start, node - end])[:, :count].max() < 1e-9
    assert report["drift"]["constraints"] < 1e-9


def test_a_body_is_attached_where_a_node_is_shared(new_mbs, solve):
    found = []
    for is_cut in (False, True):
        mbs = new_mbs()
        cables, nodes = pendulum(mbs, is_cut, 2)
        body = mbs.CreateMassPoint(mass=0.1, referencePosition=[LENGTH, 0, 0], gravity=GRAVITY[2])
        if is_cut:
            AttachToBody(mbs, cables[1], "start", body)
        else:
            pair = (
                mbs.AddMarker(MarkerBodyPosition(bodyNumber=body)),
                mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[HALF])),
            )
            mbs.AddObject(SphericalJoint(markerNumbers=list(pair), constrainedAxes=[1, 1, 0]))
        mbs.Assemble()
        solve(mbs, 0.2, stepSize=STEP)
        found.append(places(mbs, nodes))
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)


def test_a_cable_that_shares_a_node_with_one_in_space_lies_in_space(new_mbs):
    mbs = new_mbs()
    node = straight(mbs, [0, 0, 0], [1, 0, 0], dimension=3)["nodes"][-1]
    for x in (1, 2):
        cable = straight(mbs, [x, 0, 0], [x + 1, 0, 0], dimension=None, nodeNumberStart=node)
        node = cable["nodes"][-1]
    assert mbs.GetNode(node)["nodeType"] == "PointSlope1"


def spinning(mbs, is_cut):
    """Nodes of a free cable that turns about an axis that is nearly z, by 10 rad/s."""
    turn = np.cross([0.01, 0.02, 10.0], np.eye(3)).T
    nodes = []
    for x in range(2 if is_cut else 1):
        ends = np.array([[x, 0.0, 0.0], [x + 1.0 if is_cut else 2.0, 0.0, 0.0]]) * LENGTH
        line = CableShape.Line(*ends, HALF if is_cut else 2 * HALF, *(ends @ turn.T))
        shared = {"nodeNumberStart": nodes[-1] if nodes else None}
        made = CreateInextensibleCable(mbs, shape=line, beamTemplate=CABLE, gravity=GRAVITY[3], **shared)
        nodes += made["nodes"][x:]
    return nodes


def test_slopes_may_turn_round(new_mbs, solve):
    """Against the initial ones, where the equation for the slopes has no value."""
    found = []
    for is_cut in (False, True):
        mbs = new_mbs()
        nodes = spinning(mbs, is_cut)
        mbs.Assemble()
        report = solve(mbs, 0.7, steps=70, stepSize=STEP, massScaling=0.3)
        found.append(places(mbs, nodes))
    assert report["rejections"] == 0
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)


def test_a_branch_that_is_released_falls_freely(new_mbs, solve, centre_of_mass):
    mbs = new_mbs()
    cables, nodes = pendulum(mbs, True, 2)
    twig = cables[1]
    own = [int(node) for node in mbs.GetObject(twig["elements"][0])["nodeNumbers"]]
    seen = {}

    def release(mbs, t):
        q = np.array([coordinates_of(mbs, node) for node in own]).reshape(-1, 2, 2)
        seen[round(t, 9)] = centre_of_mass(q, LENGTH / HALF)
        for joint in twig["constraintObjects"]:
            mbs.SetObjectParameter(joint, "activeConnector", t < 0.1005)
        return True

    mbs.SetPreStepUserFunction(release)
    mbs.Assemble()
    solve(mbs, 0.3, steps=300, stepSize=STEP)
    places_of_centre = [seen[t] for t in (0.12, 0.2, 0.28)]
    acceleration = np.diff(places_of_centre, 2, axis=0)[0] / 0.08**2
    np.testing.assert_allclose(acceleration, GRAVITY[2][:2], atol=1e-6)
    apart = coordinates_of(mbs, own[0]) - coordinates_of(mbs, nodes[HALF])
    assert np.abs(apart).max() > 0.01
