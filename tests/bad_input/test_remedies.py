"""What a message advises works when it is followed."""

import math
import re

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadForceVector,
    MarkerBodyCable2DCoordinates,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericData,
    NodePointGround,
    ObjectANCFCable2D,
    ObjectConnectorCartesianSpringDamper,
    ObjectJointSliding2D,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    AddMarkerOnCable,
    AttachToBody,
    CableShape,
    CreateCompanionCables,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    InputError,
    RedundantConstraintError,
    SceneError,
    SolveExplicit,
    StepSizeError,
)
from exudyn_inext.integrators import find_integrator
from exudyn_inext.run.divergence import explanation
from reference_models.model import quiet_settings, silence

from .scenes import SECTION, cable_arguments, empty, run

CLAMPED = {"groundConstraintsStart": [True] * 4}
PIN = [True, True, False, False]


def native_run(mbs, sparse=False):
    settings = quiet_settings(0.02, 20)
    if sparse:
        settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    with silence():
        return mbs.SolveDynamic(settings)


def cable_and_body(**changes):
    scene = empty()
    scene.cable = CreateInextensibleCable(scene.mbs, **cable_arguments(**(CLAMPED | changes)))
    scene.body = scene.mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.1] * 3), referencePosition=[0.2, 0, 0], create2D=True
    )
    scene.on_body = scene.mbs.AddMarker(MarkerBodyRigid(bodyNumber=scene.body))
    return scene


def sliding_body(holds_rotation=False, **changes):
    """A body that slides along a cable of three elements."""
    scene = cable_and_body(**changes)
    mbs = scene.mbs
    elements = CreateCompanionCables(mbs, scene.cable)
    markers = [mbs.AddMarker(MarkerBodyCable2DCoordinates(bodyNumber=element)) for element in elements]
    place = mbs.AddNode(NodeGenericData(initialCoordinates=[0, 0.2], numberOfDataCoordinates=2))
    mbs.AddObject(
        ObjectJointSliding2D(
            name="slider",
            markerNumbers=[scene.on_body, markers[0]],
            slidingMarkerNumbers=markers,
            slidingMarkerOffsets=[0.6 * k for k in range(3)],
            nodeNumber=place,
            constrainRotation=holds_rotation,
        )
    )
    mbs.Assemble()
    return mbs


def test_a_sliding_joint_that_holds_the_rotation_is_refused_and_runs_with_native_solvers():
    says = (
        r"'slider' \(JointSliding2D\) has constrainRotation = True.*leave it out, or.*enforcement='algebraic'"
    )
    with pytest.raises(SceneError, match=says):
        run(sliding_body(True))
    assert run(sliding_body())["success"]
    assert native_run(sliding_body(True, enforcement="algebraic"))


def test_a_body_may_hang_on_a_point_of_the_cable_by_a_spring():
    scene = cable_and_body()
    mbs = scene.mbs
    markers = [scene.on_body, AddMarkerOnCable(mbs, scene.cable, 0.2)]
    mbs.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=markers, stiffness=[1e3] * 3))
    mbs.Assemble()
    assert run(mbs)["success"]


@pytest.mark.parametrize(
    ("template", "flags"),
    [
        (InextensibleCable(**SECTION), [True] * 3 + [False] * 3),
        (ObjectANCFCable2D(**SECTION), [True] * 3 + [False] * 3),
        (InextensibleCable(**SECTION), [True, True, True, False]),
    ],
)
def test_flags_of_the_other_dimension_are_told_how_to_get_it(template, flags):
    mbs = empty().mbs
    arguments = cable_arguments(beamTemplate=template)
    with pytest.raises(InputError, match=r"For a cable in space, .*use dimension = 3\."):
        CreateInextensibleCable(mbs, **arguments, groundConstraintsStart=flags)
    in_space = [*flags, *[False] * 6][:6]
    CreateInextensibleCable(mbs, **arguments, groundConstraintsStart=in_space, dimension=3)
    mbs.Assemble()
    assert run(mbs)["success"]


def test_a_planar_scene_in_space_is_told_how_to_stay_in_the_plane():
    mbs = empty().mbs
    with pytest.raises(InputError, match=r"leave z components out of shape.*dimension = 2\."):
        CreateInextensibleCable(mbs, **cable_arguments(gravity=[0, 0, -9.81]), groundConstraintsStart=PIN)
    CreateInextensibleCable(mbs, **cable_arguments(dimension=2), groundConstraintsStart=PIN)
    mbs.Assemble()
    assert run(mbs)["success"]


