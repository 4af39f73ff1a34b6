"""Bodies that slide along a cable by Exudyn's ObjectJointSliding2D."""

from itertools import pairwise
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyCable2DCoordinates,
    MarkerBodyMass,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    NodeGenericData,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectJointSliding2D,
    ObjectRigidBody2D,
    SensorNode,
    SensorObject,
)

from exudyn_inext import (
    CableShape,
    CreateCompanionCables,
    CreateInextensibleCable,
    DivergenceError,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.element.shape_functions import shape_functions
from exudyn_inext.errors import SceneError
from exudyn_inext.native.compiled_form import OF_DIFFERENCES
from exudyn_inext.native.known import joints as known_joints
from exudyn_inext.native.known.unknown import UnknownItemError
from reference_models.model import quiet_settings, silence

G, LENGTH, END = 9.81, 4.4, [4.0, 0.1]
MASS, ARM = 0.4, 0.3  # of the trolley, and how far its centre of mass hangs below the cable
OUTPUT, KEPT = exudyn.OutputVariableType, {"storeInternal": True}


def inextensible(mbs, shape, section):
    cable = CreateInextensibleCable(
        mbs,
        beamTemplate=InextensibleCable(**section),
        shape=shape,
        gravity=[0, -G, 0],
        groundConstraintsStart=[True, True, False, False],
        groundConstraintsEnd=[True, True, False, False],
        dimension=2,
    )
    return cable["nodes"], CreateCompanionCables(mbs, cable)


def native(mbs, shape, section, axial=1e6):
    """Its twin of Exudyn's own elements."""
    length = float(shape.elementLengths)
    places = zip(shape.positions, shape.slopes, strict=True)
    nodes = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[*p[:2], *t[:2]])) for p, t in places]
    given = dict(length=length, axialStiffness=axial, **section)
    elements = [mbs.AddObject(ObjectANCFCable2D(nodeNumbers=list(pair), **given)) for pair in pairwise(nodes)]
    for element in elements:
        marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=element))
        mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, -G, 0]))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for node in (nodes[0], nodes[-1]):
        for k in range(2):
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
            mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    return nodes, elements


def trolley(make, elements=16, start=0.55, mass=MASS, arm=ARM, **joint):
    """A rigid body that hangs on a slack cable."""
    scene = SimpleNamespace(container=exudyn.SystemContainer())
    mbs = scene.mbs = scene.container.AddSystem()
    shape = CableShape.Catenary([0, 0], END, LENGTH, elements, gravity=[0, -1])
    section = dict(massPerLength=0.3, bendingStiffness=1.0)
    scene.cable_nodes, cables = make(mbs, shape, section)
    length = float(shape.elementLengths)
    segment = int(start / length)
    weights = shape_functions(start / length - segment, length)
    two = slice(segment, segment + 2)
    nodal = np.stack([shape.positions[two], shape.slopes[two]], axis=1)[..., :2].reshape(4, 2)
    x, y = weights @ nodal
    scene.node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[x, y - arm, 0]))
    inertia = mass * (arm**2 + 0.01) / 6
    body = mbs.AddObject(ObjectRigidBody2D(nodeNumber=scene.node, mass=mass, inertia=inertia))
    centre, top = (
        mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[0, up, 0])) for up in (0, arm)
    )
    mbs.AddLoad(LoadForceVector(markerNumber=centre, loadVector=[0, -mass * G, 0]))
    markers = [mbs.AddMarker(MarkerBodyCable2DCoordinates(bodyNumber=cable)) for cable in cables]
    kinds = {"place": OUTPUT.Position, "speed": OUTPUT.Velocity, "spin": OUTPUT.AngularVelocity}
    scene.sensors = {
        name: mbs.AddSensor(SensorNode(nodeNumber=scene.node, outputVariableType=kind, **KEPT))
        for name, kind in kinds.items()
    }
    slide(scene, ObjectJointSliding2D, top, markers, length, start, **joint)
    mbs.Assemble()
    return scene


