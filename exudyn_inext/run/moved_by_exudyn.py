"""A coupled scene that Python moves, with forces, and what has no compiled form, from Exudyn."""

from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import starmap
from typing import Any

import numpy as np

from ..arrays import Array
from ..compiled import plain
from ..integrators.integrator import Integrator, LoadHistory, advance
from ..integrators.rattle import Rattle
from .cable_run import CableRun
from .compiled_scene import ChangedItem
from .consistent_start import StartCorrection
from .coupled_start import consistent_start
from .coupled_watch import CoupledWatch
from .mover import FULFILLED, Mover
from .paced_run import PacedRun
from .ramp import Line
from .step_control import Piece
from .time_grid import TimeGrid


class MovedByExudyn(Mover):
    """See `Mover`; mbs follows each step.

    looks_ahead: whether many steps are one call.   is_steady: see `CableRun.is_steady`.
    evaluated: the scene, by whom evaluates it.
    data, remembered: see `PacedRun`.
    """

    looks_ahead = is_steady = False
    data = PacedRun.data
    _data: Array = np.zeros((0, 0))  # (intervals, D) of contacts, after the intervals of a record
    _recorded = 0  # of them

    def __init__(
        self, scene: Any, runs: Sequence[CableRun], state: Any, method: tuple[Integrator, Any]
    ) -> None:
        super().__init__(scene, runs, state, method)
        self.evaluated, self.elsewhere, self.given = scene, scene.remembered, scene.native_items.given
        self._output = np.zeros((1, 3, scene.size))
        number = len(state.external)
        self._loads = LoadHistory(np.zeros(number), np.eye(1, number), np.zeros((1, 1, 1)))
        self._advance = plain(advance.dispatch(type(self._scheme)))

    @property
    def system(self) -> Any:
        return self._scene.system

    def external_at(self, time: float) -> Array:
        return np.array([time])

    def correct_start(self, time: float, tolerance: float) -> StartCorrection:
        """Move the state onto the joints.   tolerance: see `ExplicitSettings.startTolerance`."""
        state = time, self._state.q, self._state.v
        return consistent_start(self._scene.system, self.cables, *state, tolerance)

    def compile_steps(self, time: float) -> None:
        """Compile what takes steps from the present state on, at `time` [s], as far as there is any."""
        if not self.approaches:
            self._scene.compile_parts(time, self._state.q, self._state.v)

    def approach_joints(self, time: float, end: float) -> bool:
        """Let violated joints be fulfilled at `end` [s]; returns whether all of them can be moved."""
        self._scene.native_items.approach_joints(time, end, self._state.q, FULFILLED)
        if self.approaches and self._scene.parts_in_one:
            self._scene.leave_compiled_parts()
        return True

    def has_jumped(self, time: float) -> bool:
        """Whether functions of the user have moved joints at once, before the step from `time` [s]."""
        if not self._scene.has_steered_joints:
            return False
        return (
            float(np.abs(self._scene.native_items.present_violations(time, self._state.q)).max()) > self.jump
        )

    @property
    def asks_ahead(self) -> bool:
        """See `PacedRun`; first order states are in mbs alone."""
        return not (self._scene.mbs.systemData.ODE1Size() or self.approaches)

    @property
    def approaches(self) -> bool:
        return self._scene.native_items.approach.moves

    def rest(self) -> None:
        """Joints that have been moved stay where they are."""
        self._scene.native_items.approach.rest()

    @property
    def numbers(self) -> "MovedByExudyn":
        """What says which items may be changed between steps, see `KnownNumbers`: here, itself."""
        return self

    def can_move(self, number: int) -> bool:
        """See `KnownNumbers`: here, of any joint."""
        return True

    def has_same_entries(self, number: int) -> bool:
        """See `KnownNumbers`: here, nothing depends on that."""
        return True

    def joints_to_move(self, markers: Collection[int], objects: Collection[int]) -> None:
        """See `KnownNumbers`: nobody knows."""

    def moves_springs_alone(self, markers: Collection[int], objects: Collection[int]) -> bool:
        """See `KnownNumbers`."""
        joints = (joint.number for joint in self._scene.joints)
        return not self._scene.mbs.NumberOfGeneralContacts() and set(objects).isdisjoint(joints)

    @property
    def follows_contacts(self) -> bool:
        """Whether contact or friction may change the limit of the step as nobody knows before."""
        return self._scene.native_items.remembers

    @property
    def depths_of_contacts(self) -> Array | None:
        """Of these, see `NativeItems`."""
        return self._scene.native_items.depths_of_contacts

    def can_weigh(self, item: ChangedItem) -> bool:
        parts = self._scene.parts_in_one
        return parts.form.numbers.can_weigh(item) if parts else self._scene.can_weigh(item)

    def take_values(self, changed: Mapping[Any, Any], line: Line | None = None) -> bool:
        """Whether loads, springs and masses that were changed act now; otherwise some may.

        changed: parameters, with their values.
        line: along which loads and springs change in the next step of the loop; None: they jump.
        """
        parts, masses = self._scene.parts_in_one, [it for it in changed.items() if self.can_weigh(it[0])]
        if masses and not parts:
            self._scene.read_masses_again()
        self._scene.native_items.ramped.begin(changed, line)
        return not parts or all(starmap(parts.form.take_over, masses))

    def take_constants(self) -> None:
        if parts := self._scene.parts_in_one:
            parts.form.loads.take_constants()
        super().take_constants()

    @property
    def ramp(self) -> dict[str, list[Any]]:
        return dict(self._scene.native_items.ramped.kept)

    def take_ramp(self, kept: Mapping[str, Any]) -> None:
        self._scene.native_items.ramped.take(kept)

    def require_same_items(self, time: float) -> None:
        """Raise SceneError if Exudyn's items are not those that have moved the scene."""
        self._scene.require_agreement(None, time, self._state.q, self._state.v)

    def _settled_data(self, time: float) -> Array:
        native_items = self._scene.native_items
        native_items.finish_step(time, self._state.q, self._state.v)
        self._scene.friction.begin()
        return np.tile(native_items.remembered, (2, 1))

    def look(self, time: float) -> None:
        """Evaluate what the next step needs to know of a state that has been set."""
        self._scene.native_items.look(time, self._state.q, self._state.v)

    @property
    def remembered(self) -> Array | None:
        return self._data[: self._recorded] if self._data.size else None

    def begin_record(self, intervals: int) -> None:
        """So many intervals of the time loop are about to be taken."""
        self._put_settled()
        self._data = np.zeros((intervals, self._scene.mbs.systemData.DataSize()))

    def end_record(self, grid: TimeGrid, first: int, history: Array) -> None:
        """These intervals from number `first` on went well: mbs is left in the state at their end."""
        native_items, system = self._scene.native_items, self._scene.system
        self._recorded = len(history)
        if len(history):
            multipliers = native_items.all_multipliers(system.multipliers, self._state.a)
            native_items.show(grid.time(first + len(history)), self._state, multipliers)

    def take(self, piece: Piece, times: Array, done: int, history: Array, watch: CoupledWatch) -> None:
        """Take steps of a piece, of which some are done; `watch` counts their work.

        times: (steps, stages) of their evaluations [s].   history: see `PacedRun.take`.
        """
        state, take_step = self._state, self._step
        native_items, last = self._scene.native_items, done + len(times)
        native_items.path, native_items.settles = watch.path_of_evaluations, watch.has_one_evaluation
        try:
            for number, stages in enumerate(times.tolist(), done + 1):
                if number == last:
                    watch.look(state)
                take_step(stages, piece.h)
                native_items.finish_step(stages[-1], state.q, state.v)
                if number % piece.in_interval == 0:
                    interval = number // piece.in_interval - 1
                    row = history[interval]
                    if self._data.size:
                        self._data[len(self._data) - len(history) + interval] = native_items.remembered
                    for place, values in enumerate((state.q, state.v, state.a)):
                        row[place] = values[: row.shape[1]]
                for call in watch.after_each_step:
                    call()
        finally:
            native_items.path, native_items.settles = None, False
            native_items.ramped.finish()

    @property
    def _step(self) -> Callable[[Sequence[float], float], None]:
        """Takes a step of h [s], evaluated at the times `stages` [s]."""
        parts, native_items = self._scene.parts_in_one, self._scene.native_items
        if not parts or not isinstance(self._scheme, Rattle):
            return self._by_scheme
        return lambda stages, h: parts.take_step(native_items, stages[0], h, self._scheme, self._state)

    def _by_scheme(self, stages: Sequence[float], h: float) -> None:
        loads = self._loads._replace(factor=np.reshape(stages, (1, -1, 1)))
        self._advance(self._scheme, self._scene.system, loads, self._state, h, 1, self._output)

    def complete(self, *_: Any) -> bool:
        """See `CableRun.complete`."""
        return False
