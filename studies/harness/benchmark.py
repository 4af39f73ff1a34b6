"""A study of speed alone: figures of a machine, without a scene's reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .document import concluded, measured, store
from .progress import announce
from .store import prepare_directory
from .study import Row
from .table import TextTable, cell
from .verdict import timing_noise


@dataclass(frozen=True)
class Table:
    """The rows of one kind in the report.   columns: header -> key of the row.

    summary: computes other rows from those that were measured; None: they are shown themselves.
    """

    kind: str
    title: str
    columns: Mapping[str, str]
    summary: "Callable[[Figures], Sequence[Row]] | None" = None

    def rows(self, figures: "Figures") -> Sequence[Row]:
        """What it shows."""
        return figures.of_kind(self.kind) if self.summary is None else self.summary(figures)


@dataclass(frozen=True)
class Figures:
    """What a benchmark measured.   rows: each with its "kind"."""

    quick: bool
    rows: Sequence[Row]

    def of_kind(self, kind: str) -> list[Row]:
        return [row for row in self.rows if row["kind"] == kind]

    @property
    def noise(self) -> float:
        """Factor within which a timed figure counts as equal to its bar, see `verdict`."""
        return timing_noise(self.quick)


def no_pictures(figures: Figures, directory: Path) -> list[Path]:
    """For benchmarks without pictures."""
    return []


@dataclass(frozen=True)
class Benchmark:
    """A question about speed that one command answers.

    measure: quick -> rows; `quick` asks for few, cheap ones. Each row has a "kind".
    tables: how they are shown.
    conclusions: sentences that are computed from them.   pictures: draws into a directory.
    not_in_quick_report: why a quick report on all studies leaves it out; empty if it does not.
    """

    name: str
    question: str
    measure: Callable[[bool], Sequence[Row]]
    tables: Sequence[Table]
    conclusions: Callable[[Figures], list[str]]
    pictures: Callable[[Figures, Path], list[Path]] = no_pictures
    not_in_quick_report: str = ""


def run_benchmark(benchmark: Benchmark, output: Path, quick: bool = False) -> str:
    """Measure, write NAME.json, NAME.md and pictures into `output`; return the report."""
    prepare_directory(output)
    announce(benchmark.name, "measuring")
    figures = Figures(quick, benchmark.measure(quick))
    mode = "quick: few, short measurements" if quick else ""
    document = measured(benchmark.name, benchmark.question, quick, figures.rows, mode)
    store(output, document)
    document = concluded(document, _tables(benchmark, figures), benchmark.conclusions(figures))
    return store(output, document, benchmark.pictures(figures, output))


def _tables(benchmark: Benchmark, figures: Figures) -> list[TextTable]:
    """Those that have rows."""
    return [
        TextTable(
            table.title,
            list(table.columns),
            [[cell(row.get(key)) for key in table.columns.values()] for row in rows],
        )
        for table in benchmark.tables
        if (rows := table.rows(figures))
    ]
