"""CreateInextensibleCable: a cable as items of an mbs."""

import math
import warnings
from typing import Any

import numpy as np
from exudyn.exudynCPP import NodeIndex
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerNodeCoordinate,
    NodePoint2DSlope1,
    NodePointGround,
    NodePointSlope1,
    ObjectANCFCable,
    ObjectGenericODE2,
    VObjectGenericODE2,
)

from ..arrays import Array
from ..cable.cable import Cable
from ..checks import require_flag, require_vector
from ..errors import InputError
from ..scene.model import CableItem
from .arguments import require_system
from .attach.shared_node import SharedNode, find_shared_node
from .attach.user_forces import add_user_forces, user_forces_of
from .cable_data import carrying_graphics, find_cable_item, remember_nodes
from .enforcement import find_enforcement
from .enforcement.protocol import Enforcement
from .shape import CableShape, CheckedShape, check_shape
from .template import InextensibleCable, stiffness_left_out

SOUND = 5000.0  # sqrt(E / rho) of steel, aluminium and glass [m/s]
AIR = 1.0  # [kg/m^3]
LONG, SLENDER = 100.0, 1e6  # of an element [m]; length over diameter [-]
HEAVY = 1000.0  # [m/s^2]
DENSE = 1e7  # [kg/m^3], as soft ropes seem to be
OF_TONNES_AND_MILLIMETRES = 1e18  # a density for which t, mm and s were taken as kg, m and s [-]
FREE_FREE = 22.373  # (omega L^2 / sqrt(EI / rho_A)) of the lowest bending vibration


def warn_of_units(cable: Cable, gravity: Array) -> None:
    """Warn if no solid round section of a stiff material has these constants, or if elements are huge.

    Not where gravity [m/s^2] is huge: 9810 mm/s^2 say that other units are meant. Where there is none, these
    may be mm, t and s.

    EI / rho_A = E / rho d^2 / 16 gives the diameter d, from which density and slenderness follow.
    """
    weight, section, length = np.linalg.norm(gravity), cable.section, cable.length
    ratio = math.sqrt(section.bending_stiffness / section.mass_per_length)
    diameter = 4.0 * ratio / SOUND
    density = 4.0 * section.mass_per_length / (math.pi * diameter**2)
    if weight > HEAVY or (weight == 0.0 and AIR < density * OF_TONNES_AND_MILLIMETRES < DENSE):
        return
    longest = float(cable.element_lengths.max())
    if density < AIR:
        wrong = f"a density of {density:.2g} kg/m^3, less than that of air"
    elif longest > LONG and length > SLENDER * diameter:
        wrong = f"elements of {longest:.4g} m"
    else:
        return
    period = 2.0 * math.pi * length**2 / (FREE_FREE * ratio)
    warnings.warn(
        f"length = {length:g} m, massPerLength = {section.mass_per_length:g} kg/m and bendingStiffness = "
        f"{section.bending_stiffness:g} N m^2 can hardly be meant: a round wire of metal would have a "
        f"diameter of {diameter:.2g} m, a slenderness of {length / diameter:.2g}, a lowest bending period of "
        f"{period:.2g} s and {wrong}. Check the units: m, kg and s, for EI N m^2 (1 N mm^2 = 1e-6 N m^2).",
        stacklevel=3,
    )


__all__ = ["CableItem", "CreateInextensibleCable", "find_cable_item", "supports_of_flags"]

STRAIGHT = 1e-12  # difference of slopes [-]
_OTHER_DIMENSION = {
    2: "For a cable in space, whose nodes have three positions and three slopes, use dimension = 3.",
    3: "For a planar cable, whose nodes have two positions and two slopes, leave z components out of shape, "
    "velocities and gravity, and use dimension = 2.",
}


