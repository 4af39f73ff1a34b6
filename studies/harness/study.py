"""What a study is, and what a run of it gives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reference_models.scenes import Scene
from reference_models.trajectory import Case, Trajectory

from .reference import ReferenceOf, ReferenceSolution, from_data

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


@dataclass(frozen=True)
class Study:
    """A question that one command answers.

    paper: the paper's figures, stored beside the measured ones.
    cases: (scene, quick) -> what is run and timed; `quick` asks for few, cheap ones.
    figures: draws into a directory and returns the files.
    conclusions: sentences that are computed from the results.
    reference: scene -> what errors are measured against; default: the scene's trajectory from the data.
    quick_end_time: [s] end time of the scene in a quick run.
    """

    name: str
    question: str
    scene: Scene
    paper: Mapping[str, Any]
    cases: Callable[[Scene, bool], Sequence[Case]]
    conclusions: Callable[[Results], list[str]]
    figures: Callable[[Results, Path], list[Path]] = no_figures
    reference: ReferenceOf = from_data
    quick_end_time: float = 0.5
    repeats: int = 5
