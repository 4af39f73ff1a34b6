"""Velocities and accelerations after forces, or velocities of joints, have jumped between two steps."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, kernel
from ..system import accelerate_and_project, report_energy
from .kept_state import KeptState
from .watch import Watch, count_impulses

_AXIAL = {"axial nodes": "nodes", "axial elements": "elements"}


@kernel
def _take_impulses(system, external, state, lag, memory):
    """See `Jumps`.   lag: for which accelerations act before the state [s].   memory: (2, n) zeros."""
    before, after = memory[0], memory[1]
    accelerate_and_project(system, external, state.q, state.v, 0.0, before, after)
    for i in range(len(state.v)):
        state.v[i] = after[i]
        before[i] = after[i] - lag * state.a[i]
    accelerate_and_project(system, external, state.q, before, lag, state.a, after)


@kernel
def _count_impulses(system, external, state, watch):
    report_energy(system, external, state.q, state.v, state.a, watch.force, watch.present_report)
    count_impulses(watch, state)


class Jumps:
    """How a run goes on where something jumps.

    Axial forces of cables that stretch are means of steps, see `cable.axial`. Those of the present strains
    alone are no measure: axial waves that the step does not resolve change their sign from step to step. So
    accelerations are found as at the end of the step before; drift corrections stay what they were.

    Args:
        cables: drift corrections and axial forces of each, see `cable.linked_cable.memory_of`.
        learned: these, and what else evaluations learn.
    """

    def __init__(self, cables: Mapping[str, Any], learned: Mapping[str, Any]) -> None:
        self._cables, self._learned = cables.values(), KeptState(learned)
        self._take, self._count = Prepared(_take_impulses), Prepared(_count_impulses)

    @property
    def keep_means(self) -> bool:
        """Whether steps have left mean axial forces."""
        found = (memory[name][:, 0] for memory in self._cables for name in _AXIAL if name in memory)
        return any(map(np.count_nonzero, found))  # faster than any()

    @contextmanager
    def _in_last_step(self) -> Iterator[None]:
        self._learned.keep()
        for memory in self._cables:
            for name, records in _AXIAL.items():
                if name in memory:
                    memory[name][:, 1] = memory[records]  # what is foreseen has been found already
        yield
        self._learned.restore()

    def accelerate(self, system: Any, external: Array, state: Any, h: float) -> None:
        """Set state.a with other forces, if steps have left means.

        system, external, state: see `integrators.rattle`.   h: of the next step [s].
        """
        with self._in_last_step():
            before = state.v - 0.5 * h * state.a
            rest = np.zeros_like(before)
            accelerate_and_project(system, external, state.q, before, 0.5 * h, state.a, rest)

    def take_impulses(self, system: Any, external: Array, state: Any, h: float, watch: Watch) -> None:
        """Let joints and supports have other velocities at once, by impulses, whose work is counted.

        system, external, state, h: see `accelerate`; a system called by address.
        watch: whose account was drawn up in this state.
        """
        with self._in_last_step():
            lag = 0.5 * h if self.keep_means else 0.0
            self._take(system, external, state, lag, np.zeros((2, len(state.q))))
        self._count(system, external, state, watch)
