"""Series of cases: what varies, and what is measured, or timed in turn; one runner for all of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from tqdm import tqdm

from .bars import Bar, conclusions
from .store import Row, plain
from .study import Study
from .table import tables
from .timing import OK, Measurement, in_turn, sampled


def varied(quick: Mapping[str, Sequence[Any]], **values: Sequence[Any]) -> Callable[[bool], list[Row]]:
    """All combinations of these values, by name.   quick: other values of a quick run."""

    def cases(is_quick: bool) -> list[Row]:
        chosen = {**values, **(quick if is_quick else {})}
        return [dict(zip(chosen, some, strict=True)) for some in product(*chosen.values())]

    return cases


@dataclass(frozen=True)
class Series:
    """Rows of one kind: what varies, and what is measured.

    cases: quick -> what varies, see `varied`.
    row: (case, measurements by key) -> what is stored; without tasks, of the case alone, see `rows_of`.
    tasks: case -> key -> `Prepare`, or, with `least`, `Task`; equal keys are the same task.
    turn: keys; cases that agree in them are timed in turn; empty: all are.
    rounds: of a quick and of a full run.   least: of a sample, quick and full [s].
    rotates: whether each round begins with another task.
    """

    kind: str
    cases: Callable[[bool], Sequence[Row]]
    row: Callable[..., Row]
    tasks: Callable[[Row], Mapping[Any, Any]] | None = None
    turn: Sequence[str] = ()
    rounds: tuple[int, int] = (1, 1)
    least: tuple[float, float] | None = None
    rotates: bool = True

    def rows(self, quick: bool) -> Iterator[Row]:
        """Turn by turn."""
        cases = self.cases(quick)
        if self.tasks is None:
            for case in tqdm(cases, desc=self.kind, unit="case"):
                yield from rows_of(self.row, {"kind": self.kind, **case})
            return
        turns: dict[tuple[Any, ...], list[Row]] = {}
        for case in cases:
            turns.setdefault(tuple(case[key] for key in self.turn), []).append(case)
        for turn, some in turns.items():
            found = self._timed(some, not quick, " ".join(map(str, (self.kind, *turn))))
            yield from ({"kind": self.kind, **self.row(case, found)} for case in some)

    def _timed(self, cases: Sequence[Row], full: bool, name: str) -> Mapping[Any, Measurement]:
        of = self.tasks or (lambda case: {})
        tasks = {key: task for case in cases for key, task in of(case).items()}
        if self.least is None:
            return in_turn(tasks, self.rounds[full], name, turns=self.rotates)
        return sampled(tasks, self.rounds[full], self.least[full], name)


@dataclass(frozen=True)
class Benchmark:
    """How the rows of a study are measured: one series after another."""

    series: Sequence[Series]

    def __call__(self, quick: bool) -> list[Row]:
        return [row for one in self.series for row in one.rows(quick)]


def rows_of(run: Callable[[Row], Row | list[Row]], case: Row) -> list[Row]:
    """The case with what was found and its status, or rows of its own; if it fails, the others go on."""
    try:
        found = plain(run(case))
    except Exception as error:
        return [{**case, "status": f"failed: {type(error).__name__}: {error}"}]
    return found if isinstance(found, list) else [{**case, **found, "status": OK}]


def benchmark(
    name: str, question: str, series: Sequence[Series], bars: Sequence[Bar], shown: str, **more: Any
) -> Study:
    """An entry of the table.   shown: its tables, see `tables`.   more: of `Study`."""
    return Study(name, question, Benchmark(series), conclusions(*bars), tables(shown), **more)
