"""Accelerations after forces have jumped between two steps, of cables that stretch."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..arrays import Array
from ..system import accelerate_and_project
from .kept_state import KeptState

_RECORDS = ("nodes", "elements")


def remembers_axial_forces(memory: Mapping[str, Any]) -> bool:
    """Whether steps have left mean axial forces.   memory: see `cable.linked_cable.memory_of`."""
    return any(memory[f"axial {name}"][:, 0].any() for name in _RECORDS if f"axial {name}" in memory)


def accelerate_again(
    system: Any,
    external: Array,
    state: Any,
    h: float,
    cables: Iterable[Mapping[str, Any]],
    learned: KeptState,
) -> None:
    """Set state.a as at the end of the step before, with other forces.

    Axial forces are means of steps there, see `cable.axial`. Those of the present strains alone are no
    measure: axial waves that the step does not resolve change their sign from step to step.

    Args:
        system, external, state: see `integrators.rattle`.   h: of the next step [s].
        cables: drift corrections and axial forces of each, see `cable.linked_cable.memory_of`.
        learned: keeps these, and what else the evaluation learns; afterwards they are what they were.
    """
    learned.keep()
    for memory in cables:
        for name in _RECORDS:
            if f"axial {name}" in memory:
                memory[f"axial {name}"][:, 1] = memory[name]  # what is foreseen has been found already
    before = state.v - 0.5 * h * state.a
    accelerate_and_project(system, external, state.q, before, 0.5 * h, state.a, np.zeros_like(before))
    learned.restore()
