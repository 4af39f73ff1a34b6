"""A table of the paper: its rows at the paper's settings, and rows that are tuned on both sides."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from reference_models.conventional.cases import largest_step_case, native_case
from reference_models.conventional.settings import Newton
from reference_models.scenes import Scene
from reference_models.trajectory import Case

from .cases import compiled_case, explicit_case
from .ratios import Comparison, Ratio, paper_ratios
from .study import Results

EACH_STEP: Newton = "modifiedEachStep"


@dataclass(frozen=True)
class PaperTable:
    """Rows and ratios of one study.

    at_paper_settings: (scene, quick) -> cases.   seconds: their labels -> the paper's CPU times [s].
    proposed: the label that others are divided by.   comparisons: of the tuned rows.
    inextensible: of `explicit_case`: scheme, N, h [s], mass scaling, zeta [1/s], curvature measure.
    compiled: the cheapest of them, without Exudyn's loop.
    implicit: N, solver, quadrature; see the study's head for how they were chosen; coarse ones first.
    explicit: N, integrator, quadrature, at their largest stable steps.
    quick: how many of the inextensible, compiled and implicit ones a quick run takes.
    """

    at_paper_settings: Callable[[Scene, bool], list[Case]]
    seconds: Mapping[str, float]
    proposed: str
    comparisons: Sequence[Comparison]
    inextensible: Sequence[tuple[Any, ...]]
    implicit: Sequence[tuple[Any, ...]]
    explicit: Sequence[tuple[Any, ...]]
    compiled: Sequence[tuple[Any, ...]] = ()
    quick: tuple[int, int, int] = (2, 0, 2)

    def cases(self, scene: Scene, quick: bool) -> list[Case]:
        """All rows; a quick run leaves out the costly ones."""
        own, compiled, implicit = self.quick if quick else (None, None, None)
        return [
            *self.at_paper_settings(scene, quick),
            *(explicit_case(scene, *row) for row in self.inextensible[:own]),
            *(compiled_case(scene, *row) for row in self.compiled[:compiled]),
            *(native_case(scene, *row) for row in self.implicit[:implicit]),
            *([] if quick else self.explicit_cases(scene)),
        ]

    def explicit_cases(self, scene: Scene) -> list[Case]:
        """Native explicit integrators at their largest stable steps, which are searched here."""
        return [largest_step_case(scene, *row) for row in self.explicit]

    def ratios(self, results: Results) -> list[Ratio]:
        """At the paper's settings beside the paper's, then best against best."""
        found = paper_ratios(results.rows, self.seconds, self.proposed)
        return found + [ratio for one in self.comparisons for ratio in one.ratios(results.rows)]
