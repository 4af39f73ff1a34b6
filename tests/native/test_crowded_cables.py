"""Cables with many joints, the nodes of which are unknowns, move as Exudyn says; costs are linear."""

from dataclasses import replace
from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    DistanceConstraint,
    MarkerBodyPosition,
    MarkerNodePosition,
    ObjectJointSpherical,
    SensorObject,
)

from exudyn_inext import (
    AddMarkerOnCable,
    CableShape,
    CreateCompanionCables,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    Rattle,
    SolveExplicit,
)
from exudyn_inext.errors import RedundantConstraintError
from exudyn_inext.multibody import build_joints
from exudyn_inext.multibody.build_nodes import MANY
from reference_models.model import quiet_settings, silence
from tests.items.attach.contact import Circle, add_contact

CABLE = InextensibleCable(massPerLength=0.2, bendingStiffness=0.02)
STEP, STEPS = 2e-4, 100
TOLERANCE = 1e-10  # of coordinates after all steps, relative to the extent of the scene
SIDE = 0.1  # between two nodes [m]


def bow(places):
    """The shape through places (n, 2), middles of its elements (n - 1, 3), and their arc lengths."""
    slopes = np.gradient(places, axis=0)
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    angles = np.linalg.norm(np.diff(slopes, axis=0), axis=1)
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1) * (1 + angles**2 / 24)
    middles = (places[1:] + places[:-1]) / 2 - lengths[:, None] / 8 * np.diff(slopes, axis=0)
    places, slopes, middles = (np.pad(some, ((0, 0), (0, 1))) for some in (places, slopes, middles))
    return CableShape(places, slopes, lengths), middles, np.cumsum(lengths) - lengths / 2


class Crowd:
    """A cable that hangs in a bow, and what is tied to its nodes and elements.   dimension: 2 or 3."""

    def __init__(self, joints, dimension=2, section=CABLE):
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.axes = [1] * dimension + [0] * (3 - dimension)
        x = np.linspace(-1, 1, joints + 3)
        self.places = np.column_stack([SIDE * np.arange(len(x)), 0.02 * len(x) * x**2])
        shape, self.middles, self.arcs = bow(self.places)
        gravity = [0, -9.81, 0]
        self.cable = CreateInextensibleCable(
            self.mbs, shape=shape, beamTemplate=section, gravity=gravity, dimension=dimension
        )
        self.ground = self.mbs.CreateGround()
        for node in (0, -1):
            self.tie(self.on_node(node), self.on_body(self.ground, self.place(node)))

    def place(self, k):
        return [*self.places[k], 0.0]

    def on_node(self, k):
        return self.mbs.AddMarker(MarkerNodePosition(nodeNumber=self.cable["nodes"][k]))

    def on_body(self, body, place=(0, 0, 0)):
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=list(place)))

    def tie(self, one, other):
        self.mbs.AddObject(ObjectJointSpherical(markerNumbers=[one, other], constrainedAxes=self.axes))

    def hang(self, below=(0, 0, 0)):
        """A mass point below a place."""
        at = np.add(below, [0, -0.05, 0])
        return self.mbs.CreateMassPoint(mass=0.02, referencePosition=list(at), gravity=[0, -9.81, 0])


def mass_points(joints=MANY, **cable):
    """At nodes, with two of them at one."""
    crowd = Crowd(joints, **cable)
    for k in [*range(1, joints + 1), 3]:
        body = crowd.mbs.CreateMassPoint(mass=0.02, referencePosition=crowd.place(k))
        crowd.tie(crowd.on_node(k), crowd.on_body(body))
    return crowd


def rods(joints=MANY, **cable):
    """From within elements to mass points, and between neighbours of these."""
    crowd = Crowd(joints, **cable)
    last = None
    for k in range(1, joints + 1):
        body = crowd.hang(crowd.middles[k])
        marker = AddMarkerOnCable(crowd.mbs, crowd.cable, float(crowd.arcs[k]))
        crowd.mbs.AddObject(DistanceConstraint(markerNumbers=[marker, crowd.on_body(body)], distance=0.05))
        if last is not None and k % 5 == 0:
            crowd.mbs.CreateDistanceConstraint(itemNumbers=[last, body])
        last = body
    return crowd


def droppers(joints=MANY, **cable):
    """Between two cables that run in opposite directions."""
    crowd = Crowd(joints, **cable)
    lower = CreateInextensibleCable(
        crowd.mbs, shape=bow(crowd.places[::-1] - [0, 0.3])[0], beamTemplate=CABLE, gravity=[0, -9.81, 0]
    )
    for k in range(1, joints + 1):
        pair = [crowd.cable["nodes"][k], lower["nodes"][-1 - k]]
        crowd.mbs.CreateDistanceConstraint(itemNumbers=pair)
    return crowd


SCENES = {
    "mass points": mass_points,
    "mass points in space": partial(mass_points, dimension=3),
    "long length constraints": partial(mass_points, section=replace(CABLE, numberOfLengthConstraints=13)),
    "rods": rods,
    "droppers": droppers,
}


