"""Random scenes at default settings: does every run end, how accurate is it, and what does it cost?

Question
    What does a user meet who releases ropes of any stiffness in any direction, alone and among bodies,
    springs and contact, and gives no setting at all?

What would refute it
    A run that does not end; in more than one run out of twenty, a distance to the run with a quarter of the
    step of more than 1 % of the motion, before the first snap.

Protocol
    600 lone ropes and 200 with a mass point, a rigid body, springs or a contact, drawn from their seeds
    (`robust`), over 1.5 s, the free end at 100 Hz; CPU time of the whole call. A snap is an output period in
    which the velocity of the end changes by more than half of its largest value so far. Beside the first 30
    lone ropes, native cables with generalized-alpha at h = 5e-4 s and default settings otherwise. A failure
    is a row with its reason.

What is left out
    Accuracy after a snap: the motion is chaotic there. Stretch, which softens snaps.
"""

import math
import time
import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from exudyn_inext import ExplicitSettings, SolveExplicit
from reference_models.model import quiet_settings, silence
from reference_models.trajectory import Array

from .harness import Results, Row, Study, column, groups, tables, verdict
from .harness.bars import Bar, conclusions
from .harness.benchmark import Benchmark, Series
from .harness.inner import largest_step
from .robust.scenes import LONE, NATIVE, Rope, build, lone_rope, mixed_rope, moved

END, PERIOD = 1.5, 0.01  # [s]
NATIVE_STEP = 5e-4  # [s]
ACCURATE, SHARE = 0.01, 0.95  # of the motion; of the runs
JUMP = 0.5  # of the velocity that counts as a snap
SLOW_START = 5  # output periods after which a jump can be told


def lone_cases(quick: bool) -> list[Row]:
    """Seeds of lone ropes."""
    return [{"partner": LONE, "seed": seed} for seed in range(8 if quick else 600)]


def own_cases(quick: bool) -> list[Row]:
    """All scenes, by what is in them and their seeds."""
    mixed = [{"partner": mixed_rope(seed).partner, "seed": seed} for seed in range(4 if quick else 200)]
    return lone_cases(quick) + mixed


def _rope(case: Row) -> Rope:
    return (lone_rope if case["partner"] == LONE else mixed_rope)(case["seed"])


def own_row(case: Row) -> Row:
    """A run at default settings, and its distance to one with a quarter of the step."""
    rope = _rope(case)
    found, path, report = _run(rope, ExplicitSettings())
    row = _described(rope) | found
    if row["failure"]:
        return row
    step, _ = largest_step(report["bounds"])
    finer = ExplicitSettings(stepSize=step / 4, massScaling=report["massScaling"], allowUnstableStep=True)
    reference, fine, _ = _run(rope, finer)
    row |= {
        "stepSize": step,
        **{key: report[key] for key in ("massScaling", "steps", "rejections")},
        "energyGain": report["drift"].get("energyGain", 0.0),
    }
    if reference["failure"]:
        return row | {"errorBeforeSnap": math.inf, "error": math.inf}
    distance = np.linalg.norm(path - fine, axis=1) / moved(fine)
    calm = periods_before_snap(fine)
    errors = {"errorBeforeSnap": float(distance[:calm].max()), "error": float(distance.max())}
    return row | errors | {"calm": calm}


def native_row(case: Row) -> Row:
    """Native cables with generalized-alpha."""
    rope = _rope(case)
    return _described(rope) | _run(rope)[0]


MEASURE = Benchmark(
    [
        Series("own", own_cases, own_row),
        Series("native", lambda quick: lone_cases(quick)[: 2 if quick else 30], native_row),
    ]
)


def _described(rope: Rope) -> Row:
    return {
        "label": f"{rope.partner}, seed {rope.seed}",
        **{key: getattr(rope, key) for key in ("elements", "stiffness", "dimension")},
        "tipMass": rope.tip_mass,
        "support": "clamped" if rope.clamped else "pinned",
    }


