"""Compilation ahead of quick runs, on all cores at once: nothing is timed, all results are discarded.

What it compiles is read from the cache by the studies, which run one after another.
"""

import os
from collections.abc import Mapping
from concurrent.futures import wait
from contextlib import redirect_stderr, suppress
from dataclasses import replace
from io import StringIO

from studies.harness.interleaved import each_task_once
from studies.harness.progress import announce
from studies.harness.study import Study
from studies.harness.sweep.case import is_timed
from studies.harness.sweep.engines import processes
from studies.harness.sweep.study import SweepStudy
from studies.registry import AnyStudy, find_study

BRIEF = 0.02  # [s] of motion

Task = tuple[str, int]
"""Name of a study, and which of its timed cases if it sweeps over many."""


def warm_up(studies: Mapping[str, AnyStudy]) -> None:
    """Run quick cases: of studies on a scene for a moment, of sweeps the timed ones; and benchmarks, once."""
    tasks = _tasks(studies)
    if tasks:
        announce("report", f"compiling on {os.cpu_count()} cores, nothing is timed yet")
        with processes().open() as executor:
            wait([executor.submit(rehearse, *task) for task in tasks])


def _tasks(studies: Mapping[str, AnyStudy]) -> list[Task]:
    """Studies on scenes first: they compile most."""
    ordered = sorted(studies.items(), key=lambda item: not isinstance(item[1], Study))
    return [(name, n) for name, study in ordered for n in range(_count(study))]


def _count(study: AnyStudy) -> int:
    """Without building cases, which compiles."""
    return sum(map(is_timed, study.cases(True))) if isinstance(study, SweepStudy) else 1


def rehearse(name: str, number: int) -> None:
    """Run one task; if it fails, its study will say so."""
    study = find_study(name)
    with suppress(Exception), redirect_stderr(StringIO()):  # without progress bars
        if isinstance(study, Study):
            _run_for_a_moment(study)
        elif isinstance(study, SweepStudy):
            study.run([case for case in study.cases(True) if is_timed(case)][number] | study.brief)
        else:
            with each_task_once():
                study.measure(True)


def _run_for_a_moment(study: Study) -> None:
    for case in study.cases(replace(study.scene, end_time=BRIEF), True):
        with suppress(Exception):
            case.prepare()()
