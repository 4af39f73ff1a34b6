"""Cables, bodies and joints of an mbs as one coupled system, which Exudyn evaluates."""

from collections.abc import Iterator, Mapping, Sequence, Set
from functools import cached_property
from typing import Any, NamedTuple

import exudyn
import numpy as np

from ..arrays import Array
from ..cable.many_cables import Systems, in_few_chains
from ..called_system import Bound
from ..errors import SceneError
from ..items.attach.inert import ANCF_CABLES, is_inert_cable
from ..items.functions_of_time import is_of_time_alone, step_functions
from ..items.functions_that_look import asked_item_functions
from ..items.parameters import Parameter
from ..run.cable_loads import CableLoads
from ..run.coupled_watch import EvaluatedScene
from ..run.flight import is_tied
from ..run.parts_in_one import CompiledParts
from ..scene.bodies import BodiesSystem, MassBlock
from ..scene.coupled_system import CoupledSystem, Part
from ..scene.model import CableInScene, HeldCoordinate
from ..scene.open_contacts import OpenContacts
from ..scene.path_work import build_path
from ..system import (
    ACCELERATION_ENERGY,
    KINETIC,
    POWER,
    REPORTED,
    RESOLVED,
    VIOLATION,
    index_reduced_rates,
    report_energy,
)
from .bodies import BodyMasses, SystemMass, read_bodies, read_quaternions, require_mass
from .contact_rates import open_contacts
from .coordinates import CoordinateMap
from .flight import may_fly
from .friction_check import FrictionCheck
from .held import HeldCoordinates, holders
from .joint_items import read_joints
from .joint_rows import JointRows
from .native_items import DataCoordinates, NativeItems, evaluator, state_kept
from .tilted_angles import TiltedAngles

_NONE: Mapping[int, HeldCoordinate] = {}


class CoupledCable(NamedTuple):
    """A cable of the scene.

    cable: `CableInScene.among_others`.   system: its index-reduced equations.
    loads: gravity and motions; Exudyn evaluates all others.
    """

    cable: CableInScene
    system: Any
    loads: CableLoads


class _Chain:
    """Cables that share records.   dofs: their place.   nothing: external force."""

    def __init__(self, dofs: slice, loads: Sequence[CableLoads], system: Any) -> None:
        self._dofs, self._loads, self._report = dofs, loads, Bound(report_energy, system)
        self._force = np.zeros(dofs.stop - dofs.start)
        self.nothing = np.zeros(sum(len(one.constant) for one in loads))

    def external(self, t: float) -> Array:
        """As the system takes it, at t [s]."""
        return np.concatenate([loads.at(t) for loads in self._loads])

    def report(self, external: Array, q: Array, v: Array, a: Array) -> Array:
        """(6,) see `report_energy`.   q, v, a: (n,) of all parts."""
        result = np.zeros(REPORTED)
        self._report(external, *(x[self._dofs] for x in (q, v, a)), self._force, result)
        return result


