"""Every kind of item that has a compiled form moves as Exudyn's own evaluation of it says."""

from dataclasses import replace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    CoordinateSpringDamper,
    CoordinateSpringDamperExt,
    CoordinateVectorConstraint,
    DistanceConstraint,
    GenericJoint,
    LoadCoordinate,
    LoadForceVector,
    LoadMassProportional,
    LoadTorqueVector,
    MarkerBodyCable2DShape,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerKinematicTreeRigid,
    MarkerNodeCoordinate,
    MarkerNodeCoordinates,
    MarkerNodePosition,
    MarkerNodeRigid,
    MarkerNodeRotationCoordinate,
    Node1D,
    NodeGenericData,
    NodeGenericODE1,
    NodeGenericODE2,
    NodePoint,
    NodePoint2D,
    NodePointGround,
    NodeRigidBody2D,
    ObjectContactCircleCable2D,
    ObjectContactFrictionCircleCable2D,
    ObjectGenericODE1,
    ObjectGenericODE2,
    ObjectJointRollingDisc,
    ObjectKinematicTree,
    ObjectMass1D,
    ObjectMassPoint,
    ObjectRigidBody2D,
    ObjectRotationalMass1D,
    PrismaticJoint2D,
    RevoluteJoint2D,
    RigidBodySpringDamper,
    SphericalJoint,
    SpringDamper,
    TorsionalSpringDamper,
)
from exudyn.utilities import InertiaCuboid, RotationMatrixZ, RotXYZ2RotationMatrix
from hypothesis import given, settings
from hypothesis import strategies as st

from exudyn_inext import (
    AddMarkerOnCable,
    AttachToBody,
    CreateCompanionCables,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    Rattle,
    SolveExplicit,
)
from exudyn_inext.errors import SceneError
from exudyn_inext.native.coupled_scene import CoupledScene
from exudyn_inext.native.friction_check import FrictionCheck
from exudyn_inext.native.known import scene
from exudyn_inext.native.known.connectors import read_connector
from exudyn_inext.run.moved_by_kernels import MovedByKernels
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import COARSE, that_remembers

STEP, STEPS = 5e-5, 50
SEGMENTS = 3  # of an element in contact
TOLERANCE = 1e-10  # of coordinates after all steps, relative to the largest one
OF_JOINTS = 1e-9  # with joints, whose second derivatives Exudyn's side finds by differences
OFF_UNITY = {"RATTLE": 3e-9, "RK4": 5e-8, "Zhai": 3e-6}  # where quaternions are not quite of unit norm
pytestmark = [
    pytest.mark.filterwarnings(
        "ignore:.*velocit", "ignore:.*rotationMarker.*deprecated", "ignore:.*the energy has grown"
    ),
    COARSE,
]
every_integrator = pytest.mark.parametrize(
    ("integrator", "dimension"), [("RATTLE", 2), ("RATTLE", 3), ("RK4", 3), ("Zhai", 2)]
)


class Builder:
    """A cable and bodies around it, at random places, to which an item is added.

    cable: what CreateInextensibleCable returned.   bodies: numbers of objects.   nodes: of these.
    """

    def __init__(self, seed: int, dimension: int) -> None:
        self.random = np.random.default_rng(seed)
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.dimension = dimension
        self.ground = self.mbs.CreateGround(
            referencePosition=[0.2, 0.4, 0.0], referenceRotationMatrix=RotationMatrixZ(0.3)
        )
        self.cable = CreateInextensibleCable(
            self.mbs,
            beamTemplate=InextensibleCable(massPerLength=0.2, bendingStiffness=0.01),
            positionStart=[0, 0, 0],
            positionEnd=[1.2, 0, 0],
            numberOfElements=4,
            gravity=[0, -9.81, 0],
            groundConstraintsStart=[True] * dimension + [False] * dimension,
            dimension=dimension,
        )
        self.bodies, self.nodes = [], []
        for _ in range(2):
            number, node = self._planar_body() if dimension == 2 else self._body()
            self.bodies.append(number)
            self.nodes.append(node)

    def vector(self, size=1.0):
        values = size * self.random.uniform(-1.0, 1.0, 3)
        values[self.dimension :] = 0.0
        return values

    def _planar_body(self):
        node = self.mbs.AddNode(
            NodeRigidBody2D(
                referenceCoordinates=[*self.vector()[:2], self.random.uniform(-1, 1)],
                initialVelocities=[*self.vector()[:2], 1.0],
            )
        )
        offset = self.vector(0.05)[:2]
        body = ObjectRigidBody2D(nodeNumber=node, mass=0.3, inertia=0.01, centerOfMass=offset)
        return self.mbs.AddObject(body), node

    def _body(self):
        kinds = exudyn.NodeType.RotationEulerParameters, exudyn.NodeType.RotationRxyz
        inertia = InertiaCuboid(300, [0.1, 0.15, 0.07]).Translated(self.vector(0.05))
        made = self.mbs.CreateRigidBody(
            inertia=inertia,
            nodeType=kinds[len(self.bodies)],
            referencePosition=self.vector(),
            referenceRotationMatrix=RotXYZ2RotationMatrix(self.vector()),
            initialVelocity=self.vector(),
            initialAngularVelocity=self.vector(2.0),
            returnDict=True,
        )
        return made["bodyNumber"], made["nodeNumber"]

    def rigid(self, which, local=None):
        """A marker with a frame on a body or, for None, on the ground; at a random place it is turned."""
        body = self.ground if which is None else self.bodies[which]
        if local is not None:
            return self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=local))
        turn = RotationMatrixZ(0.4) if self.dimension == 2 else RotXYZ2RotationMatrix(self.vector())
        frame = exudyn.HT(rotation=turn, translation=self.vector(0.1))
        return self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localHT=frame))

    def position(self, which):
        body = self.ground if which is None else self.bodies[which]
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=self.vector(0.1)))

    def on_cable(self, **options):
        return AddMarkerOnCable(self.mbs, self.cable, float(self.random.uniform(0.1, 1.2)), **options)

    def coordinate(self, node, which):
        return self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=which))

    def angle(self, which, axis):
        marker = MarkerNodeRotationCoordinate(nodeNumber=self.nodes[which], rotationCoordinate=axis)
        return self.mbs.AddMarker(marker)

    def place(self, number):
        """Reference position of a body, and its frame."""
        kinds = exudyn.OutputVariableType.Position, exudyn.OutputVariableType.RotationMatrix
        configuration = exudyn.ConfigurationType.Reference
        position, frame = (
            self.mbs.GetObjectOutputBody(number, kind, [0, 0, 0], configuration) for kind in kinds
        )
        return np.array(position), np.array(frame).reshape(3, 3)


def spring(b):
    pairs = [(b.position(0), b.position(1)), (b.on_cable(), b.position(0)), (b.position(None), b.on_cable())]
    for pair in pairs:
        b.mbs.AddObject(
            SpringDamper(markerNumbers=list(pair), stiffness=40, damping=0.3, referenceLength=0.4, force=0.7)
        )


def cartesian_spring(b):
    for pair in [(b.position(0), b.position(1)), (b.on_cable(), b.position(1))]:
        options = {"stiffness": [40, 30, 20], "damping": [0.3, 0.2, 0.1], "offset": [0.1, 0.2, 0]}
        b.mbs.AddObject(CartesianSpringDamper(markerNumbers=list(pair), **options))


def rigid_body_spring(b):
    turn = RotationMatrixZ(0.2)
    for pair in [(b.rigid(0), b.rigid(1)), (b.rigid(1), b.rigid(None))]:
        b.mbs.AddObject(
            RigidBodySpringDamper(
                markerNumbers=list(pair),
                stiffness=np.diag([40, 30, 20, 0.4, 0.3, 0.5]) + 0.05,
                damping=np.diag([0.2, 0.1, 0.3, 0.02, 0.03, 0.01]),
                offset=[0.1, 0, 0, 0.05, 0, 0.1],
                rotationMarker0=turn.tolist(),
                rotationMarker1=turn.T.tolist(),
            )
        )


