"""Everything that moves one scene: measured in turn, compared with the scene's reference, and read off."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tqdm import tqdm

from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case
from studies.harness.progress import announce
from studies.harness.reference import ReferenceSolution, from_data
from studies.harness.rows import make_row
from studies.harness.study import Row
from studies.harness.timing import Measurement, measure
from studies.table3 import refined

from .enforced import enforced_cases
from .families import INEXTENSIBLE, OPPONENTS, family_of, members
from .inextensible import inextensible_selection
from .links import links_selection
from .native import native_selection
from .reading import Front, front_of, read

BOUNDS = (1e-2, 5e-3, 3e-3, 1e-3, 7e-4, 3e-4)  # [m]
BELOW = "below the reference's uncertainty"
REPEATS, SLOW_REPEATS, SLOWEST_REPEATS = 5, 3, 1
SLOW, SLOWEST = 0.3, 3.0  # [s] of CPU time


def repeats_of(seconds: float) -> int:
    """Timed runs of a case whose warm-up took that CPU time [s]."""
    if seconds > SLOWEST:
        return SLOWEST_REPEATS
    return SLOW_REPEATS if seconds > SLOW else REPEATS


def reference_of(scene: Scene) -> ReferenceSolution:
    """The independent trajectory, where there is one; else a refined solution and what refinement changes."""
    return from_data(scene) if scene.reference else refined(scene)


def cases_of(scene: Scene, quick: bool) -> list[Case]:
    """All formulations, integrators, meshes and steps."""
    return [
        *inextensible_selection(scene, quick).cases,
        *enforced_cases(scene, quick),
        *native_selection(scene, quick).cases,
        *links_selection(scene, quick).cases,
    ]


def run_scene(case: Row) -> Row:
    """{"rows": ...} of a scene: its reference, every run, and the ratios."""
    scene = replace(load_scene(case["scene"]), end_time=case["motion"])
    announce(scene.name, "preparing the reference and the cases, finding stable steps")
    reference = reference_of(scene)
    runs = measured(scene, cases_of(scene, case["quick"]), reference, case["repeats"])
    return {
        "rows": [reference_row(scene, reference), *runs, *ratio_rows(scene.name, runs, reference.uncertainty)]
    }


def measured(
    scene: Scene, cases: Sequence[Case], reference: ReferenceSolution, repeats: int = REPEATS
) -> list[Row]:
    """One row a case; what fails or diverges keeps its row, with its status."""
    with tqdm(total=len(cases) * (repeats + 1), desc=scene.name, unit="run") as progress:

        def advance(label: str) -> None:
            progress.set_postfix_str(label[:48])
            progress.update()

        measurements = measure(cases, repeats, advance, repeats_of)
    return [_run_row(scene, measurement, reference) for measurement in measurements]


def _run_row(scene: Scene, measurement: Measurement, reference: ReferenceSolution) -> Row:
    row = {"kind": "run", "scene": scene.name} | make_row(measurement, reference.trajectory)
    return row | {"family": family_of(row)}


def reference_row(scene: Scene, reference: ReferenceSolution) -> Row:
    """What the errors of a scene are measured against."""
    return {
        "kind": "reference",
        "scene": scene.name,
        "source": reference.source,
        "uncertainty": reference.uncertainty,
        "selfConvergence": scene.reference is None,
        "motion": scene.end_time,
    }


def ratio_rows(scene: str, runs: Sequence[Row], uncertainty: float) -> list[Row]:
    """CPU time of every opponent over that of the inextensible cable, at every error bound."""
    own = front_of(members(runs, INEXTENSIBLE), uncertainty)
    rows: list[Row] = []
    for opponent, belongs in OPPONENTS.items():
        theirs = [row for row in runs if belongs(row)]
        if theirs:
            rows += _ratios(scene, opponent, front_of(theirs, uncertainty), own)
    return rows


def _ratios(scene: str, opponent: str, theirs: Front, own: Front) -> Iterator[Row]:
    for bound in BOUNDS:
        row: Row = {"kind": "speedUp", "scene": scene, "opponent": opponent, "bound": bound}
        if bound < own.uncertainty:
            yield row | {"ratio": None, "opponentOutcome": BELOW, "ownOutcome": BELOW}
            continue
        slow, quick = read(theirs, bound), read(own, bound)
        both = slow.seconds is not None and quick.seconds is not None
        yield row | {
            "ratio": slow.seconds / quick.seconds if both else None,
            "opponentSeconds": slow.seconds,
            "ownSeconds": quick.seconds,
            "opponentOutcome": slow.what,
            "ownOutcome": quick.what,
        }