def slide(scene, kind, top, markers, length, start, **joint):
    """Let the marker `top` slide along elements of that length, from the arc length `start` on."""
    mbs, segment = scene.mbs, int(start / length)
    data = mbs.AddNode(NodeGenericData(initialCoordinates=[segment, start], numberOfDataCoordinates=2))
    offsets = [length * k for k in range(len(markers))]
    given = dict(slidingMarkerNumbers=markers, slidingMarkerOffsets=offsets, nodeNumber=data) | joint
    scene.joint = mbs.AddObject(kind(name="trolley", markerNumbers=[top, markers[segment]], **given))
    for what in ("SlidingCoordinate", "Force"):
        sensor = SensorObject(objectNumber=scene.joint, outputVariableType=getattr(OUTPUT, what), **KEPT)
        scene.sensors[what] = mbs.AddSensor(sensor)


def run(scene, end=1.0, step=1e-3, solve=SolveExplicit, restarts=None, **explicit):
    """Values of the sensors, without times."""
    settings = quiet_settings(end, round(end / step))
    settings.solution.sensors.writePeriod = end / 20
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    if restarts:
        restart = settings.solution.restart
        restart.write, restart.name, restart.writePeriod = True, str(restarts), 0.5
        restart.continueIfAvailable = True
    if solve is SolveExplicit:
        scene.report = SolveExplicit(scene.mbs, settings, ExplicitSettings(**explicit))
    else:
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
        with silence():
            scene.mbs.SolveDynamic(settings)
    return {name: scene.mbs.GetSensorStoredData(n)[:, 1:] for name, n in scene.sensors.items()}


@pytest.mark.parametrize("is_classical", [True, False])
def test_a_trolley_crosses_elements_as_with_native_cables(is_classical):
    ours = run(trolley(inextensible, 32, useClassicalFormulation=is_classical))
    theirs = run(trolley(native, 32, useClassicalFormulation=is_classical), solve=None)
    assert np.ptp(ours["SlidingCoordinate"]) > 8 * LENGTH / 32
    for name in ("place", "SlidingCoordinate"):
        assert np.allclose(ours[name], theirs[name], rtol=0, atol=1e-3 * LENGTH), name


def test_a_heavy_trolley_goes_on_after_steps_that_went_wrong():
    """It pulls the cable tight: steps that end in no numbers are taken again, from where it was."""
    scene, fine = (trolley(inextensible, mass=100 * MASS) for _ in range(2))
    found, expected = run(scene, 0.6), run(fine, 0.6, stepSize=1e-4)
    assert scene.report["rejections"] > 0
    for name in ("place", "SlidingCoordinate"):
        assert np.allclose(found[name], expected[name], rtol=0, atol=1e-3), name


def test_a_trolley_crosses_elements_beside_a_dashpot_that_is_implicit():
    scenes = [trolley(inextensible) for _ in range(2)]
    for scene in scenes:
        mbs, node = scene.mbs, scene.cable_nodes[8]
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
        mbs.AddObject(CoordinateSpringDamper(markerNumbers=[ground, marker], damping=100.0))
        mbs.Assemble()
    found, expected = run(scenes[0]), run(scenes[1], stepSize=1e-4)
    assert scenes[1].report["bounds"].bending < 1e-3 < scenes[0].report["bounds"].bending
    assert np.ptp(found["SlidingCoordinate"]) > 4 * LENGTH / 16
    assert np.allclose(found["place"], expected["place"], rtol=0, atol=2e-4)


def push(scene, speed):
    """Let the trolley begin with a speed along x [m/s]."""
    data, initial = scene.mbs.systemData, exudyn.ConfigurationType.Initial
    velocities = np.array(data.GetODE2Coordinates_t(initial))
    velocities[data.GetNodeLTGODE2(scene.node)[0]] = speed
    data.SetODE2Coordinates_t(velocities, initial)


def test_a_light_bead_keeps_its_energy_on_a_cable_that_rests():
    bead = trolley(inextensible, mass=1e-6)
    SolveEquilibrium(bead.mbs)
    push(bead, 2.5)
    found = run(bead, 0.8)
    assert np.ptp(found["SlidingCoordinate"]) > 4 * LENGTH / 16
    squares = (found["speed"] ** 2).sum(axis=1) + (ARM**2 + 0.01) / 6 * found["spin"][:, 2] ** 2
    assert np.ptp(squares) > 0.2 * 2.5**2
    energy = 0.5 * squares + G * found["place"][:, 1]
    assert np.allclose(energy, energy[0], rtol=0, atol=1e-4 * 2.5**2)


