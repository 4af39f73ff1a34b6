"""Some states of a run, kept so that it can be judged after its end: a step costs nothing."""

import numpy as np

from ..arrays import Array
from ..run.coupled_run import Run
from ..run.time_grid import TimeGrid

KEPT = 128  # states of a run, at least, if it has as many outputs
MOST_NUMBERS = 4_000_000  # in them; of a large net, fewer states are kept


class KeptStates:
    """Of a run, at the ends of some intervals of the loop.

    start: (n,) displacements before the first one [m].
    begins_unstretched: whether native cables would not be stretched there.
    """

    def __init__(self, run: Run, begins_unstretched: bool = False) -> None:
        self.run = run
        self.start = run.state.q[: len(run.indices)] - run.reference
        self.begins_unstretched = begins_unstretched
        size = len(run.indices)
        self._most = 2 * min(KEPT, max(1, MOST_NUMBERS // (4 * size)))
        self._every = 1  # intervals between two states
        self._number = 0
        self._intervals = np.zeros(self._most + 1, np.int64)  # before the states
        self._times, self._steps = np.zeros((2, self._most + 1))
        self._states = np.empty((self._most + 1, 2, size))
        self._changed = -np.inf  # when what acts did so last [s]
        self._last: tuple[float, Array] = (0.0, np.zeros((0, 2, size)))

    def __len__(self) -> int:
        return self._number

    def keep(self, grid: TimeGrid, first: int, history: Array) -> None:
        """Of the intervals of the loop from number `first` on.   history: (intervals, 3, n), see `record`."""
        while self._number + len(history) // self._every > self._most:
            self._leave_out_half()
        if len(history):
            self._last = grid.time(first + len(history)), history[-1:, :2].copy()
        offset = -first % self._every
        if offset >= len(history):
            return
        found = history[offset :: self._every, :2]
        own = slice(self._number, self._number + len(found))
        self._intervals[own] = range(first + offset, first + len(history), self._every)
        self._times[own] = grid.times(self._intervals[own] + 1)
        self._steps[own] = self.run.steps_before(len(history))[offset :: self._every]
        self._states[own] = found
        self._number = own.stop

    def change_forces(self, time: float) -> None:
        """What acts on the run changes at this time [s], and states that were computed beyond it are void."""
        self._changed = time
        while self._number and self._times[self._number - 1] > time:
            self._number -= 1

    def _leave_out_half(self) -> None:
        self._every *= 2
        rows = np.flatnonzero(self._intervals[: self._number] % self._every == 0)
        self._number = len(rows)
        for memory in (self._intervals, self._times, self._steps, self._states):
            memory[: len(rows)] = memory[rows]

    @property
    def all(self) -> tuple[Array, Array, Array]:
        """Of a run that is over: times (k,), steps before them (k,) [s], places and velocities (k, 2, n)."""
        number = self._number
        return self._times[:number], self._steps[:number], self._states[:number]

    @property
    def under_present_forces(self) -> tuple[Array, Array, Array]:
        """`all` since what acts has changed, at least the last state: forces in others are not known."""
        since = int(np.searchsorted(self._times[: self._number], self._changed, "right"))
        if since < self._number:
            times, steps, states = self.all
            return times[since:], steps[since:], states[since:]
        time, states = self._last
        return np.full(len(states), time), self.run.steps_before(1), states

    def nodes(self, cable: int, displacements: Array) -> Array:
        """(T, n, 2, dim) positions and slopes of one of the cables.   displacements: (T, n) of all."""
        dofs, shape = self.run.places_of_cables[cable]
        return (displacements[:, dofs] + self.run.reference[dofs]).reshape(-1, *shape)
