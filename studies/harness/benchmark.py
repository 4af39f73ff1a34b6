"""A study of speed alone: figures of a machine, without a scene's reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .machine import machine
from .progress import announce
from .provenance import code_versions
from .store import gallery, prepare_directory, write_json, write_text
from .study import Row
from .table import cell, markdown_table


@dataclass(frozen=True)
class Table:
    """The rows of one kind in the report.   columns: header -> key of the row."""

    kind: str
    title: str
    columns: Mapping[str, str]


@dataclass(frozen=True)
class Figures:
    """What a benchmark measured.   rows: each with its "kind"."""

    quick: bool
    rows: Sequence[Row]

    def of_kind(self, kind: str) -> list[Row]:
        return [row for row in self.rows if row["kind"] == kind]


def no_pictures(figures: Figures, directory: Path) -> list[Path]:
    """For benchmarks without pictures."""
    return []


@dataclass(frozen=True)
class Benchmark:
    """A question about speed that one command answers.

    measure: quick -> rows; `quick` asks for few, cheap ones. Each row has a "kind".
    tables: how they are shown.
    conclusions: sentences that are computed from them.   pictures: draws into a directory.
    """

    name: str
    question: str
    measure: Callable[[bool], Sequence[Row]]
    tables: Sequence[Table]
    conclusions: Callable[[Figures], list[str]]
    pictures: Callable[[Figures, Path], list[Path]] = no_pictures


def run_benchmark(benchmark: Benchmark, output: Path, quick: bool = False) -> str:
    """Measure, write NAME.json, NAME.md and pictures into `output`; return the report."""
    prepare_directory(output)
    announce(benchmark.name, "measuring")
    figures = Figures(quick, benchmark.measure(quick))
    conclusions = benchmark.conclusions(figures)
    document = {
        "study": benchmark.name,
        "quick": quick,
        "machine": machine(),
        "versions": code_versions(),
        "rows": figures.rows,
        "conclusions": conclusions,
    }
    write_json(output / f"{benchmark.name}.json", document)
    report = _report(benchmark, figures, conclusions)
    pictures = benchmark.pictures(figures, output)
    write_text(output / f"{benchmark.name}.md", report + gallery(pictures))
    return report


def _report(benchmark: Benchmark, figures: Figures, conclusions: Sequence[str]) -> str:
    mode = " (quick: few, short measurements)" if figures.quick else ""
    paragraphs = [f"# {benchmark.name}{mode}", benchmark.question]
    for table in benchmark.tables:
        rows = figures.of_kind(table.kind)
        if rows:
            lines = [[cell(row.get(key)) for key in table.columns.values()] for row in rows]
            paragraphs += [table.title, markdown_table(list(table.columns), lines)]
    return "\n\n".join([*paragraphs, "\n".join(f"- {sentence}" for sentence in conclusions)]) + "\n"