@pytest.mark.parametrize("kind", [MarkerBodyPosition, MarkerBodyMass])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_marker_on_the_object_of_a_cable_is_told_what_takes_its_place(kind, dimension):
    scene = empty()
    mbs = scene.mbs
    cable = CreateInextensibleCable(mbs, **cable_arguments(dimension=dimension))
    mbs.AddMarker(kind(bodyNumber=cable["elements"][0]))
    says = r"AddMarkerOnCable\(mbs, cable, arcLength\).*MarkerNodePosition.*for weight the argument gravity"
    with silence(), pytest.raises(exudyn.ModelError):
        mbs.Assemble()
    with pytest.raises(SceneError, match=says):
        run(mbs)
    scene = empty()
    cable = CreateInextensibleCable(scene.mbs, **cable_arguments(dimension=dimension))
    node = scene.mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    for marker in (AddMarkerOnCable(scene.mbs, cable, 0.7), node):
        scene.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0.1, 0]))
    scene.mbs.Assemble()
    assert run(scene.mbs)["success"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_ring_is_told_which_joint_holds_it(dimension):
    scene = empty()
    mbs = scene.mbs
    ring = CreateInextensibleCable(
        mbs,
        shape=CableShape.Circle([0, 0], 0.5, numberOfElements=8),
        beamTemplate=InextensibleCable(**SECTION),
        gravity=[0, -9.81, 0],
        dimension=dimension,
    )
    ground = mbs.CreateGround(referencePosition=[0.5, 0, 0])
    with pytest.raises(InputError, match=r"closed cable has no ends.* SphericalJoint of Marker") as caught:
        AttachToBody(mbs, ring, "start", ground)
    axes = re.search(r"\(in the plane with constrainedAxes=\[(.*)\]\)", str(caught.value))[1]
    markers = [
        mbs.AddMarker(MarkerNodePosition(nodeNumber=ring["nodes"][0])),
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground)),
    ]
    joint = mbs.AddObject(SphericalJoint(markerNumbers=markers))
    mbs.Assemble()
    if dimension == 2:
        with pytest.raises(SceneError, match=rf"across the plane.* by constrainedAxes=\[{axes}\]"):
            run(mbs)
        mbs.SetObjectParameter(joint, "constrainedAxes", [int(axis) for axis in axes.split(",")])
        mbs.Assemble()
    assert run(mbs)["success"]


def rope(sag, **changes):
    """Between held ends; sag: what it is longer than their distance [-]."""
    mbs = empty().mbs
    x = np.linspace(-0.5, 0.5, 9)
    height = math.sqrt(6.0 * sag)  # of a parabola, nearly
    slopes = np.stack([np.ones(9), 8.0 * height * x / 2.0], axis=1)
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    shape = CableShape(np.stack([x, 2.0 * height * x**2], axis=1), slopes)
    template = InextensibleCable(0.1, 1e-3)
    held = {"groundConstraintsStart": PIN, "groundConstraintsEnd": PIN}
    arguments = {"shape": shape, "beamTemplate": template, "gravity": [0, -9.81, 0]} | held
    CreateInextensibleCable(mbs, **(arguments | {"enforcement": "algebraic"} | changes))
    mbs.Assemble()
    return mbs


def test_a_straight_rope_between_held_ends_is_refused_by_its_reason():
    mbs = empty().mbs
    before = mbs.systemData.NumberOfNodes()
    says = r"enforcement = 'algebraic': .*depend on each other.*straight cable.*sag.*free a support"
    held = {"groundConstraintsStart": PIN, "groundConstraintsEnd": PIN}
    with pytest.raises(RedundantConstraintError, match=says):
        CreateInextensibleCable(mbs, **cable_arguments(enforcement="algebraic"), **held)
    assert mbs.systemData.NumberOfNodes() == before
    assert native_run(rope(0.01))
    assert native_run(rope(0.0, groundConstraintsEnd=None))


