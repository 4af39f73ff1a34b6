"""Work and precision: what accuracy costs, for every formulation, integrator, mesh and step, on every scene.

Question
    What does a given error cost in CPU time: by inextensible cables, by native ones, and by what a
    roboticist would take instead, a chain of rigid links; and where does the inextensible cable lose?

What would refute it
    On the planar pendulum, a native front less than 50 times, or one of rigid links less than once, to
    the right of the inextensible one at 5e-3 m or at 7e-4 m.

Protocol
    All cases of a scene are run once untimed, then in turn, alone in one process: five times, three times
    above 0.3 s, once above 3 s; medians of CPU time are compared. What is timed is the solver's call, as for
    Table 1, with sensors at 100 Hz; of MuJoCo its steps alone. Inextensible runs are not ended for their
    energy, since it is the error that is measured. What diverges or fails stays, with its status.
    Fronts hold the runs that no other of their family beats, and that gain 5 % of the error at least. The
    cost of an error is read off between neighbours of a front, on logarithmic scales, and never beyond its
    ends.

Reference and tolerance
    Those of the scenes: independent MBDyn models of the inextensible limit (pendulums, ring), a refined
    solution with what refinement changes (power line). Errors below that uncertainty count as large as it;
    below it nothing is said. Native cables stretch: by Table 1, they cannot be expected within some
    3e-4 m of the limit.

How the rows were chosen
    Native: the tuned rows of `table1`, `table2`, `ring`, `table3`, and series beside them; explicit
    ones at their largest stable steps, found by bisection, and some at half of it. Inextensible: every scheme
    at 0.95 and 0.5 of its limit on every mesh, scaled masses over meshes and steps, the tuned rows of the
    tables; penalty masses and algebraic constraints under native solvers near the steps of `enforcement`.
    Rigid links (extra `peers`): RK4 at 0.95 and 0.5 of its stability limit, with the rotary inertia of
    uniform rods and with that of least error on these scenes (3/4 to 3/2 of it were tried); MuJoCo's
    other integrators, which are of first order here, where they are cheap.

What is left out
    Native explicit rows of more than some 20 s; rigid links on the ring and on the power line.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case

from .harness import Results, Row, Study, announce, groups, tables
from .harness.bars import Bar, conclusions
from .harness.benchmark import Benchmark, Series
from .harness.figures import COST_AXES, LOOKS, front_curves
from .harness.plot import COLORS, Curve, Panel, chart
from .harness.ratios import (
    BY_NATIVE_SOLVERS,
    EXPLICIT,
    IMPLICIT,
    INEXTENSIBLE,
    OPPONENTS,
    PEER,
    family_of,
    front_of,
    is_usable,
    members,
    method_of,
    read,
    speed_up,
)
from .harness.reference import ReferenceSolution
from .harness.timing import measure
from .precision.cases import LINKED_SCENES, NOT_INSTALLED, cases_of
from .table3 import reference_of

SCENES = ("planar_pendulum", "spatial_pendulum", "vibrating_ring", "power_line")
QUICK_MOTION, QUICK_REPEATS = 0.5, 1  # [s]


def make_cases(quick: bool) -> list[Row]:
    """One a scene."""
    return [
        {
            "scene": name,
            "motion": QUICK_MOTION if quick else load_scene(name).end_time,
            "repeats": QUICK_REPEATS if quick else REPEATS,
            "quick": quick,
        }
        for name in SCENES
    ]


BOUNDS = (1e-2, 5e-3, 3e-3, 1e-3, 7e-4, 3e-4)  # [m]
BELOW = "below the reference's uncertainty"
REPEATS, SLOW_REPEATS, SLOWEST_REPEATS = 5, 3, 1
SLOW, SLOWEST = 0.3, 3.0  # [s] of CPU time


def repeats_of(seconds: float) -> int:
    """Timed runs of a case whose warm-up took that CPU time [s]."""
    return SLOWEST_REPEATS if seconds > SLOWEST else SLOW_REPEATS if seconds > SLOW else REPEATS


def run_scene(case: Row) -> list[Row]:
    """Of a scene: its reference, every run, and the ratios."""
    scene = replace(load_scene(case["scene"]), end_time=case["motion"])
    announce(scene.name, "preparing the reference and the cases, finding stable steps")
    reference = reference_of(scene)
    runs = measured(scene, cases_of(scene, case["quick"]), reference, case["repeats"])
    ratios = ratio_rows(scene.name, runs, reference.uncertainty)
    return [reference_row(scene, reference), *runs, *ratios]


def measured(
    scene: Scene, cases: Sequence[Case], reference: ReferenceSolution, repeats: int = REPEATS
) -> list[Row]:
    """One row a case; what fails or diverges keeps its row, with its status."""
    found = measure(cases, repeats, reference.trajectory, scene.name, repeats_of)
    return [{"kind": "run", "scene": scene.name, **row, "family": family_of(row)} for row, _ in found]


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
    for opponent in OPPONENTS:
        theirs = front_of(some := members(runs, opponent), uncertainty)
        for bound in BOUNDS if some else ():
            row = {"kind": "speedUp", "scene": scene, "opponent": opponent, "bound": bound, "ratio": None}
            if bound < uncertainty:
                rows.append(row | {"opponentOutcome": BELOW, "ownOutcome": BELOW})
                continue
            for who, its_front in (("opponent", theirs), ("own", own)):
                row[f"{who}Seconds"], row[f"{who}Outcome"] = read(its_front, bound)
            rows.append(row | {"ratio": speed_up(theirs, own, bound)})
    return rows


BAR_SCENE, BAR_BOUNDS = "planar_pendulum", (5e-3, 7e-4)
LEAST = {IMPLICIT: 50.0, EXPLICIT: 50.0, PEER: 1.0}


def _barred(results: Results) -> list[Row]:
    """What the study has to show, on the whole motion of the planar pendulum."""
    return [
        row | {"label": f"{row['opponent']}, at {row['bound']:g} m", "bar": LEAST[row["opponent"]]}
        for row in results.of_kind("speedUp")
        if not results.quick
        and row["scene"] == BAR_SCENE
        and row["bound"] in BAR_BOUNDS
        and row["opponent"] in LEAST
    ]


def conclude(results: Results) -> list[str]:
    """Bars; where the cable loses; scenes without rigid links."""
    runs = groups(results.of_kind("run"), "scene")
    lacking = [name for name in LINKED_SCENES if name in runs and not members(runs[name], PEER)]
    return BARS(results) + [f"{name}: {NOT_INSTALLED}" for name in lacking]


OVER = "CPU time over that of the inextensible cable"
BARS = conclusions(
    Bar(_barred, "ratio", "{}: " + OVER, "bar", "label", is_least=True, noise=1.0),
    Bar("speedUp", "ratio", "{}: least " + OVER + " at any error", 1.0, "opponent", is_least=True),
)


_MARKERS = "osD^v<>PX*h"
POINTS = 200
ENDS = (min, 0), (max, -1)
_RATIO_AXES = "error [m]", "CPU time over the inextensible cable's [-]"


def draw(results: Results, directory: Path) -> list[Path]:
    """One picture a scene, and one of all ratios."""
    usable = groups(filter(is_usable, results.of_kind("run")), "scene")
    known = [(row, usable[row["scene"]]) for row in results.of_kind("reference") if row["scene"] in usable]
    if not known:
        return []
    paths = [_draw_scene(reference, runs, directory) for reference, runs in known]
    panels = [_ratios(reference, runs) for reference, runs in known]
    path = directory / "work_precision_ratios.png"
    return [*paths, chart(path, *panels, width=11.0, height=8.0, rows=2, columns=4)]


def _draw_scene(reference: Row, runs: Sequence[Row], directory: Path) -> Path:
    scene, unknown = reference["scene"], reference["uncertainty"]
    families = groups([row | {"family": family_of(row)} for row in runs], "family")
    own = [row for family in (INEXTENSIBLE, BY_NATIVE_SOLVERS) for row in families.get(family, [])]
    methods = dict(sorted(groups([row | {"method": method_of(row)} for row in own], "method").items()))
    looks = {name: (COLORS[k % len(COLORS)], _MARKERS[k % len(_MARKERS)]) for k, name in enumerate(methods)}
    panels = []
    for rows, look, title in (
        (families, LOOKS, f"{scene}: all formulations"),
        (methods, looks, "inextensible cables by method"),
    ):
        curves = front_curves(rows, look, lambda rows: front_of(rows, unknown))
        panels.append(Panel(*COST_AXES, curves, title=title, legend="below", unknown=unknown))
    return chart(directory / f"work_precision_{scene}.png", *panels, width=12.0, height=6.4)


def _ratios(reference: Row, runs: Sequence[Row]) -> Panel:
    """Where both fronts are; ends may leave one by rounding."""
    own = front_of(members(runs, INEXTENSIBLE), reference["uncertainty"])
    curves = []
    for opponent in (BY_NATIVE_SOLVERS, IMPLICIT, EXPLICIT, PEER):
        theirs = front_of(members(runs, opponent), reference["uncertainty"])
        if not (theirs and own):
            continue
        largest, least = (choose(theirs[k]["errorMax"], own[k]["errorMax"]) for choose, k in ENDS)
        if largest > least:
            errors = np.geomspace(largest, least, POINTS)[1:-1]
            ratios = [speed_up(theirs, own, float(bound)) for bound in errors]
            curves.append(Curve(errors, ratios, opponent, LOOKS[opponent][0], "-"))
    title = reference["scene"] + ("" if curves else ": no fronts overlap")
    return Panel(*_RATIO_AXES, curves, title=title, legend=False, horizontal=(1.0,))


TABLES = tables(
    """
    reference: What errors are measured against:
        scene | source | uncertainty [m]: uncertainty | self-convergence: selfConvergence
    speedUp: CPU time over that of the inextensible cable, at equal error:
        scene | opponent | error [m]: bound | ratio | opponent [s]: opponentSeconds |
        inextensible [s]: ownSeconds | opponent's front: opponentOutcome | inextensible front: ownOutcome
    run: All runs:
        case: label | scene | h [s]: stepSize | CPU [s]: cpuSeconds | CPU min [s]: cpuSecondsMin |
        repeats | error max [m]: errorMax | error rms [m]: errorRms | status
    """
)

QUESTION = "What does an accuracy cost in each formulation, and where does the inextensible cable lose?"
STUDY = Study(
    "work_precision",
    QUESTION,
    Benchmark([Series("scene", make_cases, run_scene)]),
    conclude,
    TABLES,
    draw,
    minutes=20,
)
