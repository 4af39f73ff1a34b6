"""SolveEnsemble: many parameter sets of one scene in one call, over all cores."""

import math
import os
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from itertools import tee
from typing import Any

import numpy as np

from ..arrays import Array, as_slice
from ..checks import require_finite, require_integer
from ..items.arguments import explicit_settings, simulation_settings
from ..run.cable_run import CableRun
from ..run.coupled_run import CoupledRun
from ..run.settings import ExplicitSettings
from ..run.step_choice import StepChoice, require_stable, warn_of_damping
from ..run.time_grid import TimeGrid, grid_of_period
from .bend_check import largest_turns, warn_of_turns
from .console import compile_notice
from .ensemble_members import Member, all_systems, read_members
from .kept_states import KeptStates
from .reports import EnsembleReport
from .stretch_check import left_out_stretch, warn_of_worst

MOST_WAITING = 8  # members for each thread, which hold memory
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
    """Explicit dynamics of many systems with equally many coordinates, in compiled code on all cores.

    For parameter sweeps and model-predictive control. Each member moves, bit for bit, as it would with
    SolveExplicit alone; where no step is given, each takes its own. Members may differ in all but the number
    of their coordinates. Exudyn's time loop is not entered: sensors and files are not written, and the
    systems stay as they are.

    Bodies, springs and joints among cables must all have compiled forms; accelerations are there those of
    SolveExplicit within round-off.

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
        InputError: no member, or members of different numbers of coordinates (it says which one).
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
    members = read_members(builders, time, duration, h, explicit, _grid(settings, math.inf, math.inf).h)
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
        self._stretch: list[tuple[float, str]] = []
        self._turns: list[tuple[float, str]] = []
        self._explicit = explicit
        self._number, self._derivatives = number, derivatives

    def solve(self, members: Iterable[Member], threads: int, done: Callable[[int], Any]) -> None:
        """Advance all members, `threads` at the same time; `done` is told of each that has got to its end.

        The calling thread reads systems while the others compute.
        """
        if threads == 1:
            for job in self._jobs(members):
                job()
                done(1)
            return
        pending: deque[Future[None]] = deque()
        with ThreadPoolExecutor(threads) as pool, _SHORT_TURNS:
            for job in self._jobs(members):
                pending.append(pool.submit(job))
                if len(pending) > MOST_WAITING * threads:
                    pending.popleft().result()
                    done(1)
            for future in pending:
                future.result()
                done(1)

    def _jobs(self, members: Iterable[Member]) -> Iterator[Callable[[], None]]:
        """What advances one member after the other."""
        for number, member in enumerate(members):
            if not number:
                self._allocate(member)
            self.choices.append(member.choice)
            yield partial(self._advance, number, member)

    def _allocate(self, member: Member) -> None:
        """Memory of all members, which are of the same size as the given one."""
        size = len(member.reference)
        self.states = np.full((self._derivatives, self._number, self.grid.loop_steps + 1, size), np.nan)
        self.reference = np.zeros((self._number, size))
        self._good = np.full(self._number, self.grid.loop_steps)  # intervals before a divergence
        self._steps = np.zeros(self._number, dtype=int)
        self._smallest = np.full(self._number, np.inf)  # steps [s]

    def _advance(self, number: int, member: Member) -> None:
        """Put the states of a member into their places, up to a divergence."""
        grid = self._grids(member.choice.h)
        self.reference[number] = member.reference
        for run in member.runs:
            run.set_step(grid.h)
            run.start(grid.start)
            kept_states = KeptStates(run)
            history = np.empty((grid.loop_steps + 1, 3, len(run.indices)))
            history[0] = run.state.q - run.reference, run.state.v, run.state.a
            good = run.record(grid, 0, history[1:])
            if isinstance(run, CoupledRun) and self._derivatives == len(DERIVATIVES):
                times = np.array([grid.time(k) for k in range(good + 1)])
                run.set_accelerations(times, history[: good + 1])
            if run.finding:
                self._findings.append(f"member {number} of the ensemble: {run.finding}")
            self._good[number] = min(good, self._good[number])
            self._steps[number] = max(run.control.steps, self._steps[number])
            self._smallest[number] = min(run.control.smallest, self._smallest[number])
            kept = history[: good + 1, : self._derivatives].swapaxes(0, 1)
            self.states[:, number, : good + 1][..., as_slice(run.indices)] = kept
            kept_states.keep(grid, 0, history[1 : good + 1])
            turns = largest_turns(kept_states)
            self._turns += [(turn, f"member {number} of the ensemble: {said}") for turn, said in turns]
            if number == 0 and isinstance(run, CableRun):  # the others ask Exudyn, which threads share
                self._stretch += left_out_stretch(kept_states)

    def results(self) -> dict[str, Any]:
        """What `SolveEnsemble` returns; of several cables, the first divergence ends their member."""
        grid, explicit = self.grid, self._explicit
        worst = _worst(self.choices)
        taken = grid.h if explicit.massScaling else 0.0
        require_stable(self.choices[worst].bounds_of_member(worst), explicit, taken)  # warns of it
        for finding in self._findings[:1]:
            warnings.warn(finding, stacklevel=3)
        warn_of_worst(self._stretch)
        warn_of_turns(self._turns)
        ends = self._divergence_times()
        return {
            "success": bool(np.isnan(ends).all()),
            "times": np.array([grid.time(step) for step in range(grid.loop_steps + 1)]),
            **dict(zip(DERIVATIVES, self.states, strict=False)),
            "referenceCoordinates": self.reference,
            "status": [OK if np.isnan(end) else f"diverged before t = {end:.6g} s" for end in ends],
            "divergenceTimes": ends,
            "integrator": explicit.integratorName,
            "stepSize": self._smallest,
            "steps": self._steps,
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
        for number in np.flatnonzero(self._good < self.grid.loop_steps):
            self.states[:, number, self._good[number] + 1 :] = np.nan
            ends[number] = self.grid.time(int(self._good[number]) + 1)
        return ends