def _run(rope: Rope, explicit: ExplicitSettings | None = None) -> tuple[Row, Array, Any]:
    """CPU time and what went wrong; path of the free end (T, 3); the report.   explicit: None: native."""
    _container, mbs, sensor = build(rope) if explicit else build(rope, NATIVE)
    settings = quiet_settings(END, 1 if explicit else round(END / NATIVE_STEP), PERIOD)
    start, report, failure = time.process_time(), None, ""
    with silence(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            report = SolveExplicit(mbs, settings, explicit) if explicit else mbs.SolveDynamic(settings)
        except Exception as error:  # Exudyn's solver errors have no common type
            failure = f"{type(error).__name__}: {error}"
    path = np.array(mbs.GetSensorStoredData(sensor))
    if not failure and path[-1, 0] < END - PERIOD:
        failure = f"stopped at t = {path[-1, 0]:.3g} s"
    return {"cpuSeconds": time.process_time() - start, "failure": failure}, path[:, 1:4], report


def periods_before_snap(path: Array) -> int:
    """Output periods before the velocity of the end jumps."""
    velocity = np.diff(path, axis=0)
    speed = np.maximum.accumulate(np.linalg.norm(velocity, axis=1))
    change = np.linalg.norm(np.diff(velocity, axis=0), axis=1)
    jumps = np.flatnonzero(change[SLOW_START:] > JUMP * speed[SLOW_START:-1])
    return int(jumps[0]) + SLOW_START + 1 if len(jumps) else len(path)


def _summary(results: Results) -> list[Row]:
    """One row for each kind of scene."""
    rows = []
    for group in groups([row | {"of": (row["kind"], row["partner"])} for row in results.rows], "of").values():
        errors = np.array([row["errorBeforeSnap"] for row in group if "errorBeforeSnap" in row])  # ended
        seconds = column(group, "cpuSeconds")
        rows.append(
            {
                "kind": group[0]["kind"],
                "partner": group[0]["partner"],
                "number": len(group),
                "failures": len(_failed(group)),
                "accurate": float(np.mean(errors < ACCURATE)) if errors.size else None,
                "median": float(np.median(errors)) if errors.size else None,
                "cpuMedian": float(np.median(seconds)),
                "cpuLargest": max(seconds),
            }
        )
    return rows


def _failed(rows: Iterable[Row]) -> list[Row]:
    return [row for row in rows if row["failure"]]


DISTANCE = "distance to a run with a quarter of the step, before the first snap, over the motion"
ACCURACY = conclusions(Bar("own", "errorBeforeSnap", DISTANCE, ACCURATE, noise=1.0, share=SHARE))


def conclude(results: Results) -> list[str]:
    """Failures, accuracy, cost."""
    own, native = results.of_kind("own"), results.of_kind("native")
    failures = len(_failed(own))
    said = [
        f"{failures} of {len(own)} runs at default settings did not end: {verdict(failures == 0)}.",
        *ACCURACY(results),
        f"All of them took {sum(column(own, 'cpuSeconds')):.3g} s of CPU time.",
    ]
    if native:
        seeds = set(column(native, "seed"))
        beside = sum(row["cpuSeconds"] for row in own if row["partner"] == "lone" and row["seed"] in seeds)
        taken = sum(column(native, "cpuSeconds"))
        said.append(
            f"Native cables with generalized-alpha at h = {NATIVE_STEP:g} s did not end in "
            f"{len(_failed(native))} of the first {len(native)} lone ropes, and took {taken / beside:.0f} "
            "times the CPU time there."
        )
    return said


TABLES = tables(
    """
    summary: Random scenes over 1.5 s:
        solver: kind | scenes: partner | number | failures | share within 1 %: accurate |
        median error: median | CPU, median [s]: cpuMedian | CPU, largest [s]: cpuLargest
    lost: Runs that did not end:
        solver: kind | scene: partner | seed | N: elements | why: failure
    """,
    summary=_summary,
    lost=lambda results: _failed(results.rows),
)

QUESTION = "Does every run end at default settings, how accurate is it, and what does it cost?"
STUDY = Study("robustness", QUESTION, MEASURE, conclude, TABLES, minutes=4)
