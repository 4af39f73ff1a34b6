"""The cheapest candidates on a scene of cables within bounds of the error.

A search with single runs, variants of the best ones, then medians in turn; rows of all, and comparisons.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import exudyn
from tqdm import tqdm

from exudyn_inext import InextensibleError
from exudyn_inext.arrays import Array
from reference_models.conventional.cable import Quadrature

from .benchmark import Series
from .coupled_runs import PERIOD, Candidate, Inextensible, Native, distance, prepare
from .coupled_scenes import CoupledScene
from .plot import Curve, Panel, chart
from .ratios import DEFAULT, ONE_SETTING, TUNED, front
from .store import Row
from .study import Results
from .table import column, groups, percent
from .timing import Prepare, in_turn

DEAR = (20.0, 5.0)  # times the cheapest run within each bound: smaller steps are not tried
STAYS, SMALL = 0.05, 0.1  # change of an error over the error, and size of an error, that smaller steps keep
PROMISING, MOST = 1.5, 4  # times the cheapest run, and at most so many: what is timed again
VARIED = 4  # of the cheapest runs within a bound: their variants are tried


@dataclass(frozen=True)
class Attempt:
    """One run.   error: None if it failed.   seconds: CPU time."""

    candidate: Any
    error: float | None
    seconds: float


Try = Callable[[Any], Attempt]


def search(
    series: Sequence[Sequence[Any]], attempt: Try, bounds: Sequence[float], name: str
) -> list[Attempt]:
    """Runs of candidates.

    series: of falling steps; each ends where its error stays, or where its runs are dear.
    """
    found: list[Attempt] = []
    for candidates in tqdm(series, desc=name):
        before = None
        for candidate in candidates:
            one = attempt(candidate)
            found.append(one)
            if _is_dear(one, found, bounds) or _stays(before, one.error):
                break
            before = one.error
    return found


def _is_dear(one: Attempt, found: Sequence[Attempt], bounds: Sequence[float]) -> bool:
    best = (_cheapest(found, bound)[:1] for bound in bounds)
    pairs = zip(best, DEAR, strict=True)
    return any(one.seconds > times * least.seconds for some, times in pairs for least in some)


def _stays(before: float | None, error: float | None) -> bool:
    return before is not None and error is not None and error < SMALL and abs(error - before) < STAYS * error


def vary(
    found: Sequence[Attempt], attempt: Try, bounds: Sequence[float], variants: Callable[[Any], Iterable[Any]]
) -> list[Attempt]:
    """Runs of variants of the cheapest ones within each bound."""
    known = {one.candidate for one in found}
    best = [one for bound in bounds for one in _cheapest(found, bound)[:VARIED]]
    others = dict.fromkeys(other for one in best for other in variants(one.candidate))
    return [attempt(other) for other in tqdm(others, desc="variants") if other not in known]


def choose(
    groups: Mapping[Any, tuple[Sequence[Attempt], float]], prepare: Callable[[Any], Prepare], rounds: int
) -> dict[Any, Attempt]:
    """The cheapest one of each group within its bound, by medians of runs that all groups take in turn.

    groups: name -> runs and bound; one without a run within the bound is left out.
    """
    hopes = {name: _promising(found, bound) for name, (found, bound) in groups.items()}
    tasks = {one.candidate: partial(prepare, one.candidate) for again in hopes.values() for one in again}
    timed = {name: one.median or math.inf for name, one in in_turn(tasks, rounds, "best").items()}
    medians = {
        name: [Attempt(one.candidate, one.error, timed[one.candidate]) for one in again]
        for name, again in hopes.items()
    }
    return {name: min(again, key=lambda one: one.seconds) for name, again in medians.items() if again}


def _promising(found: Sequence[Attempt], bound: float) -> list[Attempt]:
    within = _cheapest(found, bound)
    return [one for one in within if one.seconds < PROMISING * within[0].seconds][:MOST]


def _cheapest(found: Sequence[Attempt], bound: float) -> list[Attempt]:
    within = (one for one in found if one.error is not None and one.error < bound)
    return sorted(within, key=lambda one: one.seconds)


REPETITIONS = 3
TICKS = [digit * 10.0**power for power in range(-4, 3) for digit in (1, 3)]  # [s]
LEAST = 0.1  # of the CPU time of a run, where its start is taken off

Steps = list[list[Any]]


def ours(scene: CoupledScene) -> Steps:
    """Candidates: default settings, and series of steps."""
    default: Steps = [[Inextensible(n, choice=DEFAULT)] for n in scene.meshes]
    return default + [[Inextensible(n, h) for h in scene.steps] for n in scene.meshes]


def natives(scene: CoupledScene, quadratures: Sequence[Quadrature] = ("full", "lobatto")) -> Steps:
    """Candidates: series of steps."""
    grid = product(scene.meshes, scene.axial, quadratures)
    return [[Native(n, h, axial, quadrature) for h in scene.steps] for n, axial, quadrature in grid]


@dataclass(frozen=True)
class Tuning:
    """What is tuned, and against what.

    sides: name -> series of candidates.   references: a converged run, and one that says how good it is.
    bounds: of errors, see `distance` [-].
    who: name of a best run -> side, and TUNED, DEFAULT or ONE_SETTING.
    """

    scenes: Sequence[CoupledScene]
    sides: Mapping[str, Callable[[CoupledScene], Steps]]
    references: Callable[[CoupledScene], tuple[Candidate, Candidate]]
    bounds: Sequence[float]
    who: Mapping[str, tuple[str, str]]

    @property
    def series(self) -> Series:
        """One case a scene."""
        return Series("scene", self._cases, lambda case: list(self.rows(case["scene"], case["quick"])))

    def _cases(self, quick: bool) -> list[Row]:
        return [{"scene": one.name, "quick": quick} for one in self.scenes if one.is_quick or not quick]

    def rows(self, scene: str, quick: bool = False) -> Iterator[Row]:
        """The reference, candidates, and the best ones of each side within each bound, timed in turn."""
        one = next(other for other in self.scenes if other.name == scene)
        one = one.brief() if quick else one
        run = partial(prepare, one, end_time=one.end_time)
        reference, twin = self.references(one)
        attempt = partial(_attempt, one, run(reference)()[1])
        yield {"kind": "reference", "label": scene, "scene": scene, "error": attempt(twin).error}
        tried = {}
        for side, steps in self.sides.items():
            found = search(steps(one), attempt, self.bounds, f"{scene}, {side}")
            found += vary(found, attempt, self.bounds, lambda candidate: candidate.variants(one))
            tried[side, TUNED] = found
            for choice in (DEFAULT, ONE_SETTING):
                tried[side, choice] = [x for x in found if getattr(x.candidate, "choice", TUNED) == choice]
            yield from (_row("candidate", scene, side, x) for x in found)
        asked = {(bound, *who): (found, bound) for bound in self.bounds for who, found in tried.items()}
        repetitions = 1 if quick else REPETITIONS
        best = choose(asked, run, repetitions)
        begin = partial(prepare, one, end_time=PERIOD)
        starts = choose({name: ([x], math.inf) for name, x in best.items()}, begin, repetitions)
        for (bound, side, choice), x in best.items():
            row = _row("best", scene, side, x) | {"bound": bound, "choice": choice}
            yield row | {"startSeconds": starts[bound, side, choice].seconds}

    def compared(self, results: Results) -> list[Row]:
        """Best runs of each scene within each bound, and quotients of their CPU times.

        Keys: NAME, NAMEStart [s], NAMEError, NAMESettings, NAME/OTHER, and without their starts NAME//OTHER.
        """
        best = {(r["scene"], r["bound"], r["formulation"], r["choice"]): r for r in results.of_kind("best")}
        rows = []
        for reference, bound in product(results.of_kind("reference"), self.bounds):
            found = {name: best.get((reference["scene"], bound, *side)) for name, side in self.who.items()}
            row = {"scene": reference["scene"], "within": percent(bound), "agreement": reference["error"]}
            for name, one in found.items():
                if one:
                    settings = f"{one.get('elements')} elements, {one.get('settings')}"
                    row |= {name: one["cpuSeconds"], f"{name}Start": one.get("startSeconds")}
                    row |= {f"{name}Error": one.get("error"), f"{name}Settings": settings}
            for name, other in product(found, found):
                if name in row and other in row:
                    row[f"{name}/{other}"] = row[name] / row[other]
                    alone = [row[key] - (row[f"{key}Start"] or math.nan) for key in (name, other)]
                    if alone[1] > LEAST * row[other]:
                        row[f"{name}//{other}"] = alone[0] / alone[1]
            rows.append(row)
        return rows


def _attempt(scene: CoupledScene, reference: Array, candidate: Candidate) -> Attempt:
    """One that fails with modified Newton steps is run with full ones."""
    try:
        seconds, paths = prepare(scene, candidate, scene.end_time)()
    except (InextensibleError, exudyn.ExudynError):
        if isinstance(candidate, Native) and candidate.newton == "modified":
            return _attempt(scene, reference, replace(candidate, newton="full"))
        return Attempt(candidate, None, 0.0)
    return Attempt(candidate, distance(paths, reference), seconds)


def _row(kind: str, scene: str, side: str, one: Attempt) -> Row:
    candidate = one.candidate
    return {
        "kind": kind,
        "label": f"{scene}, {side}, {candidate.elements} elements, {candidate}",
        "scene": scene,
        "formulation": side,
        "elements": candidate.elements,
        "settings": str(candidate),
        "error": one.error,
        "cpuSeconds": one.seconds,
    }


def draw_fronts(results: Results, path: Path, bounds: Sequence[float]) -> Path:
    """Error over CPU time of the best candidates of each side, and of default settings."""
    known = [row for row in results.of_kind("candidate") if row["error"] and row["cpuSeconds"]]
    panels = []
    for scene, rows in groups(known, "scene").items():
        shown = groups(rows, "formulation")
        shown["default settings"] = [row for row in rows if row["settings"] == DEFAULT]
        best = {name: front(some, "error") for name, some in shown.items()}
        curves = [
            Curve(column(some, "cpuSeconds"), column(some, "error"), name) for name, some in best.items()
        ]
        times = [seconds for curve in curves for seconds in curve.x]
        ticks = [x for x in TICKS if 0.7 * min(times) < x < 1.4 * max(times)]
        axes = {"title": scene, "legend": False, "horizontal": bounds, "ticks": ticks}
        panels.append(Panel("CPU time [s]", "error [-]", curves, **axes))
    rows_of_panels = -(-len(panels) // 4)
    width, height = 3.4 * -(-len(panels) // rows_of_panels), 0.5 + 2.9 * rows_of_panels
    return chart(path, *panels, width=width, height=height, rows=rows_of_panels, columns=len(shown))
