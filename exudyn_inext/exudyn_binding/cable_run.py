"""One cable during a run: its compiled system, its state, and its place in the mbs."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..chain.border import all_links
from ..chain.cable import Cable
from ..chain.frequency import largest_frequency
from ..chain.linked_cable import LinkedCableSystem, cable_system
from ..errors import RedundantConstraintError
from ..integrators.integrator import Integrator, record
from .cable_loads import CableLoads
from .consistent_start import (
    ROUND_OFF,
    StartCorrection,
    Violation,
    project,
    require_consistent,
    worst_violation,
)
from .link_items import require_smooth_motions
from .scene import CableInScene
from .time_grid import TimeGrid

PIVOT_TOLERANCE = 1e-10
STRETCH_LIMIT = 0.05  # |r_x|^2 - 1 [-] beyond which a run has diverged


@dataclass(frozen=True)
class Start:
    """How a cable starts.

    time: [s].   tolerance: see `ExplicitSettings.startTolerance`.
    zeta: stabilisation rate [1/s].   mass_scaling: see `build_chain` [s^2].
    """

    time: float
    tolerance: float
    zeta: float
    mass_scaling: float


class CableRun:
    """A cable that an integrator moves.

    system: the index-reduced equations.   state: of the integrator.
    indices: (n_dof,) places of the coordinates in the system vector.
    reference: (n_dof,) what separates total coordinates from Exudyn's displacements.
    loads: external force and motions.
    looks_ahead: whether several steps of the time loop can be computed at once.   reason: why not.
    start_correction: how far the initial state was from its constraints.
    """

    reason = (
        "user functions of loads or moving supports may depend on more than the time (if they do not, set "
        "function.dependsOnTimeOnly = True)"
    )

    def __init__(
        self,
        scene_cable: CableInScene,
        initial: tuple[Array, Array],
        start: Start,
        integrator: Integrator,
    ) -> None:
        require_smooth_motions(scene_cable.moving, start.time)
        violation = worst_violation(scene_cable, *initial, start.time)
        require_consistent(scene_cable, violation, start.tolerance)
        cable = scene_cable.cable
        self.scene_cable = scene_cable
        self.indices = scene_cable.indices
        self.reference = cable.reference.ravel()
        self.system = cable_system(cable, start.zeta, start.mass_scaling)
        self._element_masses = _element_masses(cable, start.mass_scaling)
        self._integrator = integrator
        self.loads = CableLoads(scene_cable)
        self.state: Any = integrator.allocate(cable.reference.size, len(self.loads.constant))
        self.state.q[:], self.state.v[:] = (array.ravel() for array in initial)
        self.looks_ahead = self.loads.known_ahead
        self.start_correction = self._project(violation, start.time)

    def _project(self, violation: Violation, time: float) -> StartCorrection:
        if violation.size < ROUND_OFF:
            return StartCorrection()
        self.start(time)  # redundant constraints are named before the projection meets them
        cable = self.scene_cable.cable
        return project(self.system, self.loads.at(time), cable, self.state.q, self.state.v)

    @property
    def name(self) -> str:
        return f"cable '{self.scene_cable.name}'"

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; the history of a multi-step scheme begins here.

        Raises:
            RedundantConstraintError: length constraints and supports depend on each other.
        """
        self.forget()
        self._integrator.start(self.system, self.loads.at(time), self.state)
        self.check_pivots()

    def forget(self) -> None:
        """What earlier steps taught the constraints does not hold any more."""
        for records in self._records():
            records.foresight = 0.0

    @property
    def cables(self) -> list[Cable]:
        return [self.scene_cable.cable]

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [self.start_correction]

    def damping_ratio(self, frequency: float) -> float:
        """Of a vibration of that frequency [rad/s]: bending damping grows with it."""
        section = self.scene_cable.cable.section
        return frequency * section.bending_damping / section.bending_stiffness

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration."""
        q = self.state.q.reshape(self.scene_cable.cable.reference.shape)
        return largest_frequency(self.system, self.loads.at(time), q.copy())

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> None:
        """Advance through len(history) loop steps from loop step `first`, in one compiled call.

        history: (intervals, 3, n_dof) output: displacements from the reference, v, a after each.
        """
        steps = len(history) * grid.substeps
        loads = self.loads.sample(
            grid.start, grid.h, steps, self._integrator.stages, first=first * grid.substeps
        )
        record(scheme, self.system, loads, self.state, grid.h, grid.substeps, history)
        history[:, 0] -= self.reference

    def is_credible(self, history: Array) -> np.ndarray:
        """(intervals,) whether the slopes are still those of an inextensible cable; history as above."""
        shape = self.scene_cable.cable.reference.shape
        slopes = (history[:, 0] + self.reference).reshape(-1, *shape)[:, :, 1]
        stretch = np.abs(np.einsum("tki,tki->tk", slopes, slopes) - 1.0)
        return (stretch < STRETCH_LIMIT).all(axis=1)

    def _records(self) -> list[Any]:
        """Everything that holds constraints."""
        chain = self.system.chain
        links = [self.system.border.links] if isinstance(self.system, LinkedCableSystem) else []
        return [chain.nodes, chain.elements, *links]

    def check_pivots(self) -> None:
        """Each length multiplier's pivot must be negative, each link's positive, clear of round-off.

        Raises:
            RedundantConstraintError: it is not; at the latest evaluation.
        """
        nodes = self.system.chain.nodes
        ends = np.flatnonzero(nodes.ends_group)
        pivots = 1.0 / nodes.inverse_pivot[ends, -1]
        dependent = ~(pivots < -PIVOT_TOLERANCE * 8.0 / self._element_masses[ends - 1])
        if dependent.any():
            k, names = int(ends[np.argmax(dependent)]), self.scene_cable.item.node_names
            raise RedundantConstraintError(
                f"the length constraint of the element between nodes {names[k - 1]} and {names[k]} of "
                f"{self.name} is not independent of the other constraints (a straight cable between two "
                "supports as far apart as it is long, or an element clamped at both ends): let it sag, "
                "free a support, or use a smaller numberOfLengthConstraints."
            )
        if isinstance(self.system, LinkedCableSystem):
            self._check_links(self.system.border.schur)

    def _check_links(self, factor: Array) -> None:
        squares = np.tril(factor) ** 2
        dependent = ~(np.diag(squares) > PIVOT_TOLERANCE * squares.sum(axis=1))
        if dependent.any():
            link = all_links(self.scene_cable.cable)[int(np.argmax(dependent))]
            names = " and ".join(str(self.scene_cable.item.node_names[k]) for k in link.nodes)
            raise RedundantConstraintError(
                f"the {link.kind} constraint at node {names} of {self.name} is not independent of the other "
                "constraints (a node that is held or moved twice, or a cable pulled straight between what "
                "holds it): remove one of them, or let the cable sag."
            )


def _element_masses(cable: Cable, mass_scaling: float) -> Array:
    """(N,) rho_A l, and what mass scaling adds to it [kg]."""
    section, lengths = cable.section, cable.element_lengths
    masses: Array = section.mass_per_length * lengths
    return masses + mass_scaling * 24.0 * section.bending_stiffness / lengths**3
