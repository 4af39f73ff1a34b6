"""Ensembles: many pendulums in one call, on one core and on all.

Question
    Does a cable in an ensemble cost no more than alone, and do two cores do nearly twice as much as one?

What would refute it
    More CPU time a cable on one core than SolveExplicit takes; less than 1.8 times the speed on two cores.

Protocol
    Planar pendulums of Table 1: all alike, or each with a stiffness (0.5 to 1 times) and an angle (-60 to
    60 degrees) of its own; 5 s of motion, or 0.5 s as in model-predictive control; positions at 100 Hz.
    The systems are built before. "Alone" is SolveExplicit with a tip sensor, one member after the other.
    "In the ensemble" is the whole SolveEnsemble: reading and checking the systems, the compiled call, the
    arrays. Costs of one core are CPU time; the gain of all cores is wall time over wall time in the same
    round. Every round runs all three, after an untimed one; medians. Gains count from rounds before
    and after which all cores were free, as hashing the same bytes on one core and on all shows.

Check
    The last coordinates of members alone and in the ensemble, on one and on all cores, are equal bit for bit.

What is left out
    Building the systems: some 0.8 ms a pendulum, the same for both.
"""

import hashlib
import os
import statistics
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from exudyn_inext import ExplicitSettings, SolveEnsemble, SolveExplicit
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import Line, Scene, load_scene

from .harness import Order, Results, Row, Study, Table, groups, judged, largest
from .harness.timing import in_turn

SCENE = load_scene("planar_pendulum")
MILLI = 1e3
GAIN_PER_CORE = 0.9  # the bar: 1.8 on two cores
HASHED_BYTES = 2**25
QUIET = 0.95  # share of all cores that must be free
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
MOST_ALONE = 100  # members that are also run alone


@dataclass(frozen=True)
class Case:
    """An ensemble.   end_time: [s].   different: whether the members have parameters of their own."""

    elements: int
    settings: ExplicitSettings
    end_time: float
    different: bool


SETTINGS = {5: ExplicitSettings(stepSize=2.5e-3), 10: ExplicitSettings(stepSize=2e-3, massScaling=0.3)}
CASES = (
    Case(5, SETTINGS[5], 5.0, False),
    Case(5, SETTINGS[5], 5.0, True),
    Case(10, SETTINGS[10], 5.0, False),
    Case(10, SETTINGS[10], 5.0, True),
    Case(5, SETTINGS[5], 0.5, True),
)
QUICK_CASES = (replace(CASES[1], end_time=0.5), replace(CASES[3], end_time=0.5))


def measure(order: Order) -> list[Row]:
    """One row a case."""
    cases, members, rounds = (QUICK_CASES, 50, 2) if order.quick else (CASES, 1000, 5)
    return [_row(case, members, rounds) for case in cases]


