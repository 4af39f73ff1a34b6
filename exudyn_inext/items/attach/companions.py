"""Companions: native ANCF cables without mass and stiffness on the nodes of an inextensible cable.

Exudyn rejects MarkerBodyPosition, SensorBody and contact on a cable's own object; on these they work.
"""

from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

from exudyn.itemInterface import (
    MarkerBodyPosition,
    MarkerBodyRigid,
    ObjectANCFCable,
    ObjectANCFCable2D,
    VObjectANCFCable,
    VObjectANCFCable2D,
)

from ...cable.attached import place_on_elements
from ...checks import require_finite, require_flag
from ...errors import InputError
from ...scene.model import CableItem
from ..cable_data import point_on_cable, require_cable
from .inert import INERT, nodes_of_inert_cable


def CreateCompanionCables(mbs: Any, cable: Any, show: bool = False) -> list[int]:
    """Native ANCF cables without mass and stiffness on the nodes of a cable, one for each element.

    What Exudyn attaches to bodies then attaches to the cable: MarkerBodyPosition, in the plane also
    MarkerBodyRigid, points beside the axis, MarkerBodyCable2DShape and MarkerBodyCable2DCoordinates, in
    space MarkerBodyBeamShape, SensorBody, and through them loads, springs, joints and contact. Companions
    that nothing acts on change neither motion nor cost of a run. A cable has one set of them: a second call
    returns the first set. Sensors and contour plots show motion, StrainLocal and CurvatureLocal; section
    forces and energies, which companions lack, come from `CreateCableForceSensor` and
    `CreateCableEnergySensor`.

    Contact works in the plane: ObjectContactCircleCable2D and ObjectContactFrictionCircleCable2D, whose
    stiffness and damping bound the steps of SolveExplicit before they close, and
    GeneralContact.AddANCFCable. Exudyn does not tell the stiffness of a GeneralContact: where Exudyn
    evaluates it, as the path of the report says, give a stepSize.

    Args:
        mbs: the system; call mbs.Assemble() afterwards.
        cable: what CreateInextensibleCable returned, or the number of its object.
        show: whether the renderer draws new companions, too, with their contour variables.

    Returns:
        object numbers in the order of the elements.

    Raises:
        InputError: not a cable; mbs is unchanged then.

    Example:
        elements = CreateCompanionCables(mbs, cable)
        mbs.AddSensor(SensorBody(bodyNumber=elements[2], localPosition=[0.1, 0, 0],
            outputVariableType=exu.OutputVariableType.Velocity, storeInternal=True))
    """
    _, item = require_cable(mbs, cable)
    shown = require_flag("show", show)
    existing = _companions_by_nodes(mbs)
    spans = list(pairwise(item.node_names))
    for nodes in spans:  # the system may have been built anew
        if nodes in existing and nodes_of_inert_cable(mbs.GetObject(existing[nodes])) != nodes:
            del existing[nodes]
    return [
        existing[nodes] if nodes in existing else _add_companion(mbs, item, nodes, float(length), shown)
        for nodes, length in zip(spans, item.cable.element_lengths, strict=True)
    ]


def AddMarkerOnCable(
    mbs: Any, cable: Any, arcLength: float, offset: float = 0.0, hasFrame: bool = False
) -> int:
    """A marker on a cable at any arc length, or beside it, for loads, springs, joints and sensors.

    It is a MarkerBodyPosition or MarkerBodyRigid on a companion, see `CreateCompanionCables`, which is
    created if needed. At nodes, MarkerNodePosition, MarkerNodeCoordinate and (planar) MarkerNodeRigid work
    without one, and loads on them keep a run on its fastest path.

    Args:
        mbs: the system; call mbs.Assemble() afterwards.
        cable: what CreateInextensibleCable returned, or the number of its object.
        arcLength: where, 0 to the cable's length [m].
        offset: y of the point r + y n, with the normal n to the left of the slope [m]; planar cables only.
        hasFrame: whether the marker turns with the slope, for torques, rotations and joints that hold them;
            planar cables only.

    Returns:
        marker number.

    Raises:
        InputError: not a cable, the point is not on it, or a frame in space; mbs is unchanged then.

    Example:
        mbs.AddLoad(LoadForceVector(markerNumber=AddMarkerOnCable(mbs, cable, 1.3), loadVector=[0, -2, 0]))
        lamp = AddMarkerOnCable(mbs, cable, 0.7, offset=-0.05, hasFrame=True)
    """
    _, item = require_cable(mbs, cable)
    element, x = place_on_cable(item, arcLength)
    beside, framed = require_finite("offset", offset, "m"), require_flag("hasFrame", hasFrame)
    if item.cable.dimension == 3 and (beside or framed):
        raise InputError(
            f"offset = {offset!r}, hasFrame = {hasFrame!r}: a cable in space has no orientation about its "
            "axis; leave both out, or create the cable with dimension=2."
        )
    marker = MarkerBodyRigid if framed else MarkerBodyPosition
    body = CreateCompanionCables(mbs, cable)[element]
    return int(mbs.AddMarker(marker(bodyNumber=body, localPosition=[x, beside, 0.0])))


def place_on_cable(item: CableItem, arc_length: Any) -> tuple[int, float]:
    """Element, and distance from its left node [m], of a point; InputError if it is not on the cable."""
    lengths = item.cable.element_lengths
    element, xi = place_on_elements(point_on_cable(arc_length, item.cable.length), lengths)
    return element, xi * float(lengths[element])


_known: WeakKeyDictionary[Any, tuple[int, dict[tuple[int, ...], int]]] = WeakKeyDictionary()
"""Of each system the number of objects that were looked at, and the first companions by their nodes."""


def _companions_by_nodes(mbs: Any) -> dict[tuple[int, ...], int]:
    """Numbers of all companions; what became of those that are known, whoever uses them has to see."""
    number = mbs.systemData.NumberOfObjects()
    looked_at, found = _known.get(mbs, (0, {}))
    if number < looked_at:  # the system was reset
        looked_at, found = 0, {}
    for k in range(looked_at, number):
        if nodes := nodes_of_inert_cable(mbs.GetObject(k)):
            found.setdefault(nodes, k)
    _known[mbs] = number, found
    return found


def forget_companions(mbs: Any) -> None:
    """Look at all objects again, as native cables became companions."""
    _known.pop(mbs, None)


def _add_companion(mbs: Any, item: CableItem, nodes: tuple[int, int], length: float, show: bool) -> int:
    planar = item.cable.dimension == 2
    element, drawing = (
        (ObjectANCFCable2D, VObjectANCFCable2D) if planar else (ObjectANCFCable, VObjectANCFCable)
    )
    nothing = dict.fromkeys(INERT, 0.0)
    return int(
        mbs.AddObject(
            element(nodeNumbers=list(nodes), length=length, visualization=drawing(show=show), **nothing)
        )
    )