def CreateInextensibleCable(
    mbs: Any,
    positionStart: Any = None,
    positionEnd: Any = None,
    numberOfElements: int | None = None,
    beamTemplate: Any = None,
    gravity: Any = (0, 0, 0),
    groundConstraintsStart: list | None = None,
    groundConstraintsEnd: list | None = None,
    nodeNumberStart: Any = None,
    nodeNumberEnd: Any = None,
    shape: CableShape | None = None,
    dimension: int | None = None,
    enforcement: Any = "projection",
    shareSlopeStart: bool = True,
    shareSlopeEnd: bool = True,
    extensible: bool = False,
) -> dict[str, Any]:
    """Add an inextensible ANCF cable to mbs; arguments and result as GenerateBeamElementsAlongLine.

    The cable is one ObjectGenericODE2 on NodePoint2DSlope1 (planar) or NodePointSlope1 nodes. These take
    SensorNode, MarkerNodePosition, MarkerNodeCoordinate(s) and, in the plane, MarkerNodeRigid;
    `AddMarkerOnCable` and `CreateCompanionCables` lead to any arc length, SensorBody and contact,
    `AttachToBody` to bodies. Items MarkerBody... and MarkerSuperElement... on the object itself are refused.
    `SolveExplicit` moves the cable. Native solvers know nothing of inextensibility: they stop with an error,
    unless the cable has another `enforcement` than the default.

    Args:
        mbs: the system where the items are added.
        positionStart: first point of a straight cable [m]; None if shape is given.
        positionEnd: last point of a straight cable [m]; None if shape is given.
        numberOfElements: of a straight cable; None if shape is given.
        beamTemplate: InextensibleCable, or a native ObjectANCFCable2D or ObjectANCFCable.
        gravity: vector of the gravity acceleration [m/s^2].
        groundConstraintsStart: True/False for each coordinate (positions, then slopes) of the first
            node: all positions (pin), some of them (roller), all slopes (guide), positions and slopes
            (clamp); None: free.
        groundConstraintsEnd: the same for the last node.
        nodeNumberStart: node of an inextensible cable, an inner one as well, at which this one begins;
            None: a node of its own. Loads and supports of a shared node act once.
        nodeNumberEnd: the same for the last node.
        shape: CableShape for curved cables and initial velocities, in place of the three arguments
            of the straight cable.
        dimension: 2 or 3; None: 3 if beamTemplate is an ObjectANCFCable, or a node is shared with a cable
            in space; otherwise 2 if shape, velocities and gravity lie in the x-y plane.
        enforcement: of inextensibility in native solvers. 'projection': none, these stop with an error;
            'penaltyMass' or PenaltyMass(...): penalties, for native explicit solvers; 'algebraic': exact
            constraint objects, for native implicit solvers. SolveExplicit takes all of them alike.
        shareSlopeStart: True: position and slope of that node are shared, as by native elements, and the
            cable leaves along that slope; False: the position only, a hinge.
        shareSlopeEnd: the same for the last node.
        extensible: whether a native beamTemplate brings its axialStiffness, axialDamping and
            referenceAxialStrain with it; an InextensibleCable has its own axialStiffness.

    Returns:
        dict with 'nodes' (with the shared ones; at a hinge, the cable has a node of its own), 'elements'
        (the one cable object), 'nodePositions', 'constraintObjects' (supports, none with 'penaltyMass', then
        joints of shared nodes, then inextensibility with 'algebraic'), 'loads' (none: gravity belongs to the
        object).

    Raises:
        InputError: a value outside of its limits, or a cable apart from a shared node; mbs is unchanged then.
        RedundantConstraintError: with 'algebraic', lengths and supports that depend on each other.

    Example:
        cable = CreateInextensibleCable(mbs, [0, 0, 0], [1.8, 0, 0], numberOfElements=5,
            beamTemplate=InextensibleCable(massPerLength=0.0348, bendingStiffness=0.0866),
            gravity=[0, -9.81, 0], groundConstraintsStart=[True, True, False, False])
    """
    require_system(mbs)
    way = find_enforcement(enforcement)
    template = InextensibleCable.from_template(beamTemplate, require_flag("extensible", extensible))
    given_shape = _the_shape(positionStart, positionEnd, numberOfElements, shape)
    checked = check_shape(given_shape, template.axialStiffness is not None)
    _require_projection(template, way)
    gravity_vector = require_vector("gravity", gravity, " [m/s^2]")
    shared = _shared_nodes(mbs, way, (nodeNumberStart, nodeNumberEnd), (shareSlopeStart, shareSlopeEnd))
    in_space = isinstance(beamTemplate, ObjectANCFCable) or any(one.dimension == 3 for one in shared.values())
    dim = _dimension(3 if in_space and dimension is None else dimension, checked, gravity_vector)
    functions, section = user_forces_of(mbs, beamTemplate, template, dim)
    cable = cable_of(section, checked, dim)
    for name, given in (("groundConstraints", groundConstraintsEnd), ("nodeNumber", nodeNumberEnd)):
        if checked.closed and given is not None:
            raise InputError(
                f"{name}End is given, but a closed cable has no end: use {name}Start for its first node."
            )
    for place, node in shared.items():
        node.require_meeting(cable.reference[place], checked.v[place, :, :dim], cable.length)
    held = np.zeros(cable.reference.shape, dtype=bool)
    held[0] = _constraint_flags("groundConstraintsStart", groundConstraintsStart, cable, 0)
    if not checked.closed:
        held[-1] = _constraint_flags("groundConstraintsEnd", groundConstraintsEnd, cable, -1)
    warn_of_units(cable, gravity_vector)
    item, made = _add_items(mbs, cable, checked.v[:, :, :dim], gravity_vector[:dim], held, way, shared)
    item.left_out = stiffness_left_out(beamTemplate, template)
    add_user_forces(mbs, item, template, functions)
    return made