class SceneOfExudyn(EvaluatedScene):
    """The parts of a scene in one order, cables, bodies, first order states, as Exudyn evaluates them.

    system: all of it.   map: places of the coordinates.   size: how many, with first order states.
    native_items: forces and joints.   joints: that couple the parts.   rows: of them.
    held: coordinates that belong to no part.   body_system: the equations of all bodies.
    bodies_of_variable_mass: how many there are.
    cable_systems: of the cables.   groups: of those that share records.
    parts_in_one: what evaluates bodies and joints, if it is compiled code.
    path: memory of the work of the forces at evaluations, see `build_path`.
    """

    parts_in_one: CompiledParts | None = None

    def __init__(
        self,
        mbs: Any,
        cables: Sequence[CoupledCable],
        own_constraints: frozenset[int],
        zeta: float,
        held: Mapping[int, HeldCoordinate] = _NONE,
        moved: Set[int] = frozenset(),
    ) -> None:
        """Read all but the cables from mbs.

        Args:
            mbs: assembled; Exudyn's own evaluation of the cables is switched off.
            cables: its inextensible cables.   own_constraints: object numbers of what belongs to them.
            zeta: stabilisation rate of the joints [1/s].
            held: coordinates to be left out where a body of constant mass has them, by their constraints.
            moved: numbers of constraints whose offsets or lengths may be set between steps.

        Raises:
            SceneError: coordinates without mass, or a joint that is not supported.
        """
        self.mbs = mbs
        self.cables = cables
        self.elsewhere, self.moved = own_constraints, moved
        solver = evaluator(mbs)
        on_cables = np.concatenate([np.zeros(0, int), *(part.cable.indices for part in cables)])
        total = SystemMass(mbs, solver)
        self.bodies = bodies = read_bodies(mbs, [part.cable.number for part in cables], on_cables, total)
        quaternions = read_quaternions(mbs)
        by_place = holders(mbs, held)
        self._masses = masses = BodyMasses(mbs, bodies, quaternions, zeta, total, by_place)
        self.held = HeldCoordinates(mbs, masses, [by_place[place] for place in masses.held.tolist()], held)
        places = [(one.indices, one.cable.reference.ravel()) for one, _, _ in cables]
        places.append((masses.coordinates, np.zeros(len(masses.coordinates))))
        self.map = CoordinateMap(mbs.systemData.ODE2Size(), places)
        require_mass(mbs, np.setdiff1d(self.map.missing(), masses.held))
        self.groups: Sequence[Systems] = in_few_chains([cable.system for cable in cables])
        groups = self.groups
        self.cable_systems: Sequence[Any] = [system for _, alike in groups for system in alike]
        others = [Part(masses.system, self.map.slices[-1]), *self._first_order_states()]
        of_cables = list(_parts_of_cables(groups, self.map.slices))
        parts = [*of_cables, *others]
        evaluated = [part.whole or part for part in of_cables]
        wholes = [*{id(whole): whole for whole in evaluated}.values(), *others]
        self.joints: Sequence[Any] = read_joints(mbs, own_constraints.union(self.held.numbers))
        self.tilted_angles = TiltedAngles(mbs, self.joints, self.map.place)
        self.rows = rows = JointRows(self.joints, quaternions, parts, self.map, masses.held)
        loads = [cable.loads for cable in cables]
        self.native_items = NativeItems(mbs, solver, wholes, self.map, loads, masses, rows, self.held)
        self.system = CoupledSystem(parts, self.native_items, zeta, wholes)
        self.size = parts[-1].dofs.stop
        self.path = build_path(self.size)
        self.system.states = slice(len(self.map.indices), self.size)
        self.has_bodies = len(masses.coordinates) > 0
        self.body_system, self.bodies_of_variable_mass = masses.system, masses.number_of_variable

    def displacements(self, q: Array) -> Array:
        """(size,) of all coordinates of mbs, from those of all parts; held ones are where they begin."""
        total = np.array(self.mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Initial))
        own = self.map.indices
        total[own] = np.array(self.map.displacements(q[: len(own)]))[own]
        return total

    def take_hold(self, v: Array, tolerance: float) -> None:
        """Stop the held coordinates at the start; see `HeldCoordinates`.   v: (n,) of all parts, in place."""
        bodies = self.system.parts[len(self.cables)].dofs
        self.held.take_hold(v[bodies], tolerance)

    @property
    def places_of_nodes(self) -> dict[int, tuple[int, int]]:
        """First coordinate of each node of cables and bodies, and the dimension of its space."""
        data, found = self.mbs.systemData, {}
        for number in range(data.NumberOfNodes()):
            own = data.GetNodeLTGODE2(number)
            place = self.map.place(own[0]) if len(own) else -1
            if place >= 0:
                kind = self.mbs.GetNode(number)["nodeType"]
                found[number] = place, 2 if "2D" in kind else 3
        return found

    @property
    def ways_of_flight(self) -> Array:
        """(dim, n) see `Flight`."""
        flies = not any(is_tied(one.cable.cable) for one in self.cables) and may_fly(self.mbs)
        places, dimensions = np.array([*self.places_of_nodes.values()] if flies else [(0, 0)]).T
        ways = np.zeros((dimensions.min(), self.size))
        for axis, way in enumerate(ways):
            way[places + axis] = 1.0
        return ways

    @property
    def forces(self) -> Array:
        return self.native_items.varying_forces

    def report_energy(self, t: float, state: Any, energy_report: Array, scale: float = np.inf) -> None:
        q, v, a = state.q, state.v, state.a
        if self.joints:
            for cable, (_, _, loads) in enumerate(self.cables):
                if len(loads.pattern):  # its own solve knows no joints
                    self.set_multipliers(cable, t, q, v)
        energy_report[:] = 0.0
        for one in self._chains:
            own = one.report(one.external(t), q, v, a)
            worst = np.maximum(energy_report[VIOLATION], own[VIOLATION])
            energy_report += own
            energy_report[VIOLATION] = worst
        energy_report[KINETIC] += self._kinetic_energy_of_bodies(q, v)
        energy_report[RESOLVED] += self._kinetic_energy_of_bodies(q, a)
        energy_report[POWER] += float(self.system.multipliers @ self.system.drift)
        if self.joints and scale < np.inf:
            violation = float(np.abs(self.violations(t, q)).max())
            energy_report[VIOLATION] = max(energy_report[VIOLATION], violation / scale)

    def kinetic_energy(self, q: Array, v: Array) -> float:
        total = self._kinetic_energy_of_bodies(q, v)
        for one in self._chains:  # the mass alone, without what bending adds to it
            total += one.report(one.nothing, q, v, v)[ACCELERATION_ENERGY]
        return total

    @cached_property
    def _chains(self) -> Sequence["_Chain"]:
        found: list[_Chain] = []
        done = 0
        for system, alike in self.groups:
            end = done + len(alike)
            dofs = slice(self.map.slices[done].start, self.map.slices[end - 1].stop)
            found.append(_Chain(dofs, [cable.loads for cable in self.cables[done:end]], system))
            done = end
        return found

    def _kinetic_energy_of_bodies(self, q: Array, v: Array) -> float:
        if self.parts_in_one:
            return self.parts_in_one.kinetic_energy_of_bodies(q, v)
        return self.body_system.kinetic_energy(v[self.map.slices[-1]])

    def energies_of_spins(self, duration: float) -> Array:
        """See `EvaluatedScene`; not known of bodies that Exudyn evaluates."""
        parts = self.parts_in_one
        return parts.form.energies_of_spins(duration) if parts else np.zeros(self.size)

    @property
    def fastest_turn(self) -> float:
        return 0.0

    def leave_out_turns(self, way: Array) -> None:
        if self.parts_in_one:
            self.parts_in_one.form.leave_out_turns(way)

    def violations(self, t: float, q: Array) -> Array:
        if self.parts_in_one:
            return self.parts_in_one.form.violations(t, q)
        return self.native_items.violations(t, q)

    def memory(self) -> dict[str, Any]:
        """Drift corrections of joints and quaternions, where joints slide, how they are steered, by names."""
        corrections = {"joints": self.system.drift_correction, "quaternions": self.body_system.memory()}
        joints = self.native_items
        return corrections | {"places": joints.places, "steered": joints.approach.memory}

    def forget(self) -> None:
        """Reset the drift corrections of joints and quaternions."""
        self.system.drift_correction[:] = 0.0
        self.body_system.forget()

    def read_masses_again(self) -> None:
        """Bodies may have other masses than when they were read."""
        self._masses.read_again()
        self.native_items.forget()

    def can_weigh(self, item: tuple[str, int, str]) -> bool:
        """See `KnownNumbers.can_weigh`, where Exudyn evaluates bodies."""
        return self._masses.can_weigh(Parameter(*item))

    def _first_order_states(self) -> list[Part]:
        """y of y' = f as velocities of unit masses: every scheme then integrates them as it does v."""
        number = self.mbs.systemData.ODE1Size()
        if not number:
            return []
        start = len(self.map.indices)
        unit = BodiesSystem(number, [MassBlock(np.arange(number), np.eye(number))])
        return [Part(unit, slice(start, start + number))]

    @cached_property
    def has_steered_joints(self) -> bool:
        """Whether functions of the user move joints by what they change between steps."""
        given = (self.mbs.GetObject(joint.number).get("offsetUserFunction") for joint in self.joints)
        return bool(step_functions(self.mbs)) and not all(is_of_time_alone(self.mbs, f) for f in given if f)

    @property
    def has_hidden_changes(self) -> bool:
        """Whether step functions may change what functions of items read."""
        return bool(step_functions(self.mbs) and asked_item_functions(self.mbs))

    @property
    def initial_state(self) -> tuple[Array, Array]:
        """q and v (n,) of all parts at the start."""
        return self.state(exudyn.ConfigurationType.Initial)

    @cached_property
    def friction(self) -> FrictionCheck:
        """Whether friction of cables on circles obeys Coulomb's law."""
        return FrictionCheck(self.mbs)

    def open_contacts(
        self, t: float, q: Array, v: Array, data: Array | None, implicit: Mapping[int, float]
    ) -> OpenContacts | None:
        """Contacts that are open in a state, if there are any.

        data: (D,) of them; None: mbs knows.   implicit: see `Mover.implicit_contacts`.
        """
        if not self.mbs.systemData.DataSize():
            return None
        with state_kept(self.mbs):
            self.native_items.set_state(t, q, v)
            if data is not None and len(data):
                self.mbs.systemData.SetDataCoordinates(data.tolist())
            found = open_contacts(self.mbs, self.map, self.size, implicit)
        self.native_items.forget()
        return found

    @property
    def remembered(self) -> DataCoordinates | None:
        """What contact and friction remember in mbs, if there are any."""
        data = self.mbs.systemData
        return DataCoordinates(data) if data.DataSize() else None

    def remember(self, data: Array) -> None:
        """Let contacts in mbs remember this, at present and at the start of the step.   data: (2, D)."""
        if data.shape[1]:
            DataCoordinates(self.mbs.systemData).put_back(data.tolist())

    def coordinate_name(self, index: int) -> str:
        """The node that has a coordinate, by its place in the system vector."""
        data = self.mbs.systemData
        nodes = [k for k in range(data.NumberOfNodes()) if index in data.GetNodeLTGODE2(k)]
        return f"node {nodes[0]} '{self.mbs.GetNode(nodes[0])['name']}'" if nodes else f"coordinate {index}"

    def native_cable_at(self, index: int) -> str:
        """The element of a native cable that has a coordinate, by its place in the system vector; or ''."""
        data = self.mbs.systemData
        for number in range(data.NumberOfObjects()):
            item = self.mbs.GetObject(number)
            is_own = item["objectType"] in ANCF_CABLES and not is_inert_cable(item)
            if is_own and index in data.GetObjectLTGODE2(number):
                return f"object {number} '{item['name']}' (Object{item['objectType']})"
        return ""

    def require_finite(self, v: Array) -> None:
        """Raise SceneError, which names the node, unless all velocities v (n,) are finite."""
        bad = np.flatnonzero(~np.isfinite(v[: len(self.map.indices)]))
        if len(bad):
            where = self.coordinate_name(self.map.indices[bad[0]])
            raise SceneError(
                f"an initial velocity of {where} is {v[bad[0]]:g}, no finite number: correct its initial "
                "values."
            )

    def state(self, configuration: Any = exudyn.ConfigurationType.Current) -> tuple[Array, Array]:
        """q and v (n,) of all parts in a configuration of mbs."""
        data, number = self.mbs.systemData, len(self.map.indices)
        q, v = np.zeros(self.size), np.zeros(self.size)
        q[:number] = np.asarray(data.GetODE2Coordinates(configuration))[self.map.indices] + self.map.reference
        v[:number] = np.asarray(data.GetODE2Coordinates_t(configuration))[self.map.indices]
        v[number:] = data.GetODE1Coordinates(configuration)
        return q, v

    def solve(self, t: float, q: Array, v: Array) -> None:
        """Evaluate all parts and joints, before `set_multipliers`.   t: time [s].   q, v: (n,)."""
        a, rate = np.zeros(len(q)), np.zeros(len(q))
        index_reduced_rates(self.system, np.array([t]), q, v, a, rate)

    def set_multipliers(self, cable: int, t: float, q: Array, v: Array) -> Array:
        """Accelerations (n_dof,) of one cable among all others, whose system then holds its multipliers.

        Args:
            cable: which one, in the order of the scene.   t, q, v: where all have been evaluated last.
        """
        part, dofs, _ = self.system.parts[cable]
        size = dofs.stop - dofs.start
        a, rate = np.zeros((2, size))
        force = self.cables[cable].loads.at(t).copy()
        force[:size] += self._joined_forces_on(dofs)
        index_reduced_rates(part, force, q[dofs], v[dofs], a, rate)
        return a

    def _joined_forces_on(self, dofs: slice) -> Array:
        """Of items and joints, on a part."""
        of_joints = self.system.joint_force(dofs)
        return self.native_items.native_forces[dofs] - of_joints

    def joined_forces(self) -> Array:
        """(n,) of items and joints on the cables, when accelerations were asked for last."""
        result = np.zeros(self.size)
        for dofs in self.map.slices[: len(self.cables)]:
            result[dofs] = self._joined_forces_on(dofs)
        return result


def _parts_of_cables(groups: Sequence[Systems], slices: Sequence[slice]) -> Iterator[Part]:
    """One for each cable, with what it is evaluated in.   slices: of the cables."""
    done = 0
    for system, alike in groups:
        places = slices[done : done + len(alike)]
        done += len(alike)
        whole = Part(system, slice(places[0].start, places[-1].stop)) if len(alike) > 1 else None
        yield from (Part(own, dofs, whole) for own, dofs in zip(alike, places, strict=True))
