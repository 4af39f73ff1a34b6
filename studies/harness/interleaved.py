"""Time of short tasks: samples round robin, so that a busy spell hits all alike.

Each round begins with another task: what the caches hold after the task before differs by place.
"""

import statistics
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar

from tqdm import tqdm

from .timing import garbage_collection_off, only_new_garbage

Task = Callable[[int], None]
"""Does its work that many times."""


_is_rehearsal = ContextVar("rehearsal", default=False)


@contextmanager
def each_task_once() -> Iterator[None]:
    """Inside, `seconds_per_time` runs each task once, for what it compiles; its seconds mean nothing."""
    token = _is_rehearsal.set(True)
    try:
        yield
    finally:
        _is_rehearsal.reset(token)


def seconds_per_time(
    tasks: Mapping[str, Task], repeats: int, least_seconds: float, name: str = "timing"
) -> dict[str, list[float]]:
    """CPU seconds of each task, done once, in each of `repeats` rounds over all tasks.

    Every task is first run untimed (compilation, caches), then as often in a sample as takes
    `least_seconds`.
    """
    if _is_rehearsal.get():
        for task in tasks.values():
            task(1)
        return {label: [1.0] * repeats for label in tasks}
    times = {label: _times_of(task, least_seconds) for label, task in tasks.items()}
    samples: dict[str, list[float]] = {label: [] for label in tasks}
    order = deque(tasks.items())
    with only_new_garbage():
        for _ in tqdm(range(repeats), desc=name, unit="round"):
            with garbage_collection_off():
                for label, task in order:
                    samples[label].append(_seconds(task, times[label]) / times[label])
            order.rotate(-1)
    return samples


def medians(samples: Mapping[str, list[float]]) -> dict[str, float]:
    """Label -> median."""
    return {label: statistics.median(values) for label, values in samples.items()}


def _times_of(task: Task, least_seconds: float) -> int:
    task(1)
    times = 1
    while (seconds := _seconds(task, times)) < 0.2 * least_seconds:
        times *= 4
    return max(1, round(times * least_seconds / seconds))


def _seconds(task: Task, times: int) -> float:
    start = time.process_time()
    task(times)
    return max(time.process_time() - start, 1e-9)
