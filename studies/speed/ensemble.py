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
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from exudyn_inext import ExplicitSettings, SolveEnsemble, SolveExplicit
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import Line, Scene, Section, load_scene
from studies.harness import Row
from studies.harness.timing import Prepare

SCENE = load_scene("planar_pendulum")
MILLI = 1e3
HASHED_BYTES = 2**25
QUIET = 0.95  # share of all cores that must be free
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
GAIN = 0.9 * CORES  # the bar: 1.8 on two cores
MOST_ALONE = 100  # members that are also run alone
SETTINGS = {5: ExplicitSettings(stepSize=2.5e-3), 10: ExplicitSettings(stepSize=2e-3, massScaling=0.3)}
DIFFERENT = "each different"


def cases(quick: bool) -> list[Row]:
    """Ensembles."""
    full = [(n, 5.0, label) for n in SETTINGS for label in ("all alike", DIFFERENT)] + [(5, 0.5, DIFFERENT)]
    asked, members = ([(n, 0.5, DIFFERENT) for n in SETTINGS], 50) if quick else (full, 1000)
    return [{"elements": n, "endTime": end, "label": label, "members": members} for n, end, label in asked]


def tasks(case: Row) -> dict[str, Prepare]:
    """Members alone, and the ensemble on one and on all cores, between looks at free cores."""
    members, settings = case["members"], quiet_settings(case["endTime"], 1)
    models = [build(_scene(case, m / members), case["elements"]) for m in range(members)]
    own = SETTINGS[case["elements"]]
    ensemble = partial(SolveEnsemble, [model.mbs for model in models], settings, own)
    free: list[float] = []
    some = models[:: max(1, members // MOST_ALONE)]
    runs = {
        "before": partial(_look, free),
        "alone": partial(_run_alone, some, settings, own),
        "one core": partial(ensemble, threads=1),
        "all cores": partial(ensemble, threads=CORES),
        "after": partial(_look, free),
    }
    return {label: partial(partial, run) for label, run in runs.items()}


def row(case: Row, found: Any) -> Row:
    """Costs of a member, gain of all cores in rounds in which these were free."""
    _, alone, one, all_cores, after = found.values()
    members, number = case["members"], len(alone.found)
    free = [min(pair) for pair in zip(after.found[2::2], after.found[3::2], strict=True)]
    gains = (np.array(one.wall_seconds) / all_cores.wall_seconds).tolist()
    quiet = [gain for gain, cores in zip(gains, free, strict=True) if cores > QUIET * CORES]
    cost_alone, together = alone.median / number, one.median / members
    coordinates = one.found["coordinates"]
    return case | {
        "integrator": one.found["integrator"],
        "stepSize": float(one.found["stepSize"][0]),
        "massScaling": SETTINGS[case["elements"]].massScaling,
        "cores": CORES,
        "alone": MILLI * cost_alone,
        "together": MILLI * together,
        "costRatio": together / cost_alone,
        "wallOfAllCores": MILLI * statistics.median(all_cores.wall_seconds) / members,
        "gain": statistics.median(quiet) if quiet else None,
        "quietRounds": len(quiet),
        "rounds": len(gains),
        "gains": gains,
        "freeCores": free,
        "isEqual": np.array_equal(coordinates, all_cores.found["coordinates"])
        and np.array_equal(coordinates[:: members // number, -1], alone.found),
    }


def _scene(case: Row, share: float) -> Scene:
    """The pendulum; a different one for each share, 0 to 1."""
    scene = replace(SCENE, end_time=case["endTime"])
    if case["label"] != DIFFERENT:
        return scene
    cable, angle = scene.cable, np.radians(-60.0 + 120.0 * share)
    own, stiffness = cable.section, 0.5 + 0.5 * share
    section = Section(own.mass_per_length, stiffness * own.bending_stiffness, stiffness * own.axial_stiffness)
    shape = Line(direction=(float(np.cos(angle)), float(np.sin(angle)), 0.0))
    return replace(scene, cable=replace(cable, section=section, shape=shape))


def _run_alone(models: list[Model], settings: Any, explicit: ExplicitSettings) -> list[Any]:
    """Last coordinates of each."""
    with silence():
        for model in models:
            SolveExplicit(model.mbs, settings, explicit)
    return [model.mbs.systemData.GetODE2Coordinates() for model in models]


def _look(free: list[float]) -> list[float]:
    """Adds how many cores this process gets at present."""
    data = bytes(HASHED_BYTES)
    with ThreadPoolExecutor(CORES) as pool:
        start = time.perf_counter()
        hashlib.sha256(data)
        middle = time.perf_counter()
        list(pool.map(hashlib.sha256, [data] * CORES))
        end = time.perf_counter()
    free.append(min(float(CORES), CORES * (middle - start) / (end - middle)))
    return free