def cable_of(template: InextensibleCable, shape: CheckedShape, dimension: int) -> Cable:
    """A cable of that shape, without supports.

    Raises:
        InputError: a number of the template out of range, or what cables in space do not have.
    """
    number = len(shape.lengths)
    cable = Cable(
        reference=np.ascontiguousarray(shape.q[:, :, :dimension]),
        element_lengths=shape.lengths,
        section=template.section(dimension),
        measure=template.measure(),
        length_constraints=template.length_constraints(number),
        fixed=np.zeros((number + 1, 2), dtype=bool),
        closed=shape.closed,
        straight_lengths=shape.straight_lengths,
    )
    _require_plane_curves(cable)
    return cable


def _shared_nodes(
    mbs: Any, way: Enforcement, numbers: tuple[Any, Any], slopes: tuple[Any, Any]
) -> dict[int, SharedNode]:
    """By their place in the cable, 0 or -1."""
    found = {}
    for place, end, number, share_slope in zip((0, -1), ("Start", "End"), numbers, slopes, strict=True):
        node = find_shared_node(mbs, end, number, share_slope)
        if node is not None and not way.supports_are_objects:
            raise InputError(
                f"{node.name} with enforcement = '{way.name}': native explicit solvers do not take the "
                "joints by which cables share a node; use 'projection' with SolveExplicit, or 'algebraic'."
            )
        if node is not None:
            found[place] = node
    return found


def _require_projection(template: InextensibleCable, way: Enforcement) -> None:
    if template.axialStiffness is not None and way.name != "projection":
        raise InputError(
            f"enforcement = {way.name!r} with axialStiffness = {template.axialStiffness!r}: native solvers "
            "have ObjectANCFCable for cables that stretch; use these, or enforcement='projection'."
        )


def _require_plane_curves(cable: Cable) -> None:
    share, slopes = cable.section.strain_is_relative, cable.reference[:, 1]
    if share and cable.dimension == 3 and np.abs(slopes - slopes[0]).max() > STRAIGHT:
        raise InputError(
            f"strainIsRelativeToReference = {share!r} with a shape that is curved, in 3D: which way the "
            "section faces is not modelled; set it to zero, or use dimension=2."
        )


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
    if not isinstance(stated, int | np.integer) or stated not in (2, 3):
        raise InputError(f"dimension = {stated!r}: must be 2, 3 or None.")
    if stated == 2 and not planar:
        raise InputError(
            "dimension = 2, but positions, slopes, velocities or gravity have z components: rotate the "
            "scene into the x-y plane, or use dimension = 3."
        )
    return int(stated)


def _constraint_flags(name: str, given: list | None, cable: Cable, place: int) -> np.ndarray:
    """(2, dim) flags of the coordinates of its node there; see `supports_of_flags`."""
    node = cable.reference[place]
    if given is None:
        return np.zeros(node.shape, dtype=bool)
    is_list = isinstance(given, list | tuple) or (isinstance(given, np.ndarray) and given.ndim > 0)
    flags = [require_flag(f"{name}[{k}]", flag) for k, flag in enumerate(given)] if is_list else []
    if len(flags) != node.size:
        raise InputError(
            f"{name} = {given!r} has {len(flags)} entries: needs {node.size}, positions and slopes of the "
            f"{node.shape[1]}D node. {_OTHER_DIMENSION[node.shape[1]]}"
        )
    of_node: np.ndarray = np.reshape(flags, node.shape)
    supports_of_flags(name, of_node, node, cable.stretches)
    return of_node


