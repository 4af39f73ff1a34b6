"""Cables, bodies and joints of a scene, moved together: one right-hand side call for each evaluation."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.linked_cable import memory_of
from ..compiled import plain
from ..errors import DivergenceError, OffCableError, RedundantConstraintError, SceneError
from ..integrators.integrator import Integrator, LoadHistory, advance, remembered
from ..integrators.linear_stability import frequency_limit
from ..scene.closed_contacts import rates_in_contact
from ..scene.small_vibrations import FastestRates, VibrationTracker, fastest_rates
from ..system import accelerate_and_project, index_reduced_rates
from .cable_run import CableRun, Start
from .compiled_scene import ChangedItem, CompiledScene, RememberedByContacts, Steps
from .consistent_start import StartCorrection, agree
from .coupled_start import compiled_start, consistent_start
from .coupled_watch import LENIENCE, CoupledWatch
from .divergence import explanation, listed
from .joined_scene import EvaluatedScene, JoinedScene, OpenContacts
from .jump import accelerate_again, remembers_axial_forces
from .kept_state import Elsewhere, KeptState
from .paced_run import PacedRun
from .redundancy import is_held_straight, with_straight_cables
from .step_control import FrequencyFollower, Piece, StepControl, StepRule
from .time_grid import TimeGrid

FULFILLED = 1e-9  # violation of a joint [m, -] that needs no motion to be removed
STEPS_BETWEEN_LOOKS = 128  # at the frequency, which costs as much as some 10 evaluations


class CoupledRun(PacedRun):
    """All of a scene, see `time_loop.Run`.

    Args:
        scene: all of it.   cable_runs: of its cables.   method: integrator and scheme.
        start: as of a cable.
        why: what it contains, for messages.
    end_of_step: of the time loop [s], at which violated joints shall be fulfilled, for a run that takes over
        from another one; None: they are violated by at most the tolerance.
    cables: models of the inextensible cables.   start_corrections: one for each of them, and for joints.
    why_not: why Exudyn evaluates the scene; empty if it does not.
    """

    lenience = LENIENCE

    def __init__(
        self,
        scene: JoinedScene,
        cable_runs: Sequence[CableRun],
        method: tuple[Integrator, Any],
        start: Start,
        why: str,
        end_of_step: float | None = None,
    ) -> None:
        self._scene = scene
        self._runs = cable_runs
        self._why = why
        integrator, scheme = self.integrator, self.scheme = method
        self._time = start.time
        self.indices, self.reference = scene.map.indices, scene.map.reference
        self.state: Any = integrator.allocate(scene.size, 1)
        self.state.q[:], self.state.v[:] = scene.initial_state
        for run, dofs, system in zip(cable_runs, scene.map.slices, scene.cable_systems, strict=False):
            run.adopt(system)
            self.state.q[dofs], self.state.v[dofs] = run.state.q, run.state.v
        scene.require_finite(self.state.v)
        self.start_correction = StartCorrection()
        self._form: CompiledScene | None = None
        self._end_of_step = start.time  # until which joints are moved [s]
        with self._naming_straight_cables():
            self._form, self.why_not = scene.compiled(start.time, self.state.q, self.state.v)
            if end_of_step is None:
                self._project(start)
            else:
                self._approach(start.time, end_of_step)
        if self._form:
            self._form.provide(integrator.calls)
        if not (self._form or self.approaches):
            scene.compile_parts(start.time, self.state.q, self.state.v)
        self._tracker: VibrationTracker | None = None
        self._fastest = np.zeros((2, 2, scene.size))  # see `fastest_rates`: as it is, and in contact
        self._rejects = start.rejects
        self.control = StepControl(rejects=start.rejects)
        self._recorded = 0  # intervals
        self._first_data = self.data[0]  # of them
        self._is_alone = False  # mbs does not follow it
        self._data_of_intervals = np.zeros((0, 0))  # with places of what slides
        self._unsolvable = ""  # what was said of joints that could not be solved for
        self._output = np.zeros((1, 3, scene.size))
        external = np.zeros(len(self._form.loads.constant) if self._form else 1)
        self.state = self.state._replace(external=external)
        evaluated: EvaluatedScene = self._form or scene
        tolerance = start.energy_tolerance
        self.watch = CoupledWatch(evaluated, scene, cable_runs, self.state, integrator, scheme, tolerance)
        if scene.friction.is_needed:
            self.watch.after_each_step.append(scene.friction.look)

    def make_consistent(self, start: Start) -> None:
        """See `CableRun.make_consistent`."""
        scene, state = self._scene, self.state
        scene.require_finite(state.v)
        scene.surroundings.forget()
        for run, dofs in zip(self._runs, scene.map.slices, strict=False):
            run.state.q[:], run.state.v[:] = state.q[dofs], state.v[dofs]
            run.make_consistent(start)
            state.q[dofs], state.v[dofs] = run.state.q, run.state.v
        if self._form and self.approaches:  # Exudyn knows nothing of that
            for evaluated in (self._form, scene.surroundings):
                evaluated.approach_joints(start.time, self._end_of_step, state.q, FULFILLED)
        self._project(start)
        if self._form:
            scene.surroundings.approach = None

    def _project(self, start: Start) -> None:
        """Onto all constraints: impulses at the start meet the mass as it is, without scaling."""
        scene, state = self._scene, self.state
        scene.take_hold(state.v, start.tolerance)
        with self._mass_as_it_is():
            given = start.time, state.q, state.v, start.tolerance
            form = None if self._hides_dependence else self._form
            correction = compiled_start(form, *given) if form else None
            self.start_correction = correction or consistent_start(scene.system, self.cables, *given)

    @property
    def _hides_dependence(self) -> bool:
        """Whether the compiled form may miss that joints depend on each other: its knots yield a little."""
        return self._form is not None and self._form.has_knots and any(self._held_straight())

    @contextmanager
    def _naming_straight_cables(self) -> Iterator[None]:
        """In what is said of joints that depend on each other."""
        try:
            yield
        except RedundantConstraintError as error:
            raise with_straight_cables(error, list(self._held_straight())) from None

    def _held_straight(self) -> Iterator[str]:
        """Names of straight cables between what holds them."""
        blocks = self._scene.surroundings.blocks
        for run, cable, dofs in zip(self._runs, self.cables, self._scene.map.slices, strict=False):
            jacobians = [block.jacobian for block in blocks if block.dofs == dofs]
            if is_held_straight(cable, self.state.q[dofs], jacobians):
                yield run.name

    @contextmanager
    def _mass_as_it_is(self) -> Iterator[None]:
        """Nothing of the cables' bending is in the matrix on the left."""
        with ExitStack() as stack:
            for run in self._runs:
                stack.enter_context(run.mass_as_it_is())
            yield

    @property
    def name(self) -> str:
        cables = listed([run.name for run in self._runs])
        joints = len(self._scene.joints)
        others = [f"{joints} joint(s)"] if joints else []
        others += ["bodies"] if self._scene.has_bodies else []
        return " and ".join([cables, *others]) if cables else "native items"

    def holds(self, number: int) -> bool:
        """Whether the equations leave out the coordinate that this constraint holds."""
        return number in self._scene.held.numbers

    @property
    def cable_runs(self) -> Sequence[CableRun]:
        """Those of the inextensible cables, which move as its parts."""
        return self._runs

    @property
    def cables(self) -> list[Cable]:
        return [run.scene_cable.cable for run in self._runs]

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [run.start_correction for run in self._runs] + [self.start_correction]

    @cached_property
    def _rates(self) -> FastestRates:
        return self._rates_at(self._time)

    def _rates_at(self, time: float) -> FastestRates:
        """Of the present state."""
        with self._without_implicit_forces(time):
            return fastest_rates(*self._system_at(time), self.state.q, self.state.v, self._fastest[0])

    def _system_at(self, time: float) -> tuple[Any, Array]:
        """What takes the steps, and the external force that it is given."""
        if self._form:
            return self._form.system, self._form.loads.at(time)
        return self._scene.system, np.array([time])

    def _begin_by(self, function: Callable[..., None], time: float) -> None:
        """Begin with a function of the integrator, of (system, external, state)."""
        system, external = self._system_at(time)
        plain(function)(self._form or system, external, self.state)

    def leave_kernels(self, why: str, time: float) -> None:
        """Let Exudyn evaluate its items from the present state on, at `time` [s]."""
        if self._form is None:
            return
        self._leave_form(why)
        self.watch.evaluate_by(self._scene)
        self._scene.surroundings.forget()
        self._begin_by(self.integrator.resume, time)

    def _leave_form(self, why: str) -> None:
        self._form, self.why_not = None, why
        self.__dict__.pop("_kept", None)  # elsewhere is another place now

    def take_values(self, changed: Sequence[ChangedItem]) -> bool:
        """Whether loads and springs that were changed act now; otherwise some may."""
        return self._form is None or all(map(self._form.take_over, changed))

    def take_over(self, changed: Sequence[ChangedItem], is_simple: bool, time: float) -> None:
        """Go on from the present state, at `time` [s], with items that were changed.

        is_simple: whether they are loads, springs, and joints that are moved, only.
        """
        if self._form is None:
            if not is_simple and self._scene.parts_in_one:
                self._scene.leave_compiled_parts()
                self._begin_by(self.integrator.resume, time)
            return
        if not is_simple or not self.take_values(changed):
            self.leave_kernels("items that were changed during the run", time)

    def require_same_items(self, time: float) -> None:
        """Raise SceneError if Exudyn's items are not those that have moved the scene."""
        with ExitStack() as stack:
            if self._form:
                self._form.rest()
                stack.enter_context(self._form.explicit_contact())
            self._scene.require_agreement(self._form, time, self.state.q, self.state.v)

    @contextmanager
    def _without_implicit_forces(self, time: float) -> Iterator[None]:
        """Damping and axial forces of cables, at present, and damping of contact do not bound the step."""
        with ExitStack() as stack:
            if self._form and self._may_damp_contact:
                stack.enter_context(self._form.explicit_contact(damping=0.0))
            for run in self._runs:
                stack.enter_context(run.implicit_damping_left_out())
            if any(cable.stretches for cable in self.cables):
                memory = np.zeros((2, len(self.state.q)))
                system, external = self._system_at(time)
                accelerate_and_project(system, external, self.state.q, self.state.v, 0.0, *memory)
            for run in self._runs:
                stack.enter_context(run.axial_forces_frozen)
            yield

    def forget_rates(self, time: float) -> None:
        """Find them again, for the configuration at `time` [s]; the run must then begin again."""
        self._time = time
        self.__dict__.pop("_rates", None)
        if self._tracker:
            self._tracker.vibration[:] = 0.0

    @property
    def _may_damp_contact(self) -> bool:
        """Whether there is contact, and the integrator hands on the accelerations that its damping needs."""
        has_contacts = self._form is not None and self._form.has_contacts
        return has_contacts and self.integrator.has_implicit_damping and not self.integrator.stabilised

    @cached_property
    def contacts(self) -> OpenContacts | None:
        """Contacts that are open at the start, if there are any."""
        state, data, implicit = (self._time, self.state.q, self.state.v), None, np.zeros(0, int)
        if self._form:
            data = self.data[0]
            if self._may_damp_contact:
                implicit = self._form.dofs_in_implicit_contact
        return self._scene.open_contacts(*state, data, implicit)

    @property
    def rates_in_contact(self) -> FastestRates:
        """The rates if all of these contacts close at once; zero where there are none."""
        if self.contacts is None:
            return FastestRates(0.0, 0.0)
        system, external = self._system_at(self._time)
        given = self._form.given if self._form else None
        with self._without_implicit_forces(self._time):
            kept = self.state.q, self.state.v, self._fastest[1]
            return rates_in_contact(system, external, given, self.contacts.closed, *kept)

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration, joints included."""
        return self._rates.frequency

    def follow_frequency(self, rule: StepRule) -> None:
        """Let the steps follow the present stability limit."""
        self._tracker = VibrationTracker(self._scene.size)
        follower = FrequencyFollower(rule, self._present_frequency, STEPS_BETWEEN_LOOKS)
        self.control = StepControl(follower, self._rejects)

    def _present_frequency(self, time: float) -> float:
        """w_max [rad/s] about the present state, of which the integrator then knows again."""
        assert self._tracker is not None
        with self._without_implicit_forces(time):
            found = self._tracker.frequency(*self._system_at(time), self.state.q, self.state.v)
        self.resume(time)
        return found

    @property
    def reason(self) -> str:
        """What an evaluation needs."""
        joints, bodies = len(self._scene.joints), self._scene.bodies_of_variable_mass
        needs = ["one right-hand side of Exudyn"]
        if self._scene.parts_in_one:
            needs += ["no mass and no Jacobian (bodies and joints are compiled)"]
        else:
            needs += [f"the mass of {bodies} bodies"] if bodies else ["no mass (all constant, inverted once)"]
            needs += [f"the Jacobians of {joints} joints"] if joints else ["no Jacobian (no joints)"]
        said = f"each evaluation takes {', '.join(needs)}, as mbs contains {self._why}"
        return f"{said}; Exudyn evaluates them because of {self.why_not}"

    def damping_ratio(self, frequency: float) -> float:
        """Strongest damping [1/s], as a share of that frequency."""
        ratio = self._rates.damping / frequency if frequency > 0.0 else 0.0
        return ratio if ratio > 1e-6 else 0.0

    def scale_mass(self, theta: float, h: float) -> None:
        """See `CableRun.scale_mass`."""
        self.__dict__.pop("_rates", None)
        for run in self._runs:
            run.scale_mass(theta, h)

    def set_step(self, h: float) -> None:
        """Prepare the cables, and contact with them, for steps of h [s]."""
        self.control.present = h
        for run in self._runs:
            run.set_step(h)
        if self._form and self._may_damp_contact:
            self._form.set_step(h)

    def approach(self, time: float, end: float) -> None:
        """Let joints that have been changed be fulfilled at `end` [s], with velocities for that."""
        is_compiled = self._form is not None or self._scene.parts_in_one is not None
        self._approach(time, end)
        if is_compiled and not self._form:
            self.watch.evaluate_by(self._scene)
            self._begin_by(self.integrator.resume, time)

    def _approach(self, time: float, end: float) -> None:
        scene, q, self._end_of_step = self._scene, self.state.q, end
        if self._form and not self._form.approach_joints(time, end, q, FULFILLED):
            self._leave_form("joints that are being moved")
        if not self._form:
            scene.surroundings.approach_joints(time, end, q, FULFILLED)
            if self.approaches:
                scene.leave_compiled_parts()
        self._agree(time)

    def can_move(self, number: int) -> bool:
        """Whether the offset of a joint may be set between steps, with the system as it is."""
        return self._form is None or self._form.can_move(number)

    def rest_joints(self, time: float) -> None:
        """After an approach."""
        self._scene.surroundings.approach = None
        if self._form:
            self._form.rest()
        self._agree(time)

    def _agree(self, time: float) -> None:
        """Project the velocities onto all constraints."""
        self._begin_by(agree, time)

    @property
    def approaches(self) -> bool:
        """Whether joints have moved through the last step, as they were changed."""
        if self._form:
            return self._form.approaches
        return self._scene.surroundings.approach is not None

    def accelerations(self, time: float, multipliers: Array) -> Array:
        """See `CableRun.accelerations`; neither extrapolated nor stabilised, as those of the steps are."""
        state, (a, rest) = self.state, np.zeros((2, self._scene.size))
        arguments = self._scene.system, np.array([time]), state.q, state.v
        surroundings = self._scene.surroundings
        surroundings.forget()
        with self._mass_as_it_is():
            if self.integrator.stabilised:
                accelerate_and_project(*arguments, 0.0, a, rest)
            else:
                index_reduced_rates(*arguments, a, rest)
        multipliers[:] = surroundings.all_multipliers(self._scene.system.multipliers, a)
        self._put_reactions(self._scene, time, (state.q, state.v), multipliers)
        if self.has_implicit_bending:
            self.resume(time)
        surroundings.show(time, state, multipliers)
        return a[: len(self.indices)]

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; see `CableRun.start`."""
        self._forget()
        self._begin(time)
        for run in self._runs:
            run.require_independence()

    def begin_again(self, time: float) -> None:
        """As `start`, with supports that have been looked at, and axial forces of earlier steps.

        What has changed the energy is no error.
        """
        if not self._has_axial_forces:
            self._forget()
        self.start_scheme(time)
        self.watch.begin_again(time, self.state)

    def _forget(self) -> None:
        """What earlier steps taught does not hold any more."""
        self._scene.forget()
        for run in self._runs:
            run.forget()

    def _begin(self, time: float) -> None:
        self.start_scheme(time)
        self.watch.open(time, self.state)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on; see `CableRun.memory`."""
        tracker = self._tracker
        return {
            "state": remembered(self.state),
            "scene": self._scene.memory(),
            "places": self._form.places if self._form else {},
            "cables": self._taught,
            "watch": self.watch.memory(),
            "control": self.control.memory() | ({"vibration": tracker.vibration} if tracker else {}),
            "friction": self._scene.friction.sums,
        }

    @property
    def _taught(self) -> dict[str, Any]:
        """What earlier steps taught the cables."""
        return {str(k): memory_of(system) for k, (system, _) in enumerate(self._scene.groups)}

    @property
    def _has_axial_forces(self) -> bool:
        return any(map(remembers_axial_forces, self._taught.values()))

    def resume(self, time: float) -> None:
        """Go on at `time` [s] with the memory that has been set; data coordinates are those of mbs."""
        if self.control.present:
            self.set_step(self.control.present)
        self._scene.surroundings.forget()
        if not self._form:
            self._scene.surroundings.forces(time, self.state.q, self.state.v)
        self._begin_by(self.integrator.resume, time)
        self.watch.resume()

    def record(self, grid: TimeGrid, first: int, history: Array) -> int:
        """See `CableRun.record`; where Exudyn evaluates its items, mbs is left in the state at the end."""
        surroundings = self._scene.surroundings
        surroundings.forget()
        if self._form and self._form.remembers:
            self._first_data = self.data[0].copy() if self._is_alone else surroundings.remembered
            self._form.begin_history(self._first_data, len(history))
        with np.errstate(over="ignore", invalid="ignore"):  # of a run that diverges
            good = self.advance(grid, first, history)
        self._recorded = good
        if self._form and surroundings.has_sliding_joints:
            self._data_of_intervals = self._with_places(grid, first, history[:good])
        history[:good, 0] -= self.reference
        if good and not self._form:
            multipliers = surroundings.all_multipliers(self._scene.system.multipliers, self.state.a)
            surroundings.show(grid.time(first + good), self.state, multipliers)
        return good

    @property
    def places_of_cables(self) -> list[tuple[slice, tuple[int, ...]]]:
        """See `CableRun.places_of_cables`."""
        places = zip(self._scene.map.slices, self.cables, strict=False)
        return [(dofs, cable.reference.shape) for dofs, cable in places]

    @property
    def places_of_nodes(self) -> dict[int, tuple[int, int]]:
        """See `CableRun.places_of_nodes`; of cables and bodies."""
        return self._scene.places_of_nodes

    def leave_mbs(self, who: str) -> None:
        """Do without mbs from now on.   who: asks, for messages.

        Raises:
            SceneError: Exudyn evaluates items of the scene.
        """
        if self._form is None:
            raise SceneError(
                f"{who} needs compiled forms of all items, and Exudyn evaluates this scene because of "
                f"{self.why_not}: use SolveExplicit, or leave that item out."
            )
        if self._scene.surroundings.has_sliding_joints:
            raise SceneError(
                f"{who} does not say where joints are that slide along cables: use SolveExplicit, or leave "
                "these out."
            )
        self._is_alone = True
        if self._form.remembers:
            self._form.begin_history(self.data[0], 1)

    @property
    def settable_forces(self) -> Array:
        """(n,) forces that act besides those of the items, and may be changed between steps."""
        assert self._form is not None
        return self._form.given

    def complete(self, times: Array, history: Array, multipliers: Array) -> bool:
        """See `Run.complete`; one by one where supports of cables are asked for after each."""
        if not self._form:
            return False
        contacts = None if self._of_contacts is None else self._of_contacts[-len(times) :]
        history[:, 0] += self.reference
        together = 1 if any(run.has_reactions for run in self._runs) else len(times)
        for first in range(0, len(times), together):
            which = slice(first, first + together)
            remembered = None if contacts is None else contacts[which]
            rows = self._form.evaluate(self.cables, times[which], history[which], remembered)
            states = zip(rows, times[which].tolist(), history[which, 0], strict=True)
            multipliers[which] = [self._scene.surroundings.multipliers(*state) for state in states]
            self._put_reactions(self._form, times[first], history[first], multipliers[first])
        history[:, 0] -= self.reference
        return True

    def set_accelerations(self, times: Array, history: Array) -> None:
        """As `complete`, of the beginning and all intervals of the last `record`, without multipliers."""
        assert self._form is not None
        history[:, 0] += self.reference
        data = None if self._of_contacts is None else np.vstack([self._first_data, self._of_contacts])
        self._form.evaluate(self.cables, times, history, data)
        history[:, 0] -= self.reference

    def _put_reactions(self, evaluated: EvaluatedScene, t: float, state: Any, multipliers: Array) -> None:
        """Of the cables' own supports; `evaluated` is so at t [s].   state: q, v, ... of all parts."""
        supported = [cable for cable, run in enumerate(self._runs) if run.has_reactions]
        forces = evaluated.joined_forces() if supported else np.zeros(0)
        for cable in supported:
            run, dofs = self._runs[cable], self._scene.map.slices[cable]
            external = run.loads.at(t).copy()
            external[: dofs.stop - dofs.start] += forces[dofs]
            run.put_reactions(external, state[0][dofs], state[1][dofs], multipliers)

    @property
    def is_compiled(self) -> bool:
        """Whether compiled code evaluates bodies and joints, at least."""
        return self._form is not None or self._scene.parts_in_one is not None

    @property
    def looks_ahead(self) -> bool:  # type: ignore[override]
        """See `PacedRun`."""
        return self._form is not None

    @property
    def is_steady(self) -> bool:
        """See `CableRun.is_steady`; what contacts and sliding joints remember is in mbs, too."""
        return self._form is not None and self.remembered is None and self._form.loads.are_steady

    @property
    def elsewhere(self) -> Elsewhere | None:  # type: ignore[override]
        """See `PacedRun`: what contact and friction remember, in mbs if Exudyn evaluates them."""
        return RememberedByContacts(self._form.contacts.data) if self._form else self._scene.remembered

    @property
    def data(self) -> Array:  # type: ignore[override]
        """See `PacedRun`."""
        return self._form.contacts.data if self._form else PacedRun.data

    @property
    def remembered(self) -> Array | None:  # type: ignore[override]
        """See `PacedRun`."""
        slides = self._form is not None and self._scene.surroundings.has_sliding_joints
        return self._data_of_intervals if slides else self._of_contacts

    @property
    def _of_contacts(self) -> Array | None:
        """(k, D) data of compiled contacts after the intervals of the last `record`."""
        form = self._form
        return form.contacts.history[: self._recorded] if form and form.remembers else None

    def _with_places(self, grid: TimeGrid, first: int, history: Array) -> Array:
        """(k, D) data, with the places of what slides, in states (k, 3, n) from an interval on."""
        surroundings, data = self._scene.surroundings, self._of_contacts
        if data is None:
            data = np.tile(surroundings.remembered, (len(history), 1))
        times = [grid.time(first + 1 + k) for k in range(len(history))]
        return surroundings.places_in(data, times, history)

    @cached_property
    def _kept(self) -> KeptState:
        """The state before the steps that are being taken."""
        return KeptState(self.memory(), self.elsewhere)

    @property
    def has_implicit_bending(self) -> bool:
        """See `PacedRun.has_implicit_bending`."""
        return any(run.has_implicit_bending for run in self._runs)

    def reject(self, time: float) -> bool:
        """See `PacedRun.reject`; joints that cannot be solved for end the run."""
        try:
            return super().reject(time)
        except RedundantConstraintError as error:
            self._unsolvable, self.gave_up = str(error), True
            return False

    def start_scheme(self, time: float) -> None:
        """See `PacedRun.start_scheme`."""
        if not self._has_axial_forces:
            self._begin_by(self.integrator.start, time)
            return
        scene = KeptState(self._scene.memory())
        cables = list(self._taught.values())
        accelerate_again(*self._system_at(time), self.state, self.control.present, cables)
        scene.restore()

    def watch_on(self, time: float) -> None:
        """See `PacedRun.watch_on`."""
        self.watch.go_on(time, self.state)

    def take(self, piece: Piece, history: Array) -> int:
        """See `PacedRun.take`; where Exudyn evaluates its items, all steps or none."""
        times = piece.times(self.integrator.stages)
        self._kept.keep()
        done = kept = 0
        while done < piece.steps:
            end = min(done + self.watch.steps_ahead, piece.steps)
            if not self._goes_well(piece, times[done:end], done, history):
                self.trouble = self.integrator.trouble(self.scheme, self.watch.watch.kept)
                with self.watch.finding_kept():
                    self._kept.restore()
                return kept
            done = end
            if self._form and done < piece.steps:
                self._kept.keep()
                kept = done
        if not self._form:
            for place, values in enumerate((self.state.q, self.state.v, self.state.a)):
                history[0, place] = values[: len(self.indices)]
        return piece.steps

    def _goes_well(self, piece: Piece, times: Array, done: int, history: Array) -> bool:
        """Take steps of a piece, of which some are done; returns whether all is well.

        times: (steps, stages) of their evaluations [s].
        """
        self._unsolvable, end = "", done + len(times)
        is_judged = not piece.is_whole and end == piece.steps
        try:
            if self._form:
                once, where = self.watch.has_one_evaluation, (done, history, piece.in_interval)
                steps = Steps(self.scheme, piece.h, times, once, *where)
                self._form.take(steps, self.state, self.watch.path, self.watch.before)
                self._scene.system.multipliers = self._form.multipliers
            else:
                self._take_steps(piece, times, done)
            self.watch.count(len(times))
            return self.watch.is_well_at(piece.time(end), piece.h, self.state, is_judged)
        except (DivergenceError, RedundantConstraintError, OffCableError) as error:
            self._unsolvable = "" if isinstance(error, DivergenceError) else str(error)
            self.watch.give_up(self.state)
            return False
        except Exception as error:  # Exudyn's, in place of that of a user function
            if "OverflowError" not in str(error):
                raise
            self.watch.give_up(self.state)
            return False

    def _take_steps(self, piece: Piece, times: Array, done: int) -> None:
        """Steps of a piece, of which some are done.   times: (steps, stages) of their evaluations [s]."""
        take_step = plain(advance.dispatch(type(self.scheme)))
        system, state, watch = self._scene.system, self.state, self.watch
        nothing, the_time = np.zeros(len(state.external)), np.eye(1, len(state.external))
        surroundings, last = self._scene.surroundings, done + len(times)
        surroundings.path, surroundings.settles = watch.path_of_evaluations, watch.has_one_evaluation
        try:
            for number, factors in enumerate(times[:, np.newaxis, :, np.newaxis], done + 1):
                if number == last:
                    watch.look(state)
                loads = LoadHistory(nothing, the_time, factors)
                take_step(self.scheme, system, loads, state, piece.h, 1, self._output)
                surroundings.finish_step(piece.time(number), state.q, state.v)
                for call in watch.after_each_step:
                    call()
        finally:
            surroundings.path, surroundings.settles = None, False

    @property
    def finding(self) -> str:  # type: ignore[override]
        """Whether friction contradicted Coulomb's law."""
        return self._scene.friction.finding

    @property
    def _place(self) -> str:
        """Where the last good state has its largest acceleration."""
        largest = int(np.argmax(np.abs(self.state.a[: len(self.indices)])))
        return f"its accelerations are largest at {self._scene.coordinate_name(self.indices[largest])}"

    def figures(self) -> dict[str, float]:
        """How well constraints and energy were kept."""
        return self.watch.figures()

    def verdict(self, time: float, h: float) -> str:
        """What went wrong in the last steps; see `CableRun.verdict`."""
        if not self.gave_up:
            return ""
        if self._unsolvable:
            return f"{self.name}: {self._unsolvable} If the motion before that is wrong, reduce stepSize."
        limit, scaled = self._limit_now(time), any(run.is_scaled for run in self._runs)
        said = explanation(self.integrator, self.trouble, self.control.present, limit, scaled)
        return f"{self.name}: {self.watch.found}; {self._place}; {self.control.said}. {said}"

    def _limit_now(self, time: float) -> float:
        """Stability limit [s] in the state of the last inspection; infinite if there is none."""
        rates = self._rates_at(time)
        if not rates.frequency > 0.0:
            return np.inf
        return (
            frequency_limit(self.integrator, self.scheme, rates.damping / rates.frequency) / rates.frequency
        )
