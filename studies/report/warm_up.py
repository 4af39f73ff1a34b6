"""Compilation ahead of quick runs, on all cores at once: nothing is timed, all results are discarded.

What it compiles is read from the cache by the studies, which run one after another.
"""

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, wait
from contextlib import redirect_stderr, suppress
from dataclasses import replace
from io import StringIO
from itertools import chain, zip_longest

from reference_models.trajectory import Case
from studies.harness.progress import announce
from studies.harness.study import Study
from studies.harness.sweep.case import is_timed
from studies.harness.sweep.engines import processes
from studies.harness.sweep.study import SweepStudy
from studies.registry import AnyStudy, find_study

BRIEF = 0.02  # [s] of motion

Task = tuple[str, int]
"""Name of a study, number of its quick case."""


def warm_up(studies: Mapping[str, AnyStudy]) -> None:
    """Run quick cases: of studies on a scene for a moment, of sweeps the timed ones; and benchmarks."""
    tasks = _tasks(studies)
    if not tasks:
        return
    announce("report", f"compiling for {len(tasks)} cases on {os.cpu_count()} cores")
    with processes().open() as executor:
        _submit(executor, tasks)


def _tasks(studies: Mapping[str, AnyStudy]) -> list[Task]:
    """The first cases of all studies, the second ones, ...: neighbours seldom need the same kernels."""
    numbers = [[(name, n) for n in range(_count(study))] for name, study in studies.items()]
    return [task for task in chain.from_iterable(zip_longest(*numbers)) if task]


def _count(study: AnyStudy) -> int:
    if isinstance(study, Study):
        return len(_cases(study))
    if isinstance(study, SweepStudy):
        return sum(map(is_timed, study.cases(True)))
    return 1


def _cases(study: Study) -> Sequence[Case]:
    return study.cases(replace(study.scene, end_time=BRIEF), True)


def _submit(executor: Executor, tasks: list[Task]) -> None:
    wait([executor.submit(rehearse, *task) for task in tasks])


def rehearse(name: str, number: int) -> None:
    """Run one case; if it fails, its study will say so."""
    study = find_study(name)
    with suppress(Exception), redirect_stderr(StringIO()):  # without progress bars
        if isinstance(study, Study):
            _cases(study)[number].prepare()()
        elif isinstance(study, SweepStudy):
            study.run([case for case in study.cases(True) if is_timed(case)][number])
        else:
            study.measure(True)
