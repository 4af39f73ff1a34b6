"""CPU time of cases: warm-up, then repeated round robin, so that a busy spell hits all alike."""

import gc
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from exudyn_inext.errors import DivergenceError
from reference_models.trajectory import Case, Trajectory

OK = "ok"
DIVERGED = "diverged"


@dataclass(eq=False)
class Measurement:
    """Timed runs of one case.   cpu_seconds: one entry a timed run [s].   warm_up: of the first run [s]."""

    case: Case
    cpu_seconds: list[float] = field(default_factory=list)
    warm_up: float = 0.0
    trajectory: Trajectory | None = None
    status: str = OK

    @property
    def median(self) -> float | None:
        return statistics.median(self.cpu_seconds) if self.cpu_seconds else None

    @property
    def minimum(self) -> float | None:
        return min(self.cpu_seconds, default=None)


def measure(
    cases: Sequence[Case],
    repeats: int,
    advance: Callable[[str], None] = lambda label: None,
    repeats_of: Callable[[float], int] | None = None,
) -> list[Measurement]:
    """Run every case once untimed, then `repeats` rounds over all that have not failed.

    The warm-up takes compilation and caches out of the timing. A case that fails or diverges keeps
    its place, with its status and without further runs. `advance` hears of every run, skipped ones
    included: len(cases) * (repeats + 1) calls. `repeats_of` says, from the CPU time of the warm-up [s], in
    how many of the rounds a case takes part; default: in all.
    """
    measurements = [Measurement(case) for case in cases]
    with only_new_garbage():
        for completed in range(repeats + 1):
            for measurement in measurements:
                advance(measurement.case.label)
                wanted = repeats if repeats_of is None else repeats_of(measurement.warm_up)
                if measurement.status == OK and completed <= wanted:
                    _run_once(measurement)
    return measurements


def _run_once(measurement: Measurement) -> None:
    """Build, run, and record; the first run of a case is its warm-up."""
    is_warm_up = measurement.trajectory is None
    try:
        run = measurement.case.prepare()
        with garbage_collection_off():
            start = time.process_time()
            found = run()
            elapsed = time.process_time() - start
        trajectory = found if isinstance(found, Trajectory) else found()
    except DivergenceError as error:
        measurement.status = f"{DIVERGED}: {error}"
        return
    except Exception as error:  # a failing case must not take the other rows with it
        measurement.status = f"failed: {type(error).__name__}: {error}"
        return
    measurement.trajectory = trajectory
    if not trajectory.is_finite:
        measurement.status = DIVERGED
    elif is_warm_up:
        measurement.warm_up = elapsed
    else:
        measurement.cpu_seconds.append(elapsed)


@contextmanager
def only_new_garbage() -> Iterator[None]:
    """Inside, collections leave what is there already alone: modules and compilers are a million objects."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


@contextmanager
def garbage_collection_off() -> Iterator[None]:
    """As little else as possible inside of the block; garbage is collected before it."""
    gc.collect()
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