def _row(case: Case, members: int, rounds: int) -> Row:
    models = [build(_scene(case, m / members), case.elements) for m in range(members)]
    settings, cores, free = quiet_settings(case.end_time, 1), CORES, []
    ensemble = partial(SolveEnsemble, [model.mbs for model in models], settings, case.settings)
    some = models[:: max(1, members // MOST_ALONE)]
    tasks = {
        "before": lambda: free.append(_free_cores(cores)),
        "alone": partial(_run_alone, some, settings, case.settings),
        "one core": partial(ensemble, threads=1),
        "all cores": partial(ensemble, threads=cores),
        "after": lambda: free.append(_free_cores(cores)),
    }
    runs = {label: partial(partial, task) for label, task in tasks.items()}
    found = in_turn(runs, rounds, f"N = {case.elements}, {case.end_time:g} s", turns=False)
    _, alone, one, all_cores, _ = found.values()
    free_cores = [min(pair) for pair in zip(free[2::2], free[3::2], strict=True)]
    gains = (np.array(one.wall_seconds) / all_cores.wall_seconds).tolist()
    quiet = [gain for gain, cores_free in zip(gains, free_cores, strict=True) if cores_free > QUIET * cores]
    cost_alone, together = (alone.median or 0.0) / len(some), (one.median or 0.0) / members
    coordinates = one.found["coordinates"]
    return {
        "kind": "ensemble",
        "label": "each different" if case.different else "all alike",
        "members": members,
        "elements": case.elements,
        "endTime": case.end_time,
        "integrator": one.found["integrator"],
        "stepSize": float(one.found["stepSize"][0]),
        "massScaling": case.settings.massScaling,
        "cores": cores,
        "alone": MILLI * cost_alone,
        "together": MILLI * together,
        "costRatio": together / cost_alone,
        "wallOfAllCores": MILLI * statistics.median(all_cores.wall_seconds) / members,
        "gain": statistics.median(quiet) if quiet else None,
        "quietRounds": len(quiet),
        "rounds": rounds,
        "gains": gains,
        "freeCores": free_cores,
        "isEqual": np.array_equal(coordinates, all_cores.found["coordinates"])
        and np.array_equal(coordinates[:: members // len(some), -1], alone.found),
    }


def _scene(case: Case, share: float) -> Scene:
    """The pendulum; a different one for each share, 0 to 1."""
    scene = replace(SCENE, end_time=case.end_time)
    if not case.different:
        return scene
    cable, angle = scene.cable, np.radians(-60.0 + 120.0 * share)
    section = replace(cable.section, youngs_modulus=(0.5 + 0.5 * share) * cable.section.youngs_modulus)
    shape = Line(direction=(float(np.cos(angle)), float(np.sin(angle)), 0.0))
    return replace(scene, cable=replace(cable, section=section, shape=shape))


def _run_alone(models: list[Model], settings: Any, explicit: ExplicitSettings) -> list[Any]:
    """Last coordinates of each."""
    with silence():
        for model in models:
            SolveExplicit(model.mbs, settings, explicit)
    return [model.mbs.systemData.GetODE2Coordinates() for model in models]


def _free_cores(cores: int) -> float:
    """How many cores this process gets at present."""
    data = bytes(HASHED_BYTES)
    with ThreadPoolExecutor(cores) as pool:
        start = time.perf_counter()
        hashlib.sha256(data)
        middle = time.perf_counter()
        list(pool.map(hashlib.sha256, [data] * cores))
        end = time.perf_counter()
    return min(float(cores), cores * (middle - start) / (end - middle))


def conclude(results: Results) -> list[str]:
    """Whether the bars are kept."""
    rows = results.of_kind("ensemble")
    dearest = largest(rows, "costRatio")
    return [
        "A cable in the ensemble costs at most {costRatio:.2f} of a cable alone (N = {elements}, {endTime:g} "
        "s, {label}); the bar of 1 is ".format_map(dearest)
        + f"{judged(dearest['costRatio'], 1.0, results.noise)}.",
        *(_gain(end, own, results.noise) for end, own in sorted(groups(rows, "endTime").items())),
        "Alone, in the ensemble, and on any number of cores, the motions are "
        + ("equal bit for bit." if all(row["isEqual"] for row in rows) else "NOT EQUAL."),
    ]


def _gain(end_time: float, rows: Sequence[Row], noise: float) -> str:
    """What all cores do in motions of one length."""
    motions, cores = f"Motions of {end_time:g} s:", rows[0]["cores"]
    measured = [row for row in rows if row["gain"] is not None]
    if not measured:
        return f"{motions} no round in which all {cores} cores were free, no gain measured."
    slowest, bar = min(measured, key=lambda row: float(row["gain"])), GAIN_PER_CORE * cores
    return (
        f"{motions} {cores} cores do at least {slowest['gain']:.2f} times as much as one ("
        f"N = {slowest['elements']}, {slowest['label']}); the bar of {bar:g} is "
        f"{judged(bar, slowest['gain'], noise)}."
    )


TABLE = Table(
    "ensemble",
    "Milliseconds a cable (CPU time; for all cores, wall time):",
    "parameters: label | members | N: elements | motion [s]: endTime | h [s]: stepSize | "
    "alone [ms]: alone | one core [ms]: together | ratio: costRatio | "
    "all cores [ms]: wallOfAllCores | gain | quiet rounds: quietRounds",
)

QUESTION = "What does a pendulum cost among a thousand others, and how much do more cores do?"
STUDY = Study("ensemble", QUESTION, measure, conclude, [TABLE], minutes=5)
