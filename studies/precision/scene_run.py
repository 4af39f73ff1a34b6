"""Everything that moves one scene: measured in turn, compared with the scene's reference, and read off."""

from collections.abc import Sequence
from dataclasses import replace

from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case
from studies.harness import Row, announce
from studies.harness.reference import ReferenceSolution
from studies.harness.timing import measure
from studies.table3 import reference_of

from .cases import cases_of
from .fronts import INEXTENSIBLE, OPPONENTS, family_of, front_of, members, read, speed_up

BOUNDS = (1e-2, 5e-3, 3e-3, 1e-3, 7e-4, 3e-4)  # [m]
BELOW = "below the reference's uncertainty"
REPEATS, SLOW_REPEATS, SLOWEST_REPEATS = 5, 3, 1
SLOW, SLOWEST = 0.3, 3.0  # [s] of CPU time


def repeats_of(seconds: float) -> int:
    """Timed runs of a case whose warm-up took that CPU time [s]."""
    if seconds > SLOWEST:
        return SLOWEST_REPEATS
    return SLOW_REPEATS if seconds > SLOW else REPEATS


def run_scene(case: Row) -> Row:
    """{"rows": ...} of a scene: its reference, every run, and the ratios."""
    scene = replace(load_scene(case["scene"]), end_time=case["motion"])
    announce(scene.name, "preparing the reference and the cases, finding stable steps")
    reference = reference_of(scene)
    runs = measured(scene, cases_of(scene, case["quick"]), reference, case["repeats"])
    ratios = ratio_rows(scene.name, runs, reference.uncertainty)
    return {"rows": [reference_row(scene, reference), *runs, *ratios]}


def measured(
    scene: Scene, cases: Sequence[Case], reference: ReferenceSolution, repeats: int = REPEATS
) -> list[Row]:
    """One row a case; what fails or diverges keeps its row, with its status."""
    found = measure(cases, repeats, reference.trajectory, scene.name, repeats_of)
    rows = [{"kind": "run", "scene": scene.name} | row for row, _ in found]
    return [row | {"family": family_of(row)} for row in rows]


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
    own, rows = front_of(members(runs, INEXTENSIBLE), uncertainty), []
    for opponent, belongs in OPPONENTS.items():
        theirs = front_of(filter(belongs, runs), uncertainty)
        for bound in BOUNDS if any(map(belongs, runs)) else ():
            row = {"kind": "speedUp", "scene": scene, "opponent": opponent, "bound": bound, "ratio": None}
            if bound < uncertainty:
                rows.append(row | {"opponentOutcome": BELOW, "ownOutcome": BELOW})
                continue
            slow, quick = read(theirs, bound), read(own, bound)
            found = {"ratio": speed_up(theirs, own, bound)}
            found |= {"opponentSeconds": slow.seconds, "ownSeconds": quick.seconds}
            rows.append(row | found | {"opponentOutcome": slow.what, "ownOutcome": quick.what})
    return rows
