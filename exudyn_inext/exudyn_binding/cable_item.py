"""CreateInextensibleCable: a cable as items of an mbs."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerNodeCoordinate,
    NodePoint2DSlope1,
    NodePointGround,
    NodePointSlope1,
    ObjectGenericODE2,
    VObjectGenericODE2,
)

from ..arrays import Array
from ..chain.cable import Cable
from ..errors import EnforcementError, InputError
from .graphics import cable_graphics
from .shape import CableShape, CheckedShape, _finite, check_shape
from .template import InextensibleCable


@dataclass(eq=False)
class CableItem:
    """An inextensible cable in an mbs, as the solver sees it.

    cable: model without supports; these are the constraint objects of the mbs. See `change`.
    gravity: (dim,) [m/s^2].
    nodes: node numbers in the order of the arc length, each once.
    """

    cable: Cable
    gravity: Array
    nodes: tuple[int, ...]

    @property
    def node_names(self) -> tuple[int, ...]:
        """(n,) node numbers; the first one of a closed cable comes again at the end."""
        return (*self.nodes, self.nodes[0]) if self.cable.closed else self.nodes

    def change(self, cable: Cable) -> None:
        """Another model on the same nodes, for all runs that start from now on."""
        self.cable = cable


def CreateInextensibleCable(
    mbs: Any,
    positionStart: Any = None,
    positionEnd: Any = None,
    numberOfElements: int | None = None,
    beamTemplate: Any = None,
    gravity: Any = (0, 0, 0),
    groundConstraintsStart: list | None = None,
    groundConstraintsEnd: list | None = None,
    shape: CableShape | None = None,
    dimension: int | None = None,
) -> dict[str, Any]:
    """Add an inextensible ANCF cable to mbs; arguments and result as GenerateBeamElementsAlongLine.

    The cable is one ObjectGenericODE2 on NodePoint2DSlope1 (planar) or NodePointSlope1 nodes. These take
    SensorNode, MarkerNodePosition, MarkerNodeCoordinate(s) and, in the plane, MarkerNodeRigid;
    `MarkerOnCable` and `CreateCompanionCables` lead to any arc length, SensorBody and contact,
    `AttachToBody` to bodies;
    MarkerBody... and MarkerSuperElement... items on the object itself cannot work. The cable moves under
    `SolveExplicit` only: other solvers, which do not enforce inextensibility, stop with an error.

    Args:
        mbs: the system where the items are added.
        positionStart: first point of a straight cable [m]; None if shape is given.
        positionEnd: last point of a straight cable [m]; None if shape is given.
        numberOfElements: of a straight cable; None if shape is given.
        beamTemplate: InextensibleCable, or a native ObjectANCFCable2D or ObjectANCFCable.
        gravity: vector of the gravity acceleration [m/s^2].
        groundConstraintsStart: True/False for each coordinate (positions, then slopes) of the first
            node: all positions (pin), all slopes (guide), or both (clamp); None: free.
        groundConstraintsEnd: the same for the last node.
        shape: CableShape for curved cables and initial velocities, in place of the three arguments
            of the straight cable.
        dimension: 2 or 3; None: 2 if shape, velocities and gravity lie in the x-y plane.

    Returns:
        dict with 'nodes', 'elements' (the one cable object), 'nodePositions',
        'constraintObjects', 'loads' (none: gravity belongs to the object).

    Raises:
        InputError: a value outside of its limits; mbs is unchanged then.

    Example:
        cable = CreateInextensibleCable(mbs, [0, 0, 0], [1.8, 0, 0], numberOfElements=5,
            beamTemplate=InextensibleCable(massPerLength=0.0348, bendingStiffness=0.0866),
            gravity=[0, -9.81, 0], groundConstraintsStart=[True, True, False, False])
    """
    checked = check_shape(_the_shape(positionStart, positionEnd, numberOfElements, shape))
    template = InextensibleCable.from_template(beamTemplate)
    gravity_vector = _finite("gravity", gravity)
    if gravity_vector.shape != (3,):
        raise InputError(f"gravity = {gravity!r}: must be a vector of 3 numbers [m/s^2].")
    dim = _dimension(dimension, checked, gravity_vector)
    number = len(checked.lengths)
    cable = Cable(
        reference=np.ascontiguousarray(checked.q[:, :, :dim]),
        element_lengths=checked.lengths,
        section=template.section(dim),
        measure=template.measure(),
        length_constraints=template.length_constraints(number),
        fixed=np.zeros((number + 1, 2), dtype=bool),
        closed=checked.closed,
        straight_lengths=checked.straight_lengths,
    )
    if checked.closed and groundConstraintsEnd is not None:
        raise InputError(
            "groundConstraintsEnd is given, but a closed cable has no end: use groundConstraintsStart for "
            "its first node."
        )
    flags = {
        node: _constraint_flags(name, given, cable.reference[node])
        for name, node, given in (
            ("groundConstraintsStart", 0, groundConstraintsStart),
            ("groundConstraintsEnd", number, groundConstraintsEnd),
        )
    }
    return _add_items(mbs, cable, checked.v[:, :, :dim], gravity_vector[:dim], flags)


def _the_shape(start: Any, end: Any, number: Any, shape: CableShape | None) -> CableShape:
    line = (start, end, number)
    if shape is None:
        return CableShape.Line(start, end, number)
    if any(argument is not None for argument in line):
        raise InputError(
            "shape is given together with positionStart, positionEnd or numberOfElements: give either "
            "the shape or the straight line."
        )
    return shape


def _dimension(stated: int | None, shape: CheckedShape, gravity: Array) -> int:
    planar = not (shape.q[:, :, 2].any() or shape.v[:, :, 2].any() or gravity[2])
    if stated is None:
        return 2 if planar else 3
    if isinstance(stated, float) or stated not in (2, 3):
        raise InputError(f"dimension = {stated!r}: must be 2, 3 or None.")
    if stated == 2 and not planar:
        raise InputError(
            "dimension = 2, but positions, slopes, velocities or gravity have z components: rotate the "
            "scene into the x-y plane, or use dimension = 3."
        )
    return stated


def _constraint_flags(name: str, given: list | None, node: Array) -> list[bool]:
    """One flag a coordinate; see `supports_of_flags`."""
    if given is None:
        return [False] * node.size
    is_list = np.iterable(given) and not isinstance(given, str)
    flags = [bool(flag) for flag in given] if is_list else []
    if len(flags) != node.size:
        raise InputError(
            f"{name} = {given!r} has {len(flags)} entries: needs {node.size}, positions and slopes of the "
            f"{node.shape[1]}D node."
        )
    supports_of_flags(name, np.reshape(flags, node.shape), node)
    return flags


def supports_of_flags(name: str, flags: np.ndarray, node: Array) -> tuple[bool, bool]:
    """Whether position and slope of a node are held, from the flags of its coordinates.

    A unit slope is held as soon as all components transverse to it are. A position of which only some
    coordinates are held does not count.

    Args:
        name: culprit for messages.
        flags: (2, dim) constrained coordinates.
        node: (2, dim) reference position and slope.

    Raises:
        InputError: only a part of the slopes is held.
    """
    position = bool(flags[0].all())
    released = node[1][~flags[1]]
    tangent_only = len(released) == 1 and abs(abs(released[0]) - 1.0) < 1e-12
    slope = bool(flags[1].all() or tangent_only)
    if flags[1].any() != slope:
        raise InputError(
            f"{name} holds the coordinates {flags.astype(int).tolist()} ([positions], [slopes]): hold all or "
            "no slopes (the component along the cable may be left out)."
        )
    return position, slope


def _no_enforcement(*_: Any) -> Any:
    raise EnforcementError(
        "an inextensible cable was evaluated by a solver that does not enforce inextensibility "
        "(its axial stiffness is not modelled, the cable would fall apart): use "
        "exudyn_inext.SolveExplicit(mbs, simulationSettings), or native ANCF cables."
    )


def _refusing_user_function(item: CableItem) -> Any:
    """User function of force and mass matrix; it also carries the cable's data."""

    def inextensible_cable_user_function(mbs, t, itemNumber, q, q_t):
        return _no_enforcement()

    inextensible_cable_user_function.cable_item = item  # type: ignore[attr-defined]
    return inextensible_cable_user_function


