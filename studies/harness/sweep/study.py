"""A study whose rows come from a sweep."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from exudyn_inext.errors import InputError

from ..benchmark import Benchmark, Figures, Table, no_pictures, run_benchmark
from ..study import Row
from .case import Outcome, Sweep
from .engines import Engine, dask, mpi, processes
from .folder import CaseFolder
from .run import run_sweep


@dataclass(frozen=True)
class SweepOptions:
    """How a sweep is run: from the command line.

    workers: processes of this machine; None: one a core.   dask: address of a scheduler.
    mpi: whether MPI runs the cases.
    fresh: discard stored cases.   retry_failed: run failed cases again.
    """

    workers: int | None = None
    dask: str | None = None
    mpi: bool = False
    fresh: bool = False
    retry_failed: bool = False

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise InputError(f"--workers {self.workers}: must be at least 1.")
        if (self.workers is not None) + (self.dask is not None) + self.mpi > 1:
            raise InputError("--workers, --dask and --mpi exclude each other: give one of them.")

    def engine(self) -> Engine:
        """Where the cases run."""
        if self.dask is not None:
            return dask(self.dask)
        return mpi() if self.mpi else processes(self.workers)


def one_row(case: Row, outcome: Outcome) -> list[Row]:
    """The case, what was found, and its status."""
    return [{**case, **outcome.result, "status": outcome.status}]


@dataclass(frozen=True)
class SweepStudy:
    """A question that one command answers, over many cases.

    cases: quick -> cases, each with its "kind"; see `Sweep`.   run: case -> what was found.
    tables, conclusions, pictures, not_in_quick_report: see `Benchmark`; a row is a case, what was found,
    and its "status".
    rows: of a case and its outcome; default: one.
    brief: what makes a case short, when it is run for what it compiles.
    """

    name: str
    question: str
    cases: Callable[[bool], Sequence[Row]]
    run: Callable[[Row], Row]
    tables: Sequence[Table]
    conclusions: Callable[[Figures], list[str]]
    pictures: Callable[[Figures, Path], list[Path]] = no_pictures
    not_in_quick_report: str = ""
    rows: Callable[[Row, Outcome], list[Row]] = one_row
    brief: Row = field(default_factory=dict)


def run_sweep_study(
    study: SweepStudy, output: Path, quick: bool = False, options: SweepOptions | None = None
) -> str:
    """Run what is not finished, write NAME.json, NAME.md and pictures into `output`; return the report."""
    options = options or SweepOptions()
    sweep = Sweep(study.name, study.run, study.cases(quick))

    def measure(quick: bool) -> list[Row]:
        outcomes = run_sweep(
            sweep, CaseFolder(output, sweep, options.fresh), options.engine(), options.retry_failed
        )
        pairs = zip(sweep.cases, outcomes, strict=True)
        return [row for case, outcome in pairs for row in study.rows(case, outcome)]

    benchmark = Benchmark(
        study.name, study.question, measure, study.tables, study.conclusions, study.pictures
    )
    return run_benchmark(benchmark, output, quick)