def moved(mbs, integrator):
    """Coordinates, multipliers and the report."""
    mbs.Assemble()
    explicit = ExplicitSettings(integrator, stepSize=STEP)
    if integrator == "RATTLE":
        explicit = replace(explicit, massScaling=0.3, integrator=Rattle(tolerance=1e-13))
    with silence():
        report = SolveExplicit(mbs, quiet_settings(STEPS * STEP, 2), explicit)
    data = mbs.systemData
    return np.array(data.GetODE2Coordinates()), np.array(data.GetAECoordinates()), report


@pytest.fixture
def factors(monkeypatch):
    """Factors of joints that are built."""
    found, build = [], build_joints.build_joints

    def keep(*args):
        found.append(build(*args))
        return found[-1]

    monkeypatch.setattr("exudyn_inext.multibody.build.build_joints", keep)
    return found


CASES = [(scene, "RATTLE") for scene in SCENES if scene != "long length constraints"]  # there it diverges
CASES += [("mass points", "RK4"), ("long length constraints", "RK4"), ("droppers", "RK4")]
CASES += [("mass points in space", "Zhai"), ("long length constraints", "Zhai"), ("rods", "Zhai")]


@pytest.mark.parametrize(("scene", "integrator"), CASES)
def test_crowded_cables_move_as_exudyn_says(scene, integrator, by_exudyn, monkeypatch):
    crowd = SCENES[scene]()
    theirs, their_forces, _ = moved(crowd.mbs, integrator)
    monkeypatch.undo()
    ours, our_forces, report = moved(SCENES[scene]().mbs, integrator)
    assert "in one compiled call" in report["path"]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=TOLERANCE * np.ptp(crowd.places))
    np.testing.assert_allclose(our_forces, their_forces, rtol=0, atol=1e-4 * np.abs(their_forces).max())


@pytest.mark.parametrize("scene", ["mass points", "rods", "droppers"])
def test_the_factor_grows_with_the_number_of_joints(scene, factors):
    sizes = []
    for joints in (2 * MANY, 8 * MANY):
        moved_once(SCENES[scene](joints).mbs)
        assert len(factors[-1].nodes.place)
        sizes.append(len(factors[-1].factor.values))
    assert sizes[1] < 4.4 * sizes[0]


def moved_once(mbs):
    mbs.Assemble()
    with silence():
        SolveExplicit(mbs, quiet_settings(STEP, 1), ExplicitSettings(stepSize=STEP))


def test_cables_with_few_joints_keep_their_solve(factors):
    moved_once(mass_points(MANY // 4).mbs)
    assert not len(factors[-1].nodes.place)


def test_a_node_that_is_held_twice_is_named():
    crowd = mass_points()
    crowd.tie(crowd.on_node(5), crowd.on_body(crowd.ground, crowd.place(5)))
    crowd.tie(crowd.on_node(5), crowd.on_body(crowd.ground, crowd.place(5)))
    crowd.mbs.Assemble()
    with silence(), pytest.raises(RedundantConstraintError, match="equations 0, 1, are not independent"):
        SolveExplicit(crowd.mbs, quiet_settings(0.01, 10))


def test_the_support_of_a_crowded_cable_carries_it():
    """At the start it hangs straight down: its pin carries the weight of the cable and its 12 masses."""
    mbs = exudyn.SystemContainer().AddSystem()
    section, gravity = InextensibleCable(massPerLength=0.2, bendingStiffness=0.5), [0, -10, 0]
    pin = [True, True, False, False]
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [0, -1, 0], 12, section, gravity, pin)
    for node, place in zip(cable["nodes"][1:], cable["nodePositions"][1:], strict=True):
        mass = {"referencePosition": [place[0], place[1], 0], "mass": 0.1, "gravity": gravity}
        point = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateMassPoint(create2D=True, **mass)))
        pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)), point]
        mbs.AddObject(ObjectJointSpherical(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
    force = SensorObject(
        objectNumber=cable["constraintObjects"][1],
        outputVariableType=exudyn.OutputVariableType.Force,
        storeInternal=True,
    )
    sensor = mbs.AddSensor(force)
    mbs.Assemble()
    with silence():
        SolveExplicit(mbs, quiet_settings(0.01, 1))
    found = np.abs(mbs.GetSensorStoredData(sensor)[:, 1])
    np.testing.assert_allclose(found, 10 * (0.2 + 12 * 0.1), rtol=1e-6)


def test_a_crowded_cable_on_a_circle_moves_as_without_unknowns_of_its_nodes(monkeypatch):
    """Contact is in the matrix of its nodes, as in the cable's own solve."""
    found = []
    for many in (MANY, 10 * MANY):
        monkeypatch.setattr(build_joints, "MANY", many)
        crowd = mass_points()
        middle, radius = SIDE * (len(crowd.places) - 1) / 2, 0.5
        circle = crowd.mbs.CreateGround(referencePosition=[middle, 1e-3 - radius, 0])
        law = Circle(radius, 1e4, 20.0, 0.3, friction_damping=50.0)
        add_contact(crowd.mbs, CreateCompanionCables(crowd.mbs, crowd.cable), law, circle)
        q, _, report = moved(crowd.mbs, "RATTLE")
        assert "in one compiled call" in report["path"]
        assert (crowd.mbs.systemData.GetDataCoordinates() < 0.0).any()
        found.append(q)
    np.testing.assert_allclose(*found, rtol=0, atol=1e-8 * np.abs(found[0]).max())
