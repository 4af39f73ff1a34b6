"""SolveEnsemble: many parameter sets of one scene in one call, over all cores."""

import os
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from itertools import groupby, islice, tee
from typing import Any

import numpy as np

from ..arrays import Array, as_slice
from ..called_system import addresses_of
from ..checks import require_finite, require_integer
from ..items.arguments import explicit_settings, simulation_settings
from ..run.cable_run import CableRun
from ..run.coupled_run import CoupledRun, Run
from ..run.members import record_members, stacked
from ..run.settings import ExplicitSettings
from ..run.step_choice import StepChoice, require_stable, warn_of_damping
from ..run.time_grid import TimeGrid, grid_of_period
from .console import compile_notice
from .ensemble_members import Member, all_systems, read_members
from .reports import EnsembleReport

NUMBERS_IN_A_CHUNK = 4_000_000  # coordinates and load factors that a thread handles at once
CHUNKS_OF_A_THREAD = 8  # so that threads begin at once and end together
TURN = 1e-4  # of a thread that holds Python's lock [s]; the usual 5 ms cost a tenth of the gain of two cores
DERIVATIVES = ("coordinates", "velocities", "accelerations")
OK = "ok"
MOST_THREADS = 1024


def SolveEnsemble(
    systems: Any,
    simulationSettings: Any = None,
    explicitSettings: ExplicitSettings | None = None,
    parameters: Iterable[Any] | None = None,
    derivatives: int = 0,
    threads: int | None = None,
) -> dict[str, Any]:
    """Explicit dynamics of many systems of the same structure, in compiled code on all cores.

    For parameter sweeps and model-predictive control. Each member moves, bit for bit, as it would with
    SolveExplicit alone; where no step is given, each takes its own. Numbers may differ between members
    (sections, lengths, supports, gravity, loads, initial states), the structure must not (dimension, number
    of elements, curvature measure, number of cables, links and load histories). Exudyn's time loop is not
    entered: sensors and files are not written, and the systems stay as they are.

    Among bodies, springs and joints, all of which must have compiled forms, and with adaptiveStep, each
    thread moves one member after the other; accelerations among bodies are those of SolveExplicit within
    round-off.

    Args:
        systems: sequence of assembled mbs, or a function that builds one: f(parameters[i]) -> mbs.
        simulationSettings: exudyn.SimulationSettings; used are startTime, endTime, numberOfSteps (a
            lower bound of the number of outputs), solution.sensors.writePeriod, the output period, and
            verboseMode: from 1 on, progress and remaining time are shown, if tqdm is installed.
        explicitSettings: as for SolveExplicit.
        parameters: one entry a member, handed to the function.
        derivatives: 0: coordinates only, 1: velocities, too, 2: accelerations, too.
        threads: number of threads; None: one a core.

    Returns:
        dict, which prints as a summary, with 'times' (T,), 'coordinates' (members, T, n) and, if asked for,
        'velocities' and 'accelerations', in the order of mbs.systemData.GetODE2Coordinates(): displacements,
        to which 'referenceCoordinates' (members, n) add up to positions and slopes; 'status' of each member,
        'ok' or how it diverged, 'divergenceTimes' (members,), NaN for those that did not; a diverged member
        has NaN after the last output before the inspection that found it. And, as from SolveExplicit,
        'success' (of all) and 'integrator', besides 'threads'; of each member 'stepSize' [s], 'steps',
        'massScaling', 'decidedBy' and 'bounds'.

    Raises:
        InputError: no member, members of different structure (it says which differs in what).
        SceneError: a member contains what is not supported, or items that only Exudyn can evaluate, such as
            user functions that depend on the state.
        StepSizeError: stepSize is above the stability limit of a member.

    Example:
        result = SolveEnsemble(build, settings, ExplicitSettings(stepSize=1e-3), parameters=lengths)
    """
    settings = simulation_settings(simulationSettings)
    explicit = explicit_settings(explicitSettings)
    workers = _number_of_threads(threads)
    derivatives = require_integer("derivatives", derivatives, 0, 2)
    smallest = explicit.stepSize
    h = _grid(settings, smallest, smallest).h if explicit.massScaling and smallest else 0.0
    builders = all_systems(systems, parameters)
    time = require_finite("timeIntegration.startTime", settings.timeIntegration.startTime, "s")
    duration = float(settings.timeIntegration.endTime) - time
    members = read_members(builders, time, duration, h, explicit)
    silent = settings.timeIntegration.verboseMode < 1
    with compile_notice(settings):
        if smallest is None:  # outputs at every step are those of the shortest one
            members, all_of_them = tee(members)
            choices = [member.choice for member in all_of_them]
            worst = _worst(choices)
            named = replace(choices[worst], bounds=choices[worst].bounds_of_member(worst))
            warn_of_damping(named, duration)
            smallest = min(choice.h for choice in choices)
        grids = partial(_grid, settings, smallest)
        ensemble = _Ensemble(len(builders), grids, smallest, explicit, derivatives + 1)
        with _progress(len(builders), silent) as count:
            ensemble.solve(members, workers, count)
    return EnsembleReport(ensemble.results(), threads=workers)


