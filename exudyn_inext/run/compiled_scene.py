"""A scene of which all items have compiled forms: many steps in one call."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cached_property, partial
from itertools import pairwise, starmap
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.axial_stiffness import set_step_of_means
from ..cable.cable import Cable
from ..cable.chain import Chain
from ..cable.many_cables import Systems, cable_systems, in_few_chains
from ..called_system import Bound, behind, called, implements, provide
from ..compiled import Prepared, kernel, placed
from ..errors import OffCableError, RedundantConstraintError
from ..multibody.build import copied, held_coordinates, with_dashpots
from ..multibody.cables import Cables, cables_in_a_row, provide_cables
from ..multibody.dashpots import freeze, rows_of_dashpots
from ..multibody.implicit_contacts import implicit_parameters
from ..multibody.joints import Joints
from ..multibody.ramps import Numbers, Ramps, begin_ramps, note_numbers, with_room
from ..multibody.scene import (
    ALL_BUT_FIRST,
    AS_PRESSED,
    EACH,
    EVALUATION,
    MODE,
    NOT_COUNTED,
    SETTLING,
    SceneSystem,
    evaluate_states,
    finish_step,
    joint_violation,
    leave_out_turns,
    set_energies_of_spins,
    settle_contacts,
    subtract_joint_forces,
    take_steps,
)
from ..multibody.sliding import BEYOND, PLACE
from ..scene.redundant_rows import NOT_FINITE, dependent_rows, not_independent
from ..system import (
    ACCELERATION_ENERGY,
    REPORTED,
    VIOLATION,
    accelerate_and_project,
    index_reduced_rates,
    report_energy,
)
from .cable_loads import CableLoads
from .coupled_watch import CoupledWatch
from .kept_state import KeptState
from .ramp import NO_STEP, Line
from .scene_loads import SceneLoads
from .step_control import Piece

FEW = 50  # states
_CHANGING = "connectors", "linear_forces", "loads", "given"  # during a run
_OF_LAWS = "damping", "stiffness", "force", "offset", "rate_offset"  # of connectors

ChangedItem = tuple[str, int, str]  # kind, number, name of the parameter


def cables_of_scene(groups: Sequence[Systems], loads: Sequence[CableLoads]) -> Cables:
    """The systems of all cables.   groups: see `in_few_chains`.   loads: of each cable."""
    rest = iter(loads)
    inputs = [sum(len(next(rest).constant) for _ in alike) for _, alike in groups]
    return cables_in_a_row([system for system, _ in groups], inputs)


class CompiledScene:
    """The compiled system of a scene, and its loads; `scene` is the same one, evaluated by Exudyn.

    Args:
        system: of all.   chains: of its cables, see `in_few_chains`.
        loads: of the cables, and functions of time.   cables: place, and system of each.
        names: of the rows of joints, for messages.
        numbers: of items that may be changed, see `native.known.scene.KnownNumbers`.

    forces: (n,) what the items did to the coordinates at the last evaluation [N, Nm].
    multipliers: (m,) of the joints there, whose forces `subtract_joint_forces` takes off (n,) ones.
    given: (n,) forces that others set, besides those of the items.
    history: (intervals, D) what contacts remember after each interval that has begun with `begin_history`.
    """

    def __init__(
        self,
        system: SceneSystem,
        chains: Sequence[Any],
        loads: SceneLoads,
        cables: Sequence[tuple[slice, Any, CableLoads]],
        names: Sequence[str],
        numbers: Any,
    ) -> None:
        self.loads = loads
        self._chains, self._cables = chains, cables
        self._names = names
        self.numbers, self._moved = numbers, numbers.moved
        rotations = system.items.bodies["rotations"]
        self._has_angles, self._has_spins = bool((rotations == 3).any()), bool((rotations > 1).any())
        self._unscaled: SceneSystem | None = None
        self._stretching: list[Chain] = []  # cables of that one
        self._step_of_means = 0.0  # of these [s]
        self._limit_of_springs = 0.0  # of steps in which they are explicit [s]
        self._take_steps = Prepared(take_steps)
        self._set(system)
        self._memory = np.zeros(len(system.items.force)), np.zeros(REPORTED)
        self._spins, self._set_spins = np.zeros(len(system.items.force)), Prepared(set_energies_of_spins)
        self._rates_of_cables = [Bound(index_reduced_rates, own) for _, own, _ in cables]
        self._find_violated = Prepared(_violated)
        self._note_numbers, self._begin_ramps = Prepared(note_numbers), Prepared(begin_ramps)
        self.forces = system.items.force
        self.given, self.data = system.items.given, system.items.data
        self.history = system.items.history

    def _set(self, system: SceneSystem) -> None:
        self.system = system
        joints = system.items.joints
        self.multipliers = joints.multipliers[: joints.holding]
        self._accelerate = Bound(accelerate_and_project, system)
        self._report = Bound(report_energy, system)
        at = placed(system)
        self._violation = partial(Prepared(joint_violation), at)
        self.subtract_joint_forces = partial(Prepared(subtract_joint_forces), at)
        self._called: Any = None
        self.__dict__.pop("_ramps", None)

    def provide(self, calls: tuple[Any, ...]) -> None:
        """Compile what an integrator calls, see `Integrator`."""
        self._calls = calls
        provide_cables(self.system.cables, self._chains, *calls)

    @property
    def called(self) -> Any:
        """The system, for kernels that call it by address as an integrator does, see `provide`."""
        self._called = self._called or called(self.system, *self._calls, finish_step, report_energy)
        return self._called

    @property
    def contacts(self) -> Any:
        """See `Contacts` and `GeneralContacts`."""
        return behind(self.system.items.contacts)

    @property
    def remembers(self) -> bool:
        """Whether contacts remember anything."""
        return self.data.shape[1] > 0

    def settle(self, t: float, q: Array, v: Array) -> None:
        """Let what contacts remember at present agree with the state at t [s]."""
        counting = self.system.items.counting
        counting[MODE] = SETTLING
        self.accelerate(self.loads.at(t), q, v, 0.0, *np.zeros((2, len(q))))
        counting[MODE] = NOT_COUNTED

    @contextmanager
    def pressed_as_before(self) -> Iterator[None]:
        """Leave contact in the cables' matrices as it is, or was read from a file, see `pressed`."""
        counting = self.system.items.counting
        counting[MODE] = AS_PRESSED
        yield
        counting[MODE] = NOT_COUNTED

    @property
    def pressed(self) -> dict[str, Array]:
        """Contact in the matrices of cables, see `cable.contact_mass`, by names; in place.

        And the forces of joints by which it is reconsidered, see `multibody.scene`.
        """
        if not self.contacts.records["implicit"].any():
            return {}
        found = {"foreseen": self.system.items.joints.foreseen}
        for k, system in enumerate(self._chains):
            elements = system.chain.elements
            if elements["contact"].size:
                found |= {f"{name} {k}": elements[name] for name in ("contact", "touches")}
        return found

    def foresee_joints(self) -> None:
        """Let joints pull in the next step as at the last evaluation, until they are solved for."""
        joints = self.system.items.joints
        joints.foreseen[:] = joints.multipliers

    def set_step(self, h: float) -> None:
        """Prepare implicit damping of contact and dashpots for steps of h [s]; 0: it is explicit.

        Springs are implicit in steps that are too long for explicit ones.
        """
        records = self.contacts.records
        records["lag"] = h * records["implicit"]
        if self.damps_implicitly:
            self.loads.springs.step = h
        self._dashpots["lag"] = h
        self._dashpots["reach"] = h if h > self._limit_of_springs else 0.0

    @property
    def _dashpots(self) -> Any:
        """Records of the rows of dashpots that are implicit."""
        joints = self.system.items.joints
        return joints.rows[joints.holding :]

    @property
    def damps_implicitly(self) -> bool:
        """Whether dashpots of springs are implicit."""
        return len(self._dashpots) > 0

    def damp_implicitly(self, limit: float) -> bool:
        """Let springs be implicit from now on; whether there are any.

        limit: of steps in which they are explicit, but for their dashpots [s].
        """
        self._limit_of_springs = limit
        places = [dofs for dofs, _, _ in self._cables]
        still = held_coordinates([system for _, system, _ in self._cables])
        system = with_dashpots(self.system, self._chains, places, still)
        if system:
            self._set(system)
            self._unscaled = None
        return system is not None

    @contextmanager
    def explicit_damping(self, damping: float = 1.0) -> Iterator[None]:
        """Nothing of it is implicit; what is implicit otherwise counts with that share, 0 or 1.

        Implicit springs are explicit with 1; with 0 they pull as at the last evaluation.
        """
        dashpots = self._dashpots
        saved, which = dashpots.copy(), np.unique(dashpots["connector"])
        dashpots["lag"] = dashpots["reach"] = 0.0
        try:
            with self._weak_springs(which, damping), self._explicit_contact(damping):
                yield
        finally:
            dashpots[:] = saved

    @contextmanager
    def _weak_springs(self, which: np.ndarray, damping: float) -> Iterator[None]:
        """As `explicit_damping`; with 0, springs pull as at the last evaluation.   which: connectors."""
        connectors, ramps = self.system.items.connectors, self.system.items.ramps
        saved, number = {name: connectors[name].copy() for name in _OF_LAWS}, int(ramps.number[0])
        ramps.number[0] = 0
        connectors["damping"][which] *= damping
        held = self.loads.springs.held if damping == 0.0 and len(which) else nullcontext
        if damping == 0.0:
            freeze(connectors, which)
        try:
            with held():
                yield
        finally:
            ramps.number[0] = number
            for name, values in saved.items():
                connectors[name] = values

    def springs_left_out(self) -> AbstractContextManager[None]:
        """Those that can be implicit pull as at the last evaluation, and do not damp."""
        which = np.unique(rows_of_dashpots(self.system.items.connectors)["connector"])
        return self._weak_springs(which, 0.0)

    def stretch_springs(self, t: float, q: Array, v: Array) -> None:
        """Evaluate the state at t [s], and leave contact in the cables' matrices as it is."""
        with self.pressed_as_before():
            self.accelerate(self.loads.at(t), q, v, 0.0, *np.zeros((2, len(q))))

    @contextmanager
    def _explicit_contact(self, damping: float) -> Iterator[None]:
        """As `explicit_damping`."""
        records = self.contacts.records
        if not len(records):
            yield
            return
        saved, is_implicit = records.copy(), records["implicit"]
        pressed = KeptState(self.pressed)
        records["lag"] = 0.0
        for name in implicit_parameters(records):
            records[name][is_implicit] *= damping
        try:
            yield
        finally:
            records[:] = saved
            pressed.restore()

    def begin_history(self, data: Array, intervals: int) -> None:
        """Begin intervals with what contacts remember.   data: (D,)."""
        self.data[:] = data
        if len(self.system.items.history) < intervals:
            self._set(_with_history(self.system, np.zeros((intervals, len(data)))))
        history = self.system.items.history
        self.history = history[len(history) - intervals :]

    def take_over(self, item: ChangedItem, value: Any) -> bool:
        """Whether the changed item is now what it is in Exudyn; joints that are moved are not looked at."""
        if item[0] == "Object" and self.numbers.can_move(item[1]):
            return True
        return bool(self.numbers.read_again(item, value, [system.items for system in self._systems]))

    def take_values(self, changed: Mapping[Any, Any], line: Line | None) -> bool:
        """As `take_over`, of all these; what are numbers of springs and loads only, along a line if wanted.

        line: that one; None: they jump.
        """
        self.system.items.ramps.number[0] = 0
        ramp = self.loads.ramp
        numbers = self._numbers_along(line, changed) if line and ramp else None
        if numbers:
            self._note_numbers(self._ramps, *numbers)
        if not all(starmap(self.take_over, changed.items())):
            return False
        if numbers and line and ramp:
            ramp.begin(*line.step)
            self._begin_ramps(self._ramps, *numbers)
        return True

    def _numbers_along(self, line: Line, changed: Mapping[Any, Any]) -> Numbers | None:
        """Those that follow parameters which change along the line; None: there are none."""
        numbers = self.numbers.places_of(tuple(key for key in changed if key in line.before))
        self._set_ramps(with_room(self.system.items.ramps, len(numbers.kind)))
        return numbers if len(numbers.kind) else None

    @cached_property
    def _ramps(self) -> Any:
        return placed(self.system.items.ramps)

    @property
    def ramp(self) -> dict[str, list[Any]]:
        """See `CableRun.ramp`."""
        ramps, ramp = self.system.items.ramps, self.loads.ramp
        numbers = [own[: ramps.number[0]].tolist() for own in ramps[-4:]]
        return {"step": ramp.step, "numbers": numbers} if ramp and ramps.number[0] else {}

    def take_ramp(self, kept: Mapping[str, Any]) -> None:
        """See `CableRun.take_ramp`."""
        ramp = self.loads.ramp
        if ramp:
            ramp.begin(*kept.get("step", NO_STEP))
            numbers = kept.get("numbers", [[]])
            self._set_ramps(with_room(self.system.items.ramps, len(numbers[0])))
            ramps = self.system.items.ramps
            ramps.number[0] = len(numbers[0])
            for memory, own in zip(ramps[-4:], numbers, strict=False):
                memory[: len(own)] = own

    def _set_ramps(self, ramps: Ramps) -> None:
        if ramps is not self.system.items.ramps:
            self._set(self.system._replace(items=self.system.items._replace(ramps=ramps)))

    def weigh(self) -> None:
        """Let masses that change be those of the configuration of mbs."""
        self.numbers.weigh([system.items for system in self._systems])

    def approach_joints(self, time: float, end: float, q: Array, tolerance: float) -> bool:
        """Let joints that are violated by more than the tolerance at (time, q) be fulfilled at `end` [s].

        Returns whether all of them can be moved.
        """
        moved, given = self._moved, self._moved.given
        for one in self._systems:
            one.items.joints.rows["rest"][moved.rows] = given
        moved.rest()
        self.violation(time, q)
        left = np.zeros(len(given))
        values, others = self.system.items.joints.value, self._not_moved
        can_move = self._find_violated(values, moved.rows, others, tolerance, left)
        moved.aim(left, time, end)
        return bool(can_move)

    @property
    def _systems(self) -> Sequence[SceneSystem]:
        """With the cables' mass scaled, and as it is."""
        return (self.system, self._unscaled) if self._unscaled else (self.system,)

    @cached_property
    def _not_moved(self) -> np.ndarray:
        """Rows of joints whose offset nobody sets between steps."""
        return np.setdiff1d(np.arange(len(self.multipliers)), self._moved.rows)

    def rest(self) -> None:
        """Joints that have been moved stay where they are."""
        self._moved.rest()

    @property
    def approaches(self) -> bool:
        """Whether joints have moved through the last step."""
        return self._moved.moves

    @property
    def steered(self) -> str:
        """The first joint whose function reads what step functions may change; empty if there is none."""
        return next((sampled.name for sampled in self._moved.steered), "")

    def steered_violation(self, t: float, q: Array) -> float:
        """As `violation`, after step functions have been called."""
        self.loads.forget()
        return self.violation(t, q)

    def take(
        self,
        scheme: Any,
        piece: Piece,
        times: Array,
        done: int,
        history: Array,
        state: Any,
        watch: CoupledWatch,
    ) -> None:
        """Take steps of a piece by a scheme, see `MovedByExudyn.take`.   state: of the integrator.

        Raises:
            RedundantConstraintError: names a joint that depends on others.
            JumpError: a support or joint jumps in these steps, before which the state is.
        """
        items = self.system.items
        sampled = self.loads.sample(times, piece.time(done))
        items.counting[MODE] = EACH if watch.has_one_evaluation else ALL_BUT_FIRST
        items.counting[EVALUATION] = 0
        if self.remembers and not watch.has_one_evaluation:
            provide(self.called.functions, self.system, settle_contacts)
        where = piece.h, done, piece.in_interval, history
        self._take_steps(scheme, self.called, sampled, state, *where, watch.path, watch.before)
        items.counting[MODE] = NOT_COUNTED
        self.require_independence()
        self._require_on_cables()

    def require_independence(self) -> None:
        """Raise RedundantConstraintError if a joint depends on others."""
        if self.has_dependent_joints:
            raise _dependent(self.system.items.joints, self._names)

    def _require_on_cables(self) -> None:
        """Raise OffCableError if what slides has left its cable; it names the joint."""
        sliders, rows = behind(self.system.items.sliders).records, self.system.items.joints.rows
        for slider in sliders if len(sliders) else ():  # an empty array takes long to look through
            beyond = max(-slider.x, slider.x - slider.length)
            if beyond > BEYOND * slider.length:
                row = int(np.flatnonzero(rows["points"][:, 0] == slider.point)[0])
                raise off_cable(self._names[row], beyond, slider.x < 0.0)

    @property
    def places(self) -> dict[str, Array]:
        """Where what slides is on its cables, for the next steps, how offsets are set, and asked springs."""
        sliders = behind(self.system.items.sliders).records
        places = {name: sliders[name] for name in PLACE}
        return places | {"steered": self._moved.memory} | self.loads.springs.memory

    @property
    def has_dependent_joints(self) -> bool:
        """Whether a joint depends on others, as seen at the last evaluation."""
        return bool(self.system.items.joints.dependent[0] >= 0)

    def evaluate(
        self,
        cables: Sequence[Cable],
        times: Array,
        steps: Array,
        history: Array,
        remembered: Array | None = None,
    ) -> tuple[Array, Array]:
        """Accelerations of states, by the mass as it is; see `evaluate_states`.

        Args:
            cables: of the scene.   times, steps: (k,) of the states, and before them [s].
            history: (k, 3, n) total coordinates, velocities, and output: accelerations.
            remembered: (k, D) by contacts, if there are any.

        Returns:
            (k, m) multipliers of the joints, and (k, n) what items and joints do to the coordinates.
        """
        if self._unscaled is None:
            self._unscaled = self._without_scaling(cables)
            self._accelerate_unscaled = Bound(accelerate_and_project, self._unscaled)
            self._subtract_unscaled = partial(Prepared(subtract_joint_forces), placed(self._unscaled))
        multipliers = np.zeros((len(times), len(self.multipliers)))
        forces = np.zeros((len(times), len(self.system.items.force)))
        may_change = self._stretching and len(steps) > 1
        changes: Any = np.flatnonzero(np.diff(steps)) + 1 if may_change else ()
        for rows in starmap(slice, pairwise([0, *changes, len(times)])):
            self._take_means(steps[rows.start])
            data = None if remembered is None else remembered[rows]
            with self.loads.springs.kept():
                self._evaluate_alike(times[rows], history[rows], data, multipliers[rows], forces[rows])
        return multipliers, forces

    def _take_means(self, step: float) -> None:
        """Let cables that stretch, with their mass as it is, have mean forces of such a step [s]."""
        for chain in self._stretching if step != self._step_of_means else ():
            set_step_of_means(step, chain.nodes, chain.elements)
        self._step_of_means = step

    def _evaluate_alike(
        self, times: Array, history: Array, remembered: Array | None, multipliers: Array, forces: Array
    ) -> None:
        """As `evaluate`, of states after steps of one size."""
        system, rate = self._unscaled, np.zeros(history.shape[2])
        assert system
        if len(times) > FEW and self.loads.of_state is None:  # it takes long to compile
            if remembered is not None:
                system = _with_history(system, remembered)
            memory = np.zeros(len(self.loads.constant)), rate
            loads = self.loads.sample(times[:, np.newaxis])
            given = called(system, accelerate_and_project), placed(system), loads
            evaluate_states(*given, history, multipliers, forces, *memory)
            return
        for k, (t, (q, v, a)) in enumerate(zip(times.tolist(), history, strict=True)):
            if remembered is not None:
                system.items.data[0] = remembered[k]
            external = self.loads.follow(self.loads.at(t), q, v)
            self._accelerate_unscaled(external, q, v, 0.0, a, rate)
            multipliers[k] = system.items.joints.multipliers[: multipliers.shape[1]]
            forces[k] = system.items.force
            self._subtract_unscaled(forces[k])

    def _without_scaling(self, cables: Sequence[Cable]) -> SceneSystem:
        """The same system in memory of its own, with the cables' mass as it is."""
        groups = in_few_chains(cable_systems(cables, self.system.zeta))
        chains = [system.chain for system, _ in groups]
        self._step_of_means = 0.0
        self._stretching = [chain for chain in chains if chain.elements["axial"].size]
        own = cables_of_scene(groups, [loads for _, _, loads in self._cables])
        own.functions[:] = self.system.cables.functions
        items = self.system.items
        shared = {id(one): one for one in (getattr(items, name) for name in _CHANGING)}
        copies = copied(items, {id(self.system.cables): own, **shared})
        behind(copies.contacts).records["lag"] = 0.0
        copies.ramps.number[0] = 0
        copies.joints.drift_correction[:] = 0.0
        copies.joints.rows["lag"] = copies.joints.rows["reach"] = 0.0
        copies.bodies["drift_correction"] = 0.0
        return self.system._replace(cables=own, items=copies)

    def _joined_forces(self) -> Array:
        """(n,) what items and joints did at the last evaluation."""
        total: Array = self.forces.copy()
        self.subtract_joint_forces(total)
        return total

    def accelerate(self, external: Array, q: Array, v: Array, *others: Any) -> None:
        """See `accelerate_and_project`, without the system."""
        self._accelerate(self.loads.follow(external, q, v), q, v, *others)

    def report_energy(self, t: float, state: Any, energy_report: Array, scale: float = np.inf) -> None:
        """See `EvaluatedScene`."""
        if len(self.multipliers):
            for cable, (_, _, loads) in enumerate(self._cables):
                if len(loads.pattern):  # its own solve knows no joints
                    self.set_multipliers(cable, t, state.q, state.v)
        external, q = self.loads.at(t), state.q
        self._report(external, q, state.v, state.a, self._memory[0], energy_report)
        if len(self.multipliers) and scale < np.inf:
            functions = external[len(self.system.cable_force) :]
            violation = self._violation(functions, q) / scale
            energy_report[VIOLATION] = max(energy_report[VIOLATION], violation)

    def kinetic_energy(self, q: Array, v: Array) -> float:
        """See `EvaluatedScene`."""
        force, energy_report = self._memory
        self._report(self.loads.constant, q, v, v, force, energy_report)
        return float(energy_report[ACCELERATION_ENERGY])  # without what bending adds to the mass

    def energies_of_spins(self, duration: float) -> Array:
        """See `EvaluatedScene`."""
        if self._has_spins:
            self._set_spins(self.system.items.bodies, duration, self._spins)
        return self._spins

    @property
    def fastest_turn(self) -> float:
        """See `EvaluatedScene`."""
        connectors = self.system.items.connectors
        return float(np.abs(connectors["rate"][connectors["place"] >= 0, 5]).max(initial=0.0))

    def leave_out_turns(self, way: Array) -> None:
        """See `EvaluatedScene`."""
        if self._has_angles:
            leave_out_turns(self.system.items.bodies, way)

    def violation(self, t: float, q: Array) -> float:
        """Largest |c| of the joints [m, -]."""
        return float(self._violation(self.loads.of_joints(t), q))

    def violations(self, t: float, q: Array) -> Array:
        """See `EvaluatedScene`."""
        self.violation(t, q)
        return self.system.items.joints.value[: len(self.multipliers)].copy()

    def set_multipliers(self, cable: int, t: float, q: Array, v: Array) -> Array:
        """See `EvaluatedScene`."""
        dofs, _, loads = self._cables[cable]
        size = dofs.stop - dofs.start
        force, (a, rate) = loads.at(t).copy(), np.zeros((2, size))
        force[:size] += self._joined_forces()[dofs]
        self._rates_of_cables[cable](force, q[dofs], v[dofs], a, rate)
        return a


