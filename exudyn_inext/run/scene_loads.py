"""What acts on a scene of which all items have compiled forms: constants, and functions of time."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from ..arrays import Array
from ..integrators.integrator import NO_WORK, LoadHistory
from ..multibody.build import FunctionOfTime
from .cable_loads import CableLoads
from .jump_ahead import JumpSight
from .load_functions import LoadFunctions, StateFunctions
from .moved_offsets import MovedOffsets
from .ramp import Ramp
from .spring_functions import SpringFunctions


class SceneLoads:
    """What acts on the cables of a scene, with functions of time behind it; see `CableLoads`.

    functions: of joints.   moved: offsets of joints that are set between steps.
    of_loads: functions of loads on bodies and cables. Each has three values.
    follows: whether numbers of springs and loads may change along a line; what is missing comes last.
    """

    def __init__(
        self,
        loads: Sequence[CableLoads],
        functions: Sequence[FunctionOfTime],
        moved: MovedOffsets,
        of_loads: LoadFunctions,
        follows: bool = False,
    ) -> None:
        self.ramp = Ramp() if follows else None
        self._of_cables = loads
        self._loads = [of_cable for of_cable in loads if len(of_cable.pattern)]
        self._functions, self._moved, self._of_loads = functions, moved, of_loads
        number = len(functions) + len(moved.joints) + len(of_loads.numbers)
        self._is_given = (np.arange(3) < of_loads.numbers[:, np.newaxis]).ravel()
        self._has_all = bool(len(self._is_given) and self._is_given.all())
        parts = [of_cable.constant for of_cable in loads]
        self.constant: Array = np.concatenate([*parts, np.zeros(3 * number + follows)])
        rows = sum(len(of_cable.pattern) for of_cable in loads) + 3 * number + follows
        self.pattern = np.zeros((rows, len(self.constant)))
        row = column = 0
        for of_cable in loads:
            rows, columns = of_cable.pattern.shape
            self.pattern[row : row + rows, column : column + columns] = of_cable.pattern
            row, column = row + rows, column + columns
        np.fill_diagonal(self.pattern[row:, column:], 1.0)
        self._on_cables = slice(row), slice(column)  # of the pattern; each factor after it is an input
        least = max((of_cable.sight.least for of_cable in loads), default=0.0)
        self._sight = JumpSight(self._columns_of_places(row), least, self.factors)
        self.of_state = of_loads if isinstance(of_loads, StateFunctions) else None
        self.springs = self.of_state.springs if self.of_state else SpringFunctions({})
        self.vary_on_cables = bool(self._loads)
        end = len(self.constant) - follows
        self._last = slice(end - len(self._is_given), end)
        self._only_moves = 3 * len(moved.joints) + follows == len(self.pattern)
        self._kept: tuple[float, Array] | None = None  # time [s], and what `at` says then

    @contextmanager
    def kept_at(self, time: float) -> Iterator[None]:
        """Nothing that acts at `time` [s] changes meanwhile: `at` finds it once."""
        self._kept = None if self.of_state else (time, self.at(time))
        try:
            yield
        finally:
            self._kept = None

    def take_constants(self) -> None:
        """Constant loads on cables, which have been changed."""
        constants = [of_cable.constant for of_cable in self._of_cables]
        self.constant[: sum(map(len, constants))] = np.concatenate(constants)

    def follow(self, external: Array, q: Array, v: Array) -> Array:
        """`external`, with the functions that depend on the state as they are at (q, v)."""
        if self.of_state is None:
            return external
        followed = external.copy()
        followed[self._last][self._is_given] = self.of_state.look(q, v)
        return followed

    def at(self, t: float) -> Array:
        """(n_external,) at t [s]; not to be written to."""
        if self._kept and self._kept[0] == t:
            return self._kept[1]
        external = self.constant.copy()
        if not len(self.pattern):
            return external
        if self._only_moves:
            external[self._on_cables[1].stop : self._last.stop] = self._moved.values([t])
            if self.ramp:
                external[-1] = self.ramp.share(t)
        else:
            (rows, columns), factors = self._on_cables, self.factors([t])[0]
            if rows.stop:
                external[columns] += factors[rows] @ self.pattern[rows, columns]
            external[columns.stop :] = factors[rows.stop :]
        return external

    @property
    def are_steady(self) -> bool:
        """Whether nothing depends on the time, as long as no offset is set."""
        return self._only_moves and not self._moved.moves

    def factors(self, times: list[float]) -> Array:
        """(T, P) of all that depends on the time."""
        columns = [loads.factors(times) for loads in self._loads]
        if self._functions or self._moved.joints:
            columns.append(self._of_joints(times))
        if self._has_all:
            columns.append(self._of_loads.values(times))
        elif len(self._is_given):
            of_loads = np.zeros((len(times), len(self._is_given)))
            of_loads[:, self._is_given] = self._of_loads.values(times)
            columns.append(of_loads)
        if self.ramp:
            columns.append(self.ramp.missing(times)[:, np.newaxis])
        return np.concatenate(columns, axis=1) if len(columns) != 1 else columns[0]

    def _of_joints(self, times: list[float]) -> Array:
        values = self._moved.values(times)
        if not self._functions:
            return values
        return np.concatenate([*(function(times) for function in self._functions), values], axis=1)

    def of_joints(self, t: float) -> Array:
        """(F,) values of the functions of joints at t [s]."""
        return self._of_joints([t])[0]

    def forget(self) -> None:
        """Step functions have been called: what functions of joints read may be something else."""
        for sampled in self._moved.steered:
            sampled.forget()
        self._sight.forget()

    def _columns_of_places(self, first: int) -> tuple[list[int], list[int]]:
        """See `CableLoads`; of joints too.   first: column of these."""
        places, rates, column = list[int](), list[int](), 0
        for of_cable in self._loads:
            places += (column + of_cable.sight.places).tolist()
            rates += (column + of_cable.sight.rates).tolist()
            column += len(of_cable.pattern)
        joints = range(first, first + 3 * len(self._functions), 3)
        return [*places, *joints], [*rates, *(place + 1 for place in joints)]

    def sample(self, times: Array, since: float | None = None) -> LoadHistory:
        """History of steps.

        Args:
            times: (steps, stages) [s].   since: their start, from which on jumps are looked for [s].

        Raises:
            JumpError: a support or joint jumps in these steps.
        """
        shape = (*times.shape, len(self.pattern))
        if self.are_steady and not (self.ramp and times[0, 0] < self.ramp.end):
            return LoadHistory(self.constant, self.pattern, np.zeros(shape), NO_WORK)
        sampled = times.ravel().tolist()
        found = self.factors(sampled) if since is None else self._sight.look(since, sampled)
        factors = np.array(found, order="C")  # of one type
        return LoadHistory(self.constant, self.pattern, factors.reshape(shape), NO_WORK)