def test_a_trolley_at_rest_hangs_where_the_cable_is_level_and_stays_there():
    scene = trolley(inextensible)
    SolveEquilibrium(scene.mbs)
    place = scene.mbs.GetObjectOutput(scene.joint, OUTPUT.SlidingCoordinate)
    found = run(scene, 0.3)
    assert np.allclose(found["SlidingCoordinate"], place, rtol=0, atol=1e-8)
    assert np.allclose(found["Force"], [0, MASS * G, 0], rtol=0, atol=1e-6)
    assert np.allclose(found["place"][-1, :2] + [0, ARM], foot_of(scene, place), rtol=0, atol=1e-8)


def foot_of(scene, s):
    """Position of the cable at s, from its nodes."""
    length = LENGTH / 16
    pair = scene.cable_nodes[int(s / length) : int(s / length) + 2]
    nodal = [
        np.array(scene.mbs.GetNodeOutput(n, OUTPUT.Coordinates))
        + scene.mbs.GetNode(n)["referenceCoordinates"]
        for n in pair
    ]
    return shape_functions(s / length % 1.0, length) @ np.reshape(nodal, (4, 2))


def test_the_data_node_says_element_and_place():
    scene = trolley(inextensible)
    found = run(scene)
    s = found["SlidingCoordinate"][-1, 0]
    assert scene.mbs.systemData.GetDataCoordinates() == pytest.approx([int(s / (LENGTH / 16)), s])
    turn = scene.mbs.GetNodeOutput(scene.node, OUTPUT.Coordinates)[2]
    top = found["place"][-1, :2] + ARM * np.array([-np.sin(turn), np.cos(turn)])
    assert np.allclose(top, foot_of(scene, s), rtol=0, atol=1e-8)


def test_exudyns_evaluation_and_the_compiled_form_agree(monkeypatch):
    compiled = run(trolley(inextensible), 0.3)

    def refuse(joint, reader):
        raise UnknownItemError("the trolley")

    monkeypatch.setattr(known_joints, "_sliding", refuse)
    scene = trolley(inextensible)
    found = run(scene, 0.3)
    assert "the trolley" in scene.report["path"]
    assert np.allclose(found["place"], compiled["place"], rtol=0, atol=1e-8)
    assert np.allclose(found["SlidingCoordinate"], compiled["SlidingCoordinate"], rtol=0, atol=1e-8)
    of_differences = OF_DIFFERENCES * np.abs(compiled["Force"]).max()
    difference = np.abs(found["Force"] - compiled["Force"]).max()
    assert difference < of_differences


def test_elements_of_some_millimetres_are_compiled():
    """The states at which both forms are compared do not fold the cable."""
    scene = trolley(inextensible, elements=500, start=0.552)
    run(scene, 1e-4, 1e-4)
    assert "compiled call" in scene.report["path"]


def test_a_run_goes_on_from_a_restart_file(tmp_path):
    whole = run(trolley(inextensible))
    run(trolley(inextensible), 0.5, restarts=tmp_path / "half")
    rest = run(trolley(inextensible), restarts=tmp_path / "half")
    for name in ("place", "SlidingCoordinate"):
        assert len(rest[name]) < len(whole[name])
        assert np.allclose(rest[name][-5:], whole[name][-5:], rtol=0, atol=1e-12), name


def test_who_leaves_the_cable_is_named_with_the_remedy():
    scene = trolley(inextensible)
    push(scene, 20.0)
    says = (
        r"'trolley' \(JointSliding2D\).* beyond the end of the elements in its slidingMarkerNumbers.*stop the"
    )
    warned = pytest.warns(UserWarning, match="initial velocities violate")
    with warned, pytest.raises(DivergenceError, match=says):
        run(scene)
    s = scene.mbs.GetObjectOutput(scene.joint, OUTPUT.SlidingCoordinate)
    assert 0.8 * LENGTH < s < LENGTH


def test_a_stepper_refuses_what_slides():
    with pytest.raises(SceneError, match=r"ExplicitStepper does not say where joints .* use SolveExplicit"):
        ExplicitStepper(trolley(inextensible).mbs)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"constrainRotation": True}, "'trolley' .* has constrainRotation = True, .* leave it out"),
        ({"axialForce": 2.0}, r"'trolley' .* has axialForce = 2\.0, .* leave it out"),
        (
            {"slidingMarkerOffsets": [0.2 * k for k in range(16)]},
            "has slidingMarkerOffsets .* follow each other",
        ),
    ],
)
def test_what_is_not_supported_is_refused(changes, says):
    with pytest.raises(SceneError, match=says):
        run(trolley(inextensible, **changes))
