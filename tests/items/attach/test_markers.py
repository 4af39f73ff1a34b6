"""Markers on a cable: which work, and what a user reads who tries another one."""

import exudyn
import pytest
from exudyn.itemInterface import (
    MarkerBodyCable2DShape,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodeCoordinates,
    MarkerNodePosition,
    MarkerNodeRigid,
    MarkerNodeRotationCoordinate,
    MarkerObjectODE2Coordinates,
    MarkerSuperElementPosition,
    MarkerSuperElementRigid,
    ObjectGround,
    SensorBody,
)

from exudyn_inext import CableForces, SceneError, SolveExplicit

ON_OBJECT = {
    "BodyPosition": lambda number: MarkerBodyPosition(bodyNumber=number),
    "BodyMass": lambda number: MarkerBodyMass(bodyNumber=number),
    "BodyRigid": lambda number: MarkerBodyRigid(bodyNumber=number),
    "BodyCable2DShape": lambda number: MarkerBodyCable2DShape(bodyNumber=number, numberOfSegments=3),
    "SuperElementPosition": lambda number: MarkerSuperElementPosition(
        bodyNumber=number, meshNodeNumbers=[0], weightingFactors=[1.0]
    ),
    "SuperElementRigid": lambda number: MarkerSuperElementRigid(
        bodyNumber=number, meshNodeNumbers=[0, 1], weightingFactors=[0.5, 0.5]
    ),
}
ON_NODE = {
    "NodePosition": lambda number: MarkerNodePosition(nodeNumber=number),
    "NodeCoordinate": lambda number: MarkerNodeCoordinate(nodeNumber=number, coordinate=1),
    "NodeCoordinates": lambda number: MarkerNodeCoordinates(nodeNumber=number),
    "NodeRigid": lambda number: MarkerNodeRigid(nodeNumber=number),
    "NodeRotationCoordinate": lambda number: MarkerNodeRotationCoordinate(
        nodeNumber=number, rotationCoordinate=2
    ),
}
WORKS = [(2, "NodePosition"), (2, "NodeCoordinate"), (2, "NodeCoordinates"), (2, "NodeRigid")]
WORKS += [(3, "NodePosition"), (3, "NodeCoordinate"), (3, "NodeCoordinates")]
FAILS = [(2, "NodeRotationCoordinate"), (3, "NodeRigid"), (3, "NodeRotationCoordinate")]


@pytest.fixture
def add_marker(mbs, add_cable):
    def add(dim, kind):
        cable = add_cable(mbs, dimension=dim)
        item = (
            ON_OBJECT[kind](cable["elements"][0]) if kind in ON_OBJECT else ON_NODE[kind](cable["nodes"][1])
        )
        mbs.AddMarker(item)
        return mbs, cable

    return add


@pytest.mark.parametrize(("dim", "kind"), WORKS)
def test_markers_of_the_documentation_work(add_marker, solve, dim, kind):
    mbs, _ = add_marker(dim, kind)
    mbs.Assemble()
    if dim == 2:
        assert "in one compiled call" in solve(mbs, 0.01)["path"]


def test_marker_on_all_coordinates_of_the_object_works(mbs, add_cable, solve):
    mbs.AddMarker(MarkerObjectODE2Coordinates(objectNumber=add_cable(mbs)["elements"][0]))
    mbs.Assemble()
    assert solve(mbs, 0.01)["success"]


@pytest.mark.parametrize(("dim", "kind"), FAILS + [(dim, kind) for dim in (2, 3) for kind in ON_OBJECT])
def test_other_markers_are_refused_and_told_which_can(add_marker, dim, kind):
    mbs, cable = add_marker(dim, kind)
    where = "object 0" if kind in ON_OBJECT else f"{dim}D node 1"
    message = rf"marker 0 'marker0' \(Marker{kind}\) on the cable's {where}: on a cable use AddMarkerOnCable"
    with pytest.raises(exudyn.ModelError, match=rf"(?s)Marker 0.*{message}") as caught:
        mbs.Assemble()
    assert "Python file" not in str(caught.value)
    for use in (SolveExplicit, lambda mbs: CableForces(mbs, cable)):
        with pytest.raises(SceneError, match=message):
            use(mbs)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_sensor_on_the_object_is_told_what_takes_its_place(mbs, add_cable, dim):
    body = add_cable(mbs, dimension=dim)["elements"][0]
    kind = exudyn.OutputVariableType.Position
    mbs.AddSensor(SensorBody(bodyNumber=body, localPosition=[0.5, 0, 0], outputVariableType=kind))
    message = (
        r"(?s)Sensor 0.*sensor 0 'sensor0' \(SensorBody\) on the cable's object 0: on a cable use AddMarkerOn"
    )
    with pytest.raises(exudyn.ModelError, match=message):
        mbs.Assemble()


def test_other_errors_of_exudyn_stay_as_they_are(mbs, add_cable):
    add_cable(mbs)
    ground = mbs.AddObject(ObjectGround())
    mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=[0, 0, 0]))
    kind = exudyn.OutputVariableType.StrainLocal
    mbs.AddSensor(SensorBody(bodyNumber=ground, localPosition=[0, 0, 0], outputVariableType=kind))
    with pytest.raises(exudyn.ModelError) as caught:
        mbs.Assemble()
    assert "AddMarkerOnCable" not in str(caught.value)
