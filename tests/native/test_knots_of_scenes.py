"""Cables that meet in knots move as Exudyn's evaluation of their joints says, joint by joint."""

from dataclasses import replace
from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodePosition,
    SphericalJoint,
)
from exudyn.utilities import InertiaSphere

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    Rattle,
    SolveExplicit,
)
from exudyn_inext.multibody import build_joints
from reference_models.model import quiet_settings, silence

CABLE = InextensibleCable(massPerLength=0.2, bendingStiffness=0.002)
ELEMENTS = 4  # of each cable
SIDE, SAG = 0.25, 0.1  # of a mesh [m], of the net by its size
STEP, STEPS = 2e-4, 50
TOLERANCE = 1e-10  # of coordinates after all steps, relative to the extent of the scene
EXTENT = 0.5  # of the smallest one [m]: displacements, some cm, have the round-off of places


class Knots:
    """Cables between places, joined where they meet.

    Args:
        knot: (mbs, place) adds what else is tied to each knot, and returns its marker.
    """

    def __init__(self, dimension=3, knot=None):
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.dimension, self.knot = dimension, knot
        self.ground = self.mbs.CreateGround()
        self.ends = {}

    def lay(self, start, end):
        gravity = [0, 0, -9.81] if self.dimension == 3 else [0, -9.81, 0]
        cable = CreateInextensibleCable(
            self.mbs,
            shape=CableShape.Line(start, end, ELEMENTS),
            beamTemplate=CABLE,
            gravity=gravity,
            dimension=self.dimension,
        )
        self.ends.setdefault(start, []).append(cable["nodes"][0])
        self.ends.setdefault(end, []).append(cable["nodes"][-1])

    def join(self, held):
        """Tie what meets; some places are held by the ground."""
        mbs = self.mbs
        axes = [1] * self.dimension + [0] * (3 - self.dimension)
        for place, nodes in self.ends.items():
            markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes]
            if self.knot is not None:
                markers.insert(1, self.knot(mbs, place))
            if place in held:
                anchor = MarkerBodyPosition(bodyNumber=self.ground, localPosition=place)
                markers.insert(0, mbs.AddMarker(anchor))
            for k, marker in enumerate(markers[1:]):  # a chain of two, and a star from there on
                pair = [markers[min(k, 1)], marker]
                mbs.AddObject(SphericalJoint(markerNumbers=pair[:: 1 if k % 2 else -1], constrainedAxes=axes))
        return self


def net(meshes=3, knot=None):
    """Square meshes that sag between their corners."""

    def place(i, j):
        x, y = i / meshes, j / meshes
        return SIDE * i, SIDE * j, -4.0 * SAG * meshes * SIDE * (x * (1 - x) + y * (1 - y))

    knots = Knots(3, knot)
    for i, j in np.ndindex(meshes + 1, meshes + 1):
        if i < meshes:
            knots.lay(place(i, j), place(i + 1, j))
        if j < meshes:
            knots.lay(place(i, j), place(i, j + 1))
    return knots.join({place(i, j) for i in (0, meshes) for j in (0, meshes)})


def tree(dimension=2, knot=None):
    """A trunk from the ground that branches twice, bent in its plane."""
    knots = Knots(dimension, knot)
    for start, end in (((0, 0), (0.3, -0.1)), ((0.3, -0.1), (0.6, 0)), ((0.3, -0.1), (0.5, -0.4))):
        knots.lay((*start, 0.0), (*end, 0.0))
    for end in ((0.4, -0.7), (0.6, -0.7)):
        knots.lay((0.5, -0.4, 0.0), (*end, 0.0))
    return knots.join({(0.0, 0.0, 0.0)})


def mass_point(mbs, place):
    body = mbs.CreateMassPoint(mass=0.05, referencePosition=list(place))
    return mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))


def ball(mbs, place):
    """Held at a point off its centre."""
    inertia = InertiaSphere(0.05, 0.03)
    centre = [place[0], place[1] + 0.02, place[2] + 0.01]
    body = mbs.CreateRigidBody(inertia=inertia, referencePosition=centre)
    return mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[0.0, -0.02, -0.01]))


def moved(mbs, integrator, end=STEPS * STEP):
    """Coordinates, multipliers and the report."""
    mbs.Assemble()
    explicit = ExplicitSettings(integrator, stepSize=STEP)
    if integrator == "RATTLE":
        explicit = replace(explicit, massScaling=0.3, integrator=Rattle(tolerance=1e-13))
    with silence():
        report = SolveExplicit(mbs, quiet_settings(end, 2), explicit)
    data = mbs.systemData
    return np.array(data.GetODE2Coordinates()), np.array(data.GetAECoordinates()), report


