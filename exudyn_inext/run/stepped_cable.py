"""One cable of a stepper: memory that is allocated once, and forces that are set in place."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import LARGEST
from ..errors import InputError
from .cable_run import CableRun
from .kept_state import KeptState
from .time_grid import TimeGrid

_SEQUENCES = (Sequence, np.ndarray)


class SteppedCable:
    """A `CableRun` that is advanced without allocation.

    run: the cable.   nodes: node number -> place along the cable.
    q, v: (n, 2, dim) views of the present state.
    """

    def __init__(self, run: CableRun) -> None:
        shape = run.scene_cable.cable.reference.shape
        self.run = run
        self.nodes = {node: place for place, node in enumerate(run.scene_cable.item.nodes)}
        self.q: Array = run.state.q.reshape(shape)
        self.v: Array = run.state.v.reshape(shape)
        self._without_forces = run.loads.constant.copy()
        self._initial = KeptState(run.memory())
        self._present, self._before = (np.zeros((1, 3, run.state.q.size)) for _ in range(2))

    def start(self, time: float, h: float) -> None:
        """Back to the initial state, for steps of h [s]; see `CableRun.start`."""
        run, state = self.run, self.run.state
        self._initial.restore()
        run.gave_up = False
        run.set_step(h)
        run.start(time)
        self._present[0] = state.q, state.v, state.a

    def step(self, grid: TimeGrid) -> bool:
        """Take the one loop step of the grid; returns whether it went well."""
        self._present, self._before = self._before, self._present
        return self.run.advance(grid, 0, self._present) == 1

    def verdict(self, time: float, h: float) -> str:
        """What went wrong; see `CableRun.verdict`."""
        return self.run.verdict(time, h)

    def restore(self) -> None:
        """Coordinates, velocities and accelerations before the last call of `step`."""
        self._present[:] = self._before
        state = self.run.state
        state.q[:], state.v[:], state.a[:] = self._present[0]

    def set_force(self, node: int, force: Sequence[float]) -> None:
        """Set the force (3,) [N] on a node, in place of the last one; InputError if it is none."""
        dim = self.q.shape[2]
        first = self.nodes[node] * 2 * dim
        if not _are_three_numbers(force):
            raise InputError(f"force = {force!r} on node {node}: must be 3 finite numbers [N].")
        if dim == 2 and force[2] != 0.0:
            raise InputError(
                f"force on node {node} has the z component {force[2]:g} N, but its cable is planar: create "
                "the cable with dimension=3."
            )
        constant = self.run.loads.constant
        for i in range(dim):
            constant[first + i] = self._without_forces[first + i] + force[i]

    def write(self, states: Array) -> None:
        """Displacements, velocities, accelerations into the system's (3, n_ode2)."""
        indices, state = self.run.indices, self.run.state
        states[0, indices] = state.q - self.run.reference
        states[1, indices] = state.v
        states[2, indices] = state.a


def _are_three_numbers(force: Any) -> bool:
    """Without an array: a force is set at each step."""
    if not isinstance(force, _SEQUENCES) or len(force) != 3:
        return False
    try:
        return all(map(isfinite, force)) and max(map(abs, force)) <= LARGEST
    except (TypeError, ValueError, OverflowError):
        return False