def bushing(b):
    """As `CreateRigidBodySpringDamper` makes it; a second one is turned by up to almost half a turn."""
    law = {"stiffness": np.diag([40, 30, 20, 0.1, 0.05, 0.08]) + 0.01, "damping": 0.01 * np.eye(6) + 0.002}
    given = {"useIntrinsicFormulation": True, "offset": [0.1, 0, 0, 0.05, 0, 0.1], **law}
    turn = {"rotationMatrixJoint": RotationMatrixZ(0.4)}
    b.mbs.CreateRigidBodySpringDamper(itemNumbers=b.bodies, localPosition0=b.vector(0.1), **law, **turn)
    turn = RotationMatrixZ(2.0) if b.dimension == 2 else RotXYZ2RotationMatrix(b.vector(2.0))
    b.mbs.AddObject(
        RigidBodySpringDamper(
            markerNumbers=[b.rigid(1), b.rigid(None)], rotationMarker1=turn.tolist(), **given
        )
    )


def torsional_spring(b):
    frames = {
        "rotationMarker0": RotationMatrixZ(0.2).tolist(),
        "rotationMarker1": RotationMatrixZ(-0.1).tolist(),
    }
    law = {"stiffness": 0.6, "damping": 0.02, "offset": 0.1, "velocityOffset": 0.3, "torque": 0.05}
    for pair in [(b.rigid(0), b.rigid(1)), (b.rigid(None), b.rigid(1))]:
        b.mbs.AddObject(TorsionalSpringDamper(markerNumbers=list(pair), **frames, **law))


def springs_that_count_turns(b):
    """One has turned three times before the run."""
    if b.mbs.NumberOfGeneralContacts():  # beside which Exudyn evaluates them
        return
    law = {"stiffness": 0.01, "damping": 0.002, "offset": 0.1}
    for pair, start in [((b.rigid(0), b.rigid(1)), 20.0), ((b.rigid(None), b.rigid(1)), 0.0)]:
        turns = data_node(b, [start])
        b.mbs.AddObject(TorsionalSpringDamper(markerNumbers=list(pair), nodeNumber=turns, **law))


def torsional_spring_at_a_node(b):
    """In the plane, a node of a cable has a frame."""
    if b.dimension == 2:
        tip = b.mbs.AddMarker(MarkerNodeRigid(nodeNumber=b.cable["nodes"][-1]))
        b.mbs.AddObject(TorsionalSpringDamper(markerNumbers=[b.rigid(0), tip], stiffness=0.3, damping=0.01))
        hinge = {"stiffness": np.diag([9, 8, 0, 0, 0, 0.2]), "damping": 0.01 * np.eye(6)}
        b.mbs.AddObject(RigidBodySpringDamper(markerNumbers=[tip, b.rigid(1)], **hinge))


def beside_the_cable(b):
    """In the plane, a cable has frames, and points beside its axis, at any arc length."""
    if b.dimension == 2:
        beside, turned = b.on_cable(offset=0.1), b.on_cable(offset=-0.07, hasFrame=True)
        b.mbs.AddLoad(LoadForceVector(markerNumber=beside, loadVector=b.vector(3.0)))
        b.mbs.AddLoad(LoadTorqueVector(markerNumber=turned, loadVector=[0, 0, 0.1]))
        b.mbs.AddLoad(LoadForceVector(markerNumber=turned, loadVector=b.vector(3.0), bodyFixed=True))
        law = {"stiffness": np.diag([9, 8, 0, 0, 0, 0.2]), "damping": 0.01 * np.eye(6)}
        b.mbs.AddObject(RigidBodySpringDamper(markerNumbers=[turned, b.rigid(1)], **law))


def fixed_beside_the_cable(b):
    """A body on an arm, and a slider along the cable's frame."""
    if b.dimension == 2:
        first, second = b.on_cable(offset=0.1, hasFrame=True), b.on_cable(offset=-0.2)
        position, frame = b.place(b.bodies[0])
        x = b.mbs.GetMarker(first)["localPosition"][0] + element_start(b, first)
        local = frame.T @ ([x, 0.1, 0.0] - position)
        pair = [first, b.mbs.AddMarker(MarkerBodyRigid(bodyNumber=b.bodies[0], localPosition=local))]
        b.mbs.AddObject(
            GenericJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0, 0, 0, 1], rotationMarker1=frame.T)
        )
        x = b.mbs.GetMarker(second)["localPosition"][0] + element_start(b, second)
        distance = float(np.linalg.norm(b.place(b.bodies[1])[0] - [x, -0.2, 0]))
        other = b.mbs.AddMarker(MarkerNodePosition(nodeNumber=b.nodes[1]))
        b.mbs.AddObject(DistanceConstraint(markerNumbers=[second, other], distance=distance))


def element_start(b, marker):
    """x of the first node of a marker's element."""
    left = b.mbs.GetObject(b.mbs.GetMarker(marker)["bodyNumber"])["nodeNumbers"][0]
    return b.mbs.GetNode(left)["referenceCoordinates"][0]


def coordinate_spring(b):
    ground = b.coordinate(b.mbs.AddNode(NodePointGround()), 0)
    tip = b.cable["nodes"][-1]
    for pair in [(ground, b.coordinate(tip, 1)), (b.coordinate(tip, 0), b.coordinate(b.nodes[0], 0))]:
        b.mbs.AddObject(
            CoordinateSpringDamper(markerNumbers=list(pair), stiffness=30, damping=0.2, offset=0.1)
        )


RUBBING_LAWS = [
    {"dynamicFrictionForce": 0.3, "staticFrictionOffsetForce": 0.2, "frictionProportionalZone": 0.1},
    {"dynamicFrictionForce": 0.2, "stickingStiffness": 200.0, "stickingDamping": 0.5},
    {"useLimitStops": True, "limitStopsLower": -3e-3, "limitStopsUpper": 1e-3},
]


def rubbing_springs(b):
    """On coordinates with factors: they rub always, stick and slide, and have stops."""
    if b.mbs.NumberOfGeneralContacts():  # beside which Exudyn evaluates them
        return
    law = {
        "stiffness": 30.0,
        "damping": 0.2,
        "offset": 0.1,
        "velocityOffset": 0.3,
        "factor0": 0.7,
        "factor1": 1.3,
    }
    law |= {"exponentialDecayStatic": 0.5, "viscousFrictionFactor": 0.1}
    law |= {"limitStopsStiffness": 500.0, "limitStopsDamping": 0.2}
    for node, own in zip((b.cable["nodes"][-1], b.nodes[1], b.nodes[1]), RUBBING_LAWS, strict=True):
        pair = [b.coordinate(b.nodes[0], 1), b.coordinate(node, 0)]
        remembered = {} if "frictionProportionalZone" in own else {"nodeNumber": data_node(b, [0, 0.01, 0])}
        b.mbs.AddObject(CoordinateSpringDamperExt(markerNumbers=pair, **law, **own, **remembered))


def data_node(b, values):
    return b.mbs.AddNode(NodeGenericData(initialCoordinates=values, numberOfDataCoordinates=len(values)))


def forces(b):
    def pull(mbs, t, load):
        return [3.0 * np.sin(20 * t), load[1], 0]

    for marker in (b.position(0), b.on_cable()):
        b.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=b.vector(3.0)))
        b.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 2, 0], loadVectorUserFunction=pull))
    fixed = b.rigid(1, b.vector(0.1))
    b.mbs.AddLoad(LoadForceVector(markerNumber=fixed, loadVector=b.vector(3.0), bodyFixed=True))


def torques(b):
    for body, fixed in [(0, False), (1, True), (1, False)]:
        torque = b.vector(0.1) if b.dimension == 3 else [0, 0, 0.1]
        marker = b.rigid(body, b.vector(0.1)) if fixed else b.rigid(body)
        b.mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=torque, bodyFixed=fixed))


def weights(b):
    for body in b.bodies:
        mass = b.mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        b.mbs.AddLoad(LoadMassProportional(markerNumber=mass, loadVector=b.vector(9.81)))


def coordinate_loads(b):
    for node in (b.nodes[0], b.cable["nodes"][2]):
        b.mbs.AddLoad(LoadCoordinate(markerNumber=b.coordinate(node, 1), load=0.8))


