"""The cheapest candidate within a bound of the error: a search with single runs, then medians in turn."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from tqdm import tqdm

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

    def is_within(self, bound: float) -> bool:
        return self.error is not None and self.error < bound


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
    return sorted((one for one in found if one.is_within(bound)), key=lambda one: one.seconds)
