"""One cable during a run: its compiled system, its state, and its place in the mbs."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, Places
from ..cable.attached_forces import drag_rate
from ..cable.axial_energy import middle_tension
from ..cable.axial_stiffness import STRAIN, frozen, set_step_of_means
from ..cable.cable import Cable
from ..cable.chain import set_mass
from ..cable.frequency import FrequencyTracker, largest_frequency, nodal_multipliers_of
from ..cable.implicit_bending import EXPLICIT, ImplicitBending
from ..cable.linked_cable import cable_system, memory_of
from ..cable.section_forces import constraint_tension
from ..cable.support_forces import Solved, SupportedCable
from ..called_system import called, kernel_behind
from ..compiled import Prepared
from ..errors import SceneError
from ..integrators.integrator import Integrator, remembered
from ..integrators.linear_stability import frequency_limit
from ..scene.links import require_smooth_motions
from ..scene.model import CableInScene, put_reactions
from ..system import accelerate_and_project, report_energy
from .cable_loads import CableLoads
from .cable_watch import CableWatch
from .consistent_start import (
    NOTHING,
    StartCorrection,
    Violation,
    agree,
    project,
    require_consistent,
    worst_violations,
)
from .divergence import GIVEN_UP, explanation
from .jump import Jumps
from .paced_run import PacedRun
from .redundancy import PULLED, element_masses, is_held_straight, require_independent
from .settings import SAY_OF_TIME, ExplicitSettings
from .step_control import ROUND_OFF, FrequencyFollower, Piece, StepControl, StepRule
from .time_grid import TimeGrid
from .watch import ENERGY, go_back, record_watched

STEPS_BETWEEN_LIMITS = 20_000  # so that a look at the present stability limit costs next to nothing


@dataclass(frozen=True)
class Start:
    """How a run starts.

    time: [s].   h: step that is likely, which scales the mass [s]; 0 without mass scaling.
    explicit: settings.   follows: whether loads of cables may be set step by step.
    """

    time: float
    h: float
    explicit: ExplicitSettings
    follows: bool = False

    @property
    def tolerance(self) -> float:
        """See `ExplicitSettings.startTolerance`."""
        return self.explicit.startTolerance


def require_implicit_axial_forces(scene_cable: CableInScene, integrator: Integrator) -> None:
    """Raise SceneError if a cable stretches, and the integrator would treat its axial forces explicitly."""
    if scene_cable.cable.stretches and integrator.stabilised:
        raise SceneError(
            f"integrator = {integrator.name!r} with axialStiffness of cable '{scene_cable.name}': only "
            "RATTLE treats axial forces implicitly, here its axial waves would bound the step; use "
            "integrator='RATTLE', or leave out axialStiffness."
        )


class CableRun(PacedRun):
    """A cable that an integrator moves.

    system: the index-reduced equations.   state: of the integrator.
    indices: (n_dof,) places of the coordinates in the system vector.
    reference: (n_dof,) what separates total coordinates from Exudyn's displacements.
    loads: external force and motions.
    looks_ahead: whether several steps of the time loop can be computed at once.   reason: why not.
    start_correction: how far the initial state was from its constraints.
    control: of the steps.
    watch: stops a run that goes wrong.   drag_rate: see `attached_forces.drag_rate` [1/s].
    """

    lenience = 1.0  # of the energy's tolerance
    reason = (
        "user functions of loads or moving supports may depend on more than the time (if they do not, "
        f"{SAY_OF_TIME})"
    )

    def __init__(
        self,
        scene_cable: CableInScene,
        system: Any,
        initial: tuple[Array, Array],
        start: Start,
        method: tuple[Integrator, Any],
        is_kept: bool = False,
    ) -> None:
        """Begin at `initial`, coordinates and velocities.

        Args:
            scene_cable: the cable.   system: its equations.   start: how.   method: integrator and scheme.
            is_kept: whether the initial state is known to fulfil the constraints.
        """
        require_smooth_motions(scene_cable.moving, start.time)
        cable = scene_cable.cable
        integrator, scheme = method
        self.integrator = integrator
        require_implicit_axial_forces(scene_cable, integrator)
        self.scene_cable = scene_cable
        self.indices = scene_cable.indices
        self.reference = cable.reference.ravel()
        self._theta, self._likely_step = start.explicit.massScaling or 0.0, start.h
        self._lag = 0.5 if integrator.has_implicit_damping and cable.section.bending_damping else 0.0
        self._stretches = cable.stretches
        self.system = system
        violations = (NOTHING, NOTHING) if is_kept else self._violations(*initial, start)
        self._tracker = FrequencyTracker(self.system, cable.reference.shape)
        self._looked_after = 0  # steps, at the stability limit
        self._largest_share = 0.0  # of the stability limit, that the step has been
        self.loads = CableLoads(scene_cable, start.follows)
        self.drag_rate = drag_rate(cable, self.loads.gravity_at(start.time), initial[1])
        self.state: Any = integrator.allocate(cable.reference.size, len(self.loads.constant))
        self.state.q[:], self.state.v[:] = (array.ravel() for array in initial)
        self.scheme = integrator.for_size(scheme, self.size)
        self.looks_ahead = self.loads.known_ahead
        tolerance, gains_energy = start.explicit.energyTolerance, integrator.stabilised
        self.watch = CableWatch(scene_cable, self.loads, self.state, tolerance, gains_energy)
        self._record_watched = Prepared(record_watched)
        self._start_scheme = Prepared(kernel_behind(integrator.start))
        self._rejects = start.explicit.rejectSteps
        self.control = StepControl(rejects=self._rejects)
        self.start_correction = self._project(*violations, start)

    def make_consistent(self, start: Start) -> None:
        """Let the present state be a start: check it, and project it onto the constraints.

        Raises:
            SceneError: it violates a constraint by more than the tolerance.
        """
        shape = self.scene_cable.cable.reference.shape
        q, v = (x.reshape(shape) for x in (self.state.q, self.state.v))
        self._project(*self._violations(q, v, start), start)

    def _violations(self, q: Array, v: Array, start: Start) -> tuple[Violation, Violation]:
        """The worst ones, of coordinates and of velocities (n, 2, dim); SceneError if they are too large."""
        self._table = called(self.system)  # made once for all who call the system by its address
        violations = worst_violations(self.scene_cable, self.system, q, v, start.time)
        require_consistent(self.scene_cable, violations[0], start.tolerance)
        if not math.isfinite(violations[1].size):  # whatever is a number can be projected
            require_consistent(self.scene_cable, violations[1], start.tolerance)
        return violations

    def _project(self, of_places: Violation, of_rates: Violation, start: Start) -> StartCorrection:
        if max(of_places.size, of_rates.size) < ROUND_OFF:
            return StartCorrection()
        given = self.state.v.copy()
        self.start(start.time)  # redundant constraints are named before the projection meets them
        self.state.v[:] = given
        far = of_rates if of_rates.size > start.tolerance else None
        inputs = self.loads.at(start.time)
        return project(self.scene_cable, self.system, inputs, self.state, start.time, far, start.tolerance)

    @property
    def name(self) -> str:
        return f"cable '{self.scene_cable.name}'"

    def adopt(self, system: Any) -> None:
        """The same equations in memory that cables share."""
        self.system, self._tracker = system, FrequencyTracker(system, self.scene_cable.cable.reference.shape)
        for name in ("called", "_corrections", "_jumps", "_strains"):
            self.__dict__.pop(name, None)

    @cached_property
    def called(self) -> Any:
        """The system, as kernels call it that move and watch it."""
        return called(self.system, *self.integrator.calls, accelerate_and_project, report_energy)

    @cached_property
    def _corrections(self) -> dict[str, Any]:
        """See `memory_of`."""
        return memory_of(self.system)

    @cached_property
    def _jumps(self) -> Jumps:
        return Jumps({"": self._corrections}, self._corrections)

    def follow_frequency(self, rule: StepRule) -> None:
        """Let the steps follow the present stability limit."""
        self.control = StepControl(FrequencyFollower(rule, self._present_frequency), self._rejects)

    def _present_frequency(self, time: float) -> float:
        """w_max [rad/s] about the state that was evaluated last; implicit damping is no mass there."""
        shape = self.scene_cable.cable.reference.shape
        q, a = self.state.q.reshape(shape), self.state.a.reshape(shape)
        if not (self._lag or self._stretches):
            return self._tracker.frequency(q, a)
        plain = cable_system(self.scene_cable.cable, self.system.zeta)
        return largest_frequency(plain, self.state.external, q.copy(), self.state.v.reshape(shape).copy())

    @contextmanager
    def mass_as_it_is(self) -> Iterator[None]:
        """Nothing is in the matrix on the left but mass, and mean axial forces of steps."""
        if not self.has_implicit_bending:
            yield
            return
        set_mass(self.system.chain, self.scene_cable.cable, EXPLICIT)
        self.take_means(self.control.present)
        try:
            yield
        finally:
            set_mass(self.system.chain, self.scene_cable.cable, self._implicit)

    @property
    def places_of_cables(self) -> list[tuple[slice, tuple[int, ...]]]:
        """Its coordinates in the state, and their shape."""
        return [(slice(0, self.state.q.size), self.scene_cable.cable.reference.shape)]

    @property
    def places_of_nodes(self) -> dict[int, tuple[int, int]]:
        """First coordinate of each node, and the dimension of space."""
        dim = self.scene_cable.cable.dimension
        return {node: (2 * dim * k, dim) for k, node in enumerate(self.scene_cable.item.nodes)}

    @property
    def settable_forces(self) -> Array:
        """(n_external,) constant part of the external force, which may be changed between steps."""
        return self.loads.constant

    @cached_property
    def _supported(self) -> SupportedCable:
        return SupportedCable(self.scene_cable.cable)

    @property
    def has_reactions(self) -> bool:
        """Whether constraints of the mbs hold or move it."""
        return bool(self.scene_cable.reactions)

    def put_reactions(
        self, times: Array, joined: Array | float, q: Array, v: Array, steps: Array, multipliers: Array
    ) -> None:
        """Multipliers (k, m) of Exudyn's algebraic equations, those of the cable's own supports.

        Args:
            times, steps: (k,) of the states, and before them [s].   q, v: (k, n_dof).
            joined: (k, n_dof) forces of items and joints.   multipliers: output.
        """
        forces = self._supported.solve(self._external_at(times.tolist(), joined), q, v, steps)
        put_reactions(self.scene_cable.reactions, forces, multipliers)

    def _external_at(self, times: list[float], joined: Array | float) -> Array:
        """(k, n_external) all that acts at these times."""
        external = self.loads.at_times(times)
        external[:, : len(self.reference)] += joined
        return external

    def solved(self, number: int, time: float, state: Sequence[Array], step: float) -> Solved | None:
        """The cable with that object in a state of mbs after steps, by the mass as it is.

        Args:
            number: of its object; None is returned if it is another one.
            time, step: of the state, and before it [s].   state: displacements and velocities of mbs.
        """
        return self.solved_among(0.0, time, state, step) if number == self.scene_cable.number else None

    def solved_among(self, joined: Array | float, time: float, state: Sequence[Array], step: float) -> Solved:
        """As `solved`.   joined: (n_dof,) forces of items and joints."""
        q, v = (x[self.scene_cable.indices] for x in state)
        external = self.loads.at(time).copy()
        external[: len(q)] += joined
        return self._supported.solved(external, q + self.reference, v, step)

    def complete(
        self, times: Array, rows: Places, history: Array, multipliers: Array, of_supports: bool = True
    ) -> bool:
        """Set accelerations, unless they are those of the scheme, and multipliers of recorded states.

        Args:
            times: (k,) of the states [s].
            rows: (k,) which of the last recorded ones they are, rising; -1 is the last one.
            history: (k, 3, n) displacements and velocities, and output: accelerations.
            multipliers: (k, m) output, of Exudyn's algebraic equations.
            of_supports: whether those of the supports of cables are asked for.

        Returns:
            Whether multipliers have been set.
        """
        if self.has_reactions and of_supports:
            q, steps = history[:, 0] + self.reference, self.steps_before_rows(rows)
            self.put_reactions(times, 0.0, q, history[:, 1], steps, multipliers)
        return self.has_reactions

    def accelerations(self, time: float, multipliers: Array) -> Array:
        """(n_dof,) of the present state, by the mass as it is.

        Args:
            time: at present [s].
            multipliers: (m,) output, of Exudyn's algebraic equations; a coupled run also leaves them in mbs
                with the state.
        """
        if not (self.has_reactions or self.has_implicit_bending):
            return np.asarray(self.state.a)
        external, q, v = (row[np.newaxis] for row in (self.loads.at(time), self.state.q, self.state.v))
        forces = self._supported.solve(external, q, v, np.array([self.control.present]))
        put_reactions(self.scene_cable.reactions, forces, multipliers[np.newaxis])
        return np.asarray(forces.accelerations[0] if self.has_implicit_bending else self.state.a)

    @property
    def is_steady(self) -> bool:
        """Whether nothing but the state, and values that are set, decides on the next steps."""
        return self.loads.are_steady

    @property
    def is_scaled(self) -> bool:
        """Whether its mass is scaled."""
        return self._theta > 0.0

    @property
    def has_implicit_bending(self) -> bool:
        """Whether the system depends on the step."""
        return self._theta > 0.0 or self._lag > 0.0 or self._stretches

    @property
    def _implicit(self) -> ImplicitBending:
        """What is in the matrix on the left at present."""
        h = self.control.present or self._likely_step
        return ImplicitBending(self._theta * h**2, self._lag * self.control.present, self.control.present)

    def scale_mass(self, theta: float, h: float) -> None:
        """Make that share of bending implicit, for steps of h [s] as long as no other ones are taken."""
        self._theta, self._likely_step = theta, h
        set_mass(self.system.chain, self.scene_cable.cable, ImplicitBending(theta * h**2))

    def set_step(self, h: float) -> None:
        """Prepare the system for steps of h [s]: what is implicit depends on it."""
        self.control.present = h
        if self.has_implicit_bending:
            set_mass(self.system.chain, self.scene_cable.cable, self._implicit)

    @contextmanager
    def implicit_damping_left_out(self) -> Iterator[None]:
        """The system without the damping and axial forces that are implicit, for limits of the step."""
        if not (self._lag or self._stretches):
            yield
            return
        elements, step = self.system.chain.elements, self.control.present
        weights = elements["damping"][:, :, 0].copy()
        elements["damping"][:, :, 0] = 0.0
        scaled = ImplicitBending(self._theta * (step or self._likely_step) ** 2)
        set_mass(self.system.chain, self.scene_cable.cable, scaled)
        try:
            yield
        finally:
            elements["damping"][:, :, 0] = weights
            if step:
                self.set_step(step)

    @property
    def axial_forces_frozen(self) -> AbstractContextManager[None]:
        """Axial forces as at the last evaluation, see `axial_stiffness.frozen`."""
        chain = self.system.chain
        return frozen(chain.nodes, chain.elements) if self._stretches else nullcontext()

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; the history of a multi-step scheme begins here.

        From none, as implicit damping takes part of those before from the right, which are of another motion.

        Raises:
            RedundantConstraintError: length constraints and supports depend on each other.
        """
        self.forget()
        self.take_ramp({})
        self.state.a.fill(0.0)
        self.start_scheme(time)
        self.require_independence()
        self.watch.open(self.called, self.loads.at(time), self.state)

    @property
    def ramp(self) -> dict[str, list[Any]]:
        """Numbers that change along a line in the next step of the loop, as JSON has it; empty: none."""
        return self.loads.kept_ramp

    def take_ramp(self, kept: Mapping[str, Any]) -> None:
        """Let these numbers change so from now on; see `ramp`."""
        self.loads.take_ramp(kept)

    def ramp_loads(self, values: Mapping[int, Sequence[float]], time: float, end: float) -> set[int]:
        """Let constant loads get to these values along a line; see `CableLoads.ramp`."""
        found = self.loads.ramp(values, time, end)
        if found:
            self.watch.count_ramp(self.loads, time, self.state)
        return found

    def move_on(self, time: float, end: float, has_changed: bool) -> None:
        """Begin again with supports that have been moved; arguments: see `CoupledRun.move_on`."""
        given = self.called, self.loads.at(time), self.state
        if not self._stretches:
            self.forget()
        self.watch.begin_work()
        if self.integrator.stabilised:
            agree(*given)
            self._start_scheme(*given)
            self.watch.go_on(*given)
        else:
            self._jumps.take_impulses(*given, self.control.present, self.watch.watch)
        if self.loads.follows:
            self.watch.count_ramp(self.loads, time, self.state)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on, by names: to be kept, or set before `resume`."""
        return {
            "state": remembered(self.state),
            "drift_correction": self._corrections,
            "watch": self.watch.memory(),
            "control": self.control.memory() | {"vibration": self._tracker.vibration},
        }

    def resume(self, time: float) -> None:
        """Go on at `time` [s], with the memory that has been set."""
        if self.control.present:
            self.set_step(self.control.present)
        self.integrator.resume(self.called, self.loads.at(time), self.state)

    def forget(self) -> None:
        for drift_correction in self._corrections.values():
            drift_correction[:] = 0.0

    def take(self, piece: Piece, history: Array) -> int:
        """See `PacedRun.take`: in one compiled call."""
        before, loads = self.watch.steps, self.loads.sample(piece, self.integrator.stages)
        rows, steps = history[: piece.intervals], (piece.h, piece.in_interval)
        given = self.called, loads, self.state
        good = self._record_watched(self.scheme, *given, *steps, rows, self.watch.placed)
        if good < len(rows):
            go_back(self.watch.watch, self.state)
        taken = self.watch.steps - before
        if taken < piece.steps:
            self.trouble = self.integrator.trouble(self.scheme, self.watch.watch.kept)
            self.forget()
        return taken

    def start_scheme(self, time: float) -> None:
        """See `PacedRun.start_scheme`."""
        given = self.called, self.loads.at(time), self.state
        if self._jumps.keep_means:
            self._jumps.accelerate(*given, self.control.present)
        else:
            self._start_scheme(*given)

    def watch_on(self, time: float) -> None:
        """See `PacedRun.watch_on`."""
        self.watch.go_on(self.called, self.loads.at(time), self.state)

    @property
    def cables(self) -> list[Cable]:
        return [self.scene_cable.cable]

    @property
    def size(self) -> float:
        """Of the coordinates, over the shortest element [-]: round-off shows in its constraints by that."""
        return float(np.abs(self.state.q).max() / self.scene_cable.cable.element_lengths.min())

    @property
    def cable_runs(self) -> list["CableRun"]:
        return [self]

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [self.start_correction]

    def damping_ratio(self, frequency: float) -> float:
        """Of a vibration of that frequency [rad/s]: bending damping grows with it, drag does not."""
        section = self.scene_cable.cable.section
        of_drag = self.drag_rate / frequency if frequency > 0.0 else 0.0
        if self._lag:
            return of_drag  # implicit damping does not bound the step
        return of_drag + frequency * section.bending_damping / section.bending_stiffness

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration; NaN if it is not found."""
        q = self.state.q.reshape(self.scene_cable.cable.reference.shape)
        if not self._stretches:
            return largest_frequency(self.system, self.loads.at(time), q.copy())
        with self.implicit_damping_left_out():
            return largest_frequency(self.system, self.loads.at(time), q.copy())

    def record(self, grid: TimeGrid, first: int, history: Array) -> int:
        """As `advance`, but displacements from the reference."""
        good = self.advance(grid, first, history)
        history[:good, 0] -= self.reference
        self._look_at_limit()
        return good

    @property
    def tension_by_mass(self) -> float:
        """Largest tension of an element over its rho_A l^2, at the last evaluation [1/s^2]; 0: no stretch."""
        return float((self._strains * self._stiffness_by_mass).max()) if self._stretches else 0.0

    @cached_property
    def _strains(self) -> Array:
        """(N,) of the elements; memory of the system."""
        return self.system.chain.elements["axial"][:, STRAIN]

    @cached_property
    def _stiffness_by_mass(self) -> Array:
        """(N,) EA over rho_A l^2 [1/s^2]."""
        section, lengths = self.scene_cable.cable.section, self.scene_cable.cable.element_lengths
        return (section.axial_stiffness or 0.0) / (section.mass_per_length * lengths**2)

    def take_means(self, h: float) -> None:
        """Let evaluations see mean axial forces of steps of h [s], from now on; 0: those of the state."""
        if self._stretches:
            set_step_of_means(h, self.system.chain.nodes, self.system.chain.elements)

    def tensions(self, time: float, displacements: Array, velocities: Array) -> list[Array]:
        """(N,) mean of each element in a state of this run, which then is the present one [N].

        Args:
            time: of the state [s].   displacements, velocities: (n_dof,).
        """
        self.state.q[:], self.state.v[:] = displacements + self.reference, velocities
        self.forget()
        self._start_scheme(self.called, self.loads.at(time), self.state)
        return [self.tension(self.state.a)]

    def tension(self, a: Array) -> Array:
        """(N,) mean of each element by the multipliers of the last evaluation, which gave a (n_dof,) [N].

        In the middle of elements, where the cable stretches.
        """
        cable, length = self.scene_cable.cable, self.system.chain.elements["multiplier"][:, 0]
        if self._stretches:
            return middle_tension(cable, self.system.chain, a.reshape(cable.reference.shape))
        nodal = nodal_multipliers_of(self.system, a.reshape(cable.reference.shape))
        return constraint_tension(cable, nodal, length)

    def figures(self) -> dict[str, float]:
        """How well constraints and energy were kept, and the step within its stability limit."""
        share = {"stepOverLimit": self._largest_share} if self._largest_share else {}
        return self.watch.figures() | share

    def _look_at_limit(self) -> None:
        """From time to time: the share that the step is of the present stability limit."""
        if self.control.steps - self._looked_after < STEPS_BETWEEN_LIMITS:
            return
        if not self.control.is_nominal or self.watch.trouble or self._lag or self._stretches:
            return
        self._looked_after = self.control.steps
        shape = self.scene_cable.cable.reference.shape
        frequency = self._tracker.frequency(self.state.q.reshape(shape), self.state.a.reshape(shape))
        self._largest_share = max(
            self._largest_share, self.control.present / self._stability_limit(frequency)
        )

    def verdict(self, time: float, h: float) -> str:
        """What went wrong in the last steps, and why; empty if all is well."""
        if not self.gave_up:
            return ""
        if self.jump:
            return f"{self.name}: {self.known_cause(time)}"
        if not self.watch.trouble:
            return f"{self.name}: {GIVEN_UP}."
        tried, taken = f"; {self.control.said}", self.control.present
        if self.watch.trouble == ENERGY:
            tried, taken = "", h
        limit = self._stability_limit(self.largest_frequency(time))
        said = self.known_cause(time) or explanation(
            self.integrator, self.trouble, taken, limit, self.is_scaled
        )
        return f"{self.name}: {self.watch.finding(self.state)}{tried}. {said}"

    def straight_cables(self) -> list[str]:
        """See `PacedRun.straight_cables`."""
        is_straight = is_held_straight(self.scene_cable.cable, self.state.q, (), PULLED)
        return [self.name] if is_straight else []

    def places(self, time: float) -> Array:
        """See `PacedRun.places`."""
        return self.loads.places(time)

    @property
    def names_of_places(self) -> list[str]:
        return self.loads.names_of_places

    def _stability_limit(self, frequency: float) -> float:
        if math.isnan(frequency):
            return math.nan
        limit = frequency_limit(self.integrator, self.scheme, self.damping_ratio(frequency))
        return limit / frequency if frequency > 0.0 else math.inf

    def require_independence(self) -> None:
        """RedundantConstraintError if constraints depend on each other; at the latest evaluation."""
        masses = element_masses(self.scene_cable.cable, self._implicit)
        require_independent(self.scene_cable, self.system, masses)
