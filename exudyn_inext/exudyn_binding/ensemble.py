"""SolveEnsemble: many parameter sets of one scene in one call, over all cores."""

import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice, tee
from typing import Any

import numpy as np
from tqdm import tqdm

from ..arrays import Array, as_slice
from ..checks import require_finite, require_integer
from ..integrators import find_integrator
from ..integrators.ensemble import record_members, stacked
from ..integrators.step_size import StepSizeBounds
from .arguments import explicit_settings, simulation_settings
from .cable_run import CableRun
from .ensemble_members import Member, all_systems, read_members, tightest_bounds
from .explicit_runs import scheme_of, wanted_step
from .settings import ExplicitSettings
from .time_grid import TimeGrid, grid_of_period

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
    SolveExplicit alone and the same step; numbers may differ between members (sections, lengths,
    supports, gravity, loads, initial states), the structure must not (dimension, number of elements,
    curvature measure, number of cables, links and load histories). Exudyn's time loop is not entered: sensors
    and files are not written, and the systems stay as they are.

    Args:
        systems: sequence of assembled mbs, or a function that builds one: f(parameters[i]) -> mbs.
        simulationSettings: exudyn.SimulationSettings; used are startTime, endTime, numberOfSteps (a
            lower bound of the number of outputs), solution.sensors.writePeriod, the output period, and
            verboseMode: from 1 on, progress and remaining time are shown.
        explicitSettings: as for SolveExplicit; without stepSize, the largest step that is safe for all
            members.
        parameters: one entry a member, handed to the function.
        derivatives: 0: coordinates only, 1: velocities, too, 2: accelerations, too.
        threads: number of threads; None: one a core.

    Returns:
        dict with 'times' (T,), 'coordinates' (members, T, n) and, if asked for, 'velocities' and
        'accelerations', in the order of mbs.systemData.GetODE2Coordinates(): displacements, to which
        'referenceCoordinates' (members, n) add up to positions and slopes; 'status' of each member, 'ok'
        or how it diverged, 'divergenceTimes' (members,), NaN for those that did not; a diverged member
        has NaN after the last output before the inspection that found it. And, as from SolveExplicit,
        'success' (of all), 'integrator', 'stepSize' [s], 'steps', 'decidedBy', 'bounds', besides 'threads'.

    Raises:
        InputError: no member, members of different structure (it says which differs in what).
        SceneError: a member contains what is not supported, or user functions that depend on the state.
        StepSizeError: stepSize is above the stability limit of a member.

    Example:
        result = SolveEnsemble(build, settings, ExplicitSettings(stepSize=1e-3), parameters=lengths)
    """
    settings = simulation_settings(simulationSettings)
    explicit = explicit_settings(explicitSettings)
    workers = _number_of_threads(threads)
    derivatives = require_integer("derivatives", derivatives, 0, 2)
    h = _grid(settings, explicit.stepSize).h if explicit.massScaling and explicit.stepSize else 0.0
    builders = all_systems(systems, parameters)
    time = require_finite("timeIntegration.startTime", settings.timeIntegration.startTime, "s")
    members = read_members(builders, time, h, explicit)
    wanted = explicit.stepSize
    if wanted is None:  # all members decide on it before the first one moves
        members, all_of_them = tee(members)
        wanted, _ = wanted_step(tightest_bounds([member.bounds for member in all_of_them]), explicit)
    ensemble = _Ensemble(len(builders), _grid(settings, wanted), explicit, derivatives + 1)
    silent = settings.timeIntegration.verboseMode < 1
    with tqdm(total=len(builders), desc="SolveEnsemble", unit="member", disable=silent) as progress:
        ensemble.solve(members, workers, progress.update)
    return ensemble.results() | {"threads": workers}


def _number_of_threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return require_integer("threads", threads, 1, MOST_THREADS, "; None for one a core")


def _grid(settings: Any, wanted: float) -> TimeGrid:
    return grid_of_period(settings, wanted, settings.solution.sensors.writePeriod)


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
    """Members from number `first`: their runs of cable number `cable`, and these stacked."""

    cable: int
    first: int
    runs: list[CableRun]
    systems: Any
    loads: Any
    states: Any
    watches: Any


class _Ensemble:
    """States of all members, while they are computed.

    grid: output intervals and steps.   states: (derivatives, members, T, n).
    bounds: of the members that have been started.
    """

    def __init__(self, number: int, grid: TimeGrid, explicit: ExplicitSettings, derivatives: int) -> None:
        self.grid = grid
        self.bounds: list[StepSizeBounds] = []
        self._explicit = explicit
        self._scheme = scheme_of(explicit)
        self._stages = find_integrator(explicit.integrator).stages
        self._number, self._derivatives = number, derivatives

    def solve(self, members: Iterator[Member], threads: int, done: Callable[[int], Any]) -> None:
        """Advance all members, `threads` at the same time; `done` is told how many have got to their end.

        The calling thread reads systems and samples loads while the others compute.
        """
        if threads == 1:
            for chunk in self._chunks(members, threads):
                done(self._advance(chunk))
            return
        pending: deque[Future[int]] = deque()
        with ThreadPoolExecutor(threads) as pool, _SHORT_TURNS:
            for chunk in self._chunks(members, threads):
                pending.append(pool.submit(self._advance, chunk))
                if len(pending) > 2 * threads:  # the chunks that wait hold memory
                    done(pending.popleft().result())
            for future in pending:
                done(future.result())

    def _chunks(self, members: Iterator[Member], threads: int) -> Iterator[_Chunk]:
        while len(self.bounds) < self._number:
            first = len(self.bounds)
            size = self._size_of_chunk(threads) if first else 1
            together = list(islice(members, size))
            if first == 0:
                self._allocate(together[0])
            self.bounds += [member.bounds for member in together]
            for cable in range(len(together[0].runs)):
                yield self._chunk(cable, first, [member.runs[cable] for member in together])

    def _allocate(self, member: Member) -> None:
        """Memory of all members, which are of the same size as the given one."""
        shape = (self._derivatives, self._number, self.grid.loop_steps + 1, member.size)
        self.states = np.full(shape, np.nan)
        self.reference = np.zeros((self._number, member.size))
        self._good = np.zeros((len(member.runs), self._number), dtype=int)  # intervals before a divergence
        outputs = self._derivatives * self.grid.loop_steps * member.size
        patterns = sum(len(run.loads.pattern) for run in member.runs)
        factors = self.grid.loop_steps * self.grid.substeps * len(self._stages) * patterns
        self._numbers_of_a_member = outputs + factors

    def _size_of_chunk(self, threads: int) -> int:
        fair = -(-self._number // (CHUNKS_OF_A_THREAD * threads))
        return max(1, min(fair, NUMBERS_IN_A_CHUNK // self._numbers_of_a_member))

    def _chunk(self, cable: int, first: int, runs: list[CableRun]) -> _Chunk:
        grid, steps = self.grid, self.grid.loop_steps * self.grid.substeps
        for number, run in enumerate(runs, first):
            self._start(number, run)
        return _Chunk(
            cable,
            first,
            runs,
            systems=stacked([run.system for run in runs]),
            loads=stacked([run.loads.sample(grid.start, grid.h, steps, self._stages) for run in runs]),
            states=stacked([run.state for run in runs]),
            watches=stacked([run.watch.watch for run in runs]),
        )

    def _start(self, number: int, run: CableRun) -> None:
        run.set_step(self.grid.h)
        run.start(self.grid.start)
        self.reference[number, run.indices] = run.reference
        first = (run.state.q - run.reference, run.state.v, run.state.a)
        for states, values in zip(self.states[:, number, 0], first, strict=False):
            states[run.indices] = values

    def _advance(self, chunk: _Chunk) -> int:
        """Compute the chunk's states and put them into their places, up to a divergence.

        Returns:
            Number of members that have got to their end: with the last one of their cables.
        """
        grid, run = self.grid, chunk.runs[0]
        shape = (len(self.states), len(chunk.runs), grid.loop_steps, len(run.indices))
        output = np.full(shape, np.nan)
        stacks = (chunk.systems, chunk.loads, chunk.states)
        good = np.zeros(len(chunk.runs), dtype=int)
        record_members(self._scheme, *stacks, grid.h, grid.substeps, chunk.watches, output, good)
        for member in np.flatnonzero(good < grid.loop_steps).tolist():
            good[member] = self._recorded_alone(chunk.runs[member], output[:, member])
        for member, run in enumerate(chunk.runs):
            number, places = chunk.first + member, as_slice(run.indices)
            output[0, member] -= run.reference
            self._good[chunk.cable, number] = good[member]
            self.states[:, number, 1 : good[member] + 1][..., places] = output[:, member, : good[member]]
        return len(chunk.runs) if chunk.cable == len(self._good) - 1 else 0

    def _recorded_alone(self, run: CableRun, output: Array) -> int:
        """Steps of a member that went wrong are rejected, as in a run of its own; returns its good intervals.

        output: (derivatives, intervals, n_dof) q, v, a.
        """
        grid = self.grid
        history = np.empty((grid.loop_steps, 3, len(run.indices)))
        good = run.record(self._scheme, grid, 0, history)
        history[:good, 0] += run.reference
        output[:, :good] = history[:good, : len(output)].swapaxes(0, 1)
        return good

    def results(self) -> dict[str, Any]:
        """What `SolveEnsemble` returns; of several cables, the first divergence ends their member."""
        grid, explicit = self.grid, self._explicit
        bounds = tightest_bounds(self.bounds)
        wanted, decided_by = wanted_step(bounds, explicit)
        ends = self._divergence_times()
        return {
            "success": bool(np.isnan(ends).all()),
            "times": np.array([grid.time(step) for step in range(grid.loop_steps + 1)]),
            **dict(zip(DERIVATIVES, self.states, strict=False)),
            "referenceCoordinates": self.reference,
            "status": [OK if np.isnan(end) else f"diverged before t = {end:.6g} s" for end in ends],
            "divergenceTimes": ends,
            "integrator": explicit.integrator,
            "stepSize": grid.h,
            "steps": grid.loop_steps * grid.substeps,
            "decidedBy": decided_by if grid.substeps > 1 or grid.h > 0.99 * wanted else "output period",
            "bounds": bounds,
        }

    def _divergence_times(self) -> Array:
        """(members,) NaN where there was none; later states are made NaN."""
        ends = np.full(self._number, np.nan)
        good = self._good.min(axis=0)
        for number in np.flatnonzero(good < self.grid.loop_steps):
            self.states[:, number, good[number] + 1 :] = np.nan
            ends[number] = self.grid.time(int(good[number]) + 1)
        return ends
