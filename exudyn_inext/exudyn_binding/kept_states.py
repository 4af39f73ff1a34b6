"""Some states of a run, kept so that it can be judged after its end: a step costs nothing."""

from ..arrays import Array
from ..run.coupled_run import Run
from ..run.time_grid import TimeGrid

KEPT = 128  # states of a run, at least, if it has as many outputs
MOST_NUMBERS = 4_000_000  # in them; of a large net, fewer states are kept


class KeptStates:
    """Of a run.

    start: (n,) displacements before the first interval of the loop [m].
    begins_unstretched: whether native cables would not be stretched there.
    states: time [s], step before it [s] and (2, n), by intervals of the loop.
    """

    def __init__(self, run: Run, begins_unstretched: bool = False) -> None:
        self.run = run
        self.start = run.state.q[: len(run.indices)] - run.reference
        self.begins_unstretched = begins_unstretched
        self.states: dict[int, tuple[float, float, Array]] = {}
        self._every = 1  # intervals between two states
        self._kept = min(KEPT, max(1, MOST_NUMBERS // (4 * len(run.indices))))

    def keep(self, grid: TimeGrid, first: int, history: Array) -> None:
        """Of the intervals of the loop from number `first` on.   history: (intervals, 3, n), see `record`."""
        while len(self.states) + len(history) // self._every > 2 * self._kept:
            self._every *= 2
            self.states = {k: kept for k, kept in self.states.items() if k % self._every == 0}
        numbers = range(first + -first % self._every, first + len(history), self._every)
        steps = self.run.steps_before(len(history)) if numbers else ()
        for number in numbers:
            row = number - first
            self.states[number] = grid.time(number + 1), float(steps[row]), history[row, :2].copy()