def mass_points(b):
    create = b.mbs.CreateMassPoint
    for _ in range(2):
        point = create(mass=0.1, referencePosition=b.vector(), gravity=[0, -9.81, 0], returnDict=True)
        pair = b.on_cable(), b.mbs.AddMarker(MarkerNodePosition(nodeNumber=point["nodeNumber"]))
        b.mbs.AddObject(
            SpringDamper(markerNumbers=list(pair), stiffness=30, damping=0.1, referenceLength=0.4)
        )
    b.mbs.AddObject(ObjectMassPoint(mass=0.1, nodeNumber=b.mbs.AddNode(NodePointGround())))


def joined(b, constrained):
    """The cable's end on the first body, where that is."""
    position, frame = b.place(b.bodies[0])
    end = np.array([1.2, 0.0, 0.0])
    local = frame.T @ (end - position)
    pair = (
        b.mbs.AddMarker(MarkerNodePosition(nodeNumber=b.cable["nodes"][-1])),
        b.mbs.AddMarker(MarkerBodyPosition(bodyNumber=b.bodies[0], localPosition=local)),
    )
    b.mbs.AddObject(SphericalJoint(markerNumbers=list(pair), constrainedAxes=constrained))


def spherical_joint(b):
    joined(b, [1, 1, b.dimension - 2])
    joined(b, [0, 0, 0])  # which holds nothing
    if b.dimension == 3:
        between(b, b.mbs.CreateSphericalJoint)


def between(b, create, **options):
    """A joint between both bodies, and one between the second one and ground."""
    for pair in ([b.bodies[0], b.bodies[1]], [b.ground, b.bodies[1]]):
        create(itemNumbers=pair, position=b.vector(), **options)
        if b.random.uniform() < 0.5:
            break


def revolute_joint(b):
    if b.dimension == 3:
        between(b, b.mbs.CreateRevoluteJoint, axis=b.vector())


def prismatic_joint(b):
    if b.dimension == 3:
        between(b, b.mbs.CreatePrismaticJoint, axis=b.vector())


def generic_joint(b):
    if b.dimension == 2:
        axes = [[1, 1, 0, 0, 0, 0], [1, 0, 0, 0, 0, 1], [0, 1, 0, 0, 0, 0], [1, 1, 0, 0, 0, 1]]
        choice = axes[b.random.integers(len(axes))]
    else:
        choice = b.random.integers(0, 2, 6).tolist()
        choice[0] |= not any(choice)
    turn = RotationMatrixZ(0.4) if b.dimension == 2 else RotXYZ2RotationMatrix(b.vector())
    create = {"position": b.vector(), "rotationMatrixAxes": turn, "constrainedAxes": choice}
    return b.mbs.CreateGenericJoint(itemNumbers=b.bodies, **create)


def turned_generic_joint(b):
    """Distances and angles follow the time, from those that it has."""
    joint = generic_joint(b)
    way, turn = b.vector(0.1), (b.vector(0.3) if b.dimension == 3 else np.array([0.0, 0.0, 0.3]))

    def moving(mbs, t, itemNumber, offsets):
        distances = np.array(offsets[:3]) + way * np.sin(9.0 * t)
        return [*distances, *(turn * np.sin(7.0 * t))]

    b.mbs.SetObjectParameter(joint, "offsetUserFunction", moving)
    b.mbs.SetObjectParameter(joint, "offsetUserFunctionParameters", [2e-3, 1e-3, 0, 0, 0, 0])


def rolling_discs(b):
    """The first body rolls on the second one, in any direction, and that one on the ground, along a line."""
    for plane, disc, sideways in ((1, 0, 1), (None, 1, 0)):
        normal, axis = b.vector(), b.vector() if b.dimension == 3 else np.array([0.0, 0.0, 1.0])
        b.mbs.AddObject(
            ObjectJointRollingDisc(
                markerNumbers=[b.rigid(body, [0, 0, 0]) for body in (plane, disc)],
                constrainedAxes=[sideways * (b.dimension - 2), 1, 1],
                discRadius=0.2,
                planeNormal=normal / np.linalg.norm(normal),
                discAxis=axis / np.linalg.norm(axis),
            )
        )


def planar_joints(b):
    if b.dimension == 2:
        (one, turn), (other, other_turn) = map(b.place, b.bodies)
        point = b.vector()
        pair = b.rigid(0, turn.T @ (point - one)), b.rigid(1, other_turn.T @ (point - other))
        b.mbs.AddObject(RevoluteJoint2D(markerNumbers=list(pair)))


def planar_slider(b):
    if b.dimension == 2:
        (one, turn), (_, other_turn) = map(b.place, b.bodies)
        axis = RotationMatrixZ(0.3)[:, 0]
        pair = b.rigid(0, turn.T @ (b.place(b.bodies[1])[0] - one)), b.rigid(1, np.zeros(3))
        axes = {"axisMarker0": turn.T @ axis, "normalMarker1": other_turn.T @ [-axis[1], axis[0], 0]}
        held = bool(b.random.uniform() < 0.5)
        b.mbs.AddObject(PrismaticJoint2D(markerNumbers=list(pair), constrainRotation=held, **axes))


def distances(b):
    pairs = [[b.bodies[0], b.bodies[1]], [b.ground, b.bodies[1]]]
    for pair in pairs:
        b.mbs.CreateDistanceConstraint(itemNumbers=pair, localPosition0=b.vector(0.1))
    tip, node = b.cable["nodes"][-1], b.nodes[0]
    markers = [b.mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (tip, node)]
    distance = float(np.linalg.norm(b.place(b.bodies[0])[0] - [1.2, 0, 0]))
    b.mbs.AddObject(DistanceConstraint(markerNumbers=markers, distance=distance))


def coordinate_constraints(b):
    tip = b.coordinate(b.cable["nodes"][-1], 1)
    pair = [b.coordinate(b.nodes[0], 1), tip]
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=list(pair), factor1=0.5))


def angles(b):
    """Springs and loads on angles of bodies by Euler parameters and by angles; planar ones have none."""
    ground = b.coordinate(b.mbs.AddNode(NodePointGround()), 0)
    for axis in range(3 if b.dimension == 3 else 0):
        law = {"stiffness": 0.6, "damping": 0.02, "offset": 0.1}
        for pair in [(ground, b.angle(1, axis)), (b.angle(0, axis), b.angle(1, 2 - axis))]:
            b.mbs.AddObject(CoordinateSpringDamper(markerNumbers=list(pair), **law))
        b.mbs.AddLoad(LoadCoordinate(markerNumber=b.angle(0, axis), load=0.1))


def geared_angles(b):
    """Wheels about z, which sway on springs."""
    kinds, wheels = [exudyn.NodeType.RotationEulerParameters, exudyn.NodeType.RotationRxyz], []
    for kind in kinds[: 2 * (b.dimension - 2)]:
        made = b.mbs.CreateRigidBody(
            inertia=InertiaCuboid(300, [0.1, 0.15, 0.07]),
            nodeType=kind,
            initialAngularVelocity=[0.2, 0.3, 4.0 * (1 + len(wheels))],
            returnDict=True,
        )
        pair = [b.ground, made["bodyNumber"]]
        b.mbs.CreateCartesianSpringDamper(itemNumbers=pair, stiffness=[50] * 3, damping=[1] * 3)
        axis = MarkerNodeRotationCoordinate(nodeNumber=made["nodeNumber"], rotationCoordinate=2)
        wheels.append(b.mbs.AddMarker(axis))
    if wheels:
        b.mbs.AddObject(CoordinateConstraint(markerNumbers=wheels, factor1=0.5))


def drums(b):
    """Masses with one coordinate: one is geared to a body, one drags the cable's tip by a spring."""
    turning, sliding = (b.mbs.AddNode(Node1D(referenceCoordinates=[x])) for x in (0.0, 0.1))
    b.mbs.AddObject(ObjectRotationalMass1D(inertia=0.02, nodeNumber=turning))
    b.mbs.AddObject(ObjectMass1D(mass=0.4, nodeNumber=sliding))
    turn, way = (b.coordinate(node, 0) for node in (turning, sliding))
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=[turn, b.coordinate(b.nodes[0], 0)], factor1=5.0))
    tip = b.coordinate(b.cable["nodes"][-1], 0)
    b.mbs.AddObject(CoordinateSpringDamper(markerNumbers=[way, tip], stiffness=40.0, damping=0.3))
    b.mbs.AddLoad(LoadCoordinate(markerNumber=turn, load=0.7))


