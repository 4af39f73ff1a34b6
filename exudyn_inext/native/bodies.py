"""Everything with mass but the inextensible cables: which coordinates, which mass matrix."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import exudyn
import numpy as np
import scipy
from exudyn.exudynCPP import ObjectIndex

from ..arrays import Array, SparseArray
from ..errors import SceneError
from ..items.arguments import described
from ..items.mass_points import node_of_mass_point
from ..items.parameters import Parameter
from ..scene.bodies import BodiesSystem, MassBlock, VariableBlocks

_MASS = exudyn.ComputeItemType.MassMatrix
_CONSTANT_MASS = {
    "ANCFCable",
    "ANCFCable2D",
    "MassPoint",
    "MassPoint2D",
    "Mass1D",
    "RotationalMass1D",
}
_SINGULAR = 1e-13  # part of a mass that must resist in each direction
_LOCKED = 1e-6  # cosine of the second of three angles
_SINGULAR_MASSES = {  # remedies for objects whose mass matrices are singular however they are given
    "ObjectANCFBeam": "the slopes of {} have a singular mass matrix; take ObjectBeamGeometricallyExact on "
    "NodeRigidBodyRxyz",
    "BeamGeometricallyExact3D": "{} couples the masses of Euler parameters; put it on NodeRigidBodyRxyz",
    "FFRF": "frame and mesh of {} can move as a whole both; take ObjectFFRFreducedOrder",
    "ALEANCFCable2D": "the motion through {} needs a mass of its own; put an ObjectGenericODE2 with a "
    "massMatrix on the GenericODE2 node of it",
}
_NOT_ADDITIVE = {"RigidBodyRotVecLG", "RigidBodyRotVecDataLG"}


@dataclass(frozen=True, eq=False)
class Body:
    """An object with mass.

    number: of the object.   coordinates: (k,) places in the system vector.
    initial_mass: (k, k) when it was read.
    has_constant_mass: whether its mass does not depend on the configuration.
    tells_mass: whether Exudyn gives the mass matrix of this object alone.
    """

    number: int
    coordinates: np.ndarray
    has_constant_mass: bool
    tells_mass: bool
    initial_mass: Array

    def mass(self, mbs: Any) -> Array:
        """(k, k) in the current configuration."""
        return np.asarray(mbs.ComputeItem(ObjectIndex(self.number), _MASS))


class Quaternions(NamedTuple):
    """Euler parameters of Q nodes.

    coordinates: (Q, 4) places.   references: (Q, 4) what Exudyn's coordinates are displacements from.
    """

    coordinates: np.ndarray
    references: Array


class SystemMass:
    """The (n, n) mass matrix of all items, which Exudyn gives dense: for those that do not tell theirs.

    Args:
        mbs: assembled.   solver: of Exudyn, that evaluates it.
    """

    def __init__(self, mbs: Any, solver: Any) -> None:
        self._mbs, self._solver = mbs, solver
        self._known: Array | None = None

    def forget(self) -> None:
        """The configuration is another one."""
        self._known = None

    def part(self, places: np.ndarray) -> Array:
        """(..., k, k) in the current configuration.   places: (..., k)."""
        if self._known is None:
            self._solver.ComputeMassMatrix(self._mbs)
            self._known = np.asarray(self._solver.GetSystemMassMatrix())
        return self._known[places[..., :, None], places[..., None, :]]


def _mass_of_object(mbs: Any, number: int, coordinates: np.ndarray, total: SystemMass) -> tuple[Array, bool]:
    """Mass matrix of an object (empty if it has none), and whether it is given for this object alone."""
    index = ObjectIndex(number)
    if _MASS not in mbs.ComputeItem(index):
        return np.zeros((0, 0)), False
    try:
        return np.asarray(mbs.ComputeItem(index, _MASS)), True
    except exudyn.InternalError:  # stored as sparse matrix, or not at all
        own = _mass_among_parameters(mbs.GetObject(number), len(coordinates))
        return (total.part(coordinates), False) if own is None else (own, False)


def _mass_among_parameters(data: dict[str, Any], size: int) -> Array | None:
    """(size, size) of an object whose mass is one of its parameters, empty if it has none; None of others."""
    if node_of_mass_point(data) >= 0:
        return float(data["mass"]) * np.eye(size)
    if data["objectType"] == "GenericODE2" and not data["massMatrixUserFunction"]:
        return np.asarray(data["massMatrix"].Convert2DenseMatrix())
    return None


def read_bodies(mbs: Any, cables: Sequence[int], on_cables: np.ndarray, total: SystemMass) -> list[Body]:
    """All objects with mass but the inextensible cables, and mass points on their nodes.

    Args:
        mbs: assembled.   cables: object numbers.   on_cables: system coordinates of the cables.
        total: mass of all items.

    Raises:
        SceneError: another object with mass on nodes of an inextensible cable.
    """
    bodies, inner, of_cables = [], set(cables), set(on_cables.tolist())
    for number in range(mbs.systemData.NumberOfObjects()):
        coordinates = np.array(mbs.systemData.GetObjectLTGODE2(number), dtype=int)
        if number in inner or not len(coordinates):
            continue
        mass, tells_mass = _mass_of_object(mbs, number, coordinates, total)
        if not mass.any():
            continue
        data = mbs.GetObject(number)
        if not of_cables.isdisjoint(coordinates.tolist()):
            if node_of_mass_point(data) >= 0:
                continue
            raise SceneError(
                f"{described(data, number)} has mass and lies on nodes of an inextensible cable: put it on "
                "the cable by AddPointMass, give it no mass (a companion for markers and contact), give it "
                "its own nodes and a joint, or let ReplaceNativeCables take native elements."
            )
        bodies.append(Body(number, coordinates, _has_constant_mass(data), tells_mass, mass))
    return bodies


def _has_constant_mass(data: dict[str, Any]) -> bool:
    if data["objectType"] == "GenericODE2":
        return not data["massMatrixUserFunction"]
    if data["objectType"] == "RigidBody2D":
        return not np.any(data["centerOfMass"])
    return data["objectType"] in _CONSTANT_MASS


def read_quaternions(mbs: Any) -> Quaternions:
    """Euler parameters of all nodes; SceneError for nodes whose coordinates do not add up."""
    coordinates, references = [], []
    for number in range(mbs.systemData.NumberOfNodes()):
        data = mbs.GetNode(number)
        if data["nodeType"] in _NOT_ADDITIVE:
            raise SceneError(
                f"node {number} '{data['name']}' ({data['nodeType']}) has rotations that an explicit scheme "
                "cannot add up: create its body by mbs.CreateRigidBody with nodeType=exu.NodeType."
                "RotationEulerParameters or RotationRxyz, or put beams on NodeRigidBodyRxyz."
            )
        if data["nodeType"] == "RigidBodyEP":
            coordinates.append(mbs.systemData.GetNodeLTGODE2(number)[3:7])
            references.append(data["referenceCoordinates"][3:7])
    return Quaternions(np.array(coordinates, int).reshape(-1, 4), np.array(references, float).reshape(-1, 4))


@dataclass(frozen=True, eq=False)
class _Stack:
    """Groups of bodies of variable mass with equally many coordinates, and their places in the groups."""

    blocks: VariableBlocks
    bodies: list[list[tuple[Body, Any]]]


def _coordinates_of(bodies: Sequence[Body]) -> np.ndarray:
    """Places of all their coordinates, sorted."""
    return np.array(sorted({place for body in bodies for place in body.coordinates.tolist()}), dtype=int)


def _groups(bodies: Sequence[Body]) -> list[list[Body]]:
    """Bodies that share coordinates, directly or through others."""
    groups: list[tuple[list[Body], set[int]]] = []
    owner: dict[int, tuple[list[Body], set[int]]] = {}
    for body in bodies:
        group: tuple[list[Body], set[int]] = ([body], set(body.coordinates.tolist()))
        for other in {id(owner[c]): owner[c] for c in group[1] if c in owner}.values():
            group = (other[0] + group[0], other[1] | group[1])
            groups = [one for one in groups if one is not other]
        groups.append(group)
        owner.update(dict.fromkeys(group[1], group))
    return [own for own, _ in groups]


def _assembled(bodies: Sequence[Body], size: int) -> SparseArray:
    """(size, size) masses of the bodies when they were read."""
    rows = [np.repeat(body.coordinates, len(body.coordinates)) for body in bodies]
    columns = [np.tile(body.coordinates, len(body.coordinates)) for body in bodies]
    values = [body.initial_mass.ravel() for body in bodies]
    none = np.zeros(0, int)
    entries = np.concatenate([none, *values]), tuple(np.concatenate([none, *p]) for p in (rows, columns))
    return scipy.sparse.csr_array(scipy.sparse.coo_array(entries, shape=(size, size)))


class BodyMasses:
    """Mass of the bodies: constant blocks are inverted once, the others at each configuration.

    Args:
        total: mass of all items.
        holdable: places of held coordinates; where the mass is constant, they are left out.

    coordinates: (n,) places of the bodies' other coordinates in the system vector.   system: M a = F.
    held: (k,) places of those that are left out.   held_mass, coupling: (k, k), (k, n) their rows of M.
    """

    def __init__(
        self,
        mbs: Any,
        bodies: Sequence[Body],
        quaternions: Quaternions,
        zeta: float,
        total: SystemMass,
        holdable: Collection[int] = (),
    ) -> None:
        self._mbs, self._bodies = mbs, bodies
        self._total = total
        groups = _groups(bodies)
        constant = [group for group in groups if all(body.has_constant_mass for body in group)]
        self._constant_groups = constant
        variable = [group for group in groups if not all(body.has_constant_mass for body in group)]
        self.held = np.zeros(0, int)
        if holdable:
            of_constant = _coordinates_of([body for group in constant for body in group])
            self.held = of_constant[np.isin(of_constant, sorted(holdable))]
        self.coordinates = self._free(bodies)
        self.held_mass = np.zeros((len(self.held), len(self.held)))
        self.coupling = np.zeros((len(self.held), len(self.coordinates)))
        if len(self.held):
            initial = _assembled(bodies, mbs.systemData.ODE2Size())
            self.held_mass[:] = initial[np.ix_(self.held, self.held)].toarray()
            self.coupling[:] = initial[np.ix_(self.held, self.coordinates)].toarray()
        self._needs_total = not all(body.tells_mass for group in variable for body in group)
        starts = set(self._local(quaternions.coordinates[:, 0]).tolist())
        by_kind: dict[tuple[int, bool], list[tuple[list[Body], np.ndarray]]] = {}
        for group in variable:
            dofs = self._dofs_of(group)
            by_kind.setdefault((len(dofs), starts.isdisjoint(dofs.tolist())), []).append((group, dofs))
        self._stacks = [self._stack(alike, quaternions) for _, alike in sorted(by_kind.items())]
        blocks = [block for block in map(self._block, constant) if len(block.dofs)]
        self._require_mass(blocks, is_initial=True)
        variables = [stack.blocks for stack in self._stacks]
        self.system = BodiesSystem(len(self.coordinates), blocks, variables, zeta)

    def read_again(self) -> None:
        """Constant masses, which may have been changed since."""
        self._total.forget()
        blocks = []
        for group in self._constant_groups:
            given = ((body, (self._mbs, body.number, body.coordinates, self._total)) for body in group)
            present = [replace(body, initial_mass=_mass_of_object(*own)[0]) for body, own in given]
            blocks.append(self._block(present))
        self._require_mass(blocks, is_initial=False)
        self.system.set_constant(blocks)

    def can_weigh(self, key: Parameter) -> bool:
        """Whether a mass may be read again: that of a planar body varies once its centre leaves the node."""
        body = next((one for one in self._bodies if one.number == key.number), None)
        if body is None or not key.is_mass or len(self.held):
            return False
        return not (body.has_constant_mass and key.is_centre)

    def _require_mass(self, blocks: Sequence[MassBlock], is_initial: bool) -> None:
        """Raise SceneError if something has no mass, when it was read or at present.

        blocks: of constant mass.
        """
        kind = exudyn.ConfigurationType
        q = np.array(self._mbs.systemData.GetODE2Coordinates(kind.Initial if is_initial else kind.Current))
        alike = [(block.dofs[np.newaxis], block.mass[np.newaxis]) for block in blocks if len(block.dofs)]
        for stack in self._stacks:
            masses = self._masses(stack, is_initial)
            alike.append((stack.blocks.dofs, _with_normals(stack.blocks, masses, q[self.coordinates])))
        for dofs, masses in alike:
            require_mass(self._mbs, self.coordinates[_without_mass(dofs, masses)])

    @property
    def number_of_variable(self) -> int:
        return sum(len(bodies) for stack in self._stacks for bodies in stack.bodies)

    def update(self, q: Array) -> None:
        """Masses of the current configuration of mbs, which is q (n,)."""
        self._total.forget()
        for number, stack in enumerate(self._stacks):
            if self._needs_total:
                masses = self._total.part(self.coordinates[stack.blocks.dofs])
            else:
                masses = self._masses(stack)
            self.system.set_masses(number, masses, q)

    def _local(self, coordinates: np.ndarray) -> np.ndarray:
        return np.searchsorted(self.coordinates, coordinates)

    def _free(self, bodies: Sequence[Body]) -> np.ndarray:
        """Places of their coordinates that are not held, sorted."""
        places = _coordinates_of(bodies)
        return np.setdiff1d(places, self.held) if len(self.held) else places

    def _dofs_of(self, group: Sequence[Body]) -> np.ndarray:
        return self._local(self._free(group))

    def _stack(self, groups: Sequence[tuple[Sequence[Body], np.ndarray]], quaternions: Quaternions) -> _Stack:
        """Of groups with equally many coordinates, and their places; all have quaternions, or none has."""
        dofs = np.stack([own for _, own in groups])
        bodies = [[(body, self._places(own, body.coordinates)) for body in group] for group, own in groups]
        first, reference = np.full(len(groups), -1), np.zeros((len(groups), 4))
        starts = self._local(quaternions.coordinates[:, 0])
        for own, of_node in zip(starts, quaternions.references, strict=True):
            for group in np.flatnonzero((dofs == own).any(axis=1)).tolist():
                first[group] = np.searchsorted(dofs[group], own)
                reference[group] = of_node
        return _Stack(VariableBlocks(dofs, first, reference), bodies)

    def _places(self, dofs: np.ndarray, coordinates: np.ndarray) -> Any:
        """Places of a body in the block with these dofs; all of it, if the body is alone there."""
        places = np.searchsorted(dofs, self._local(coordinates))
        return np.s_[:, :] if np.array_equal(places, np.arange(len(dofs))) else np.ix_(places, places)

    def _masses(self, stack: _Stack, initial: bool = False) -> Array:
        """(B, k, k) in the current configuration, or when the bodies were read."""
        number, size = stack.blocks.dofs.shape
        masses: Array = np.zeros((number, size, size))
        for mass, bodies in zip(masses, stack.bodies, strict=True):
            for body, places in bodies:
                mass[places] += body.initial_mass if initial else body.mass(self._mbs)
        return masses

    def _block(self, group: Sequence[Body]) -> MassBlock:
        """Initial mass of the coordinates of a group that are not held."""
        dofs = self._dofs_of(group)
        total: Array = np.zeros((len(dofs), len(dofs)))
        for body in group:
            own, mass = body.coordinates, body.initial_mass
            if len(self.held):
                free = np.flatnonzero(~np.isin(own, self.held))
                own, mass = own[free], mass[free[:, None], free]
            places = np.searchsorted(dofs, self._local(own))
            total[places[:, None], places] += mass
        return MassBlock(dofs, total)


def _with_normals(blocks: VariableBlocks, masses: Array, q: Array) -> Array:
    """Masses (B, k, k), to which one along each quaternion is added, in place."""
    for b in np.flatnonzero(blocks.quaternion >= 0):
        own = np.s_[blocks.quaternion[b] : blocks.quaternion[b] + 4]
        p = blocks.reference[b] + q[blocks.dofs[b, own]]
        masses[b, own, own] += np.outer(p, p) * np.trace(masses[b, own, own])
    return masses


def require_mass(mbs: Any, without: np.ndarray) -> None:
    """Raise SceneError, which names the node, if there are coordinates without mass.

    without: (k,) their places in the system vector.
    """
    if not len(without):
        return
    data = mbs.systemData
    for number in range(data.NumberOfNodes()):
        if np.isin(without, data.GetNodeLTGODE2(number)).any():
            node = mbs.GetNode(number)
            raise SceneError(
                f"node {number} '{node['name']}' ({node['nodeType']}) has coordinates without mass, whose "
                f"accelerations are not determined: {_remedy(mbs, number, without)}."
            )


def _remedy(mbs: Any, node: int, without: np.ndarray) -> str:
    """What to do about coordinates without mass, as far as node and objects tell.   without: (k,)."""
    if _is_locked(mbs, node):
        return (
            "its second angle is a right one, where the first and the third one turn about the same axis; "
            "give the body nodeType=exudyn.NodeType.RotationEulerParameters"
        )
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        of_kind = _SINGULAR_MASSES.get(data["objectType"])
        if of_kind and np.isin(without, mbs.systemData.GetObjectLTGODE2(number)).any():
            return of_kind.format(described(data, number))
    return "give its body mass and inertia (put one on it, if there is none), or remove it"


def _is_locked(mbs: Any, node: int) -> bool:
    """Whether axes of its angles coincide (gimbal lock)."""
    if mbs.GetNode(node)["nodeType"] != "RigidBodyRxyz":
        return False
    second = mbs.GetNodeOutput(node, exudyn.OutputVariableType.CoordinatesTotal)[4]
    return bool(abs(np.cos(second)) < _LOCKED)


def _without_mass(dofs: np.ndarray, masses: Array) -> np.ndarray:
    """Coordinates along which nothing resists; none, if all blocks have inverses.

    dofs: (B, k).   masses: (B, k, k).
    """
    sizes = np.sqrt(np.maximum(np.diagonal(masses, axis1=1, axis2=2), 0.0))
    sizes[sizes == 0.0] = 1.0
    scaled = masses / (sizes[:, :, np.newaxis] * sizes[:, np.newaxis])
    with suppress(np.linalg.LinAlgError):
        if np.diagonal(np.linalg.cholesky(scaled), axis1=1, axis2=2).min() ** 2 > _SINGULAR:
            return np.zeros(0, dtype=int)
    rests, vectors = np.linalg.eigh(scaled)
    worst = int(np.argmin(rests[:, 0]))
    shape = np.abs(vectors[worst, :, 0])
    return dofs[worst, shape == shape.max()]
