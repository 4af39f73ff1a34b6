"""What a study is, and what a run of it gives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reference_models.scenes import Scene
from reference_models.trajectory import Case, Trajectory

from .reference import ReferenceOf, ReferenceSolution, from_data
from .table import TextTable

Row = dict[str, Any]
"""One case as it is stored; the keys are those of the JSON file."""


@dataclass(frozen=True)
class Results:
    """rows: one a case, in the order of the cases.   trajectories: label -> what the case gave.

    reference: what the errors are measured against.
    """

    scene: Scene
    quick: bool
    rows: list[Row]
    trajectories: Mapping[str, Trajectory]
    reference: ReferenceSolution


def no_figures(results: Results, directory: Path) -> list[Path]:
    """For studies without pictures."""
    return []


def no_conclusions(results: Results) -> list[str]:
    """For studies that speak through their ratios."""
    return []


def no_tables(results: Results) -> list[TextTable]:
    """For studies whose rows say it all."""
    return []


@dataclass(frozen=True)
class Ratio:
    """CPU time of native cables over that of the inextensible one.

    what: the native rows.   here: measured; None where one of the times is missing.
    paper: at the paper's settings, what the paper states; None for rows of equal accuracy.
    """

    what: str
    paper: float | None
    here: float | None


def no_ratios(results: Results) -> list[Ratio]:
    """For studies that do not compare with native cables."""
    return []


@dataclass(frozen=True)
class Study:
    """A question that one command answers.

    paper: the paper's figures, stored beside the measured ones.
    cases: (scene, quick) -> what is run and timed; `quick` asks for few, cheap ones.
    figures: draws into a directory and returns the files.
    conclusions: sentences that are computed from the results.
    ratios, tables: shown beside the rows; of the ratios, sentences are made.
    reference: scene -> what errors are measured against; default: the scene's trajectory from the data.
    quick_end_time: [s] end time of the scene in a quick run.
    not_in_quick_report: why a quick report on all studies leaves it out; empty if it does not.
    """

    name: str
    question: str
    scene: Scene
    paper: Mapping[str, Any]
    cases: Callable[[Scene, bool], Sequence[Case]]
    conclusions: Callable[[Results], list[str]] = no_conclusions
    figures: Callable[[Results, Path], list[Path]] = no_figures
    reference: ReferenceOf = from_data
    ratios: Callable[[Results], list[Ratio]] = no_ratios
    tables: Callable[[Results], list[TextTable]] = no_tables
    quick_end_time: float = 0.5
    repeats: int = 5
    not_in_quick_report: str = ""
