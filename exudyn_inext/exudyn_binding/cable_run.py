"""One cable during a run: its compiled system, its state, and its place in the mbs."""

import math
from dataclasses import dataclass
from typing import Any

from ..arrays import Array
from ..chain.attached_forces import drag_rate
from ..chain.cable import Cable
from ..chain.frequency import FrequencyTracker, largest_frequency
from ..chain.linked_cable import LinkedCableSystem, cable_system
from ..integrators.integrator import Integrator
from ..integrators.linear_stability import frequency_limit
from ..integrators.watch import record_watched
from .cable_loads import CableLoads
from .cable_watch import CableWatch, figures, memory_of
from .consistent_start import (
    ROUND_OFF,
    StartCorrection,
    Violation,
    project,
    require_consistent,
    worst_violation,
)
from .divergence import GIVEN_UP, explanation
from .link_items import require_smooth_motions
from .redundancy import element_masses, require_independent
from .retrace import retrace
from .scene import CableInScene
from .step_control import StepControl, StepRule
from .time_grid import TimeGrid

STEPS_BETWEEN_LIMITS = 20_000  # so that a look at the present stability limit costs next to nothing


@dataclass(frozen=True)
class Start:
    """How a cable starts.

    time: [s].   tolerance: see `ExplicitSettings.startTolerance`.
    zeta: stabilisation rate [1/s].   mass_scaling: see `build_chain` [s^2].
    energy_tolerance: see `ExplicitSettings.energyTolerance`; infinite where nobody asks.
    """

    time: float
    tolerance: float
    zeta: float
    mass_scaling: float
    energy_tolerance: float