def matrices(b):
    """Point masses on springs, coupled masses that a gyroscope damps, and springs of a node of the cable."""
    kind = NodePoint2D if b.dimension == 2 else NodePoint
    points = [b.mbs.AddNode(kind(referenceCoordinates=[x] * b.dimension)) for x in (0.7, 0.2)]
    size = 2 * b.dimension
    springs = 40.0 * np.kron([[2, -1], [-1, 1]], np.eye(b.dimension))
    masses = {
        "massMatrix": np.diag(b.random.uniform(0.1, 0.3, size)),
        "forceVector": b.random.normal(size=size),
    }
    b.mbs.AddObject(ObjectGenericODE2(nodeNumbers=points, stiffnessMatrix=springs, **masses))
    at_point = b.mbs.AddMarker(MarkerNodePosition(nodeNumber=points[1]))
    b.mbs.AddObject(SpringDamper(markerNumbers=[at_point, b.position(0)], stiffness=30, referenceLength=0.1))
    start = {"referenceCoordinates": [0.3] * 4, "initialCoordinates": [0.1, 0, 0.2, 0]}
    wheel = b.mbs.AddNode(
        NodeGenericODE2(**start, initialCoordinates_t=[0, 1, 0, 1], numberOfODE2Coordinates=4)
    )
    mass, turn = np.diag([0.1, 0.2, 0.3, 0.4]), np.diag([0.2] * 3, 1)
    mass[0, 1] = mass[1, 0] = 0.05
    law = {"massMatrix": mass, "stiffnessMatrix": np.diag([30.0] * 4), "dampingMatrix": turn - turn.T}
    b.mbs.AddObject(ObjectGenericODE2(nodeNumbers=[wheel], **law))
    width, ends = 2 * b.dimension, [b.cable["nodes"][-1], wheel]
    tie = np.zeros((width + 4, width + 4))
    tie[np.ix_([1, width], [1, width])] = [[20.0, -15.0], [-25.0, 20.0]]
    b.mbs.AddObject(ObjectGenericODE2(nodeNumbers=ends, stiffnessMatrix=tie, dampingMatrix=0.01 * tie))


def coordinate_vectors(b):
    """Sums of coordinates of a body and of a node of the cable, and of a mass point on the ground."""
    body, tip = (MarkerNodeCoordinates(nodeNumber=node) for node in (b.nodes[1], b.cable["nodes"][-1]))
    width = 3 * (b.dimension - 1)
    b.mbs.AddObject(
        CoordinateVectorConstraint(
            markerNumbers=[b.mbs.AddMarker(marker) for marker in (body, tip)],
            scalingMarker0=b.random.normal(size=(2, width)),
            scalingMarker1=b.random.normal(size=(2, 2 * b.dimension)),
            offset=[0.1, 0.2],
        )
    )
    point = b.mbs.CreateMassPoint(
        mass=0.3, referencePosition=[0.5, 0.7, 0], gravity=[3, -9, 0], returnDict=True
    )
    nodes = b.mbs.AddNode(NodePointGround()), point["nodeNumber"]
    ground = [b.mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=node)) for node in nodes]
    law = {"scalingMarker1": np.array([[1.0, 0.4, 0.0]]), "offset": [0.8]}
    b.mbs.AddObject(CoordinateVectorConstraint(markerNumbers=ground, scalingMarker0=[], **law))


JOINTS_OF_TREE = [
    "RevoluteZ",
    "RevoluteY",
    "PrismaticX",
    "RevoluteX",
    "PrismaticZ",
    "RevoluteY",
    "PrismaticY",
]


def random_tree(b):
    """A robot of random links: the number of its object, and of its node."""
    number, random = 7, b.random
    lists = {
        "jointTransformations": exudyn.Matrix3DList(
            [RotXYZ2RotationMatrix(random.uniform(-2, 2, 3)) for _ in range(number)]
        ),
        "jointOffsets": exudyn.Vector3DList(random.uniform(-0.4, 0.4, (number, 3)).tolist()),
        "linkInertiasCOM": exudyn.Matrix3DList(
            [InertiaCuboid(300, random.uniform(0.05, 0.15, 3)).InertiaCOM() for _ in range(number)]
        ),
        "linkCOMs": exudyn.Vector3DList(random.uniform(-0.1, 0.1, (number, 3)).tolist()),
    }
    kinds, vectors = exudyn.JointType, random.uniform(0.1, 1.0, (8, number))
    node = b.mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=vectors[0],
            initialCoordinates=vectors[1],
            initialCoordinates_t=vectors[2],
            numberOfODE2Coordinates=number,
        )
    )
    tree = ObjectKinematicTree(
        nodeNumber=node,
        gravity=b.vector(9.81),
        baseOffset=[0.3, 0.5, 0.1],
        jointTypes=[getattr(kinds, name) for name in JOINTS_OF_TREE],
        linkParents=[-1, 0, 1, 0, -1, 4, 2],
        linkMasses=0.1 + vectors[3],
        jointForceVector=vectors[4],
        jointPControlVector=20.0 * vectors[5],
        jointDControlVector=vectors[6],
        jointPositionOffsetVector=vectors[7],
        jointVelocityOffsetVector=vectors[0],
        **lists,
    )
    return b.mbs.AddObject(tree), node


def link(b, tree, number):
    marker = MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=number, localPosition=b.vector(0.2))
    return b.mbs.AddMarker(marker)


def tree(b):
    """A robot whose links are on springs and under loads."""
    number, _ = random_tree(b)
    for pair in [(link(b, number, 2), b.on_cable()), (b.position(0), link(b, number, 4))]:
        law = {"stiffness": 40, "damping": 0.3, "referenceLength": 0.4}
        b.mbs.AddObject(SpringDamper(markerNumbers=list(pair), **law))
    law = {
        "stiffness": np.diag([9, 8, 7, 3, 2, 1]),
        "damping": 0.02 * np.eye(6),
        "useIntrinsicFormulation": True,
    }
    pair = [link(b, number, 3), b.rigid(None)]
    b.mbs.AddObject(RigidBodySpringDamper(markerNumbers=pair, **law))
    b.mbs.AddLoad(LoadForceVector(markerNumber=link(b, number, 1), loadVector=[1, 2, 3], bodyFixed=True))
    b.mbs.AddLoad(LoadTorqueVector(markerNumber=link(b, number, 3), loadVector=[0.1, 0.2, 0.3]))


def frame_of_link(b, tree, number):
    """Where a joint of a robot is at the start, and the frame of its link."""
    marker = b.mbs.AddMarker(MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=number))
    b.mbs.Assemble()
    kinds = exudyn.OutputVariableType.Position, exudyn.OutputVariableType.RotationMatrix
    position, frame = (b.mbs.GetMarkerOutput(marker, kind) for kind in kinds)
    return position, np.reshape(frame, (3, 3))


def link_at(b, tree, number, place):
    """A marker there at the start, and its frame."""
    position, frame = frame_of_link(b, tree, number)
    local = frame.T @ (place - position)
    marker = MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=number, localPosition=local)
    return b.mbs.AddMarker(marker), frame


def geared_tree(b):
    """A robot that holds the cable's end, with two joints that turn together."""
    number, node = random_tree(b)
    hand, _ = link_at(b, number, 2, [1.2, 0, 0])
    pair = [hand, b.mbs.AddMarker(MarkerNodePosition(nodeNumber=b.cable["nodes"][-1]))]
    b.mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, b.dimension - 2]))
    start = b.mbs.GetNodeParameter(node, "initialCoordinates")
    pair = [b.coordinate(node, k) for k in (0, 3)]
    offset = 0.5 * start[3] - start[0]
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=pair, factor1=0.5, offset=offset))


