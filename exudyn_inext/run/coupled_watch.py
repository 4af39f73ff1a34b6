"""The watch over cables, bodies and joints that move together.

Exudyn's items do work along the way, which is counted step by step: that of linear springs exactly. A mass
that depends on the configuration changes the energy, too: the forces of Exudyn contain what its change does
to the momentum, of which the kinetic energy takes one half.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np

from ..arrays import Array
from ..cable.sparse_forms import mass_entries
from ..compiled import Prepared
from ..integrators.integrator import Integrator
from ..integrators.linear_stability import frequency_limit
from ..scene.path_work import (
    ADDED,
    FLIGHT,
    FLOOR,
    LACK,
    SCALE,
    SUMS,
    WAY,
    begin_path,
    expect_energy,
    follow,
    largest_throw,
    take_sums,
)
from ..system import KINETIC, POWER
from .cable_run import CableRun
from .flight import flight_of
from .moving_parts import Motions, motions_of, see, verdict_with_parts
from .run_watch import RunWatch
from .watch import (
    LACK_OF_WORK,
    MOST_TURN,
    NOT_FINITE,
    NOW,
    SMALL,
    SPRINGS,
    THROWN_OFF,
    TURNED,
    UNSTABLE,
    VIOLENT,
    Watch,
    build_watch,
    check_velocities,
    condemn,
    go_back,
    go_on,
    keep,
    open_account,
)

STEPS_BETWEEN = 1024  # two inspections at most
FIRST_STEPS = 4  # two inspections, which are further and further apart
STEPS_WITH_POWER = 32  # at most where damping or supports that move change the energy
SAMPLES = 64  # of a run, at least, where the frequency of its motion is judged
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
BENT = 0.1  # change of the power's rise, times the square of the time, over the energy, for fewer steps
STEPS_BETWEEN_CHECKS = 32  # at the velocities, at most; outputs are looked at, too
CALM = 16.0  # growth of their square since the last inspection that calls for another one
LENIENCE = 10.0  # of the energy: forces that jump, as those of contact do, have work between two steps
ROUND_OFF = 1e-10  # of the energy, relative to the forces times the extent
OF_PLACES = 1e3 * np.finfo(float).eps  # of places, relative to the extent
STEPS_BETWEEN_LOOKS = 8  # at the frequency of a step, which is looked at more often after an inspection
GROWTH = 0.1  # of a vibration in a step [-], that is unstable
# of counts: steps since the last inspection, and until the next one at most
_STEPS, _MOST = range(2)


class EvaluatedScene(Protocol):
    """A scene by whom evaluates it: Exudyn, or compiled code.

    forces: (n,) all but gravity on the coordinates at the last evaluation [N, Nm].
    """

    @property
    def forces(self) -> Array: ...

    def report_energy(self, t: float, state: Any, energy_report: Array, scale: float = np.inf) -> None:
        """Of all but the items' work, as `system.report_energy`; the state at t [s] was evaluated last.

        scale: of violated joints [m, -]; infinite: nobody looks at them.
        """

    def kinetic_energy(self, q: Array, v: Array) -> float:
        """With velocities v (n,) at q (n,), the state of the last evaluation [J]."""

    def energies_of_spins(self, duration: float) -> Array:
        """(size,) what a . M a / 2 lacks where bodies turn in space, at the last evaluation [J/s^2].

        (0,) where none do.   duration: of the run [s].
        """

    @property
    def fastest_turn(self) -> float:
        """Largest rate of springs that count turns, at the last evaluation [rad/s]; 0 where Exudyn does."""

    def leave_out_turns(self, way: Array) -> None:
        """Take whole turns off the angles of bodies in space, in place.   way: (n,)."""

    def violations(self, t: float, q: Array) -> Array:
        """(m,) of the rows of joints [m, -]."""

    def set_multipliers(self, cable: int, t: float, q: Array, v: Array) -> Array:
        """Accelerations of a cable, whose system then holds its multipliers.

        The scene has been evaluated at (t, q, v).
        """


class CoupledWatch(RunWatch):
    """Keeps the account of a coupled scene.

    Args:
        evaluated: the scene, by whom evaluates its steps.   scene: the scene.   runs: of its cables.
        state: of the integrator, whose steps follow a scheme.
        energy_tolerance: see `ExplicitSettings.energyTolerance`.

    flight: how the scene may fly along.
    path: memory of the work of whole steps.   before: (2, n) q and a at the start of the last step.
    path_of_evaluations: for `NativeItems.path` during steps; a lack of work within a step shows in it.
    has_one_evaluation: each step.
    after_each_step: what to call then.
    bears_throws: whether bodies may be thrown off by contact that the step does not resolve, as there is no
        smaller one.   thrown: the first time that one was: t [s], its speed [m/s], coordinate, and step [s].
    is_close: whether joints are moved in this step of the loop: its end is judged, as their power jumps from
        step to step.
    """

    is_close = False
    bears_throws = False
    _flies = False  # whether the frame does that sees the motion
    thrown: tuple[float, float, int, float] | None = None

    def __init__(
        self,
        evaluated: EvaluatedScene,
        scene: Any,
        runs: Sequence[CableRun],
        state: Any,
        integrator: Integrator,
        scheme: Any,
        energy_tolerance: float,
    ) -> None:
        self._runs = runs
        self.stretches = any(cable.stretches for run in runs for cable in run.cables)
        self._bodies = scene.system.parts[len(runs)]
        tolerance = LENIENCE * energy_tolerance
        most = VIOLENT * tolerance if integrator.stabilised else np.inf
        self.watch = build_watch(state, STEPS_BETWEEN, tolerance, most=most)
        self._draw_up = Prepared(verdict_with_parts)
        self._largest_throw, self._check_velocities = Prepared(largest_throw), Prepared(check_velocities)
        self._gravity = np.zeros(len(state.q))
        self._start = np.zeros(len(state.q))  # coordinates from which the extent of the motion counts
        self._places = scene.map.slices
        lengths = [cable.length for run in runs for cable in run.cables]
        self._length = max(lengths, default=0.0)
        self._has_contact, self._remembers = scene.native_items.has_contact, scene.native_items.remembers
        self._parts = self._moving_parts(scene.ways_of_flight)
        self.take_constants(state.q)
        self._energy_tolerance = energy_tolerance
        self._limit = frequency_limit(integrator, scheme, growth=GROWTH)
        self.before = np.zeros((2, len(state.q)))  # q and a at the start of the last step
        self._is_due = False  # a look at its frequency
        self.path = self.path_of_evaluations = scene.path  # the work of all but gravity
        self._paths = [self.path]
        self._changes = np.zeros(1)  # of masses since the last inspection, see `count_changes`
        self.after_each_step: list[Callable[[], None]] = []
        self.has_one_evaluation = integrator.evaluations(scheme) == 1
        if not self.has_one_evaluation:
            self.path = scene.path.copy()
            self._paths.insert(0, self.path)
            self.after_each_step += [partial(follow, self.path, state.q, scene.forces)]
        self._lacks = self.path_of_evaluations[SUMS]  # sums that tell of them, see `build_path`
        if scene.bodies_of_variable_mass:
            way = self.path[WAY, self._bodies.dofs]
            self.after_each_step += [partial(self._bodies.system.count_changes, way, self._changes)]
        self.evaluate_by(evaluated)
        self._scale = 1.0  # of violated joints [m, -]
        self._step = 0.0  # last one [s]
        self._resolution = 0.0  # energy of velocities of round-off, times the square of the step [J s^2]
        self._last = np.zeros(3)  # inspection: time [s], square of velocities, and see `_energy_of_flight`
        self._calm = 0.0  # largest square of velocities that calls for no other one
        self._counts = np.zeros(2, int)  # see _STEPS

    def take_constants(self, q: Array) -> None:
        """Constant loads on cables, changed at q (n,), up to which those before have done work."""
        before = self._gravity.copy()
        for run, dofs in zip(self._runs, self._places, strict=False):
            self._gravity[dofs] = run.loads.constant[: dofs.stop - dofs.start]
        self.watch.account["work"][NOW] += (before - self._gravity) @ (q - self.watch.position)

    def evaluate_by(self, evaluated: EvaluatedScene) -> None:
        """Ask this form of the scene from now on."""
        self._evaluated = evaluated

    def open(self, t: float, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        self.watch.flight[:] = speeds, _ = self.flight.along(state.v)
        self._flies, self.path[FLIGHT] = bool(speeds.any()), 0.0
        self._start[:] = state.q - t * speeds
        forces = self._begin_work(t, state)
        self._counts[:] = 0, FIRST_STEPS
        self._begin(t, state)
        extent = float(np.abs(state.q).max(initial=0.0))
        self._scale = max(1.0, extent)
        size = float(np.abs(forces + self._gravity[: len(forces)]).sum())
        floor = ROUND_OFF * extent * size + sum(run.watch.round_off for run in self._runs)
        floor += OF_PLACES * self._evaluated.kinetic_energy(state.q, speeds)
        seen = float(self.watch.present_report[KINETIC] - self._last[2])
        open_account(self.watch, state, floor, seen)
        self._parts.motion[:] = 0.0
        places = np.full(len(state.q), OF_PLACES * extent)
        self._resolution = self._evaluated.kinetic_energy(state.q, places)
        self._step = 0.0
        expect_energy(self.path_of_evaluations, self.turned_over, floor, self._energy_tolerance)

    def _set_step(self, h: float) -> None:
        """Round-off of places moves everything by velocities of that over h [s]."""
        self._step, account, floor = h, self.watch.account[NOW], self._resolution / h**2
        account.round_off = max(account.round_off, floor)
        account.unsure = max(account.unsure, floor)
        self._lacks[FLOOR] = max(self._lacks[FLOOR], floor)

    def _begin_work(self, t: float, state: Any) -> Any:
        """Count work from a state on; returns the forces of Exudyn's items in it."""
        self._evaluated.report_energy(t, state, self.watch.present_report)
        self._last[2] = self._energy_of_flight(state)
        forces = self._evaluated.forces
        for path in self._paths:
            begin_path(path, state.q, forces)
        self._bodies.system.begin_changes()
        self._changes[:] = 0.0
        return forces

    def begin_again(self, t: float, state: Any) -> None:
        """Go on from a state that the integrator has just started from, and whose velocities have changed."""
        if self._counts[_STEPS]:
            see(self._parts, self._way_to(t, state.q))
        self._counts[_MOST] = FIRST_STEPS
        self._begin_work(t, state)
        self._begin(t, state)
        self.watch.position[:] = state.q
        go_on(self.watch, state)

    @property
    def has_just_looked(self) -> bool:
        """Whether the last inspection was in the present state."""
        return not self._counts[_STEPS]

    def begin_from_impulses(self, t: float, state: Any) -> None:
        """Go on from a state at t [s] in which joints have got other velocities, whose account is open."""
        begin_path(self.path, state.q, self._evaluated.forces)
        self._counts[_MOST] = FIRST_STEPS
        self._begin(t, state)

    def go_on(self, t: float, state: Any) -> None:
        """With another step, from a state that the integrator has just started from, at t [s]."""
        if self._counts[_STEPS]:  # what has gone on counts, and is not judged any more
            indifferent = self.watch._replace(tolerance=np.inf, most=np.inf, phase=np.inf)
            self._verdict(indifferent, self._step, t, state)
        self._begin_work(t, state)
        self._counts[_MOST] = FIRST_STEPS
        self._begin(t, state)
        go_on(self.watch, state)

    @property
    def steps_ahead(self) -> int:
        """That may be taken before the next `is_well_at`."""
        steps, most = self._counts.tolist()
        return min(STEPS_BETWEEN_CHECKS, most - steps)

    def begin_steps(self, h: float) -> None:
        """Steps of h [s] are about to be taken."""
        if self._flies:
            self.path[FLIGHT, : len(self._start)] = h * self.watch.flight[0]

    def count(self, steps: int) -> None:
        """These steps have been taken."""
        before = int(self._counts[_STEPS])
        self._counts[_STEPS] = now = before + steps
        looks = before // STEPS_BETWEEN_LOOKS
        self._is_due = looks == 0 or looks < now // STEPS_BETWEEN_LOOKS

    def is_well_at(self, t: float, h: float, state: Any, at_once: bool = False) -> bool:
        """Judge the steps of h [s] until t [s] from time to time, and `at_once`, or if velocities grow."""
        if h != self._step:
            self._set_step(h)
        if self._lacks[LACK] > self._energy_tolerance:
            return self._condemn(state, LACK_OF_WORK, self._lacks[LACK])
        if self._lacks[ADDED] > self._energy_tolerance:
            return self._condemn(state, SPRINGS, self._lacks[ADDED])
        if self._is_due and (excess := self._excess(h, state)) > 1.0:
            return self._condemn(state, UNSTABLE, excess)
        if self._has_contact and (thrown := self._thrown(t, h, state)) and not self.bears_throws:
            return self._condemn(state, THROWN_OFF, thrown)
        if self._remembers and (turned := h * self._evaluated.fastest_turn) > MOST_TURN:
            return self._condemn(state, TURNED, turned)
        few = self._counts[_STEPS] < self._counts[_MOST] and not (self.is_close or at_once)
        if few and self._check_velocities(state.q, self._seen(state.v), state.a) <= self._calm:
            return True
        trouble = self._verdict(self.watch, h, t, state)
        self._lacks[SCALE] = max(self._lacks[SCALE], self.turned_over)
        self._begin(t, state)
        return not trouble

    def _thrown(self, t: float, h: float, state: Any) -> float:
        """Largest speed [m/s, 1/s] at which contact has thrown a body off lately, if it matters; else 0."""
        dofs = self._bodies.dofs
        ahead = 0.0 if self.bears_throws else h
        place, way = self._largest_throw(self.path, dofs.start, dofs.stop, state.a, ahead)
        length = self._length or float(np.abs(state.q).max(initial=0.0))  # no cables: how far away bodies are
        if not way * self.watch.duration > SMALL * length * h:
            return 0.0
        if self.bears_throws and self.thrown is None:
            self.thrown = t, way / h, place, h
        return float(way / h)

    def _shorten_interval(self) -> bool:
        soon = int(self._counts[_STEPS]) + FIRST_STEPS
        was_close = bool(self._counts[_MOST] <= soon)
        self._counts[_MOST] = soon
        return not was_close

    def look(self, state: Any) -> None:
        """Remember the state before the last step that is taken now."""
        self.before[0], self.before[1] = state.q, state.a

    def _excess(self, h: float, state: Any) -> float:
        """Largest frequency of the last step's motion over that up to which it is stable; 0 if it is quiet.

        With the change a of accelerations along the way x, w^2 = -(a . M a) / (a . M x) is a mean over the
        vibrations, by their energies -a . M x / 2, and so at most the square of their largest frequency.
        Strong implicit damping of axial vibrations turns accelerations round, too: these become smaller.
        """
        way = state.q - self.before[0] - h * self.watch.flight[0]
        change = (h / self._limit) ** 2 * (state.a - self.before[1])
        energy, least = self._evaluated.kinetic_energy, self._energy_tolerance * float(self._lacks[SCALE])
        least *= 2.0 * (h / self._limit) ** 2
        of_way, of_change = energy(state.q, way), energy(state.q, change)
        if not 2.0 * math.sqrt(abs(of_way * of_change)) > least:  # the product is no larger
            return 0.0
        product = of_way + of_change - energy(state.q, way + change)
        excess = math.sqrt(2.0 * of_change / product) if product > least else 0.0
        is_damped = self.stretches and excess > 1.0 and not self._grows(state)
        return 0.0 if is_damped else excess

    def _grows(self, state: Any) -> bool:
        """Whether accelerations have become larger in the last step."""
        after, before = (self._evaluated.kinetic_energy(state.q, a) for a in (state.a, self.before[1]))
        return bool(after > before)

    def _condemn(self, state: Any, trouble: int, excess: float) -> bool:
        condemn(self.watch, state, trouble, excess)
        return False

    def give_up(self, state: Any) -> None:
        """The last step could not be taken: the state is that of the last inspection."""
        self._condemn(state, NOT_FINITE, np.nan)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next inspections depend on, by names."""
        path = {"path": self.path, "lacks": self.path_of_evaluations, "changes": self._changes}
        masses = {"masses": self._bodies.system.masses_before(), "start": self._start}
        motion = {"motion": self._parts.motion, "last": self._last, "steps": self._counts}
        return super().memory() | path | masses | motion

    def resume(self, h: float) -> None:
        """Go on with the memory that has been set, after steps of h [s]."""
        self._step, self._flies = h, bool(self.watch.flight.any())
        self._calm = CALM * float(self._last[1])

    def _begin(self, t: float, state: Any) -> None:
        """Count steps from a state at t [s]."""
        self._counts[:] = 0, min(2 * self._counts[_MOST], self._most_steps)
        seen = self._seen(state.v)
        self._last[:2] = t, seen.dot(seen)
        self._calm = CALM * float(self._last[1])

    @property
    def _most_steps(self) -> int:
        """Until the next inspection; at odd times: one phase only is seen of vibrations of their period."""
        if self.watch.present_report[POWER]:
            return STEPS_WITH_POWER
        if not self.may_shorten:
            return STEPS_BETWEEN
        of_run = self.watch.duration / (SAMPLES * self._step) if self._step else 0.0
        odd = 1.0 - 0.5 * (GOLDEN * float(self.watch.account["steps"][NOW]) % 1.0)
        return int(odd * min(max(of_run, STEPS_WITH_POWER), STEPS_BETWEEN))

    def _verdict(self, watch: Watch, h: float, t: float, state: Any) -> int:
        self._evaluated.report_energy(t, state, self.watch.present_report, self._scale)
        duration, (work, scatter) = t - self._last[0], take_sums(self.path)
        if self.path is not self.path_of_evaluations:
            take_sums(self.path_of_evaluations)
        work += 0.5 * float(self._changes[0]) / h**2
        of_flight, speeds = self._energy_of_flight(state), self.watch.flight[0]
        work += of_flight - self._last[2] - duration * float(self._gravity @ speeds)
        self._last[2] = of_flight
        self._changes[:] = 0.0
        steps, slope = int(self._counts[_STEPS]), float(watch.account["slope"][NOW])
        spins, way = self._evaluated.energies_of_spins(watch.duration), self._way_to(t, state.q)
        bare = watch._replace(kept=())  # of one type for all integrators
        seen = float(self.watch.present_report[KINETIC]) - of_flight
        of_state = state.q, self._seen(state.v), state.a, seen
        given = self._parts, way, spins, h, bare, *of_state, self._gravity
        trouble = int(self._draw_up(*given, float(work), float(scatter), steps, float(duration)))
        bend = abs(float(watch.account["slope"][NOW]) - slope)
        if not self.is_close and bend * duration**2 > BENT * self.turned_over:
            self._counts[_MOST] = max(FIRST_STEPS, steps // 2) // 2  # `_begin` doubles it
        if trouble:
            go_back(watch, state)
        else:
            keep(watch, state)
        return trouble

    def _moving_parts(self, ways: Array) -> Motions:
        """Each cable and each body; first order states are no motion.   ways: of the `flight` of all."""
        part, bodies, masses = np.arange(ways.shape[1]), self._bodies, []
        for run, dofs in zip(self._runs, self._places, strict=False):
            part[dofs] = dofs.start
            masses.append((dofs.start, mass_entries(run.scene_cable.cable)))
        part[bodies.dofs] = bodies.dofs.start + bodies.system.bodies
        masses.append((bodies.dofs.start, bodies.system.mass_entries))
        of_all = [(first + rows, first + columns, values) for first, (rows, columns, values) in masses]
        rows, columns, values = map(np.concatenate, zip(*of_all, strict=True))
        self.flight = flight_of(ways, (rows, columns, values))
        return motions_of(part, (rows, columns, values), self._length)

    def _seen(self, v: Array) -> Array:
        """Velocities (n,) as the frame sees them that flies along."""
        return v - self.watch.flight[0] if self._flies else v

    def _energy_of_flight(self, state: Any) -> float:
        """Kinetic energy that it does not see [J]."""
        if not self._flies:
            return 0.0
        energy = self._evaluated.kinetic_energy
        return energy(state.q, state.v) - energy(state.q, self._seen(state.v))

    def _way_to(self, t: float, q: Array) -> Array:
        """(n,) from where the extent of the motion counts, so seen."""
        way: Array = q - t * self.watch.flight[0] - self._start
        self._evaluated.leave_out_turns(way)
        return way