class CableRun:
    """A cable that an integrator moves.

    system: the index-reduced equations.   state: of the integrator.
    indices: (n_dof,) places of the coordinates in the system vector.
    reference: (n_dof,) what separates total coordinates from Exudyn's displacements.
    loads: external force and motions.
    looks_ahead: whether several steps of the time loop can be computed at once.   reason: why not.
    start_correction: how far the initial state was from its constraints.
    control: chooses the steps, if they are not all equal.
    watch: stops a run that goes wrong.
    """

    control: StepControl | None = None

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
        cable = scene_cable.cable
        self.scene_cable = scene_cable
        self.indices = scene_cable.indices
        self.reference = cable.reference.ravel()
        self.system = cable_system(cable, start.zeta, start.mass_scaling)
        violation = worst_violation(scene_cable, self.system, *initial, start.time)
        require_consistent(scene_cable, violation, start.tolerance)
        self._element_masses = element_masses(cable, start.mass_scaling)
        self._drag_rate = drag_rate(cable, scene_cable.item.gravity, initial[1])
        self._integrator = integrator
        self._is_scaled = start.mass_scaling > 0.0
        self._tracker = FrequencyTracker(self.system, cable.reference.shape)
        self._steps_since_limit = 0
        self._largest_share = 0.0  # of the stability limit, that the step has been
        self.loads = CableLoads(scene_cable)
        self.state: Any = integrator.allocate(cable.reference.size, len(self.loads.constant))
        self.state.q[:], self.state.v[:] = (array.ravel() for array in initial)
        self.looks_ahead = self.loads.known_ahead
        self.watch = CableWatch(scene_cable, self.loads, self.state, start.energy_tolerance)
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

    def follow_frequency(self, rule: StepRule) -> None:
        """Let the steps follow the present stability limit."""
        self.control = StepControl(rule, self._tracker)

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; the history of a multi-step scheme begins here.

        Raises:
            RedundantConstraintError: length constraints and supports depend on each other.
        """
        self.forget()
        external = self.loads.at(time)
        self._integrator.start(self.system, external, self.state)
        self.require_independence()
        self.watch.open(self.system, external, self.state)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on, by names: to be kept, or set before `resume`."""
        places = ("nodes", "elements", "links")
        foresight = {
            place: records["foresight"] for place, records in zip(places, self._records(), strict=False)
        }
        control = self.control.memory() if self.control else {}
        return {
            "state": self.state._asdict(),
            "foresight": foresight,
            "watch": memory_of(self.watch.watch),
            "control": control,
        }

    def resume(self, time: float) -> None:
        """Go on at `time` [s], with the memory that has been set."""
        self._integrator.resume(self.system, self.loads.at(time), self.state)

    @property
    def integrator(self) -> Integrator:
        """What moves it."""
        return self._integrator

    @property
    def stages(self) -> tuple[float, ...]:
        """Of the scheme, see `Integrator`."""
        return self._integrator.stages

    def go_on(self, time: float) -> None:
        """Go on at `time` [s] from a state that the last steps have not led to."""
        self.forget()
        self.resume(time)
        self.watch.open(self.system, self.loads.at(time), self.state)

    def forget(self) -> None:
        """What earlier steps taught the constraints does not hold any more."""
        for records in self._records():
            records["foresight"] = 0.0

    def _record_under_control(
        self, control: StepControl, scheme: Any, grid: TimeGrid, first: int, history: Array
    ) -> int:
        """As `record`, with steps of its own choice in each interval."""
        interval = grid.substeps * grid.h
        for k in range(len(history)):
            end = grid.time(first + k + 1)
            remaining = interval
            while remaining > ROUND_OFF * interval:
                taken = self._take_steps(control, scheme, end, remaining, history[k : k + 1])
                remaining -= taken
                if taken == 0.0:
                    return k
        return len(history)

    def _take_steps(
        self, control: StepControl, scheme: Any, end: float, remaining: float, history: Array
    ) -> float:
        """Some steps towards the time `end` [s]; returns the time that they took, 0 if they went wrong."""
        shape = self.scene_cable.cable.reference.shape
        steps, h, ratio = control.next_steps(
            remaining, self.state.q.reshape(shape), self.state.a.reshape(shape)
        )
        if not steps:
            return 0.0
        if ratio != 1.0:
            self._integrator.change_step(self.state, ratio)
        loads = self.loads.sample(end - remaining, h, steps, self._integrator.stages)
        good = record_watched(scheme, self.system, loads, self.state, h, steps, history, self.watch.watch)
        return steps * h if good else 0.0

    @property
    def cables(self) -> list[Cable]:
        return [self.scene_cable.cable]

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [self.start_correction]

    def damping_ratio(self, frequency: float) -> float:
        """Of a vibration of that frequency [rad/s]: bending damping grows with it, drag does not."""
        section = self.scene_cable.cable.section
        of_drag = self._drag_rate / frequency if frequency > 0.0 else 0.0
        return of_drag + frequency * section.bending_damping / section.bending_stiffness

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration."""
        q = self.state.q.reshape(self.scene_cable.cable.reference.shape)
        return largest_frequency(self.system, self.loads.at(time), q.copy())

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> int:
        """Advance through len(history) loop steps from loop step `first`, in one compiled call.

        history: (intervals, 3, n_dof) output: displacements from the reference, v, a after each.

        Returns:
            Number of loop steps that went well; later rows of `history` mean nothing.
        """
        if self.control is not None:
            good = self._record_under_control(self.control, scheme, grid, first, history)
        else:
            steps = len(history) * grid.substeps
            loads = self.loads.sample(
                grid.start, grid.h, steps, self._integrator.stages, first=first * grid.substeps
            )
            before = self.watch.steps
            good = record_watched(
                scheme, self.system, loads, self.state, grid.h, grid.substeps, history, self.watch.watch
            )
            if good < len(history):
                step = first * grid.substeps + self.watch.steps - before
                good = retrace(self, scheme, grid, step, history, good)
            self._look_at_limit(scheme, grid.h, steps)
        history[:good, 0] -= self.reference
        return good

    def figures(self) -> dict[str, float]:
        """How well constraints and energy were kept, and the step within its stability limit."""
        share = {"stepOverLimit": self._largest_share} if self._largest_share else {}
        return figures(self.watch.watch) | share

    def _look_at_limit(self, scheme: Any, h: float, steps: int) -> None:
        """From time to time: the share that the step is of the present stability limit."""
        self._steps_since_limit += steps
        if self._steps_since_limit < STEPS_BETWEEN_LIMITS or self.watch.has_trouble:
            return
        self._steps_since_limit = 0
        shape = self.scene_cable.cable.reference.shape
        frequency = self._tracker.frequency(self.state.q.reshape(shape), self.state.a.reshape(shape))
        self._largest_share = max(self._largest_share, h / self._stability_limit(scheme, frequency))

    def verdict(self, scheme: Any, time: float, h: float) -> str:
        """What went wrong in the last steps, of h [s] at `time` [s], and why; empty if all is well."""
        if not self.watch.has_trouble:
            return f"{self.name}: {GIVEN_UP}." if self.control and self.control.gave_up else ""
        trouble, taken = (
            self._integrator.trouble(scheme, self.watch.watch.kept),
            self.control.last if self.control else h,
        )
        limit = self._stability_limit(scheme, self.largest_frequency(time))
        said = explanation(self._integrator, trouble, taken, limit, self._is_scaled)
        return f"{self.name}: {self.watch.finding(self.state)}. {said}"

    def _stability_limit(self, scheme: Any, frequency: float) -> float:
        limit = frequency_limit(self._integrator, scheme, self.damping_ratio(frequency))
        return limit / frequency if frequency > 0.0 else math.inf

    def _records(self) -> list[Any]:
        """Everything that holds constraints."""
        chain = self.system.chain
        links = [self.system.border.links] if isinstance(self.system, LinkedCableSystem) else []
        return [chain.nodes, chain.elements, *links]

    def require_independence(self) -> None:
        """RedundantConstraintError if constraints depend on each other; at the latest evaluation."""
        require_independent(self.scene_cable, self.system, self._element_masses)