def jointed_tree(b):
    """Links that slide and turn on each other and on the ground."""
    number, _ = random_tree(b)
    place = b.vector()
    for one, other, axes in [(2, 4, [1, 1, 0, 0, 0, 0]), (3, None, [0, 0, 0, 1, 0, 0])]:
        marker, frame = link_at(b, number, one, place)
        held, other_frame = (b.rigid(None), frame) if other is None else link_at(b, number, other, place)
        if other is None:
            b.mbs.Assemble()
            other_frame = b.mbs.GetMarkerOutput(held, exudyn.OutputVariableType.RotationMatrix)
        turn = np.reshape(other_frame, (3, 3)).T @ frame
        joint = GenericJoint(markerNumbers=[marker, held], constrainedAxes=axes, rotationMarker1=turn)
        b.mbs.AddObject(joint)


def held_point(b):
    """A mass point one of whose coordinates is held pulls at the cable's tip by a spring."""
    way = {"referencePosition": [1.5, 0.3, 0.0], "initialVelocity": [0.5, 0.0, 0.0]}
    point = b.mbs.CreateMassPoint(mass=0.4, **way, create2D=b.dimension == 2, returnDict=True)
    ground = b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=b.mbs.AddNode(NodePointGround()), coordinate=0))
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, b.coordinate(point["nodeNumber"], 1)]))
    ends = [point["nodeNumber"], b.cable["nodes"][-1]]
    markers = [b.mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in ends]
    b.mbs.AddObject(SpringDamper(markerNumbers=markers, stiffness=50.0, damping=0.2, referenceLength=0.2))


def driven(b):
    """Coordinates that follow functions of time: one with its rate, one that another body shares."""
    ground = b.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=b.mbs.AddNode(NodePointGround()), coordinate=0))

    def moving(mbs, t, itemNumber, lOffset):
        return lOffset + 0.1 * np.sin(9.0 * t)

    def at_a_rate(mbs, t, itemNumber, lOffset):
        return 0.9 * np.cos(9.0 * t)

    pair = [ground, b.coordinate(b.nodes[0], 1)]
    b.mbs.AddObject(
        CoordinateConstraint(
            markerNumbers=pair, offset=0.02, offsetUserFunction=moving, offsetUserFunction_t=at_a_rate
        )
    )
    pair = [b.coordinate(b.nodes[1], 0), b.coordinate(b.cable["nodes"][-1], 0)]
    b.mbs.AddObject(CoordinateConstraint(markerNumbers=pair, factor1=0.5, offsetUserFunction=moving))


def clamp(b):
    position, frame = b.place(b.bodies[0])
    local = frame.T @ (np.array([1.2, 0.0, 0.0]) - position)
    AttachToBody(b.mbs, b.cable, "end", b.bodies[0], local.tolist(), kind="clamp")


def circles(b):
    """Wheels and a fixed circle that touch the cable, or will: slow ones stick, others slide."""
    if b.dimension == 3:
        return
    elements = CreateCompanionCables(b.mbs, b.cable)
    friction = {"frictionCoefficient": 0.4, "frictionVelocityPenalty": 2.0}
    kinds = [
        (0, 2e-3, {**friction, "frictionStiffness": 300.0, "useSegmentNormals": False}),
        (1, 1e-3, {**friction, "frictionStiffness": 3e4, "frictionCoefficient": 5.0}),
        (1, -1e-3, friction),
        (0, -5e-4, {"frictionStiffness": 2e3, "frictionCoefficient": 0.1}),
        (None, 2e-3, None),
        (1, -1e-3, None),
    ]
    for body, depth, law in kinds:
        circle(b, elements, body, depth, law)


def circle(b, elements, body, depth, law):
    """A circle on a body or ground that reaches that deep into the straight cable."""
    centre = b.place(b.ground if body is None else b.bodies[body])[0]
    nearest = np.array([np.clip(centre[0], 0.0, 1.2), 0.0, 0.0])
    radius = float(np.linalg.norm(centre - nearest)) + depth
    marker = b.rigid(body, [0, 0, 0])
    height = 2e-3 * np.sign(centre[1]) if body == 1 else 0.0
    form = {"numberOfSegments": SEGMENTS, "verticalOffset": height}
    for element in elements:
        shape = b.mbs.AddMarker(MarkerBodyCable2DShape(bodyNumber=element, **form))
        memory = [0.1] * SEGMENTS + ([-2] * SEGMENTS + [0] * SEGMENTS) * (law is not None)
        data = data_node(b, memory)
        given = {
            "markerNumbers": [marker, shape],
            "nodeNumber": data,
            "numberOfContactSegments": SEGMENTS,
            "contactStiffness": 2e3,
            "circleRadius": radius,
        }
        if law is None:
            b.mbs.AddObject(ObjectContactCircleCable2D(**given, offset=1e-4))
        else:
            b.mbs.AddObject(ObjectContactFrictionCircleCable2D(**given, contactDamping=0.5, **law))


def general_contact(b):
    """Circles on bodies and ground, and elements of several laws in any order."""
    if b.dimension == 2:
        elements = CreateCompanionCables(b.mbs, b.cable)
        contact = b.mbs.AddGeneralContact()
        contact.SetFrictionPairings(np.array([[0.3, 0.0], [0.0, 0.2]]))
        contact.SetSearchTreeCellSize(numberOfCells=[4, 4, 1])
        contact.frictionProportionalZone = 0.5
        contact.ancfCableUseExactMethod = contact.sphereSphereContact = False
        contact.ancfCableNumberOfContactSegments = SEGMENTS
        for number, body in enumerate([0, None, 1]):
            centre = b.place(b.ground if body is None else b.bodies[body])[0]
            nearest = np.array([np.clip(centre[0], 0.0, 1.2), 0.0, 0.0])
            radius = float(np.linalg.norm(centre - nearest)) + 0.02
            contact.AddSphereWithMarker(b.rigid(body, [0, 0, 0]), radius, 3e3, 0.4, number % 2)
        for number, element in enumerate(elements[2::-1]):
            contact.AddANCFCable(element, 1e-3 * number, 2e3 * (1 + number), 0.2, number % 2)


def shared_nodes(b):
    """A cable that leaves the end of the first one along it, and one that hangs on its middle."""
    section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.01)
    for node, end, has_slope in ((-1, [2.0, 0.0, 0.0], True), (2, [0.9, 0.7, 0.0], False)):
        CreateInextensibleCable(
            b.mbs,
            b.cable["nodePositions"][node],
            end,
            2,
            section,
            dimension=b.dimension,
            nodeNumberStart=b.cable["nodes"][node],
            shareSlopeStart=has_slope,
        )


KINDS = [
    spring,
    cartesian_spring,
    rigid_body_spring,
    bushing,
    torsional_spring,
    springs_that_count_turns,
    torsional_spring_at_a_node,
    beside_the_cable,
    fixed_beside_the_cable,
    coordinate_spring,
    rubbing_springs,
    forces,
    torques,
    weights,
    coordinate_loads,
    mass_points,
    matrices,
    tree,
    circles,
    spherical_joint,
    revolute_joint,
    prismatic_joint,
    generic_joint,
    planar_joints,
    planar_slider,
    distances,
    coordinate_constraints,
    angles,
    geared_angles,
    held_point,
    geared_tree,
    jointed_tree,
    drums,
    coordinate_vectors,
    clamp,
    general_contact,
    shared_nodes,
]
IN_PLANE = {torsional_spring_at_a_node, beside_the_cable, fixed_beside_the_cable, circles}
IN_PLANE |= {planar_joints, planar_slider, general_contact}
IN_SPACE = {revolute_joint, prismatic_joint, angles, geared_angles}
FORCES = {spring, cartesian_spring, rigid_body_spring, bushing, torsional_spring, springs_that_count_turns}
FORCES |= {torsional_spring_at_a_node, beside_the_cable, coordinate_spring, rubbing_springs, forces, torques}
FORCES |= {weights, coordinate_loads, circles}
PAIRS = [(kind, 2) for kind in KINDS if kind not in IN_SPACE]
PAIRS += [(kind, 3) for kind in KINDS if kind not in IN_PLANE]
each_kind = pytest.mark.parametrize(("kind", "dimension"), PAIRS)