@implements(accelerate_and_project, CompiledScene, compiled=lambda function: function)
def _accelerate_compiled(scene: CompiledScene, *arguments: Any) -> None:
    """Without a look at the types of all records, which takes as long as the evaluation."""
    scene.accelerate(*arguments)


@implements(index_reduced_rates, CompiledScene, compiled=lambda function: function)
def _rates_of_compiled(scene: CompiledScene, external: Array, q: Array, v: Array, *others: Any) -> None:
    index_reduced_rates(scene.system, scene.loads.follow(external, q, v), q, v, *others)


@kernel
def _violated(values, rows, others, tolerance, left):
    """Whether only those rows are violated by more than the tolerance, by which values are `left` (k,)."""
    for k in range(len(rows)):
        left[k] = values[rows[k]] if abs(values[rows[k]]) > tolerance else 0.0
    can_move = True
    for row in others:
        can_move = can_move and abs(values[row]) <= tolerance
    return can_move


def off_cable(name: str, beyond: float, at_start: bool) -> OffCableError:
    """What is said of a joint whose slider is a distance [m] beyond an end of its elements."""
    end = "start" if at_start else "end"
    return OffCableError(
        f"{name} has slid {beyond:.3g} m beyond the {end} of the elements in its slidingMarkerNumbers (limit "
        "0 m): let the cable go on there, or stop the body before, by a spring or a support."
    )