def supports_of_flags(name: str, flags: np.ndarray, node: Array, stretches: bool) -> tuple[bool, bool]:
    """Whether position and slope of a node are held, from the flags of its coordinates.

    One of which only some coordinates are held does not count. A unit slope that keeps its length is held as
    soon as all components transverse to it are.

    Args:
        name: culprit for messages.
        flags: (2, dim) constrained coordinates.
        node: (2, dim) reference position and slope.
        stretches: whether the cable does.

    Raises:
        InputError: only a part of the slopes is held, and these keep their lengths.
    """
    position = bool(flags[0].all())
    if stretches:
        return position, bool(flags[1].all())
    released = node[1][~flags[1]]
    tangent_only = len(released) == 1 and abs(abs(released[0]) - 1.0) < 1e-12
    slope = bool(flags[1].all() or tangent_only)
    if flags[1].any() != slope:
        raise InputError(
            f"{name} holds the coordinates {flags.astype(int).tolist()} ([positions], [slopes]): hold all or "
            "no slopes (the component along the cable may be left out), or let the cable stretch. "
            f"{_OTHER_DIMENSION[flags.shape[1]]}"
        )
    return position, slope


def _add_items(
    mbs: Any,
    cable: Cable,
    velocities: Array,
    gravity: Array,
    held: np.ndarray,
    way: Enforcement,
    shared: dict[int, SharedNode],
) -> tuple[CableItem, dict[str, Any]]:
    """The cable, and what `CreateInextensibleCable` returns."""
    own_held = held.copy()
    own_held[[k for k, node in shared.items() if node.has_slope]] = False  # the shared nodes' own
    way.require_independent(CableItem(cable, gravity, (), way.name, own_held), own_held)
    node_type = NodePoint2DSlope1 if cable.dimension == 2 else NodePointSlope1
    count = len(cable.reference) - cable.closed
    nodes = [
        mbs.AddNode(node_type(referenceCoordinates=q.ravel().tolist(), initialVelocities=v.ravel().tolist()))
        for q, v in zip(cable.reference[:count], velocities[:count], strict=True)
    ]
    held_within = np.zeros_like(held) if way.supports_are_objects else held
    known_as = {int(nodes[k]): node.number for k, node in shared.items() if node.has_slope}
    item = CableItem(cable, gravity, tuple(map(int, nodes)), way.name, held_within, known_as)
    made = add_object(mbs, item, way)
    if way.supports_are_objects:
        made["constraintObjects"] += _add_ground_constraints(mbs, made["nodes"], held)
    for k, node in shared.items():
        made["constraintObjects"] += node.join(mbs, nodes[k], cable.reference[k, 1])
    made["constraintObjects"] += way.add_constraints(mbs, made["elements"][0], item, own_held)
    return item, made


def add_object(mbs: Any, item: CableItem, way: Enforcement) -> dict[str, Any]:
    """Add the object of a cable on nodes that exist; returns what `CreateInextensibleCable` does."""
    nodes = [NodeIndex(number) for number in item.nodes]
    element = mbs.AddObject(
        ObjectGenericODE2(
            nodeNumbers=nodes,
            visualization=VObjectGenericODE2(graphicsDataUserFunction=carrying_graphics(item)),
            **way.object_parameters(item),
        )
    )
    remember_nodes(mbs, nodes, element)
    return {
        "nodes": [NodeIndex(number) for number in item.given_nodes],
        "elements": [element],
        "nodePositions": [[*q[0].tolist(), 0.0][:3] for q in item.cable.reference[: len(nodes)]],
        "constraintObjects": [],
        "loads": [],
    }


def _add_ground_constraints(mbs: Any, nodes: list[int], held: np.ndarray) -> list[int]:
    if not held.any():
        return []
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    constraints = []
    for k in (0, -1):
        for coordinate in np.flatnonzero(held[k]).tolist():
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[k], coordinate=coordinate))
            constraints.append(mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker])))
    return constraints
