"""Some states of a run, kept so that it can be judged after its end: a step costs nothing."""

from ..arrays import Array
from ..run.coupled_run import Run
from ..run.time_grid import TimeGrid

KEPT = 128  # states of a run, at least, if it has as many outputs


class KeptStates:
    """Of a run.   states: time [s], step before it [s] and (2, n), by intervals of the loop."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.states: dict[int, tuple[float, float, Array]] = {}
        self._every = 1  # intervals between two states

    def keep(self, grid: TimeGrid, first: int, history: Array) -> None:
        """Of the intervals of the loop from number `first` on.   history: (intervals, 3, n), see `record`."""
        while len(self.states) + len(history) // self._every > 2 * KEPT:
            self._every *= 2
            self.states = {k: kept for k, kept in self.states.items() if k % self._every == 0}
        steps = self.run.steps_before(len(history))
        for number in range(first + -first % self._every, first + len(history), self._every):
            row = number - first
            self.states[number] = grid.time(number + 1), float(steps[row]), history[row, :2].copy()