def _with_history(system: SceneSystem, history: Array) -> SceneSystem:
    """The same, with this memory of what contacts remember, (k, D)."""
    return system._replace(items=system.items._replace(history=history))


def _dependent(joints: Joints, names: Sequence[str]) -> RedundantConstraintError:
    """What is said of joints that depend on each other."""
    place = joints.dependent[0]
    if len(joints.members.row) or len(joints.nodes.dof):
        row = np.flatnonzero(joints.place == place)
        if len(joints.nodes.dof) and not len(row):  # a length, which rows before it hold already
            row = np.argsort(np.where(joints.place < place, -joints.place, 0))[:1]
        is_finite = len(row) and np.isfinite(joints.diagonal).all()
        return not_independent([names[row[0]]]) if is_finite else RedundantConstraintError(NOT_FINITE)
    holds, total, begin = joints.holds, np.zeros((len(joints.rows), len(joints.rows))), 0
    row_of = joints.entries.row[holds.entry]
    for end, first in zip(holds.end, holds.square, strict=True):
        own, size = row_of[begin:end], end - begin
        total[np.ix_(own, own)] += holds.local[first : first + size**2].reshape(size, size)
        begin = end
    if not np.isfinite(total).all():  # of springs, too, which are no joints
        return RedundantConstraintError(NOT_FINITE)
    return dependent_rows(np.tril(total)[: joints.holding, : joints.holding], names)
