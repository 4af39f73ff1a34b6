"""A run of a stepper: memory that is allocated once, and forces that are set in place."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import LARGEST
from ..errors import InputError
from .cable_run import Start
from .coupled_run import Run
from .time_grid import TimeGrid

_SEQUENCES = (Sequence, np.ndarray)


class SteppedRun:
    """A run of a cable, or of a coupled scene in compiled code, that is advanced without allocation.

    run: of it.   cables: views of the present q and v (n, 2, dim) of each.
    nodes: first coordinate of each node that takes forces, and the dimension of its space.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.nodes: Mapping[int, tuple[int, int]] = run.places_of_nodes
        q, v = run.state.q, run.state.v
        self.cables = [
            (q[dofs].reshape(shape), v[dofs].reshape(shape)) for dofs, shape in run.places_of_cables
        ]
        self._forces = run.settable_forces
        self._without = self._forces.copy()
        self._initial = run.present_state()
        self._data_before = run.data.copy()
        self._present, self._before = (np.zeros((1, 3, len(run.indices))) for _ in range(2))

    def start(self, time: float, h: float) -> None:
        """Back to the initial state, for steps of h [s]; see `CableRun.start`."""
        run, state = self.run, self.run.state
        self._initial.restore()
        run.try_again()
        run.set_step(h)
        run.start(time)
        self._present[0] = state.q, state.v, state.a

    def start_from(self, q: Array, v: Array, data: Array, start: Start) -> None:
        """As `start`, in another state.   q, v, data: coordinates of the mbs, displacements [m, -].

        Raises:
            SceneError: they violate a constraint by more than the tolerance.
        """
        run, state = self.run, self.run.state
        state.q[:], state.v[:] = q[run.indices] + run.reference, v[run.indices]
        if run.data.size:
            run.data[:] = data
        run.make_consistent(start)
        run.start(start.time)
        self._present[0] = state.q, state.v, state.a

    def step(self, grid: TimeGrid) -> bool:
        """Take the one loop step of the grid; returns whether it went well."""
        self._present, self._before = self._before, self._present
        self._data_before[:] = self.run.data
        return self.run.advance(grid, 0, self._present) == 1

    def restore(self) -> None:
        """Coordinates, velocities, accelerations and data before the last call of `step`."""
        self.run.data[:] = self._data_before
        self._present[:] = self._before
        state = self.run.state
        state.q[:], state.v[:], state.a[:] = self._present[0]

    def set_force(self, node: int, force: Sequence[float]) -> None:
        """Set the force (3,) [N] on a node, in place of the last one; InputError if it is none."""
        first, dim = self.nodes[node]
        if not _are_three_numbers(force):
            raise InputError(f"force = {force!r} on node {node}: must be 3 finite numbers [N].")
        if dim == 2 and force[2] != 0.0:
            raise InputError(
                f"force on node {node} has the z component {force[2]:g} N, but it moves in the plane: create "
                "the cable with dimension=3, or another body."
            )
        for i in range(dim):
            self._forces[first + i] = self._without[first + i] + force[i]

    def write(self, time: float, states: Array, reactions: Array) -> None:
        """The present state, at `time` [s], for the mbs.

        Args:
            time: of the state.
            states: (3, n_ode2) output: displacements, velocities, accelerations of the system.
            reactions: (m,) output: multipliers of its algebraic equations.
        """
        run, state = self.run, self.run.state
        present = np.stack([state.q - run.reference, state.v, state.a])[np.newaxis]
        run.complete(np.array([time]), np.array([-1]), present, reactions[np.newaxis])
        states[:, run.indices] = present[0]


def _are_three_numbers(force: Any) -> bool:
    """Without an array: a force is set at each step."""
    if not isinstance(force, _SEQUENCES) or len(force) != 3:
        return False
    try:
        return all(map(isfinite, force)) and max(map(abs, force)) <= LARGEST
    except (TypeError, ValueError, OverflowError):
        return False