def moved(build, integrator, compiled, steps=STEPS, outputs=2):
    """Coordinates and multipliers after the steps, and the path that they took; contact is explicit."""
    mbs = build()
    mbs.Assemble()
    explicit = ExplicitSettings(integrator, stepSize=STEP, startTolerance=100.0)
    if integrator == "RATTLE":
        explicit = replace(explicit, massScaling=0.3, integrator=Rattle(tolerance=1e-13))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MovedByKernels, "_may_damp", False)
        if not compiled:
            patch.setattr(CoupledScene, "compiled", lambda *_: (None, "this test"))
            patch.setattr(CoupledScene, "compile_parts", lambda *_: None)
        with silence():
            report = SolveExplicit(mbs, quiet_settings(steps * STEP, outputs), explicit)
    data = mbs.systemData
    return np.array(data.GetODE2Coordinates()), np.array(data.GetAECoordinates()), report["path"]


def require_the_same(kinds, seed, dimension, integrator="RATTLE", tolerance=None):
    containers = []

    def build():
        builder = Builder(seed, dimension)
        for kind in kinds:
            kind(builder)
        containers.append(builder.container)
        return builder.mbs

    ours, our_forces, path = moved(build, integrator, compiled=True)
    theirs, their_forces, _ = moved(build, integrator, compiled=False)
    assert "in one compiled call" in path, path
    scale, tolerance = np.abs(theirs).max(), tolerance or (OF_JOINTS if len(their_forces) else TOLERANCE)
    np.testing.assert_allclose(ours, theirs, atol=tolerance * scale, rtol=0)
    if len(their_forces):
        scale = max(1.0, np.abs(their_forces).max())
        np.testing.assert_allclose(our_forces, their_forces, atol=1e-4 * scale, rtol=0)


@each_kind
def test_a_kind_moves_as_exudyn_says(kind, dimension):
    require_the_same([kind], len(kind.__name__), dimension)


@pytest.mark.parametrize("integrator", ["RATTLE", "RK4"])
def test_contacts_that_close_stick_and_slide_are_what_exudyn_says(integrator, monkeypatch):
    """At the end of each step, as a user function sees them; so is the work of friction that is checked."""
    works = []
    monkeypatch.setattr(FrictionCheck, "finding", property(lambda self: works.append(self.sums.copy()) or ""))

    def remembered(seed, compiled):
        rows = []

        def build():
            builder = Builder(seed, 2)
            circles(builder)
            containers.append(builder.container)
            builder.mbs.SetPostStepUserFunction(
                lambda mbs, t: rows.append(mbs.systemData.GetDataCoordinates()) or True
            )
            return builder.mbs

        moved(build, integrator, compiled, steps=100, outputs=100)
        return np.array(rows)

    containers, seen = [], set()
    for seed in (2, 5):
        ours, theirs = remembered(seed, True), remembered(seed, False)
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)
        np.testing.assert_allclose(works[-2], works[-1], rtol=1e-6, atol=1e-12)
        assert works[-1].any(axis=0)[2:].all()
        with_friction = 4 * 4 * 3 * SEGMENTS  # circles, elements, numbers of a segment
        states = ours[:, :with_friction].reshape(len(ours), -1, 3, SEGMENTS)[:, :, 1]
        seen |= set(zip(states[:-1].ravel().tolist(), states[1:].ravel().tolist(), strict=True))
    closing, opening, slipping, sticking = (-2, 0), (1, -2), (0, 1), (1, 0)
    assert {closing, opening, slipping, sticking, (0, 0), (1, 1), (-1, -1)} <= seen


@every_integrator
def test_what_is_driven_moves_as_exudyn_says(integrator, dimension):
    """Exudyn's side finds rates of offsets by differences."""
    require_the_same([driven, spring], 5, dimension, integrator, max(1e-7, OFF_UNITY[integrator]))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("dimension", [2, 3])
def test_joints_that_are_turned_move_as_exudyn_says(dimension, seed):
    """Exudyn's side finds rates of offsets by differences."""
    require_the_same([turned_generic_joint, spring], seed, dimension)


@every_integrator
def test_discs_that_roll_move_as_exudyn_says(integrator, dimension):
    """But for quaternions that are not quite of unit norm: the difference is of second order in the step."""
    require_the_same([rolling_discs], 13, dimension, integrator, 2.0 * OFF_UNITY[integrator])


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai"])
def test_work_of_what_is_driven_is_in_the_energy(integrator):
    """A body is shaken, which shakes a cable; it follows the function."""
    builder = Builder(3, 2)
    mbs, node = builder.mbs, builder.nodes[0]
    driven(builder)
    mbs.Assemble()
    settings = quiet_settings(0.5, 20)
    with silence():
        report = SolveExplicit(
            mbs, settings, ExplicitSettings(integrator, stepSize=1e-4, startTolerance=100.0)
        )
    assert "in one compiled call" in report["path"]
    assert abs(report["drift"]["energyGain"]) + abs(report["drift"]["energyLoss"]) < 1e-3
    place = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates)[1]
    assert abs(place - 0.02 - 0.1 * np.sin(4.5)) < 1e-8


def test_joints_whose_pulls_on_a_body_cancel_are_compiled():
    """A light disc without weight between a hanging cable and ground: rounding is all that accelerates it."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(massPerLength=0.8, bendingStiffness=160.0)
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [2, 0, 0], 16, section, gravity=[0, -9.81, 0])
    node = mbs.AddNode(NodeRigidBody2D())
    body = mbs.AddObject(ObjectRigidBody2D(mass=1e-3, inertia=1.7e-8, nodeNumber=node))
    first = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][0]))
    on_body, on_ground = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=n)) for n in (body, mbs.CreateGround())]
    for pair in ([first, on_body], [on_body, on_ground]):
        mbs.AddObject(RevoluteJoint2D(markerNumbers=pair))
    mbs.Assemble()
    path = SolveExplicit(mbs, quiet_settings(1e-3, 10))["path"]
    assert "Exudyn evaluates" not in str(path)


def test_a_drive_that_depends_on_the_state_stays_with_exudyn():
    builder = Builder(3, 2)
    mbs = builder.mbs
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))

    def by_sensor(mbs, t, itemNumber, lOffset):
        return 0.1 * mbs.systemData.GetTime()

    pair = [ground, builder.coordinate(builder.nodes[0], 1)]
    mbs.AddObject(CoordinateConstraint(markerNumbers=pair, offsetUserFunction=by_sensor))
    mbs.Assemble()
    with silence():
        report = SolveExplicit(mbs, quiet_settings(0.01, 1), ExplicitSettings(startTolerance=100.0))
    assert "whose user function may depend on the state" in report["path"]


def controlled(b):
    """A load by the velocity of a body."""

    def brake(mbs, t, load):
        return -2.0 * np.array(mbs.GetNodeOutput(b.nodes[0], exudyn.OutputVariableType.Velocity))

    force = LoadForceVector(markerNumber=b.position(1), loadVector=[0, 0, 0], loadVectorUserFunction=brake)
    b.mbs.AddLoad(force)


def of_a_function(b):
    """A spring that only Exudyn knows."""

    def pull(mbs, t, itemNumber, displacement, velocity, *law):
        return 30.0 * displacement + 0.2 * velocity

    pair = [b.coordinate(b.cable["nodes"][-1], 0), b.coordinate(b.nodes[0], 0)]
    b.mbs.AddObject(CoordinateSpringDamper(markerNumbers=pair, springForceUserFunction=that_remembers(pull)))


@pytest.mark.parametrize(("kinds", "tolerance"), [([spring, angles, drums], OF_JOINTS), ([distances], 1e-6)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_loads_that_depend_on_the_state_move_compiled_scenes(dimension, kinds, tolerance):
    """They act at the end of each step, where joints have not moved the state yet."""
    found = []
    for compiled in (True, False):
        builder = Builder(3, dimension)
        for kind in [*kinds, controlled]:
            kind(builder)
        coordinates, _, path = moved(lambda b=builder: b.mbs, "RATTLE", compiled)
        assert ("each step asks load" in path) is compiled, path
        found.append(coordinates)
    np.testing.assert_allclose(*found, atol=tolerance * np.abs(found[1]).max(), rtol=0)


def with_compiled_parts(kinds, seed, dimension, integrator, monkeypatch, tolerance):
    """Whether bodies and joints in compiled code move as Exudyn's, under forces that only Exudyn knows."""
    found = []
    for evaluated in (False, True):
        builder = Builder(seed, dimension)
        for kind in [*kinds, of_a_function]:
            kind(builder)
        if evaluated:
            monkeypatch.setattr(CoupledScene, "compile_parts", lambda *_: None)
        *coordinates, path = moved(lambda b=builder: b.mbs, integrator, compiled=True)
        monkeypatch.undo()
        assert ("bodies and joints are compiled" in path) is not evaluated, path
        found.append(coordinates)
    (ours, our_forces), (theirs, their_forces) = found
    np.testing.assert_allclose(ours, theirs, atol=tolerance * np.abs(theirs).max(), rtol=0)
    if len(their_forces):
        scale = max(1.0, np.abs(their_forces).max())
        np.testing.assert_allclose(our_forces, their_forces, atol=1e-4 * scale, rtol=0)


