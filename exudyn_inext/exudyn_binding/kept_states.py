"""Some states of a run, kept so that it can be judged after its end: a step costs nothing."""

from functools import cached_property
from typing import Any

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
        self._most = 2 * min(KEPT, max(1, MOST_NUMBERS // (4 * len(run.indices))))
        self._every = 1  # intervals between two states
        self._blocks: list[tuple[Any, ...]] = []  # numbers of intervals, and what `all` returns
        self._number = 0

    def __len__(self) -> int:
        return self._number

    def keep(self, grid: TimeGrid, first: int, history: Array) -> None:
        """Of the intervals of the loop from number `first` on.   history: (intervals, 3, n), see `record`."""
        while self._number + len(history) // self._every > self._most:
            self._leave_out_half()
        offset = -first % self._every
        if offset < len(history):
            rows = np.arange(offset, len(history), self._every)
            steps = self.run.steps_before(len(history))[rows]
            self._blocks.append((first + rows, grid.times(first + rows + 1), steps, history[rows, :2]))
            self._number += len(rows)

    def _leave_out_half(self) -> None:
        self._every *= 2
        kept = [block[0] % self._every == 0 for block in self._blocks]
        self._blocks = [
            tuple(part[some] for part in block)
            for some, block in zip(kept, self._blocks, strict=True)
            if some.any()
        ]
        self._number = sum(map(np.count_nonzero, kept))

    @cached_property
    def all(self) -> tuple[Array, Array, Array]:
        """Of a run that is over: times (k,), steps before them (k,) [s], places and velocities (k, 2, n)."""
        _, times, steps, states = map(np.concatenate, zip(*self._blocks, strict=True))
        return times, steps, states

    def nodes(self, cable: int, displacements: Array) -> Array:
        """(T, n, 2, dim) positions and slopes of one of the cables.   displacements: (T, n) of all."""
        dofs, shape = self.run.places_of_cables[cable]
        return (displacements[:, dofs] + self.run.reference[dofs]).reshape(-1, *shape)
