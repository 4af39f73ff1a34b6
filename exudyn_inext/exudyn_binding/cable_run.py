"""One cable during a run: its compiled system, its state, and its place in the mbs."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..chain.chain import build_chain
from ..chain.frequency import largest_frequency
from ..chain.index_reduction import CableSystem
from ..constraints import constraints_of_cable
from ..errors import RedundantConstraintError, SceneError
from ..integrators.integrator import Integrator, record
from .cable_loads import CableLoads
from .scene import CableInScene
from .time_grid import TimeGrid

CONSISTENCY_TOLERANCE = 1e-6  # of constraint values [-, m] and, relative to the speed, their rates
PIVOT_TOLERANCE = 1e-10
STRETCH_LIMIT = 0.05  # |r_x|^2 - 1 [-] beyond which a run has diverged


class CableRun:
    """A cable that an integrator moves.

    system: the index-reduced equations.   state: of the integrator.
    indices: (n_dof,) places of the coordinates in the system vector.
    reference: (n_dof,) what separates total coordinates from Exudyn's displacements.
    looks_ahead: whether several steps of the time loop can be computed at once.
    """

    def __init__(
        self, scene_cable: CableInScene, initial: tuple[Array, Array], zeta: float, integrator: Integrator
    ) -> None:
        check_consistency(scene_cable, *initial)
        cable = scene_cable.cable
        self.scene_cable = scene_cable
        self.indices = scene_cable.indices
        self.reference = cable.reference.ravel()
        self.system = CableSystem(build_chain(cable), zeta)
        self.state: Any = integrator.allocate(cable.reference.size, cable.reference.size)
        self.state.q[:], self.state.v[:] = (array.ravel() for array in initial)
        self._integrator = integrator
        self._loads = CableLoads(scene_cable)
        self.looks_ahead = not self._loads.has_histories

    @property
    def name(self) -> str:
        return f"cable '{self.scene_cable.name}'"

    def scale_mass(self, mass_scaling: float) -> None:
        """Move with the mass matrix M + mass_scaling K from now on; see `build_chain` [s^2]."""
        self.system = CableSystem(build_chain(self.scene_cable.cable, mass_scaling), self.system.zeta)

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; the history of a multi-step scheme begins here.

        Raises:
            RedundantConstraintError: length constraints and supports depend on each other.
        """
        chain = self.system.chain
        chain.nodes.foresight = 0.0
        chain.elements.foresight = 0.0
        self._integrator.start(self.system, self._loads.at(time), self.state)
        self._check_pivots()

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration."""
        shape = self.scene_cable.cable.reference.shape
        external, q = self._loads.at(time), self.state.q
        return largest_frequency(self.system, external.reshape(shape), q.reshape(shape).copy())

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> None:
        """Advance through len(history) loop steps from loop step `first`, in one compiled call.

        history: (intervals, 3, n_dof) output: displacements from the reference, v, a after each.
        """
        steps = len(history) * grid.substeps
        loads = self._loads.sample(grid.time(first), grid.h, steps, self._integrator.stages)
        record(scheme, self.system, loads, self.state, grid.h, grid.substeps, history)
        history[:, 0] -= self.reference

    def is_credible(self, history: Array) -> np.ndarray:
        """(intervals,) whether the slopes are still those of an inextensible cable; history as above."""
        shape = self.scene_cable.cable.reference.shape
        slopes = (history[:, 0] + self.reference).reshape(-1, *shape)[:, :, 1]
        stretch = np.abs(np.einsum("tki,tki->tk", slopes, slopes) - 1.0)
        return (stretch < STRETCH_LIMIT).all(axis=1)

    def _check_pivots(self) -> None:
        """Each length multiplier's pivot must be negative, clear of round-off."""
        nodes = self.system.chain.nodes
        ends = np.flatnonzero(nodes.ends_group)
        pivots = 1.0 / nodes.inverse_pivot[ends, -1]
        mass = self.scene_cable.cable.section.mass_per_length * self.scene_cable.cable.element_lengths
        dependent = ~(pivots < -PIVOT_TOLERANCE * 8.0 / mass[ends - 1])
        if dependent.any():
            k, names = int(ends[np.argmax(dependent)]), self.scene_cable.item.nodes
            raise RedundantConstraintError(
                f"the length constraint of the element between nodes {names[k - 1]} and {names[k]} of "
                f"{self.name} is not independent of the other constraints (a straight cable between two "
                "supports as far apart as it is long, or an element clamped at both ends): let it sag, "
                "free a support, or use a smaller numberOfLengthConstraints."
            )


def check_consistency(scene_cable: CableInScene, q: Array, v: Array) -> None:
    """Initial coordinates and velocities (n, 2, dim) must satisfy all constraints.

    Raises:
        SceneError: names the worst constraint and by how much it is violated.
    """
    speed = max(1.0, float(np.abs(v).max()))
    worst = (0.0, "")
    for constraint in constraints_of_cable(scene_cable.cable):
        value, rate = constraint.value(q), constraint.rate(q, v) / speed
        for what, violations in (("initial coordinates", value), ("initial velocities", rate)):
            sizes = np.nan_to_num(np.abs(violations), nan=np.inf)
            row = int(np.argmax(sizes))
            where = f"{constraint.name} constraint at the {constraint.describe(row, scene_cable.item.nodes)}"
            text = f"the {what} of cable '{scene_cable.name}' violate the {where}"
            worst = max(worst, (float(sizes[row]), text), key=lambda item: item[0])
    if not worst[0] <= CONSISTENCY_TOLERANCE:
        raise SceneError(
            f"{worst[1]} by {worst[0]:.3g} (limit {CONSISTENCY_TOLERANCE:g}): correct the initial values of "
            "its nodes."
        )
