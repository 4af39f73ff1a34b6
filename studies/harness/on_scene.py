"""Cases on a scene, timed in turn in this process, compared with the scene's reference and with a paper."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from reference_models.conventional.cases import largest_step_case, native_case
from reference_models.conventional.settings import Implicit, Newton
from reference_models.conventional.zhai import zhai_case
from reference_models.inextensible import Inextensible, inextensible_case
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case, Trajectory

from .bars import Bar, conclusions
from .cases import explicit_case, paper_case, untuned_cases
from .figures import draw_cost_and_accuracy, draw_trajectories
from .ratios import equal_accuracy, front, kinds_of, time_ratio
from .reference import ReferenceOf, ReferenceSolution, from_data, interpolation_error
from .store import Row
from .study import Results, Study, announce
from .table import Table, groups, number
from .timing import OK, measure

QUICK_REPEATS = 1
LONG = 3.0  # CPU time of runs that are timed once [s]


@dataclass(frozen=True, kw_only=True)
class SceneResults(Results):
    """rows: one a case, in the order of the cases.   trajectories: label -> what the case gave.

    reference: what the errors are measured against.
    """

    scene: Scene
    trajectories: Mapping[str, Trajectory]
    reference: ReferenceSolution


@dataclass(frozen=True)
class OnScene:
    """How rows are measured.

    cases: (scene, quick) -> what is run and timed; `quick` asks for few, cheap ones.
    paper: the paper's figures, stored beside the measured ones.
    reference: scene -> what errors are measured against; default: the scene's trajectory from the data.
    quick_end_time: [s] end time of the scene in a quick run.
    """

    scene: Scene
    cases: Callable[[Scene, bool], Sequence[Case]]
    paper: Mapping[str, Any] = field(default_factory=dict)
    reference: ReferenceOf = from_data
    quick_end_time: float = 0.3
    repeats: int = 5

    def __call__(self, quick: bool) -> SceneResults:
        scene = self.scene
        if quick:
            scene = replace(scene, end_time=min(scene.end_time, self.quick_end_time))
        announce(scene.name, "preparing the reference and the cases, finding stable steps")
        reference = self.reference(scene)
        repeats = QUICK_REPEATS if quick else self.repeats
        cases = self.cases(scene, quick)
        found = measure(
            cases,
            repeats,
            reference.trajectory,
            scene.name,
            lambda seconds: 1 if seconds > LONG else math.inf,
        )
        if not quick:
            add_halved(cases, [row for row, _ in found], reference.trajectory)
        interpolation = interpolation_error(reference.trajectory)
        described = {
            "file": reference.file,
            "source": reference.source,
            "uncertainty": reference.uncertainty,
            "interpolationErrorMax": interpolation.maximum,
            "interpolationErrorRms": interpolation.rms,
        }
        return SceneResults(
            quick=quick,
            rows=[row for row, _ in found],
            mode=f"quick: {scene.end_time:g} s of motion",
            entries={"paper": self.paper, "reference": described},
            notes=[_note(described)],
            scene=scene,
            trajectories={row["label"]: path for row, path in found if path is not None},
            reference=reference,
        )


def add_halved(cases: Sequence[Case], rows: Sequence[Row], reference: Trajectory) -> None:
    """Give rows that may be the cheapest of their kind "errorHalved", with half the step, from a single run.

    A row whose error grows then owes it to errors of mesh and step that cancel.
    """
    kinds = groups([row | {"own": kinds_of(row)} for row in rows], "own").values()
    chosen = {row["label"] for kind in kinds for row in front(kind)}
    pairs = zip(cases, rows, strict=True)
    asked = {case.label: (case.halved(), row) for case, row in pairs if case.label in chosen and case.halved}
    for label, (case, row) in tqdm(asked.items(), desc="half the step"):
        ((found, _),) = measure([replace(case, label=label)], 0, reference)
        row["errorHalved"] = found["errorMax"]


def _note(reference: Row) -> str:
    """What the errors are."""
    return (
        "Errors are distances to: {source}, good to {uncertainty:.0e} m; between its samples a spline, whose "
        "error at twice the sampling period is ".format_map(reference)
        + f"{number(reference['interpolationErrorMax'], 2)} m at most, "
        f"{number(reference['interpolationErrorRms'], 2)} m rms."
    )


def _shown(results: Results) -> list[Row]:
    """All rows; a failed one shows its status instead of figures."""
    return [
        row | {"label": row["label"] + status, "stepSize": f"{row['stepSize']:.3g}"}
        for row in results.rows
        for status in ["" if row["status"] == OK else f" ({row['status']})"]
    ]


ROWS = Table(
    "",
    "",
    "case: label | N: elements | h [s]: stepSize | CPU [s]: cpuSeconds | CPU min [s]: cpuSecondsMin | "
    "error max [m]: errorMax | error rms [m]: errorRms",
    _shown,
)


EACH_STEP: Newton = "modifiedEachStep"
OVER = "CPU time over that of the inextensible cable"


def of_pendulum(
    labels: Sequence[str], implicit_step: float, proposed: Inextensible
) -> Callable[[Scene, bool], list[Case]]:
    """The columns of Tables 1 and 2: implicit, with Exudyn's defaults; explicit; proposed.

    labels: of these.   implicit_step: [s].   proposed: without the paper's choices of method.
    """
    defaults = Implicit(implicit_step, newton="modified", linear_solver="dense", relative_tolerance=1e-8)
    return lambda scene, quick: [
        native_case(scene, 10, defaults, label=labels[0]),
        zhai_case(scene, 10, 2e-5, label=labels[1]),
        inextensible_case(scene, proposed, label=labels[2]),
        *([] if quick else [paper_case(scene, proposed)]),
    ]


@dataclass(frozen=True)
class PaperTable:
    """A table of the paper: its rows at the paper's settings, and rows that are tuned on both sides.

    name: of the study.   scene: its name.   title: the scene and the length of its motion, as pages say it.
    at_paper_settings: (scene, quick) -> cases.
    paper: the paper's figures, stored beside the measured ones; "cpuSeconds": of those cases, by label [s].
    shown: labels of the rows whose motion is drawn; of the last one, others are multiples.
    bounds: errors at which the cheapest runs are compared [m].
    inextensible: of `explicit_case`: scheme, N, h [s], mass scaling, zeta [1/s], curvature measure.
    implicit: N, solver, quadrature; see the study's head for how they were chosen; coarse ones first.
    explicit: N, integrator, quadrature, at their largest stable steps.
    meshes: of default settings and of the one setting.
    quick: how many of the inextensible and implicit ones a quick run takes.
    """

    name: str
    scene: str
    title: str
    at_paper_settings: Callable[[Scene, bool], list[Case]]
    paper: Mapping[str, Any]
    shown: Sequence[str]
    bounds: Sequence[float]
    inextensible: Sequence[tuple[Any, ...]]
    implicit: Sequence[tuple[Any, ...]]
    explicit: Sequence[tuple[Any, ...]]
    meshes: Sequence[int] = (3, 4, 5, 6, 8, 10, 12)
    quick: tuple[int, int] = (2, 2)

    def cases(self, scene: Scene, quick: bool) -> list[Case]:
        """All rows; a quick run leaves out the costly ones."""
        own, implicit = self.quick if quick else (None, None)
        return [
            *self.at_paper_settings(scene, quick),
            *(explicit_case(scene, *row) for row in self.inextensible[:own]),
            *(native_case(scene, *row) for row in self.implicit[:implicit]),
            *([] if quick else [*untuned_cases(scene, self.meshes), *self.explicit_cases(scene)]),
        ]

    def explicit_cases(self, scene: Scene) -> list[Case]:
        """Native explicit integrators at their largest stable steps, which are searched here."""
        return [largest_step_case(scene, *row) for row in self.explicit]

    def ratios(self, results: Results) -> list[Row]:
        """At the paper's settings beside the paper's, then best against best; keys: see `equal_accuracy`."""
        seconds, proposed = self.paper.get("cpuSeconds", {}), self.shown[-1]
        rows = {row["label"]: row for row in results.rows}
        found = [
            {
                "what": label,
                "paper": there / seconds[proposed],
                "here": time_ratio(rows.get(label), rows.get(proposed)),
            }
            for label, there in seconds.items()
            if label != proposed
        ]
        return found + equal_accuracy(results.rows, self.bounds)

    def conclude(self, results: Results) -> list[str]:
        """The strongest native rows of equal accuracy; the paper's settings, beside the paper."""
        rows = [row | {"label": row["what"]} for row in self.ratios(results)]
        paper = [row for row in rows if row["paper"]]
        equal = [] if results.quick else [row for row in rows if not row["paper"]]
        bars = [
            Bar(lambda _: paper, "here", f"{{}}: {OVER}, beside the paper's", "paper", "label", is_least=True)
        ]
        if equal:  # the few rows of a quick run, for a short motion, decide nothing on the best of their kind
            bars.insert(0, Bar(lambda _: equal, "here", f"At equal accuracy, {OVER}", 1.0, is_least=True))
        return conclusions(*bars)(results)

    def draw(self, results: SceneResults, directory: Path) -> list[Path]:
        """Cost against accuracy; motion at the paper's settings."""
        scene, reference = results.scene, results.reference.trajectory
        runs = {label: results.trajectories[label] for label in self.shown if label in results.trajectories}
        axes = [f"{scene.main_point} {axis} [m]" for axis in ("xy" if scene.is_planar else "xyz")]
        return [
            draw_cost_and_accuracy(directory / f"{self.name}_cost.png", results.rows),
            draw_trajectories(directory / f"{self.name}_motion.png", runs, reference, axes),
        ]

    def study(
        self, question: str, reference: ReferenceOf = from_data, tables: Sequence[Table] = (), **more: Any
    ) -> Study:
        """Its rows, what else is shown, its ratios and pictures.   more: of `Study`."""
        measure = OnScene(load_scene(self.scene), self.cases, self.paper, reference)
        shown = [ROWS, *tables, Table("", "", f"{OVER}: what | paper | here", self.ratios)]
        own = {"conclusions": self.conclude, "ratios": self.ratios, "pictures": self.draw}
        return Study(self.name, question, measure, tables=shown, **{**own, **more})
