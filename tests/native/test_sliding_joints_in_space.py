"""Bodies that slide along a cable in space by Exudyn's ObjectJointSliding."""

from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    CartesianSpringDamper,
    MarkerBodyBeamShape,
    MarkerBodyPosition,
    MarkerBodyRigid,
    ObjectANCFCable,
    ObjectJointSliding,
    SensorBody,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    ComputeEigenvalues,
    CreateCompanionCables,
    CreateInextensibleCable,
    SolveEquilibrium,
)
from exudyn_inext.errors import SceneError
from exudyn_inext.native.known import joints as known_joints
from exudyn_inext.native.known.unknown import UnknownItemError

from .test_sliding_joints import KEPT, OUTPUT, run, slide

LENGTH, ELEMENTS, START, ARM = 2.0, 16, 0.7, 0.2
MASS, PULL = 0.6, [1.0, -9.81, 3.0]  # of the trolley [kg, m/s^2]


def inextensible(mbs, **arguments):
    cable = CreateInextensibleCable(mbs, dimension=3, **arguments)
    return CreateCompanionCables(mbs, cable)


def native(mbs, **arguments):
    return GenerateBeamElementsAlongLine(mbs, **arguments)["elements"]


def trolley(make, **joint):
    """A rigid body, pulled sideways, on a cable with one free end."""
    scene = SimpleNamespace(container=exudyn.SystemContainer())
    mbs = scene.mbs = scene.container.AddSystem()
    elements = make(
        mbs,
        positionStart=[0, 0, 0],
        positionEnd=[LENGTH, 0, 0],
        numberOfElements=ELEMENTS,
        beamTemplate=ObjectANCFCable(massPerLength=0.5, bendingStiffness=1.0, axialStiffness=1e5),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True] * 6,
    )
    inertia = InertiaCuboid(1000, [0.04, 0.3, 0.05])
    body = mbs.CreateRigidBody(inertia=inertia, referencePosition=[START, -ARM, 0.02], gravity=PULL)
    top = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[0, ARM, -0.02]))
    markers = [mbs.AddMarker(MarkerBodyBeamShape(bodyNumber=element)) for element in elements]
    scene.sensors = {
        "place": mbs.AddSensor(SensorBody(bodyNumber=body, outputVariableType=OUTPUT.Position, **KEPT))
    }
    given = dict(bodyNumber=body, outputVariableType=OUTPUT.Velocity, **KEPT)
    scene.sensors["speed"] = mbs.AddSensor(SensorBody(**given))
    joint = {"constrainRotations": [0, 0, 0]} | joint
    slide(scene, ObjectJointSliding, top, markers, LENGTH / ELEMENTS, START, **joint)
    mbs.Assemble()
    return scene


def test_a_trolley_crosses_elements_as_with_native_cables():
    scene = trolley(inextensible)
    ours, theirs = run(scene, 0.4), run(trolley(native), 0.4, solve=None)
    assert "compiled call" in scene.report["path"]
    assert np.ptp(ours["SlidingCoordinate"]) > 3 * LENGTH / ELEMENTS
    assert abs(ours["place"][-1, 2]) > 0.05 * LENGTH
    for name in ("place", "SlidingCoordinate"):
        assert np.allclose(ours[name], theirs[name], rtol=0, atol=1e-3 * LENGTH), name


def test_the_force_is_what_moves_the_trolley():
    scene = trolley(inextensible)
    found = run(scene, 0.4)
    impulse = np.trapezoid(found["Force"], dx=0.02, axis=0) + 0.4 * MASS * np.array(PULL)
    momentum = MASS * found["speed"][-1]
    assert np.allclose(impulse, momentum, rtol=0, atol=0.01 * np.abs(momentum).max())


def test_exudyns_evaluation_and_the_compiled_form_agree(monkeypatch):
    compiled = run(trolley(inextensible), 0.1)

    def refuse(joint, reader):
        raise UnknownItemError("the trolley")

    monkeypatch.setattr(known_joints, "_sliding", refuse)
    scene = trolley(inextensible)
    found = run(scene, 0.1)
    assert "the trolley" in scene.report["path"]
    for name in ("place", "SlidingCoordinate"):
        assert np.allclose(found[name], compiled[name], rtol=0, atol=1e-8), name
    assert np.allclose(found["Force"], compiled["Force"], rtol=1e-4, atol=1e-3)


def test_vibrations_of_what_slides_have_a_potential():
    scene = trolley(inextensible)
    mbs = scene.mbs
    ground = mbs.CreateGround(referencePosition=[0.8 * START, -0.5, 0.2])
    body = mbs.GetSensor(scene.sensors["place"])["bodyNumber"]
    markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=number)) for number in (ground, body)]
    mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, stiffness=[20.0] * 3))
    mbs.Assemble()
    report = SolveEquilibrium(mbs)
    assert report["iterations"] <= 15
    found = ComputeEigenvalues(mbs, numberOfEigenvalues=4)["eigenvalues"]
    free_to_spin = np.array([found[0], report["smallestEigenvalue"]])
    assert np.abs(free_to_spin).max() < 1e-8 * found[1]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"constrainRotations": [1, 1, 1]}, r"constrainRotations = \[1, 1, 1\], .* set it to \[0, 0, 0\]"),
        ({"constrainTranslations": [0, 1, 1]}, r"constrainTranslations = \[0, 1, 1\], .* leave it out"),
    ],
)
def test_what_is_not_supported_is_refused(changes, says):
    with pytest.raises(SceneError, match=says):
        run(trolley(inextensible, **changes))
