"""Compilation ahead of quick runs, on all cores at once: nothing is timed, all results are discarded.

What it compiles is read from the cache by the studies, which run one after another.
"""

import os
from collections.abc import Mapping
from concurrent.futures import wait
from contextlib import redirect_stderr, suppress
from dataclasses import replace
from io import StringIO
from pathlib import Path

from studies.harness import Order, Study, announce
from studies.harness.engines import processes
from studies.harness.on_scene import OnScene
from studies.harness.sweep import Sweep, is_timed
from studies.harness.timing import each_task_once
from studies.registry import find_study

BRIEF = 0.02  # [s] of motion

Task = tuple[str, int]
"""Name of a study, and which of its timed cases if it sweeps over many."""


def warm_up(studies: Mapping[str, Study]) -> None:
    """Run quick cases: of studies on a scene for a moment, of sweeps the timed ones; and benchmarks, once."""
    tasks = _tasks(studies)
    if tasks:
        announce("report", f"compiling on {os.cpu_count()} cores, nothing is timed yet")
        with processes().open() as executor:
            wait([executor.submit(rehearse, *task) for task in tasks])


def _tasks(studies: Mapping[str, Study]) -> list[Task]:
    """Studies on scenes first: they compile most. Without building cases, which compiles."""
    ordered = sorted(studies.items(), key=lambda item: not isinstance(item[1].measure, OnScene))
    found = []
    for name, study in ordered:
        sweeps = isinstance(study.measure, Sweep)
        found += [(name, n) for n in range(sum(map(is_timed, study.measure.cases(True))) if sweeps else 1)]
    return found


def rehearse(name: str, number: int) -> None:
    """Run one task; if it fails, its study will say so."""
    measure = find_study(name).measure
    with suppress(Exception), redirect_stderr(StringIO()):  # without progress bars
        if isinstance(measure, OnScene):
            for case in measure.cases(replace(measure.scene, end_time=BRIEF), True):
                with suppress(Exception):
                    case.prepare()()
        elif isinstance(measure, Sweep):
            timed = [case for case in measure.cases(True) if is_timed(case)]
            measure.run(timed[number] | measure.brief)
        else:
            with each_task_once():
                measure(Order(name, Path(), quick=True))