@pytest.mark.parametrize("joints", [False, True], ids=["coordinates", "joints"])
@pytest.mark.parametrize("sparse", [False, True], ids=["dense", "sparse"])
def test_a_straight_rope_on_native_constraints_is_refused_by_their_names(joints, sparse):
    """Where native solvers end with 'matrix is not factorized' only."""

    def held_rope(sag, ends):
        mbs = rope(sag, groundConstraintsStart=None, groundConstraintsEnd=None)
        for node in ends:
            (hold_by_a_joint if joints else hold_by_coordinates)(mbs, node)
        mbs.Assemble()
        return mbs

    says = (
        r"(?s)length constraints of the cable and object \d 'left.*, object \d 'right.* depend on each other"
    )
    both = [(0, "left"), (8, "right")]
    straight = held_rope(0.0, both)
    for _ in range(2):
        with silence(), pytest.raises(Exception, match=says):
            native_run(straight, sparse)
    assert native_run(held_rope(0.01, both), sparse)
    assert native_run(held_rope(0.0, both[:1]), sparse)


def hold_by_coordinates(mbs, end):
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for coordinate in range(2):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=end[0], coordinate=coordinate))
        mbs.AddObject(CoordinateConstraint(name=f"{end[1]}{coordinate}", markerNumbers=[ground, marker]))


def hold_by_a_joint(mbs, end):
    point = [*mbs.GetNode(end[0])["referenceCoordinates"][:2], 0]
    nodes = mbs.AddNode(NodePointGround(referenceCoordinates=point)), end[0]
    markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes]
    mbs.AddObject(SphericalJoint(name=end[1], markerNumbers=markers, constrainedAxes=[1, 1, 0]))


def test_a_step_above_the_limit_is_told_a_step_and_a_scaling_that_are_accepted():
    mbs = empty().mbs
    CreateInextensibleCable(mbs, **cable_arguments(numberOfElements=10), groundConstraintsStart=PIN)
    mbs.Assemble()
    with pytest.raises(StepSizeError) as caught:
        run(mbs, explicit=ExplicitSettings(stepSize=1e-3))
    message = str(caught.value)
    step = float(re.search(r"reduce the step below (\S+) s", message)[1])
    scaling = float(re.search(r"set massScaling = (\S+)\.$", message)[1])
    for explicit in ({"stepSize": step}, {"stepSize": 1e-3, "massScaling": scaling}):
        with silence():
            assert SolveExplicit(mbs, quiet_settings(2e-3, 2), ExplicitSettings(**explicit))["success"]


def test_a_rope_without_bending_stiffness_is_told_one_that_does_not_matter():
    """With ten times as much, its end moves by less than 0.1 % of its length."""
    with pytest.raises(InputError, match="bendingStiffness = 0") as caught:
        CreateInextensibleCable(empty().mbs, **cable_arguments(beamTemplate=InextensibleCable(1.0, 0.0)))
    share = float(re.search(r"such as (\S+) g massPerLength length\^3", str(caught.value))[1])
    ends = []
    for more in (1.0, 10.0):
        mbs = empty().mbs
        rope = InextensibleCable(massPerLength=1.0, bendingStiffness=more * share * 9.81)
        line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": 8}
        cable = CreateInextensibleCable(
            mbs, **line, beamTemplate=rope, gravity=[0, -9.81, 0], groundConstraintsStart=PIN
        )
        mbs.Assemble()
        with silence():
            SolveExplicit(mbs, quiet_settings(0.3, 4))
        ends.append(mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position))
    assert np.abs(ends[1] - ends[0]).max() < 1e-3


def test_scaling_that_is_set_already_or_does_not_help_is_not_advised():
    """Too little of it; and a spring that is too stiff for the step."""
    for stiffness, explicit in ((0.0, {"massScaling": 1e-6}), (1e8, {})):
        mbs = empty().mbs
        CreateInextensibleCable(mbs, **cable_arguments(), groundConstraintsStart=PIN)
        if stiffness:
            stone = mbs.CreateMassPoint(mass=0.1, referencePosition=[0, 1, 0])
            ground = mbs.CreateGround(referencePosition=[0, 1, 0])
            mbs.CreateCartesianSpringDamper(itemNumbers=[stone, ground], stiffness=[stiffness] * 3)
        mbs.Assemble()
        settings = quiet_settings(0.1, 2)
        with silence(), pytest.raises(StepSizeError, match="reduce the step") as caught:
            SolveExplicit(mbs, settings, ExplicitSettings(stepSize=2e-2, **explicit))
        assert "massScaling" not in str(caught.value)


@pytest.mark.parametrize("name", ["RATTLE", "Zhai"])
def test_a_limit_that_is_not_known_is_not_quoted(name):
    said = explanation(find_integrator(name), "", 1e-3, math.inf, scaled=True)
    assert "%" not in said
    assert "reduce stepSize" in said
    assert "at less than 1% of" in explanation(find_integrator(name), "", 1e-9, 1.0, scaled=True)
