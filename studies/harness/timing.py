"""CPU time in turn: warm-up, then rounds over all tasks, so that a busy spell hits all alike.

Each round begins with another task: what the caches hold after the task before differs by place.
"""

import gc
import math
import statistics
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from tqdm import tqdm

from exudyn_inext import DivergenceError, ExplicitStepper
from reference_models.trajectory import Case, Trajectory

from .reference import distance_to_reference
from .store import Row

OK = "ok"
DIVERGED = "diverged"

Prepare = Callable[[], Callable[[], Any]]
"""Builds what is needed, untimed, and returns what is timed."""
Task = Callable[[int], None]
"""Does its work that many times."""
RoundsOf = Callable[[float], float]


@dataclass(eq=False)
class Measurement:
    """Timed runs of a task: one entry each [s].

    warm_up: CPU time of the first run [s], which is not one of them.   found: what the last one returned.
    """

    prepare: Prepare
    cpu_seconds: list[float] = field(default_factory=list)
    wall_seconds: list[float] = field(default_factory=list)
    warm_up: float | None = None
    found: Any = None
    status: str = OK

    @property
    def median(self) -> float | None:
        return statistics.median(self.cpu_seconds) if self.cpu_seconds else None

    def run(self) -> None:
        """Prepare, and run once; the first time is the warm-up."""
        self.found = None  # its memory is used again
        task = self.prepare()
        gc.collect()
        start, cpu_start = time.perf_counter(), time.process_time()
        self.found = task()
        cpu, wall = time.process_time() - cpu_start, time.perf_counter() - start
        if self.warm_up is None:
            self.warm_up = cpu
        else:
            self.cpu_seconds.append(cpu)
            self.wall_seconds.append(wall)


def in_turn(
    tasks: Mapping[Any, Prepare],
    rounds: int,
    name: str,
    run: Callable[[Measurement], None] = Measurement.run,
    rounds_of: RoundsOf = lambda seconds: math.inf,
    turns: bool = True,
) -> dict[Any, Measurement]:
    """Run every task once untimed (compilation, caches), then in so many rounds.

    Args:
        tasks: by label.   rounds: over all of them.   name: of the progress bar.
        run: runs one once; after a status that is not OK there are no further runs.
        rounds_of: from the CPU time of the warm-up [s], in how many of the rounds a task takes part.
        turns: whether each round begins with another task.
    """
    measurements = {label: Measurement(prepare) for label, prepare in tasks.items()}
    order = deque(measurements.items())
    runs = len(tasks) * (rounds + 1)
    with without_garbage_collection(), tqdm(total=runs, desc=name, unit="run") as progress:
        for completed in range(rounds + 1):
            for label, measurement in order:
                progress.set_postfix_str(str(label)[:48])
                if measurement.status == OK and completed <= rounds_of(measurement.warm_up or 0.0):
                    run(measurement)
                progress.update()
            order.rotate(-1 if turns and completed else 0)
    return measurements


def measure(
    cases: Sequence[Case],
    repeats: int,
    reference: Trajectory,
    name: str = "",
    rounds_of: RoundsOf = lambda seconds: math.inf,
) -> list[tuple[Row, Trajectory | None]]:
    """Row and trajectory of each case; one that fails or diverges keeps its place, with its status.

    Raises:
        ValueError: equal labels.
    """
    labels = [case.label for case in cases]
    if repeated := {label for label in labels if labels.count(label) > 1}:
        raise ValueError(f"labels {sorted(repeated)} occur more than once; make them distinct.")
    tasks = {case.label: case.prepare for case in cases}
    found = in_turn(tasks, repeats, name, _run_case, rounds_of)
    pairs = [(case, found[case.label]) for case in cases]
    return [(row_of(case, measurement, reference), measurement.found) for case, measurement in pairs]


def _run_case(measurement: Measurement) -> None:
    """Once, with what becomes of it."""
    timed = len(measurement.cpu_seconds)
    try:
        measurement.run()
        found = measurement.found
        measurement.found = found = found if isinstance(found, Trajectory) else found()
        is_finite = found.is_finite
    except DivergenceError as error:
        measurement.status = f"{DIVERGED}: {error}"
    except Exception as error:  # a failing case must not take the other rows with it
        measurement.status = f"failed: {type(error).__name__}: {error}"
    else:
        measurement.status = OK if is_finite else DIVERGED
    if measurement.status != OK:
        del measurement.cpu_seconds[timed:]


def row_of(case: Case, measurement: Measurement, reference: Trajectory) -> Row:
    """As it is stored; times and errors of a failed case are None."""
    ended = measurement.status == OK and measurement.found is not None
    error = distance_to_reference(measurement.found, reference) if ended else None
    known = error is not None and math.isfinite(error.maximum)
    return {
        "label": case.label,
        "formulation": case.formulation,
        "integrator": case.integrator,
        "elements": case.elements,
        "stepSize": case.step_size,
        "steps": case.steps,
        "cpuSeconds": measurement.median,
        "cpuSecondsMin": min(measurement.cpu_seconds, default=None),
        "repeats": len(measurement.cpu_seconds),
        "errorMax": error.maximum if known else None,
        "errorRms": error.rms if known else None,
        "status": measurement.status,
        **case.details,
    }


def steps_task(stepper: ExplicitStepper, kept: Any = None) -> Task:
    """Steps in one compiled call, from the start of the motion.   kept: what must live as long."""

    def task(times: int, kept: Any = kept) -> None:
        stepper.Start()
        stepper.Step(times)

    return task


def sampled(
    tasks: Mapping[Any, Task], rounds: int, least_seconds: float, name: str = "timing"
) -> dict[Any, Measurement]:
    """Each task, repeated in a sample as often as takes `least_seconds`; its CPU times are those of once."""
    times = {label: _times_of(task, least_seconds) for label, task in tasks.items()}
    found = in_turn(
        {label: partial(partial, task, times[label]) for label, task in tasks.items()}, rounds, name
    )
    for label, one in found.items():
        one.cpu_seconds = [max(seconds, 1e-9) / times[label] for seconds in one.cpu_seconds]
    return found


def _times_of(task: Task, least_seconds: float) -> int:
    task(1)
    times, seconds = 1, 0.0
    while not seconds > 0.2 * least_seconds:
        times, start = 4 * times if seconds else times, time.process_time()
        task(times)
        seconds = max(time.process_time() - start, 1e-9)
    return max(1, round(times * least_seconds / seconds))


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """Inside, garbage is collected between runs only, of new objects: modules and compilers are a million."""
    was_enabled = gc.isenabled()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if was_enabled:
            gc.enable()
