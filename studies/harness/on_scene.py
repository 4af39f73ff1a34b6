"""Cases on a scene, timed in turn in this process, and compared with the scene's reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from reference_models.scenes import Scene
from reference_models.trajectory import Case, Trajectory

from .reference import ReferenceOf, ReferenceSolution, from_data, interpolation_error
from .store import Row
from .study import Order, Results, announce
from .table import Table, number
from .timing import OK, measure

QUICK_REPEATS = 2


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
    quick_end_time: float = 0.5
    repeats: int = 5

    def __call__(self, order: Order) -> SceneResults:
        scene = self.scene
        if order.quick:
            scene = replace(scene, end_time=min(scene.end_time, self.quick_end_time))
        announce(order.study, "preparing the reference and the cases, finding stable steps")
        reference = self.reference(scene)
        repeats = QUICK_REPEATS if order.quick else self.repeats
        found = measure(self.cases(scene, order.quick), repeats, reference.trajectory, order.study)
        described = _described(reference)
        return SceneResults(
            quick=order.quick,
            rows=[row for row, _ in found],
            mode=f"quick: {scene.end_time:g} s of motion",
            entries={"paper": self.paper, "reference": described},
            notes=[_note(described)],
            scene=scene,
            trajectories={row["label"]: path for row, path in found if path is not None},
            reference=reference,
        )


def _described(reference: ReferenceSolution) -> Row:
    interpolation = interpolation_error(reference.trajectory)
    return {
        "file": reference.file,
        "source": reference.source,
        "uncertainty": reference.uncertainty,
        "interpolationErrorMax": interpolation.maximum,
        "interpolationErrorRms": interpolation.rms,
    }


def _note(reference: Row) -> str:
    """What the errors are."""
    return (
        f"Errors are distances to: {reference['source']}, good to "
        f"{reference['uncertainty']:.0e} m; between its samples a spline, whose error at twice "
        "the sampling period is "
        f"{number(reference['interpolationErrorMax'], 2)} m at most, "
        f"{number(reference['interpolationErrorRms'], 2)} m rms."
    )


def _shown(results: Results) -> list[Row]:
    """All rows; a failed one shows its status instead of figures."""
    return [
        row
        | {
            "label": row["label"] + ("" if row["status"] == OK else f" ({row['status']})"),
            "stepSize": f"{row['stepSize']:.3g}",
        }
        for row in results.rows
    ]


ROWS = Table(
    "",
    "",
    "case: label | N: elements | h [s]: stepSize | CPU [s]: cpuSeconds | CPU min [s]: cpuSecondsMin | "
    "error max [m]: errorMax | error rms [m]: errorRms",
    _shown,
)