def numbers_of_knots(monkeypatch):
    """Appended to at each build of joints."""
    found, build = [], build_joints.build_joints

    def count(*args):
        joints = build(*args)
        found.append(int((~joints.is_row).sum()))
        return joints

    monkeypatch.setattr("exudyn_inext.multibody.build.build_joints", count)
    return found


SCENES = {
    "net": (net, 12 * 3),
    "net with mass points": (partial(net, knot=mass_point), 12 * 3),
    "net with balls": (partial(net, 2, ball), 5 * 3),
    "planar tree": (tree, 2 * 2),
    "tree": (partial(tree, 3), 2 * 3),
}


CASES = [(scene, "RATTLE") for scene in SCENES]
CASES += [
    (scene, integrator) for scene in ("net with balls", "planar tree") for integrator in ("RK4", "Zhai")
]


@pytest.mark.parametrize(("scene", "integrator"), CASES)
def test_knots_move_as_exudyn_says(scene, integrator, by_exudyn, monkeypatch):
    build, number = SCENES[scene]
    theirs, their_forces, _ = moved(build().mbs, integrator)
    monkeypatch.undo()
    knots = numbers_of_knots(monkeypatch)
    ours, our_forces, report = moved(build().mbs, integrator)
    assert "in one compiled call" in report["path"]
    assert knots[0] == number
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=TOLERANCE * EXTENT)
    np.testing.assert_allclose(our_forces, their_forces, rtol=0, atol=1e-4 * np.abs(their_forces).max())


def swung(integrator, h):
    """Coordinates of a tree whose last twig a force swings, a function of time."""
    knots = tree(3)
    marker = knots.mbs.AddMarker(MarkerNodePosition(nodeNumber=knots.ends[0.6, -0.7, 0.0][0]))

    def force(mbs, t, load):
        return [0.0, 0.0, 0.3 * np.sin(20.0 * t)]

    knots.mbs.AddLoad(
        LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=force)
    )
    knots.mbs.Assemble()
    explicit = ExplicitSettings(integrator, stepSize=h)
    if integrator == "RATTLE":
        explicit = replace(explicit, integrator=Rattle(tolerance=1e-13))
    with silence():
        SolveExplicit(knots.mbs, quiet_settings(0.05, 1), explicit)
    return np.array(knots.mbs.systemData.GetODE2Coordinates())


@pytest.mark.parametrize(("integrator", "order"), [("RATTLE", 2), ("Zhai", 2), ("RK4", 4)])
def test_schemes_have_their_orders_among_knots(integrator, order):
    coarse, middle, fine = (swung(integrator, h) for h in (2e-4, 1e-4, 5e-5))
    observed = np.log2(np.abs(coarse - middle).max() / np.abs(middle - fine).max())
    assert abs(observed - order) < 0.2


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cable_in_two_pieces_that_stood_upright_comes_to_rest_hanging(new_mbs, solve, dimension):
    """Their slopes turn by 180 degrees: there was no rotation from the initial one to its opposite."""
    mbs, up = new_mbs(), np.eye(3)[dimension - 1]
    section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.05, bendingDamping=0.05)
    line = {"numberOfElements": 4, "beamTemplate": section, "gravity": -9.81 * up, "dimension": dimension}
    pin = {"groundConstraintsStart": [True] * dimension + [False] * dimension}
    lower = CreateInextensibleCable(mbs, [0, 0, 0], 0.5 * up, **line, **pin)["nodes"]
    tip = CreateInextensibleCable(mbs, 0.5 * up, up, **line, nodeNumberStart=lower[-1])["nodes"][-1]
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=tip))
    anchor = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround()))
    drag = [0.4] * dimension + [0.0] * (3 - dimension)
    mbs.AddObject(CartesianSpringDamper(markerNumbers=[anchor, marker], damping=drag))
    mbs.AddLoad(
        LoadForceVector(markerNumber=marker, loadVectorUserFunction=lambda mbs, t, f: [0.3 * (t < 0.3), 0, 0])
    )
    mbs.Assemble()
    solve(mbs, 20.0)
    np.testing.assert_allclose(mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Position), -up, atol=1e-6)