@pytest.mark.parametrize(("kind", "dimension"), [pair for pair in PAIRS if pair[0] not in FORCES])
def test_bodies_and_joints_are_compiled_where_forces_are_not(kind, dimension, monkeypatch):
    """All kinds of forces together: below."""
    tolerance = OF_JOINTS if kind in JOINTS else TOLERANCE
    with_compiled_parts([kind], len(kind.__name__), dimension, "RATTLE", monkeypatch, tolerance)


def of_a_mass_function(b):
    """A pendulum in its own coordinate, of which the mass depends on it."""
    start = {"referenceCoordinates": [0.1], "initialCoordinates": [0.3], "initialCoordinates_t": [1.0]}
    node = b.mbs.AddNode(NodeGenericODE2(**start, numberOfODE2Coordinates=1))
    law = {"stiffnessMatrix": np.array([[3.0]]), "dampingMatrix": np.array([[0.1]])}
    mass = {"massMatrixUserFunction": lambda mbs, t, number, q, v: np.array([[0.2 + 0.1 * np.cos(q[0])]])}
    b.mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.array([[0.3]]), **law, **mass))
    pair = [b.coordinate(node, 0), b.coordinate(b.cable["nodes"][-1], 1)]
    b.mbs.AddObject(CoordinateSpringDamper(markerNumbers=pair, stiffness=20, damping=0.1))


@every_integrator
def test_bodies_are_compiled_whose_mass_exudyn_says_at_each_evaluation(integrator, dimension, monkeypatch):
    with_compiled_parts([of_a_mass_function, tree, spring], 5, dimension, integrator, monkeypatch, OF_JOINTS)


def filtered(b):
    """A force that two states of first order let rise."""
    size = {"referenceCoordinates": [0.0, 0.0], "initialCoordinates": [0.5, 0.0]}
    states = b.mbs.AddNode(NodeGenericODE1(**size, numberOfODE1Coordinates=2))
    matrix = [[-40.0, 10.0], [5.0, -60.0]]
    b.mbs.AddObject(ObjectGenericODE1(nodeNumbers=[states], systemMatrix=matrix, rhsVector=[20.0, 60.0]))

    def pull(mbs, t, load):
        x, y = mbs.GetNodeOutput(states, exudyn.OutputVariableType.Coordinates)
        return [x, y, 0.0]

    force = LoadForceVector(markerNumber=b.on_cable(), loadVector=[0, 0, 0], loadVectorUserFunction=pull)
    b.mbs.AddLoad(force)


@every_integrator
def test_bodies_and_joints_are_compiled_beside_states_of_first_order(integrator, dimension, monkeypatch):
    kinds = [filtered, spring, generic_joint, drums]
    with_compiled_parts(kinds, 5, dimension, integrator, monkeypatch, OF_JOINTS)


@every_integrator
def test_under_all_kinds_of_forces_bodies_and_joints_may_be_compiled(integrator, dimension, monkeypatch):
    kinds = [*WITHOUT_JOINTS, distances]
    with_compiled_parts(kinds, 8, dimension, integrator, monkeypatch, OFF_UNITY[integrator])


@pytest.mark.parametrize("item", [spherical_joint, geared_tree])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_energy_of_compiled_bodies_under_forces_of_exudyn_is_kept(dimension, item):
    """Of bodies that turn about points off their centres of mass: the damper takes what they lose."""
    builder = Builder(4, dimension)
    for kind in (spring, of_a_function, item):
        kind(builder)
    builder.mbs.Assemble()
    explicit = ExplicitSettings(stepSize=1e-4, startTolerance=100.0)
    with silence():
        report = SolveExplicit(builder.mbs, quiet_settings(0.4, 20), explicit)
    assert "bodies and joints are compiled" in report["path"]
    assert abs(report["drift"]["energyGain"]) + abs(report["drift"]["energyLoss"]) < 1e-4


def test_accelerations_of_bodies_under_forces_of_exudyn_keep_euler_parameters_at_their_norm():
    """p . p = 1 twice differentiated: p . p_tt = -p_t . p_t, without what corrects the drift of steps."""
    builder = Builder(4, 3)
    for kind in (spring, of_a_function, spherical_joint):
        kind(builder)
    mbs = builder.mbs
    mbs.Assemble()
    with silence():
        report = SolveExplicit(mbs, quiet_settings(0.1, 20), ExplicitSettings(startTolerance=100.0))
    assert "bodies and joints are compiled" in report["path"]
    kinds = exudyn.OutputVariableType
    outputs = kinds.CoordinatesTotal, kinds.Coordinates_t, kinds.Coordinates_tt
    numbers = range(mbs.systemData.NumberOfNodes())
    turning = [node for node in numbers if "EP" in mbs.GetNode(node)["nodeType"]]
    found = [[mbs.GetNodeOutput(node, kind)[3:] for kind in outputs] for node in turning]
    speeds = [v @ v for _, v, _ in found]
    assert max(speeds) > 0.1
    np.testing.assert_allclose([p @ a for p, _, a in found], np.negative(speeds), atol=1e-9)


def test_a_body_that_changes_during_the_run_is_evaluated_by_exudyn_from_then_on(monkeypatch):
    def heavier(mbs, t, body):
        if t > 0.02:
            mbs.SetObjectParameter(body, "mass", 0.6)
        return True

    found = []
    for evaluated in (False, True):
        builder = Builder(3, 2)
        spring(builder)
        of_a_function(builder)
        builder.mbs.SetPreStepUserFunction(lambda mbs, t, b=builder: heavier(mbs, t, b.bodies[0]))
        builder.mbs.Assemble()
        if evaluated:
            monkeypatch.setattr(CoupledScene, "compile_parts", lambda *_: None)
        found.append(run(builder)[0])
    np.testing.assert_allclose(*found, atol=1e-10)


WITHOUT_JOINTS = KINDS[: KINDS.index(spherical_joint)]
JOINTS = KINDS[KINDS.index(spherical_joint) :]


@every_integrator
def test_many_kinds_together_move_as_exudyn_says(integrator, dimension):
    kinds = [*WITHOUT_JOINTS, distances]
    require_the_same(kinds, 8, dimension, integrator, OFF_UNITY[integrator])


@settings(max_examples=10)
@given(seed=st.integers(0, 1000), kinds=st.sets(st.sampled_from(range(len(WITHOUT_JOINTS)))))
def test_random_scenes_move_as_exudyn_says(seed, kinds):
    """One kind of joint, which may close loops with the cable and ground, and any others."""
    chosen = [JOINTS[seed % len(JOINTS)], *(WITHOUT_JOINTS[k] for k in sorted(kinds))]
    require_the_same(chosen, seed, 2 + seed % 2, tolerance=1e-7)


def hanging(change=None):
    """A spring at the cable's end and a body on another one; `change(mbs, spring, load, t)` at each step."""
    builder = Builder(3, 2)
    mbs = builder.mbs
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=builder.ground))
    pairs = [ground, builder.on_cable()], [builder.on_cable(), builder.position(0)]
    springs = [mbs.AddObject(SpringDamper(markerNumbers=p, stiffness=30, referenceLength=0.5)) for p in pairs]
    load = mbs.AddLoad(LoadForceVector(markerNumber=builder.position(1), loadVector=[0, 1, 0]))
    if change is not None:
        mbs.SetPreStepUserFunction(lambda mbs, t: change(mbs, springs[0], load, t) or True)
    mbs.Assemble()
    return builder


