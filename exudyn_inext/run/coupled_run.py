"""Cables, bodies and joints of a scene, moved together: one right-hand side call for each evaluation."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, Places
from ..cable.cable import Cable
from ..cable.linked_cable import memory_of
from ..cable.support_forces import Solved
from ..errors import DivergenceError, OffCableError, RedundantConstraintError, SceneError
from ..integrators.integrator import Integrator, remembered
from ..scene.model import CableInScene
from ..scene.redundant_rows import NOT_FINITE
from ..system import accelerate_and_project, index_reduced_rates
from .cable_loads import CableLoads
from .cable_run import CableRun, Start
from .consistent_start import StartCorrection, agree
from .coupled_limits import SHARE, LimitedRun, steps_until_look
from .coupled_watch import LENIENCE, CoupledWatch
from .jump import Jumps
from .jump_ahead import JumpError
from .kept_state import KeptState
from .moved_by_exudyn import MovedByExudyn
from .moved_by_kernels import MovedByKernels
from .ramp import Line
from .redundancy import held_straight, with_straight_cables
from .step_control import Piece, StepControl
from .time_grid import TimeGrid

KERNELS, PARTS, EXUDYN = "kernels", "kernels of parts", "Exudyn"  # see `CoupledRun.evaluated_by`
ONE_STEP = 1e-6  # relative difference of a step from an interval of the loop that is one
SHORTER = 64.0  # step that is advised where contact throws bodies off
CHANGED = "items that were changed during the run"


class CoupledRun(LimitedRun):
    """All of a scene; see `CableRun` for what both kinds of runs offer.

    Args:
        scene: all of it.   cable_runs: of its cables.   method: integrator and scheme.
        start: as of a cable.
        why: what it contains, for messages.
    end_of_step: of the time loop [s], at which violated joints shall be fulfilled, for a run that takes over
        from another one; None: they are violated by at most the tolerance.
    cables: models of the inextensible cables.   start_corrections: one for each of them, and for joints.
    why_not: why Exudyn evaluates the scene; empty if it does not.
    """

    lenience = LENIENCE

    def __init__(
        self,
        scene: Any,
        cable_runs: Sequence[CableRun],
        method: tuple[Integrator, Any],
        start: Start,
        why: str,
        end_of_step: float | None = None,
    ) -> None:
        self._scene = scene
        self._runs = cable_runs
        self._why = why
        self.integrator, _ = method
        self._time = start.time
        self.indices, self.reference = scene.map.indices, scene.map.reference
        self.state: Any = self.integrator.allocate(scene.size, 1)
        self.state.q[:], self.state.v[:] = scene.initial_state
        for run, dofs, system in zip(cable_runs, scene.map.slices, scene.cable_systems, strict=False):
            run.adopt(system)
            self.state.q[dofs], self.state.v[dofs] = run.state.q, run.state.v
        scene.require_finite(self.state.v)
        size = max([float(np.abs(self.state.q).max(initial=0.0)), *(run.size for run in cable_runs)])
        self.scheme = self.integrator.for_size(method[1], size)
        method = self.integrator, self.scheme
        self.start_correction = StartCorrection()
        try:
            # where each step has one evaluation, at its end, loads may depend on the state there
            looks_at_ends = self.integrator.stages == (1.0,) and not self.integrator.stabilised
            form, self.why_not = scene.compiled(start.time, self.state.q, self.state.v, looks_at_ends)
            external = np.zeros(len(form.loads.constant) if form else 1)
            self.state = self.state._replace(external=external)
            given = scene, cable_runs, self.state, method
            self._move_by(MovedByKernels(form, *given) if form else MovedByExudyn(*given))
            if end_of_step is None:
                self._project(start)
            else:
                self._approach(start.time, end_of_step)
                self.mover.begin_by(agree, start.time)
        except RedundantConstraintError as error:
            raise self._explained(error) from None
        self.mover.compile_steps(start.time)
        self._fastest = np.zeros((2, 2, scene.size))
        self._depths = np.zeros((2, scene.native_items.remembered.size))
        self._rejects = start.explicit.rejectSteps
        self.control = StepControl(rejects=self._rejects)
        parts, tolerance = (scene, cable_runs, self.state), start.explicit.energyTolerance
        self.watch = CoupledWatch(self.mover.evaluated, *parts, *method, tolerance)
        if scene.friction.numbers:
            self.watch.after_each_step.append(scene.friction.look)

    def _explained(self, error: RedundantConstraintError) -> RedundantConstraintError:
        """What is said of joints at the start, or of a cable whose own constraints leave no number there."""
        if NOT_FINITE in str(error):
            try:
                for run in self._runs:
                    run.require_independence()
            except RedundantConstraintError as own:
                return own
        return with_straight_cables(error, held_straight(self._scene, self.state.q))

    def _move_by(self, mover: MovedByKernels | MovedByExudyn) -> None:
        self.mover = mover
        self.looks_ahead, self.elsewhere, self.data = mover.looks_ahead, mover.elsewhere, mover.data
        self.asks = mover.asks
        for name in ("_kept", "_jumps"):  # elsewhere is another place now
            self.__dict__.pop(name, None)

    def make_consistent(self, start: Start) -> None:
        """See `CableRun.make_consistent`."""
        scene, state = self._scene, self.state
        scene.require_finite(state.v)
        scene.native_items.forget()
        for run, dofs in zip(self._runs, scene.map.slices, strict=False):
            run.state.q[:], run.state.v[:] = state.q[dofs], state.v[dofs]
            run.make_consistent(start)
            state.q[dofs], state.v[dofs] = run.state.q, run.state.v
        self.forget()  # to look at violations has taught something, and not of this state
        self._project(start)

    def _project(self, start: Start) -> None:
        """Onto all constraints: impulses at the start meet the mass as it is, without scaling."""
        self._scene.take_hold(self.state.v, start.tolerance)
        with self.mover.mass_as_it_is():
            self.start_correction = self.mover.correct_start(start.time, start.tolerance)

    def holds(self, number: int) -> bool:
        """Whether the equations leave out the coordinate that this constraint holds."""
        return number in self._scene.held.numbers

    @property
    def cable_runs(self) -> Sequence[CableRun]:
        """Those of the inextensible cables, which move as its parts."""
        return self._runs

    @property
    def cables(self) -> list[Cable]:
        return self.mover.cables

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [run.start_correction for run in self._runs] + [self.start_correction]

    @property
    def completes(self) -> bool:
        return self._by_kernels

    @property
    def _by_kernels(self) -> bool:
        return isinstance(self.mover, MovedByKernels)

    def _leave_kernels(self, why: str) -> None:
        limit = self.explicit_limits[0]
        if self.damps_implicitly and self.watch.may_shorten:
            self._shorten_to(SHARE * limit)
        elif self.damps_implicitly:
            raise SceneError(
                f"{self.name}: Exudyn takes over because of {why}, and springs and their dashpots, which are "
                f"implicit among compiled items at steps of {self.control.present:.3g} s, would be explicit "
                f"(limit {limit:.3g} s): set stepSize below that, or let these be softer and damp less."
            )
        method = self.integrator, self.scheme
        self._scene.read_masses_again()
        self._move_by(MovedByExudyn(self._scene, self._runs, self.state, method))
        self.why_not = why

    @property
    def evaluated_by(self) -> str:
        """Who evaluates bodies and joints: KERNELS, PARTS (kernels, their forces alone) or EXUDYN."""
        return KERNELS if self._by_kernels else PARTS if self._scene.parts_in_one else EXUDYN

    def evaluate_by(self, kept: str) -> None:
        """Before `resume`: as the run did that this one continues; see `evaluated_by`."""
        if self._by_kernels and kept != KERNELS:
            self._leave_kernels(CHANGED)
            self.watch.evaluate_by(self._scene)
        if kept == EXUDYN and self._scene.parts_in_one:
            self._scene.leave_compiled_parts()

    def has_mean_forces(self, duration: float) -> bool:
        """As it is one step, which takes the mean of the forces at both ends, and counts their work so."""
        return self.integrator.stages == (1.0,) and abs(self.control.present / duration - 1.0) < ONE_STEP

    @property
    def ramp(self) -> dict[str, list[Any]]:
        return self.mover.ramp

    def take_ramp(self, kept: Mapping[str, Any]) -> None:
        self.mover.take_ramp(kept)

    def take_over(
        self,
        changed: Mapping[Any, Any],
        is_simple: bool,
        time: float,
        line: Line | None = None,
    ) -> None:
        """Go on from the present state, at `time` [s], with items that were changed.

        changed, line: see `MovedByExudyn.take_values`.
        is_simple: whether they are loads, springs, masses, and joints that are moved, only.
        """
        if is_simple and self.mover.take_values(changed, line):
            return
        if not self._by_kernels:
            if self._scene.parts_in_one:
                self._scene.leave_compiled_parts()
                self.__dict__.pop("_jumps", None)
                self.mover.begin_by(self.integrator.resume, time)
        else:
            self._leave_kernels(CHANGED)
            self.watch.evaluate_by(self._scene)
            self._scene.native_items.forget()
            self.mover.begin_by(self.integrator.resume, time)

    def take_weights(self, cables: Sequence[CableInScene]) -> bool:
        """Whether the run goes on with the present weights of cables, if no functions are new."""
        loads = [CableLoads(cable.among_others) for cable in cables]
        if not all(run.loads.has_functions_of(new) for run, new in zip(self._runs, loads, strict=True)):
            return False
        for run, new in zip(self._runs, loads, strict=True):
            run.loads.take_constants(new)
        self._take_constants()
        return True

    def set_weights(self, values: Mapping[int, Sequence[float]]) -> set[int]:
        """Let constant weights of cables be these from now on; returns which of them there are.

        values: (3,) [m/s^2], by numbers of loads.
        """
        found = set[int]().union(*(run.loads.change(values) for run in self._runs))
        self._take_constants()
        return found

    def _take_constants(self) -> None:
        """Constant loads on cables, which have been changed."""
        self.mover.take_constants()
        self.watch.take_constants(self.state.q)

    def scale_mass(self, theta: float, h: float) -> None:
        """See `CableRun.scale_mass`."""
        self.__dict__.pop("_rates", None)
        for run in self._runs:
            run.scale_mass(theta, h)

    def set_step(self, h: float) -> None:
        """Prepare the cables, and contact with them, for steps of h [s]."""
        self.control.present = h
        self.mover.set_step(h)

    def _approach(self, time: float, end: float) -> None:
        """Let joints that have been changed be fulfilled at `end` [s]."""
        if not self.mover.approach_joints(time, end):
            self._leave_kernels("joints that are being moved")
            self.mover.approach_joints(time, end)

    def accelerations(self, time: float, multipliers: Array) -> Array:
        """See `CableRun.accelerations`; neither extrapolated nor stabilised, as those of the steps are."""
        state, native_items, step = self.state, self._scene.native_items, self.control.present
        native_items.forget()
        parts = self._scene.parts_in_one
        solved = parts.solve(self.cables, native_items, time, step, state) if parts else self._solved(time)
        a, of_joints, forces = solved
        multipliers[:] = native_items.all_multipliers(of_joints, a)
        rows = (row[np.newaxis] for row in (state.q, state.v, forces, multipliers))
        self.mover.put_reactions(np.array([time]), np.array([step]), *rows)
        native_items.show(time, state, multipliers)
        return a[: len(self.indices)]

    def _solved(self, time: float) -> tuple[Array, Array, Array]:
        """See `CompiledParts.solve`."""
        a, rest = np.zeros((2, self._scene.size))
        arguments = self._scene.system, np.array([time]), self.state.q, self.state.v
        with self.mover.mass_as_it_is():
            if self.integrator.stabilised:
                accelerate_and_project(*arguments, 0.0, a, rest)
            else:
                index_reduced_rates(*arguments, a, rest)
        found = a, self._scene.system.multipliers, self._scene.joined_forces()
        if self.has_implicit_bending:
            self.mover.begin_by(self.integrator.resume, time)
        return found

    def solved(self, number: int, time: float, state: Sequence[Array], step: float) -> Solved | None:
        """See `CableRun.solved`; None: nobody has asked for forces then, see `Mover.joined_forces`."""
        forces = self.mover.joined_forces(time)
        if forces is None:
            return None
        k = [run.scene_cable.number for run in self._runs].index(number)
        return self._runs[k].solved_among(forces[self._scene.map.slices[k]], time, state, step)

    def tensions(self, time: float, displacements: Array, velocities: Array) -> list[Array]:
        """See `CableRun.tensions`; of all cables."""
        number, (q, v) = len(displacements), (self.state.q, self.state.v)
        q[:number], v[:number] = displacements + self.reference, velocities
        self.forget()
        self._scene.native_items.forget()
        self.mover.settle(time)
        self.mover.begin_by(self.integrator.start, time)
        found = []
        for k, (run, dofs) in enumerate(zip(self._runs, self._scene.map.slices, strict=False)):
            has_strains = run.scene_cable.cable.stretches
            a = self.state.a[dofs] if has_strains else self.mover.evaluated.set_multipliers(k, time, q, v)
            found.append(run.tension(a))
        return found

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; see `CableRun.start`."""
        self.forget()
        self.take_ramp({})
        self.state.a.fill(0.0)
        self.mover.settle(time)
        self.start_scheme(time)
        self.watch.open(time, self.state)
        for run in self._runs:
            run.require_independence()

    def begin_again(self, time: float) -> None:
        """As `start`, with supports that have been looked at, and axial forces of earlier steps.

        What has changed the energy is no error.
        """
        if not self._jumps.keep_means:
            self.forget()
        self.start_scheme(time)
        self.watch.begin_again(time, self.state)

    def move_on(self, time: float, end: float, has_changed: bool) -> None:
        """Begin again at `time` [s] with joints that move to where they have been set, or rest.

        end: of the step, in which they get there [s].   has_changed: whether they do.
        """
        was_compiled = self.is_compiled
        if has_changed:
            self._approach(time, end)
        else:
            self.mover.rest()
        self.watch.is_close = self.mover.approaches
        if self.watch.has_just_looked and self.mover.takes_impulses:
            if not self._jumps.keep_means:
                self.forget()
            given = self.mover.quick_system.called, self.mover.external_at(time), self.state
            self._jumps.take_impulses(*given, self.control.present, self.watch.watch)
            self.watch.begin_from_impulses(time, self.state)
            return
        with self.mover.loads_kept(time):
            self.mover.begin_by(agree, time)
            if was_compiled and not self._by_kernels:
                self.watch.evaluate_by(self._scene)
                self.mover.begin_by(self.integrator.resume, time)
            self.begin_again(time)

    def forget(self) -> None:
        self._scene.forget()
        for run in self._runs:
            run.forget()

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on; see `CableRun.memory`."""
        tracker = self._tracker
        return {
            "state": remembered(self.state),
            "scene": self._scene.memory(),
            "places": self.mover.places,
            "cables": self._corrections,
            "watch": self.watch.memory(),
            "control": self.control.memory() | ({"vibration": tracker.vibration} if tracker else {}),
            "friction": self._scene.friction.sums,
            "tilts": self._scene.tilted_angles.tilts,
            "depths": self._depths,
            "contacts": self.mover.contacts,
        }

    @cached_property
    def _corrections(self) -> dict[str, Any]:
        """Drift corrections and axial forces of the cables."""
        return {str(k): memory_of(system) for k, (system, _) in enumerate(self._scene.groups)}

    @cached_property
    def _jumps(self) -> Jumps:
        return Jumps(self._corrections, {"scene": self._scene.memory(), "cables": self._corrections})

    def resume(self, time: float) -> None:
        """Go on at `time` [s] with the memory that has been set."""
        if self.control.present:
            self.set_step(self.control.present)
        self._scene.native_items.forget()
        self.mover.look(time)
        self.mover.begin_by(self.integrator.resume, time)
        self.watch.resume(self.control.present)

    def record(self, grid: TimeGrid, first: int, history: Array) -> int:
        """See `CableRun.record`; where Exudyn evaluates its items, mbs is left in the state at the end."""
        self._scene.native_items.forget()
        self.mover.begin_record(len(history))
        with np.errstate(over="ignore", invalid="ignore"):  # of a run that diverges
            good = self.advance(grid, first, history)
        done = history[:good]
        places = done[:, 0]
        self.mover.end_record(grid, first, done)
        self._scene.tilted_angles.look(places)
        np.subtract(places, self.reference, out=places)
        return good

    @property
    def places_of_cables(self) -> list[tuple[slice, tuple[int, ...]]]:
        """See `CableRun.places_of_cables`."""
        places = zip(self._scene.map.slices, self.cables, strict=False)
        return [(dofs, cable.reference.shape) for dofs, cable in places]

    @property
    def places_of_nodes(self) -> dict[int, tuple[int, int]]:
        """See `CableRun.places_of_nodes`; of cables and bodies."""
        return self._scene.places_of_nodes

    def leave_mbs(self, who: str) -> None:
        """Do without mbs from now on.   who: asks, for messages.

        Raises:
            SceneError: Exudyn evaluates items of the scene.
        """
        if not isinstance(self.mover, MovedByKernels):
            raise SceneError(
                f"{who} needs compiled forms of all items, and Exudyn evaluates this scene because of "
                f"{self.why_not}: use SolveExplicit, or leave that item out."
            )
        self.mover.leave_mbs(who)

    @property
    def settable_forces(self) -> Array:
        """(n,) forces that act besides those of the items, and may be changed between steps."""
        return self.mover.given

    def complete(
        self, times: Array, rows: Places, history: Array, multipliers: Array, of_supports: bool = True
    ) -> bool:
        """See `CableRun.complete`."""
        steps = self.steps_before_rows(rows)
        return self.mover.complete(times, rows, steps, history, multipliers, of_supports)

    def set_accelerations(self, times: Array, history: Array) -> None:
        """See `MovedByKernels.set_accelerations`."""
        assert isinstance(self.mover, MovedByKernels)
        self.mover.set_accelerations(times, self.steps_before(len(times)), history)

    @property
    def is_compiled(self) -> bool:
        """Whether compiled code evaluates bodies and joints, at least."""
        return self._by_kernels or self._scene.parts_in_one is not None

    @property
    def is_steady(self) -> bool:
        """See `CableRun.is_steady`."""
        return self.mover.is_steady

    @property
    def asks_ahead(self) -> bool:  # type: ignore[override]
        return self.mover.asks_ahead

    @property
    def remembered(self) -> Array | None:  # type: ignore[override]
        return self.mover.remembered

    @cached_property
    def _kept(self) -> KeptState:
        """The state before the steps that are being taken."""
        return super().present_state()

    def present_state(self) -> KeptState:
        return self._kept.another()

    @cached_property
    def lightest_body(self) -> float:
        """Mass of the lightest one, or of its first coordinate [kg]; 0 if there is none."""
        bodies = self._scene.system.parts[len(self._runs)].system
        return float(min(bodies.masses[bodies.bodies], default=0.0))

    @property
    def has_implicit_bending(self) -> bool:
        return any(run.has_implicit_bending for run in self._runs)

    def reject(self, time: float, begins: bool) -> bool:
        """See `PacedRun.reject`; joints that cannot be solved for end the run."""
        try:
            return super().reject(time, begins)
        except RedundantConstraintError as error:
            self._unsolvable, self.gave_up = str(error), True
            return False

    def start_scheme(self, time: float) -> None:
        if not self._jumps.keep_means:
            self.mover.begin_by(self.integrator.start, time)
            return
        given = self.mover.quick_system, self.mover.external_at(time), self.state
        self._jumps.accelerate(*given, self.control.present)

    def watch_on(self, time: float) -> None:
        self.watch.go_on(time, self.state)

    def take(self, piece: Piece, history: Array) -> int:
        """See `PacedRun.take`; where Exudyn evaluates its items, all steps or none."""
        times = piece.times(self.integrator.stages)
        self.look_for_jumps(piece)
        self._kept.keep()
        done = kept = 0
        may_outrun = self.watch.stretches or self.mover.follows_contacts
        looks = self.watch.may_shorten and may_outrun
        looks_within = self._by_kernels or piece.intervals > 1
        while done < piece.steps:
            due = steps_until_look(self.control.steps + done) if looks else piece.steps
            end = min(done + self.watch.steps_ahead, piece.steps, done + due)
            if not self._goes_well(piece, times[done:end], done, history):
                self.trouble = self.integrator.trouble(self.scheme, self.watch.watch.kept)
                with self.watch.finding_kept():
                    self._kept.restore()
                return kept
            since = done if looks_within else 0
            is_due, done = not looks or end - done == due, end
            if self._by_kernels and done < piece.steps:
                self._kept.keep()
                kept = done
            is_due = is_due if looks_within else done == piece.steps
            if may_outrun and is_due and self.outruns_limit(piece, since, done):
                break
        return done

    def _goes_well(self, piece: Piece, times: Array, done: int, history: Array) -> bool:
        """Take steps of a piece, of which some are done; returns whether all is well.

        times: (steps, stages) of their evaluations [s].

        Raises:
            JumpError: something jumps in them, and they are the first ones of the piece.
        """
        self._unsolvable, end = "", done + len(times)
        is_checked = not piece.is_whole and end == piece.steps
        try:
            self.watch.begin_steps(piece.h)
            self.mover.take(piece, times, done, history, self.watch)
            self.watch.count(len(times))
            self.watch.bears_throws = not self.control.may_quarter
            return self.watch.is_well_at(piece.time(end), piece.h, self.state, is_checked)
        except JumpError as jump:
            if not done:
                raise
            self.stop_at(jump)
            return False
        except (DivergenceError, RedundantConstraintError, OffCableError) as error:
            self._unsolvable = "" if isinstance(error, DivergenceError) else str(error)
        except Exception as error:  # Exudyn's, in place of that of a user function
            if "OverflowError" not in str(error):
                raise
        self.watch.give_up(self.state)
        return False

    @property
    def finding(self) -> str:  # type: ignore[override]
        """Of steps that were too long, friction against Coulomb's law, axes that have tilted."""
        found = self._outrun, self._thrown, self._scene.friction.finding, self._scene.tilted_angles.finding
        return " ".join(filter(None, found))

    @property
    def _thrown(self) -> str:
        if self.watch.thrown is None:
            return ""
        t, speed, dof, h = self.watch.thrown
        return (
            f"at t = {t:.4g} s contact threw {self._scene.coordinate_name(self.indices[dof])} off at "
            f"{speed:.3g} m/s, faster than it came: it is too stiff or too damped for that mass at steps of "
            f"{h:.3g} s. Take stepSize = {h / SHORTER:.2g}, a heavier body, or contact that damps less."
        )

    def figures(self) -> dict[str, float]:
        """How well constraints and energy were kept."""
        return self.watch.figures()


Run = CableRun | CoupledRun
"""What the loop moves: a cable alone, or a scene."""
