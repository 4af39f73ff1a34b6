"""SolveEnsemble: many parameter sets of one scene in one call, over all cores."""

import os
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..integrators import find_integrator
from ..integrators.ensemble import record_members, stacked
from .cable_run import CableRun
from .ensemble_members import Member, read_members, tightest_bounds
from .explicit_runs import scheme_of, wanted_step
from .settings import ExplicitSettings
from .time_grid import TimeGrid, grid_of_period

NUMBERS_IN_A_CHUNK = 4_000_000  # coordinates and load factors that a thread handles at once
CHUNKS_OF_A_THREAD = 4  # so that threads end together
DERIVATIVES = ("coordinates", "velocities", "accelerations")
OK = "ok"


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
            lower bound of the number of outputs) and solution.sensors.writePeriod, the output period.
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
        has NaN after its last good output. And, as from SolveExplicit, 'success' (of all), 'integrator',
        'stepSize' [s], 'steps', 'decidedBy', 'bounds', besides 'threads'.

    Raises:
        InputError: no member, members of different structure (it says which differs in what).
        SceneError: a member contains what is not supported, or user functions that depend on the state.
        StepSizeError: stepSize is above the stability limit of a member.

    Example:
        result = SolveEnsemble(build, settings, ExplicitSettings(stepSize=1e-3), parameters=lengths)
    """
    settings = simulationSettings or exudyn.SimulationSettings()
    explicit = explicitSettings or ExplicitSettings()
    workers = _number_of_threads(threads)
    if derivatives not in (0, 1, 2) or isinstance(derivatives, bool):
        raise InputError(f"derivatives = {derivatives!r}: choose 0, 1 or 2.")
    h = _grid(settings, explicit.stepSize).h if explicit.massScaling and explicit.stepSize else 0.0
    start = float(settings.timeIntegration.startTime)
    members = read_members(systems, parameters, start, h, explicit)
    bounds = tightest_bounds(members)
    wanted, decided_by = wanted_step(bounds, explicit)
    ensemble = _Ensemble(members, _grid(settings, wanted), explicit, derivatives + 1)
    ensemble.solve(workers)
    grid = ensemble.grid
    return ensemble.results() | {
        "integrator": explicit.integrator,
        "stepSize": grid.h,
        "steps": grid.loop_steps * grid.substeps,
        "decidedBy": decided_by if grid.substeps > 1 or grid.h > 0.99 * wanted else "output period",
        "bounds": bounds,
        "threads": workers,
    }


def _number_of_threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise InputError(f"threads = {threads!r}: must be an integer >= 1, or None for one a core.")
    return threads


def _grid(settings: Any, wanted: float) -> TimeGrid:
    return grid_of_period(settings, wanted, settings.solution.sensors.writePeriod)


@dataclass(frozen=True, eq=False)
class _Chunk:
    """Some members, by their numbers, their runs of cable number `cable`, and stacks, see `stacked`."""

    cable: int
    numbers: range
    runs: list[CableRun]
    systems: Any
    loads: Any
    states: Any


class _Ensemble:
    """States of all members, while they are computed.

    grid: output intervals and steps.   states: (derivatives, members, T, n).
    """

    def __init__(
        self, members: Sequence[Member], grid: TimeGrid, explicit: ExplicitSettings, derivatives: int
    ) -> None:
        self.grid = grid
        self._members = members
        self._scheme = scheme_of(explicit)
        self._stages = find_integrator(explicit.integrator).stages
        intervals, size = grid.loop_steps, members[0].size
        self.states = np.full((derivatives, len(members), intervals + 1, size), np.nan)
        self.reference = np.zeros((len(members), size))
        self._good = np.full((len(members[0].runs), len(members)), intervals)  # before a divergence
        for number, member in enumerate(members):
            for run in member.runs:
                self._start(number, run)

    def _start(self, number: int, run: CableRun) -> None:
        run.start(self.grid.start)
        self.reference[number, run.indices] = run.reference
        first = (run.state.q - run.reference, run.state.v, run.state.a)
        for states, values in zip(self.states[:, number, 0], first, strict=False):
            states[run.indices] = values

    def solve(self, threads: int) -> None:
        """Advance all members, `threads` at the same time; loads are sampled by the calling thread."""
        if threads == 1:
            for chunk in self._chunks(threads):
                self._advance(chunk)
            return
        pending: deque[Future[None]] = deque()
        with ThreadPoolExecutor(threads) as pool:
            for chunk in self._chunks(threads):
                pending.append(pool.submit(self._advance, chunk))
                if len(pending) > 2 * threads:  # the chunks that wait hold memory
                    pending.popleft().result()
            for future in pending:
                future.result()

    def _chunks(self, threads: int) -> Iterator[_Chunk]:
        number = len(self._members)
        for cable in range(len(self._members[0].runs)):
            runs = [member.runs[cable] for member in self._members]
            size = min(-(-number // (CHUNKS_OF_A_THREAD * threads)), self._most_at_once(runs[0]))
            for first in range(0, number, size):
                numbers = range(first, min(first + size, number))
                yield self._chunk(cable, numbers, [runs[m] for m in numbers])

    def _most_at_once(self, run: CableRun) -> int:
        outputs = len(self.states) * self.grid.loop_steps * len(run.indices)
        factors = self.grid.loop_steps * self.grid.substeps * len(self._stages) * len(run.loads.pattern)
        return max(1, NUMBERS_IN_A_CHUNK // (outputs + factors))

    def _chunk(self, cable: int, numbers: range, runs: list[CableRun]) -> _Chunk:
        grid, steps = self.grid, self.grid.loop_steps * self.grid.substeps
        return _Chunk(
            cable,
            numbers,
            runs,
            systems=stacked([run.system for run in runs]),
            loads=stacked([run.loads.sample(grid.start, grid.h, steps, self._stages) for run in runs]),
            states=stacked([run.state for run in runs]),
        )

    def _advance(self, chunk: _Chunk) -> None:
        """Compute the chunk's states and put them into their places, up to a divergence."""
        grid, run = self.grid, chunk.runs[0]
        shape = (len(self.states), len(chunk.runs), grid.loop_steps, len(run.indices))
        output = np.full(shape, np.nan)
        stacks = (chunk.systems, chunk.loads, chunk.states)
        record_members(self._scheme, *stacks, grid.h, grid.substeps, output)
        for place, (number, run) in enumerate(zip(chunk.numbers, chunk.runs, strict=True)):
            history = output[:, place].transpose(1, 0, 2)
            history[:, 0] -= run.reference
            good = int(np.argmin(np.append(run.is_credible(history), False)))
            self._good[chunk.cable, number] = good
            self.states[:, number, 1 : good + 1][..., run.indices] = output[:, place, :good]

    def results(self) -> dict[str, Any]:
        """Arrays and statuses; of several cables, the first divergence ends their member."""
        grid = self.grid
        ends = np.full(len(self._members), np.nan)
        good = self._good.min(axis=0)
        for number in np.flatnonzero(good < grid.loop_steps):
            self.states[:, number, good[number] + 1 :] = np.nan
            ends[number] = grid.time(int(good[number]) + 1)
        times = np.array([grid.time(step) for step in range(grid.loop_steps + 1)])
        arrays: dict[str, Array] = dict(zip(DERIVATIVES, self.states, strict=False))
        return {
            "success": bool(np.isnan(ends).all()),
            "times": times,
            **arrays,
            "referenceCoordinates": self.reference,
            "status": [OK if np.isnan(end) else f"diverged before t = {end:.6g} s" for end in ends],
            "divergenceTimes": ends,
        }
