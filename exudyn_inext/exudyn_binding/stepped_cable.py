"""One cable of a stepper: memory that is allocated once, and forces that are set in place."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import LARGEST
from ..errors import InputError
from ..integrators import find_integrator
from ..integrators.integrator import LoadHistory
from .cable_run import CableRun
from .kept_state import KeptState
from .time_grid import TimeGrid

_SEQUENCES = (Sequence, np.ndarray)


class SteppedCable:
    """A `CableRun` that is advanced without allocation.

    run: the cable.   nodes: node number -> place along the cable.
    q, v: (n, 2, dim) views of the present state.
    """

    def __init__(self, run: CableRun, integrator: str, scheme: Any) -> None:
        shape = run.scene_cable.cable.reference.shape
        self.run = run
        self.nodes = {node: place for place, node in enumerate(run.scene_cable.item.nodes)}
        self.q: Array = run.state.q.reshape(shape)
        self.v: Array = run.state.v.reshape(shape)
        self._scheme = scheme
        self._stages = find_integrator(integrator).stages
        loads = run.loads
        self._without_forces = loads.constant.copy()
        self._constant_loads = (
            LoadHistory(loads.constant, loads.pattern, np.zeros((1, len(self._stages), 0)))
            if not len(loads.pattern)
            else None
        )
        self._beginning = KeptState(run.memory())
        self._present, self._before = (np.zeros((1, 3, run.state.q.size)) for _ in range(2))

    def start(self, time: float, h: float) -> None:
        """Back to the initial state, for steps of h [s]; see `CableRun.start`."""
        run = self.run
        self._beginning.restore()
        run.gave_up = False
        run.set_step(h)
        run.start(time)
        self._present[0] = run.state.q, run.state.v, run.state.a

    def step(self, start: float, h: float, first: int, steps: int) -> bool:
        """Take `steps` steps of size h [s] after the first `first` ones since the time `start` [s].

        Returns:
            Whether they went well.
        """
        run, time = self.run, start + first * h
        self._present, self._before = self._before, self._present
        if run.control.is_nominal:
            run.change_step(h, time)
            loads = self._constant_loads or run.loads.sample(start, h, steps, self._stages, first=first)
            good, taken = run.take_nominal(self._scheme, loads, h, steps, self._present)
            if good:
                return True
            run.reject_after(taken, h, time + taken * h)
        return run.finish_interval(self._scheme, TimeGrid(time, 1, steps, h), 0, self._present)

    def verdict(self, time: float, h: float) -> str:
        """What went wrong; see `CableRun.verdict`."""
        return self.run.verdict(self._scheme, time, h)

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