def find_cable_item(object_data: dict[str, Any]) -> CableItem | None:
    """The cable behind mbs.GetObject(...) data, or None if the object is something else."""
    if object_data["objectType"] != "GenericODE2":
        return None
    function = object_data["forceUserFunction"]
    return getattr(function["function"], "cable_item", None) if isinstance(function, dict) else None


def _add_items(
    mbs: Any, cable: Cable, velocities: Array, gravity: Array, flags: dict[int, list[bool]]
) -> dict[str, Any]:
    node_type = NodePoint2DSlope1 if cable.dimension == 2 else NodePointSlope1
    count = len(cable.reference) - cable.closed
    nodes = [
        mbs.AddNode(node_type(referenceCoordinates=q.ravel().tolist(), initialVelocities=v.ravel().tolist()))
        for q, v in zip(cable.reference[:count], velocities[:count], strict=True)
    ]
    item = CableItem(cable, gravity, tuple(map(int, nodes)))
    user_function = _refusing_user_function(item)
    element = mbs.AddObject(
        ObjectGenericODE2(
            nodeNumbers=nodes,
            forceUserFunction=user_function,
            massMatrixUserFunction=user_function,
            visualization=VObjectGenericODE2(graphicsDataUserFunction=cable_graphics(cable, item.node_names)),
        )
    )
    return {
        "nodes": nodes,
        "elements": [element],
        "nodePositions": [[*q[0].tolist(), 0.0][:3] for q in cable.reference[:count]],
        "constraintObjects": _add_ground_constraints(mbs, nodes, flags),
        "loads": [],
    }


def _add_ground_constraints(mbs: Any, nodes: list[int], flags: dict[int, list[bool]]) -> list[int]:
    if not any(any(held) for held in flags.values()):
        return []
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    constraints = []
    for node, held in flags.items():
        for coordinate in np.flatnonzero(held).tolist():
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[node], coordinate=coordinate))
            constraints.append(mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker])))
    return constraints
