"""A coupled scene that compiled kernels move: many steps in one call, of which mbs knows nothing."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

import numpy as np

from ..arrays import Array, Places
from ..called_system import kernel_behind
from ..compiled import Prepared, kernel
from ..errors import SceneError
from ..integrators.integrator import Integrator
from ..multibody.connectors import places_of_rubbing
from ..multibody.general_contacts import rate_of_drag
from ..multibody.implicit_contacts import contact_rates, fastest_rubbing_contact
from .cable_run import CableRun
from .compiled_scene import CompiledScene
from .consistent_start import StartCorrection
from .coupled_start import compiled_start, consistent_start
from .coupled_watch import CoupledWatch
from .mover import FULFILLED, Mover
from .ramp import Line
from .redundancy import held_straight
from .settings import SAY_OF_TIME
from .step_control import Piece
from .time_grid import TimeGrid


class MovedByKernels(Mover):
    """See `Mover`, and `MovedByExudyn` for what the methods do.

    form: the scene in compiled code.
    looks_ahead: whether no load or spring asks a function that may look at mbs, which is brought to where
        these are evaluated, at the end of a step, by the accelerations before it; and no function of a joint
        is steered.
    """

    def __init__(
        self,
        form: CompiledScene,
        scene: Any,
        runs: Sequence[CableRun],
        state: Any,
        method: tuple[Integrator, Any],
    ) -> None:
        super().__init__(scene, runs, state, method)
        self._form = self.evaluated = form
        of_state = form.loads.of_state
        self.looks_ahead = not (form.steered or (of_state and of_state.look_at_mbs))
        if of_state:
            self.asks = of_state.name
        elif form.steered:
            self.asks = f"the function of {form.steered}, which reads what step functions may change"
        self.given, self.data = form.given, form.data
        self.takes_impulses = not (self._integrator.stabilised or form.loads.vary_on_cables)
        if self._may_damp:
            bodies = form.system.items.bodies
            self.implicit_contacts = contact_rates(form.contacts.records)
            self.fastest_rubbing_contact = fastest_rubbing_contact(form.contacts, bodies)
        self._foreseen = state.q.copy(), state.v.copy()  # at the end of a step
        self._beginnings: dict[Callable[..., None], Prepared] = {}
        self._end_of_step = 0.0  # until which joints are moved [s]
        self._recorded = 0  # intervals
        self._first_data = self.data[0]  # of them
        self._is_alone = False  # mbs does not follow it
        self._slides = scene.native_items.has_sliding_joints
        self._remembers = form.remembers
        self._data_of_intervals = np.zeros((0, 0))  # with places of what slides

    @property
    def system(self) -> Any:
        return self._form.system

    @property
    def quick_system(self) -> CompiledScene:
        return self._form

    def begin_by(self, function: Callable[..., None], time: float) -> None:
        """By a kernel, if it is one, that integrators of lone cables use as well."""
        behind, again = kernel_behind(function), function is self._integrator.resume
        if behind is function:
            super().begin_by(function, time)
        else:
            begin = self._beginnings.setdefault(function, Prepared(behind))
            with self._as_before() if again else nullcontext():
                begin(self._form.called, self.external_at(time), self._state)
        if not again:
            self._form.foresee_joints()

    @contextmanager
    def _as_before(self) -> Iterator[None]:
        """Contact in the cables' matrices, and springs with functions, stay as they are or were read."""
        with self._form.pressed_as_before(), self._form.loads.springs.held():
            yield

    def external_at(self, time: float) -> Array:
        loads = self._form.loads
        return loads.follow(loads.at(time), self._state.q, self._state.v)

    def loads_kept(self, time: float) -> AbstractContextManager[None]:
        return self._form.loads.kept_at(time)

    @property
    def followed_system(self) -> Any:
        return self._form if self._form.loads.of_state else self.system

    def correct_start(self, time: float, tolerance: float) -> StartCorrection:
        """By Exudyn where straight cables may hide that joints depend on each other, or knots that yield."""
        given = time, self._state.q, self._state.v, tolerance
        if self.approaches:
            self._form.approach_joints(time, self._end_of_step, self._state.q, FULFILLED)
        scene, q = self._scene, self._state.q
        hides_dependence = bool(held_straight(scene, q))
        found = None if hides_dependence else compiled_start(self._form, *given)
        if found is None:
            if self.approaches:  # Exudyn knows nothing of that
                scene.native_items.approach_joints(time, self._end_of_step, q, FULFILLED)
            found = consistent_start(scene.system, self.cables, *given)
        scene.native_items.approach.rest()
        return found

    def compile_steps(self, time: float) -> None:
        self._form.provide(self._integrator.calls)

    @property
    def _may_damp(self) -> bool:
        """Whether the integrator hands on the accelerations that implicit damping needs."""
        return self._integrator.has_implicit_damping and not self._integrator.stabilised

    def set_step(self, h: float) -> None:
        super().set_step(h)
        if self._may_damp:
            self._form.set_step(h)

    def implicit_damping_left_out(self, time: float) -> AbstractContextManager[None]:
        if not self._may_damp:
            return super().implicit_damping_left_out(time)
        if self.damps_implicitly:
            self._form.stretch_springs(time, self._state.q, self._state.v)
        return self._form.explicit_damping(0.0)

    @property
    def has_springs(self) -> bool:  # type: ignore[override]
        return self._may_damp and len(self.system.items.connectors) > 0

    def springs_left_out(self, time: float) -> AbstractContextManager[None]:
        self._form.stretch_springs(time, self._state.q, self._state.v)
        return self._form.springs_left_out()

    @property
    def damps_implicitly(self) -> bool:
        return self._form.damps_implicitly

    def damp_implicitly(self, limit: float) -> bool:
        if not self._may_damp or self.damps_implicitly or not self._form.damp_implicitly(limit):
            return False
        number = len(self._form.multipliers)
        self._scene.system.drift_correction = self.system.items.joints.drift_correction[:number]
        return True

    @property
    def follows_contacts(self) -> bool:
        """What other contacts may do is known at the start, see `LimitedRun.contacts`."""
        return self._remembers and len(places_of_rubbing(self._form.system.items.connectors)) > 0

    @property
    def rate_of_drag(self) -> float:  # type: ignore[override]
        return rate_of_drag(self._form.contacts, self.system.items.bodies)

    @property
    def depths_of_contacts(self) -> Array:
        places, depths = places_of_rubbing(self._form.system.items.connectors), np.zeros_like(self.data)
        depths[0, places] = np.sign(self.data[0, places])
        return depths

    @property
    def places(self) -> dict[str, Array]:
        return self._form.places

    @property
    def contacts(self) -> dict[str, Array]:
        return {"data": self.data, **self._form.pressed}

    def approach_joints(self, time: float, end: float) -> bool:
        self._end_of_step = end
        return self._form.approach_joints(time, end, self._state.q, FULFILLED)

    @property
    def approaches(self) -> bool:
        return self._form.approaches

    def has_jumped(self, time: float) -> bool:
        return bool(self._form.steered) and self._form.steered_violation(time, self._state.q) > self.jump

    def rest(self) -> None:
        self._scene.native_items.approach.rest()
        self._form.rest()

    @property
    def numbers(self) -> Any:
        return self._form.numbers

    def take_values(self, changed: Mapping[Any, Any], line: Line | None = None) -> bool:
        return self._form.take_values(changed, line)

    @property
    def ramp(self) -> dict[str, list[Any]]:
        return self._form.ramp

    def take_ramp(self, kept: Mapping[str, Any]) -> None:
        self._form.take_ramp(kept)

    def take_constants(self) -> None:
        self._form.loads.take_constants()
        super().take_constants()

    def require_same_items(self, time: float) -> None:
        self._form.rest()
        with self._form.explicit_damping():
            self._scene.require_agreement(self._form, time, self._state.q, self._state.v)

    def leave_mbs(self, who: str) -> None:
        """Do without mbs from now on.   who: asks, for messages.

        Raises:
            SceneError: joints slide along cables or are steered, or functions of the state may look at mbs.
        """
        if self._form.steered:
            raise SceneError(f"{who} cannot ask {self.asks}: use SolveExplicit, or {SAY_OF_TIME}.")
        of_state = self._form.loads.of_state
        if of_state and of_state.look_at_mbs:
            raise SceneError(f"{who} cannot ask {of_state.name}: use SolveExplicit, or leave it out.")
        if self._slides:
            raise SceneError(
                f"{who} does not say where joints are that slide along cables: use SolveExplicit, or leave "
                "these out."
            )
        self._is_alone = True
        if self._remembers:
            self._form.begin_history(self.data[0], 1)

    def _settled_data(self, time: float) -> Array:
        if self._remembers:
            self._form.settle(time, self._state.q, self._state.v)
            self.data[1] = self.data[0]
        return self.data.copy()

    def look(self, time: float) -> None:
        pass

    def begin_record(self, intervals: int) -> None:
        if self._remembers:
            if not self._is_alone:
                self._put_settled()
            remembered = self._scene.native_items.remembered
            self._first_data = self.data[0].copy() if self._is_alone else remembered
            self._form.begin_history(self._first_data, intervals)

    def end_record(self, grid: TimeGrid, first: int, history: Array) -> None:
        self._recorded = len(history)
        if self._slides:
            native_items, data = self._scene.native_items, self._of_contacts
            if data is None:
                data = np.tile(native_items.remembered, (len(history), 1))
            times = [grid.time(first + 1 + k) for k in range(len(history))]
            self._data_of_intervals = native_items.places_in(data, times, history)

    def take(self, piece: Piece, times: Array, done: int, history: Array, watch: CoupledWatch) -> None:
        of_state, state = self._form.loads.of_state, self._state
        at_once = 1 if of_state else len(times)
        for first in range(0, len(times), at_once):
            own = times[first : first + at_once]
            if of_state:
                q, v = self._foreseen
                _foresee(piece.h, state.q, state.v, state.a, q, v)
                of_state.look(q, v, float(own[0, -1]))
            self._form.take(self._scheme, piece, own, done + first, history, state, watch)
        self._scene.system.multipliers = self._form.multipliers

    @property
    def is_steady(self) -> bool:
        """See `CableRun.is_steady`; what contacts and sliding joints remember is in mbs, too."""
        return self.remembered is None and self._form.loads.are_steady

    @property
    def asks_ahead(self) -> bool:
        """See `PacedRun`."""
        return self.remembered is None and not self.approaches

    @property
    def remembered(self) -> Array | None:
        return self._data_of_intervals if self._slides else self._of_contacts

    @property
    def _of_contacts(self) -> Array | None:
        """(k, D) data of compiled contacts after the intervals of the last record."""
        return self._form.history[: self._recorded] if self._remembers else None

    def complete(
        self,
        times: Array,
        rows: Places,
        steps: Array,
        history: Array,
        multipliers: Array,
        of_supports: bool,
    ) -> bool:
        """See `CableRun.complete`.   steps: (k,) before the states [s]."""
        of_record = self._of_contacts if self._recorded else None
        contacts = None if of_record is None else of_record[rows]
        q, reference = history[:, 0], self._scene.map.reference
        np.add(q, reference, out=q)
        of_joints, forces = self._form.evaluate(self.cables, times, steps, history, contacts)
        for k, state in enumerate(zip(of_joints, times.tolist(), q, strict=True)):
            multipliers[k] = self._scene.native_items.multipliers(*state)
        if of_supports:
            self.put_reactions(times, steps, q, history[:, 1], forces, multipliers)
        else:
            self._joined = times.tolist(), forces
        np.subtract(q, reference, out=q)
        return True

    def set_accelerations(self, times: Array, steps: Array, history: Array) -> None:
        """As `complete`, of the beginning and all intervals of the last record, without multipliers."""
        data = None if self._of_contacts is None else np.vstack([self._first_data, self._of_contacts])
        history[:, 0] += self._scene.map.reference
        self._form.evaluate(self.cables, times, steps, history, data)
        history[:, 0] -= self._scene.map.reference


@kernel
def _foresee(h, q, v, a, end_q, end_v):
    """The end of a step of h [s] with constant accelerations.   end_q, end_v: (n,) overwritten."""
    for i in range(len(q)):
        end_q[i] = q[i] + h * (v[i] + 0.5 * h * a[i])
        end_v[i] = v[i] + h * a[i]
