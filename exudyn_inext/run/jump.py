"""Velocities and accelerations after forces, or velocities of joints, have jumped between two steps."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from typing import Any

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, kernel
from ..system import accelerate_and_project, report_energy
from .kept_state import KeptState
from .watch import Watch, count_impulses

_AXIAL = {"axial nodes": "nodes", "axial elements": "elements"}


def remembers_axial_forces(memory: Mapping[str, Any]) -> bool:
    """Whether steps have left mean axial forces.   memory: see `cable.linked_cable.memory_of`."""
    found = (memory[name][:, 0] for name in _AXIAL if name in memory)
    return any(map(np.count_nonzero, found))  # faster than any()


def accelerate_again(
    system: Any,
    external: Array,
    state: Any,
    h: float,
    cables: Iterable[Mapping[str, Any]],
    learned: KeptState,
) -> None:
    """Set state.a as at the end of the step before, with other forces; see `in_last_step`.

    system, external, state: see `integrators.rattle`.   h: of the next step [s].
    """
    with in_last_step(cables, learned):
        before = state.v - 0.5 * h * state.a
        accelerate_and_project(system, external, state.q, before, 0.5 * h, state.a, np.zeros_like(before))


@contextmanager
def in_last_step(cables: Iterable[Mapping[str, Any]], learned: KeptState) -> Iterator[None]:
    """Cables that stretch are at the end of the step before once more.

    Axial forces are means of steps there, see `cable.axial`. Those of the present strains alone are no
    measure: axial waves that the step does not resolve change their sign from step to step.

    Args:
        cables: drift corrections and axial forces of each, see `cable.linked_cable.memory_of`.
        learned: keeps these, and what else the evaluation learns; afterwards they are what they were.
    """
    learned.keep()
    for memory in cables:
        for name, records in _AXIAL.items():
            if name in memory:
                memory[name][:, 1] = memory[records]  # what is foreseen has been found already
    yield
    learned.restore()


@kernel
def _take_impulses(system, external, state, lag, memory):
    """See `Impulses`.   lag: for which accelerations act before the state [s].   memory: (2, n) zeros."""
    before, after = memory[0], memory[1]
    accelerate_and_project(system, external, state.q, state.v, 0.0, before, after)
    for i in range(len(state.v)):
        state.v[i] = after[i]
        before[i] = after[i] - lag * state.a[i]
    accelerate_and_project(system, external, state.q, before, lag, state.a, after)


@kernel
def _count_impulses(system, external, state, watch):
    """See `count_impulses`."""
    report_energy(system, external, state.q, state.v, state.a, watch.force, watch.present_report)
    count_impulses(watch, state)


class Impulses:
    """That joints and supports take to have other velocities from now on, in compiled systems under RATTLE."""

    def __init__(self) -> None:
        self._take, self._count = Prepared(_take_impulses), Prepared(_count_impulses)

    def act(
        self,
        system: Any,
        external: Array,
        state: Any,
        h: float,
        cables: Collection[Mapping[str, Any]],
        learned: KeptState,
        watch: Watch,
    ) -> None:
        """Set velocities and accelerations, and count the work.

        system, external, state, h, cables, learned: see `accelerate_again`; called by address; no cables: see
        `integrators.rattle.start`.   watch: whose account is open.
        """
        with in_last_step(cables, learned) if cables else nullcontext():
            lag = 0.5 * h if cables else 0.0
            self._take(system, external, state, lag, np.zeros((2, len(state.q))))
        self._count(system, external, state, watch)