@contextmanager
def _progress(members: int, silent: bool) -> Iterator[Callable[[int], Any]]:
    """A bar that counts members, where it is wanted and tqdm is installed, as in Exudyn's own sweeps."""
    if silent or find_spec("tqdm") is None:
        yield lambda done: None
        return
    from tqdm import tqdm

    with tqdm(total=members, desc="SolveEnsemble", unit="member") as bar:
        yield bar.update


def _number_of_threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return require_integer("threads", threads, 1, MOST_THREADS, "; None for one a core")


def _grid(settings: Any, smallest: float, wanted: float) -> TimeGrid:
    """Of a member whose step is at most `wanted` [s]; outputs as for the `smallest` step of all [s]."""
    return grid_of_period(settings, wanted, settings.solution.sensors.writePeriod or smallest)


def _worst(choices: list[StepChoice]) -> int:
    """The member with the smallest stability limit."""
    return min(range(len(choices)), key=lambda number: choices[number].bounds.stability_limit)


class _ShortTurns:
    """Threads that are done computing must not wait for Python's lock while another one reads systems.

    The first of ensembles that overlap makes the turns short, the last one puts them back.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._ensembles = 0
        self._before = 0.0  # [s]

    def __enter__(self) -> None:
        with self._lock:
            if self._ensembles == 0:
                self._before = sys.getswitchinterval()
                sys.setswitchinterval(min(TURN, self._before))
            self._ensembles += 1

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._ensembles -= 1
            if self._ensembles == 0:
                sys.setswitchinterval(self._before)


_SHORT_TURNS = _ShortTurns()


@dataclass(frozen=True, eq=False)
class _Chunk:
    """Members from number `first`: their runs of cable number `cable`, and these stacked; of one grid."""

    grid: TimeGrid
    cable: int
    first: int
    runs: list[CableRun]
    loads: Any
    states: Any
    watches: Any


class _Ensemble:
    """States of all members, while they are computed.

    grid: output intervals, and steps of `smallest` [s].   states: (derivatives, members, T, n).
    choices: of the members that have been started.
    """

    def __init__(
        self,
        number: int,
        grids: Callable[[float], TimeGrid],
        smallest: float,
        explicit: ExplicitSettings,
        derivatives: int,
    ) -> None:
        self._grids, self.grid = grids, grids(smallest)
        self.choices: list[StepChoice] = []
        self._findings: list[str] = []
        self._explicit = explicit
        integrator, self._scheme = explicit.method
        self._stages = integrator.stages
        self._number, self._derivatives = number, derivatives

    def solve(self, members: Iterator[Member], threads: int, done: Callable[[int], Any]) -> None:
        """Advance all members, `threads` at the same time; `done` is told how many have got to their end.

        The calling thread reads systems and samples loads while the others compute.
        """
        if threads == 1:
            for chunk in self._chunks(members, threads):
                done(chunk())
            return
        pending: deque[Future[int]] = deque()
        with ThreadPoolExecutor(threads) as pool, _SHORT_TURNS:
            for chunk in self._chunks(members, threads):
                pending.append(pool.submit(chunk))
                if len(pending) > 2 * threads:  # the chunks that wait hold memory
                    done(pending.popleft().result())
            for future in pending:
                done(future.result())

    def _chunks(self, members: Iterator[Member], threads: int) -> Iterator[Callable[[], int]]:
        """Functions that advance some members, and return how many have got to their end."""
        while len(self.choices) < self._number:
            size = self._size_of_chunk(threads) if self.choices else 1
            together = list(islice(members, size))
            if not self.choices:
                self._allocate(together[0])
            for grid, alike in groupby(together, key=lambda member: self._grids(member.choice.h)):
                first, group = len(self.choices), list(alike)
                self.choices += [member.choice for member in group]
                for cable in range(len(group[0].runs)):
                    yield self._job(grid, cable, first, [member.runs[cable] for member in group])

    def _allocate(self, member: Member) -> None:
        """Memory of all members, which are of the same size as the given one."""
        shape = (self._derivatives, self._number, self.grid.loop_steps + 1, member.size)
        self.states = np.full(shape, np.nan)
        self.reference = np.zeros((self._number, member.size))
        self._good = np.zeros((len(member.runs), self._number), dtype=int)  # intervals before a divergence
        self._steps = np.zeros((len(member.runs), self._number), dtype=int)
        self._smallest = np.zeros((len(member.runs), self._number))  # steps [s]
        outputs = self._derivatives * self.grid.loop_steps * member.size
        patterns = sum(len(run.loads.pattern) for run in member.runs if isinstance(run, CableRun))
        factors = self.grid.loop_steps * self.grid.substeps * len(self._stages) * patterns
        self._numbers_of_a_member = outputs + factors

    def _size_of_chunk(self, threads: int) -> int:
        fair = -(-self._number // (CHUNKS_OF_A_THREAD * threads))
        return max(1, min(fair, NUMBERS_IN_A_CHUNK // self._numbers_of_a_member))

    def _job(self, grid: TimeGrid, cable: int, first: int, runs: Sequence[Any]) -> Callable[[], int]:
        """Advances runs of members from number `first` on: all at once, or whole scenes one by one."""
        if isinstance(runs[0], CableRun) and not self._explicit.adaptiveStep:
            return partial(self._advance, self._chunk(grid, cable, first, list(runs)))
        return partial(self._advance_one_by_one, grid, cable, first, runs)

    def _advance_one_by_one(self, grid: TimeGrid, cable: int, first: int, runs: Sequence[Run]) -> int:
        """As `_advance`, for cables among bodies, and for steps that adapt."""
        for number, run in enumerate(runs, first):
            self._start(grid, number, run)
            history = np.empty((grid.loop_steps + 1, 3, len(run.indices)))
            history[0] = run.state.q - run.reference, run.state.v, run.state.a
            good = run.record(grid, 0, history[1:])
            if isinstance(run, CoupledRun) and len(self.states) == len(DERIVATIVES):
                times = np.array([grid.time(k) for k in range(good + 1)])
                run.set_accelerations(times, history[: good + 1])
            if run.finding:
                self._findings.append(f"member {number} of the ensemble: {run.finding}")
            place = cable, number
            self._good[place] = good
            self._steps[place], self._smallest[place] = run.control.steps, run.control.smallest
            kept = history[: good + 1, : len(self.states)].swapaxes(0, 1)
            self.states[:, number, : good + 1][..., as_slice(run.indices)] = kept
        return self._ended(cable, runs)

    def _ended(self, cable: int, runs: Sequence[Any]) -> int:
        """How many members have got to their end with these runs: with the last one of their cables."""
        return len(runs) if cable == len(self._good) - 1 else 0

    def _chunk(self, grid: TimeGrid, cable: int, first: int, runs: list[CableRun]) -> _Chunk:
        for number, run in enumerate(runs, first):
            self._start(grid, number, run)
        piece = runs[0].control.whole_intervals(grid, 0, grid.loop_steps)
        self._steps[cable, first : first + len(runs)] = piece.steps
        self._smallest[cable, first : first + len(runs)] = grid.h
        return _Chunk(
            grid,
            cable,
            first,
            runs,
            loads=stacked([run.loads.sample(piece, self._stages) for run in runs]),
            states=stacked([run.state for run in runs]),
            watches=stacked([run.watch.watch for run in runs]),
        )

    def _start(self, grid: TimeGrid, number: int, run: Run) -> None:
        run.set_step(grid.h)
        run.start(grid.start)
        self.reference[number, run.indices] = run.reference
        first = (run.state.q - run.reference, run.state.v, run.state.a)
        for states, values in zip(self.states[:, number, 0], first, strict=False):
            states[run.indices] = values

    def _advance(self, chunk: _Chunk) -> int:
        """Compute the chunk's states and put them into their places, up to a divergence.

        Returns:
            See `_ended`.
        """
        grid, run = chunk.grid, chunk.runs[0]
        shape = (len(self.states), len(chunk.runs), grid.loop_steps, len(run.indices))
        output = np.full(shape, np.nan)
        systems = addresses_of([run.called for run in chunk.runs])
        stacks = systems, run.called.functions, chunk.loads, chunk.states
        good = np.zeros(len(chunk.runs), dtype=int)
        record_members(self._scheme, *stacks, grid.h, grid.substeps, chunk.watches, output, good)
        for member in np.flatnonzero(good < grid.loop_steps).tolist():
            good[member] = self._recorded_alone(chunk, member, output[:, member])
        for member, run in enumerate(chunk.runs):
            number, places = chunk.first + member, as_slice(run.indices)
            output[0, member] -= run.reference
            self._good[chunk.cable, number] = good[member]
            self.states[:, number, 1 : good[member] + 1][..., places] = output[:, member, : good[member]]
        return self._ended(chunk.cable, chunk.runs)

    def _recorded_alone(self, chunk: _Chunk, member: int, output: Array) -> int:
        """Steps of a member that went wrong are rejected, as in a run of its own; returns its good intervals.

        output: (derivatives, intervals, n_dof) q, v, a.
        """
        grid, run, place = chunk.grid, chunk.runs[member], (chunk.cable, chunk.first + member)
        run.forget()
        run.resume(grid.start)
        history = np.empty((grid.loop_steps, 3, len(run.indices)))
        good = run.advance(grid, 0, history)
        self._steps[place], self._smallest[place] = run.control.steps, run.control.smallest
        output[:, :good] = history[:good, : len(output)].swapaxes(0, 1)
        return good

    def results(self) -> dict[str, Any]:
        """What `SolveEnsemble` returns; of several cables, the first divergence ends their member."""
        grid, explicit = self.grid, self._explicit
        worst = _worst(self.choices)
        taken = grid.h if explicit.massScaling else 0.0
        require_stable(self.choices[worst].bounds_of_member(worst), explicit, taken)  # warns of it
        for finding in self._findings[:1]:
            warnings.warn(finding, stacklevel=3)
        ends = self._divergence_times()
        return {
            "success": bool(np.isnan(ends).all()),
            "times": np.array([grid.time(step) for step in range(grid.loop_steps + 1)]),
            **dict(zip(DERIVATIVES, self.states, strict=False)),
            "referenceCoordinates": self.reference,
            "status": [OK if np.isnan(end) else f"diverged before t = {end:.6g} s" for end in ends],
            "divergenceTimes": ends,
            "integrator": explicit.integratorName,
            "stepSize": self._smallest.min(axis=0),
            "steps": self._steps.max(axis=0),
            "massScaling": np.array([choice.theta for choice in self.choices]),
            "decidedBy": [self._decided_by(choice) for choice in self.choices],
            "bounds": [choice.bounds for choice in self.choices],
        }

    def _decided_by(self, choice: StepChoice) -> str:
        grid = self._grids(choice.h)
        return choice.decider(grid.substeps, grid.h, "output period")

    def _divergence_times(self) -> Array:
        """(members,) NaN where there was none; later states are made NaN."""
        ends = np.full(self._number, np.nan)
        good = self._good.min(axis=0)
        for number in np.flatnonzero(good < self.grid.loop_steps):
            self.states[:, number, good[number] + 1 :] = np.nan
            ends[number] = self.grid.time(int(good[number]) + 1)
        return ends