def run(builder, explicit=ExplicitSettings(stepSize=1e-3, massScaling=0.3)):  # noqa: B008
    with silence():
        report = SolveExplicit(builder.mbs, quiet_settings(0.1, 50), explicit)
    return np.array(builder.mbs.systemData.GetODE2Coordinates()), report["path"]


def test_a_form_that_disagrees_with_exudyn_is_not_taken_and_named(monkeypatch, fault):
    def softer(*given):
        known = read_connector(*given)
        known.record.stiffness *= 1.0 - 1e-6
        return known

    expected, path = run(hanging())
    assert "in one compiled call" in path
    monkeypatch.setattr(scene, "read_connector", softer)
    found, path = run(hanging())
    assert "Exudyn evaluates them because of node" in path and "forces are others" in path
    np.testing.assert_allclose(found, expected, atol=1e-11)
    fault("a compiled form that disagrees with Exudyn by 1e-6", "Exudyn evaluates the scene, and is named")


def change_all(mbs, spring, load, t):
    mbs.SetLoadParameter(load, "loadVector", [np.sin(50 * t), 2, 0])
    mbs.SetObjectParameter(spring, "stiffness", 30 + 200 * t)


def test_springs_and_loads_that_change_between_steps_are_followed(by_exudyn, monkeypatch):
    expected, path = run(hanging(change_all))
    assert "this test" in path
    monkeypatch.undo()
    found, path = run(hanging(change_all))
    assert "because pre- or post-step user functions may look at it" in path
    np.testing.assert_allclose(found, expected, atol=1e-11)
    assert np.abs(found - run(hanging())[0]).max() > 1e-3


def steered_tree(parameter, value):
    """Coordinates at the end, with a parameter of a robot that is set to `value(t)`; and the path."""
    builder = Builder(3, 3)
    number, _ = random_tree(builder)
    pair = [link(builder, number, 6), builder.on_cable()]
    builder.mbs.AddObject(SpringDamper(markerNumbers=pair, stiffness=40, referenceLength=0.4))
    builder.mbs.SetPreStepUserFunction(
        lambda mbs, t: mbs.SetObjectParameter(number, parameter, value(t)) or True
    )
    builder.mbs.Assemble()
    return run(builder)


def wave(t):
    return np.linspace(1, 3, 7) * (1.5 + np.sin(50 * t))


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        ("gravity", lambda t: [9 * np.sin(50 * t), 2, 0]),
        ("jointForceVector", wave),
        ("jointPositionOffsetVector", wave),
        ("jointVelocityOffsetVector", wave),
        ("jointPControlVector", wave),
        ("jointDControlVector", wave),
        ("linkForces", lambda t: exudyn.Vector3DList([[np.sin(50 * t), 2, 0]] * 7)),
    ],
)
def test_what_acts_on_a_tree_may_change_between_steps(by_exudyn, monkeypatch, parameter, value):
    expected, _ = steered_tree(parameter, value)
    monkeypatch.undo()
    found, path = steered_tree(parameter, value)
    assert ("one right-hand side" in path) is (parameter == "linkForces")
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
    assert np.abs(found - steered_tree(parameter, lambda t: value(0.0))[0]).max() > 1e-4


def test_a_spring_that_is_switched_off_is_evaluated_by_exudyn_from_then_on():
    def release(mbs, spring, load, t):
        if t > 0.05:
            mbs.SetObjectParameter(spring, "activeConnector", False)

    def soften(mbs, spring, load, t):
        if t > 0.05:
            mbs.SetObjectParameter(spring, "stiffness", 0.0)

    np.testing.assert_allclose(run(hanging(release))[0], run(hanging(soften))[0], atol=1e-11)


def test_a_change_that_nobody_was_told_of_is_an_error(fault):
    bound = []

    def change(mbs, spring, load, t):
        bound[0](spring, "stiffness", 60.0)

    builder = hanging(change)
    bound.append(builder.mbs.SetObjectParameter)
    with pytest.raises(SceneError, match=r"changed during the run without its notice: node .*by name"):
        run(builder)
    fault("a spring changed behind the run's back", "the run ends with an error that names the node")


@pytest.mark.parametrize("compiled", [True, False])
def test_a_rail_carries_the_weight_of_its_slider_and_the_pull_of_the_cable(compiled):
    """The rail is a constraint of one coordinate; the slider hangs from the cable's end."""

    def build():
        builder = Builder(4, 2)
        mbs = builder.mbs
        point = mbs.CreateMassPoint(
            mass=0.3, referencePosition=[1.2, 0, 0], gravity=[0, -9.81, 0], returnDict=True
        )
        node = point["nodeNumber"]
        ground = builder.coordinate(mbs.AddNode(NodePointGround()), 0)
        tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=builder.cable["nodes"][-1]))
        pair = [tip, mbs.AddMarker(MarkerNodePosition(nodeNumber=node))]
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, builder.coordinate(node, 1)]))
        mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
        containers.append(builder.container)
        return mbs

    containers = []
    q, forces, path = moved(build, "RATTLE", compiled)
    assert ("in one compiled call" in path) is compiled
    rail, pull = forces[-4], forces[-2]
    assert pull != pytest.approx(0.0, abs=1e-3)
    assert rail + pull == pytest.approx(-0.3 * 9.81, abs=1e-9)
    assert q[-2] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("damping", [0.0, 1e-4], ids=["a hanger", "damped"])
def test_cables_of_two_kinds_move_as_exudyn_says(damping):
    """Two plain ones, which form one chain, after one with a link, or before one with damping."""

    def build():
        builder = Builder(4, 2)
        mbs, others = builder.mbs, []
        for y, template in ((0.5, 0.0), (1.0, damping)):
            others.append(
                CreateInextensibleCable(
                    mbs,
                    beamTemplate=InextensibleCable(0.2, 0.01, bendingDamping=template),
                    positionStart=[0, y, 0],
                    positionEnd=[1, y, 0],
                    numberOfElements=3,
                    gravity=[0, -9.81, 0],
                    groundConstraintsStart=[True, True, False, False],
                )
            )
        ends = [builder.cable["nodes"][-1], *(cable["nodes"][-1] for cable in others)]
        markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in ends]
        mbs.AddObject(SpringDamper(markerNumbers=markers[:2], stiffness=20, referenceLength=0.5))
        mbs.AddObject(DistanceConstraint(markerNumbers=markers[1:], distance=0.5))
        if not damping:
            hook = mbs.AddNode(NodePointGround(referenceCoordinates=[0.59, 0.5, 0]))
            linked = builder.cable["nodes"][2]
            pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (linked, hook)]
            mbs.AddObject(DistanceConstraint(markerNumbers=pair, distance=float(np.hypot(0.01, 0.5))))
        containers.append(builder.container)
        return mbs

    containers = []
    ours, _, path = moved(build, "RATTLE", True)
    theirs, _, _ = moved(build, "RATTLE", False)
    assert "in one compiled call" in path
    np.testing.assert_allclose(ours, theirs, atol=1e-11)


def test_reactions_at_the_end_are_those_of_the_form_that_took_the_last_steps(by_exudyn, monkeypatch):
    """A spring is switched off half way, so that Exudyn evaluates what follows."""

    def release(mbs, spring, load, t):
        if t > 0.05:
            mbs.SetObjectParameter(spring, "activeConnector", False)

    def with_a_joint():
        builder = hanging(release)
        spherical_joint(builder)
        builder.mbs.Assemble()
        return builder

    found = []
    for _ in range(2):
        builder = with_a_joint()
        run(builder, ExplicitSettings(stepSize=1e-3, massScaling=0.3, startTolerance=100.0))
        found.append(np.array(builder.mbs.systemData.GetAECoordinates()))
        monkeypatch.undo()
    assert np.abs(found[0]).max() > 0.1
    np.testing.assert_allclose(found[1], found[0], atol=1e-5 * np.abs(found[0]).max())
