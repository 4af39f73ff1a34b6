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
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from tqdm import tqdm

from exudyn_inext import ExplicitSettings, SolveEnsemble, SolveExplicit
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import Line, Scene, load_scene

from .harness.benchmark import Benchmark, Figures, Table
from .harness.study import Row
from .harness.timing import garbage_collection_off
from .harness.verdict import at_most, verdict

SCENE = load_scene("planar_pendulum")
MILLI = 1e3
GAIN_PER_CORE = 0.9  # the bar: 1.8 on two cores
HASHED_BYTES = 2**25
QUIET = 0.95  # share of all cores that must be free
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


def measure(quick: bool) -> list[Row]:
    """One row a case."""
    cases, members, rounds = (QUICK_CASES, 50, 2) if quick else (CASES, 1000, 5)
    return [_measure_case(case, members, rounds) for case in cases]


def _measure_case(case: Case, members: int, rounds: int) -> Row:
    models = [build(_scene(case, m / members), case.elements) for m in range(members)]
    settings = quiet_settings(case.end_time, 1)
    systems, cores = [model.mbs for model in models], _cores()
    ensemble = partial(SolveEnsemble, systems, settings, case.settings)
    tasks: dict[str, Callable[[], Any]] = {
        "alone": partial(_run_alone, models[:: max(1, members // MOST_ALONE)], settings, case.settings),
        "one core": partial(ensemble, threads=1),
        "all cores": partial(ensemble, threads=cores),
    }
    results, wall, cpu, free_cores = _interleaved(tasks, rounds, f"N = {case.elements}, {case.end_time:g} s")
    ran_alone = len(results["alone"])
    gains = [one / many for one, many in zip(wall["one core"], wall["all cores"], strict=True)]
    quiet = [gain for gain, free in zip(gains, free_cores, strict=True) if free > QUIET * cores]
    alone = statistics.median(cpu["alone"]) / ran_alone
    together = statistics.median(cpu["one core"]) / members
    return {
        "kind": "ensemble",
        "label": "each different" if case.different else "all alike",
        "members": members,
        "elements": case.elements,
        "endTime": case.end_time,
        "integrator": results["one core"]["integrator"],
        "stepSize": float(results["one core"]["stepSize"][0]),
        "massScaling": case.settings.massScaling,
        "cores": cores,
        "alone": MILLI * alone,
        "together": MILLI * together,
        "costRatio": together / alone,
        "wallOfAllCores": MILLI * statistics.median(wall["all cores"]) / members,
        "gain": statistics.median(quiet) if quiet else None,
        "quietRounds": len(quiet),
        "rounds": rounds,
        "gains": gains,
        "freeCores": free_cores,
        "isEqual": _is_equal(results, members // ran_alone),
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


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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


def _interleaved(tasks: dict[str, Callable[[], Any]], rounds: int, name: str) -> tuple[Any, Any, Any, Any]:
    """Last result, wall and CPU seconds of each task, and free cores in each round, after an untimed one."""
    free: list[float] = []
    results: dict[str, Any] = {}
    wall: dict[str, list[float]] = {label: [] for label in tasks}
    cpu: dict[str, list[float]] = {label: [] for label in tasks}
    for number in tqdm(range(rounds + 1), desc=name, unit="round"):
        before = _free_cores(_cores())
        for label, task in tasks.items():
            results.pop(label, None)  # its memory is used again
            with garbage_collection_off():
                start = time.perf_counter(), time.process_time()
                results[label] = task()
                end = time.perf_counter(), time.process_time()
            if number > 0:
                wall[label].append(end[0] - start[0])
                cpu[label].append(end[1] - start[1])
        if number > 0:
            free.append(min(before, _free_cores(_cores())))
    return results, wall, cpu, free


def _is_equal(results: dict[str, Any], stride: int) -> bool:
    one, many = (results[name]["coordinates"] for name in ("one core", "all cores"))
    alone = np.array(results["alone"])
    return bool(np.array_equal(one, many) and np.array_equal(one[::stride, -1], alone))


def conclude(figures: Figures) -> list[str]:
    """Whether the bars are kept."""
    rows = figures.of_kind("ensemble")
    dearest = max(rows, key=lambda row: float(row["costRatio"]))
    return [
        f"A cable in the ensemble costs at most {dearest['costRatio']:.2f} of a cable alone (N = "
        f"{dearest['elements']}, {dearest['endTime']:g} s, {dearest['label']}); the bar of 1 is "
        f"{verdict(at_most(dearest['costRatio'], 1.0, figures.noise))}.",
        *(_gain_sentence(rows, end_time, figures.noise) for end_time in sorted({r["endTime"] for r in rows})),
        "Alone, in the ensemble, and on any number of cores, the motions are "
        + ("equal bit for bit." if all(row["isEqual"] for row in rows) else "NOT EQUAL."),
    ]


def _gain_sentence(rows: Sequence[Row], end_time: float, noise: float) -> str:
    """What all cores do in motions of that length."""
    cores = rows[0]["cores"]
    measured = [row for row in rows if row["endTime"] == end_time and row["gain"] is not None]
    if not measured:
        return f"Motions of {end_time:g} s: no round in which all {cores} cores were free, no gain measured."
    slowest = min(measured, key=lambda row: float(row["gain"]))
    bar = GAIN_PER_CORE * cores
    return (
        f"Motions of {end_time:g} s: {cores} cores do at least {slowest['gain']:.2f} times as much as one ("
        f"N = {slowest['elements']}, {slowest['label']}); the bar of {bar:g} is "
        f"{verdict(at_most(bar, slowest['gain'], noise))}."
    )


STUDY = Benchmark(
    name="ensemble",
    question="What does a pendulum cost among a thousand others, and how much do more cores do?",
    measure=measure,
    tables=(
        Table(
            "ensemble",
            "Milliseconds a cable (CPU time; for all cores, wall time):",
            {
                "parameters": "label", "members": "members", "N": "elements", "motion [s]": "endTime",
                "h [s]": "stepSize", "alone [ms]": "alone", "one core [ms]": "together", "ratio": "costRatio",
                "all cores [ms]": "wallOfAllCores", "gain": "gain", "quiet rounds": "quietRounds",
            },
        ),
    ),
    conclusions=conclude,
)  # fmt: skip
