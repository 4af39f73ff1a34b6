"""Long runs and many scenes: does a simulator that runs for days keep its energy, its lengths, its memory?

Question
    Does the energy of an undamped cable drift over ten million steps, do its constraints, and does the
    memory of a process grow with the scenes that it has built, run and dropped?

What would refute it
    A mean energy of the last tenth of the run that differs from that of the first by more than a tenth of
    what the energy varies by anyway; a violation of a constraint above 1e-9; a resident memory after the
    last scenes that is more than 5 % above that after the first ones.

Protocol
    The planar pendulum, N = 5, RATTLE, h = 2.5e-3 s: ten million steps in compiled calls of a thousand,
    looked at after each. As a control, a tenth of that with a bending damping that is too small for a swing
    of 5 s to show it: its loss has to be found.
    Then scenes of each way that a run can take, 200 times each in a process of its own: built, run for some
    steps, dropped; memory counts after the first 20, when libraries and kernels are loaded. As a control,
    scenes that are kept have to be found, too.

What is left out
    Memory that a scene in use needs (`scaling`). Other schemes than RATTLE.
"""

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from tqdm import tqdm

from exudyn_inext import DivergenceError, ExplicitSettings, ExplicitStepper
from studies.harness import Row, inner
from studies.harness.joined_scenes import Contents, joined_scene
from studies.harness.memory import KINDS, dropped_scenes
from studies.harness.process import ask
from studies.stability.motion import Invariants

ELEMENTS, STEP, CALL = 5, 2.5e-3, 1000  # steps in a compiled call
STEPS, SCENES, WARM_UP = (20_000, 10_000_000), (6, 200), (3, 20)  # of a quick and of a full run
CONTROL = 1e-10  # bending damping [N m^2 s]
DRIFT, VIOLATION, GROWTH = 0.1, 1e-9, 0.05  # limits, see above
MEGA = 1e6
QUICK = ("joined to bodies", "control: compiled steps, kept")
POINTS = 500  # of a curve that is stored


def runs(quick: bool) -> list[Row]:
    """Long ones, and one that has to drift."""
    steps = STEPS[not quick]
    return [
        {"label": "undamped", "damping": 0.0, "steps": steps},
        {"label": "control, slightly damped", "damping": CONTROL, "steps": steps // 10},
    ]


def watched_run(case: Row) -> Row:
    """So many steps of the pendulum with that bending damping [N m^2 s]."""
    mbs = joined_scene(Contents(elements=ELEMENTS, damping=case["damping"]))
    return long_run(case["label"], mbs, ExplicitSettings("RATTLE", stepSize=STEP), case["steps"])


def ways(quick: bool) -> list[Row]:
    """Of a run whose scenes are dropped."""
    return [{"label": kind, "full": not quick} for kind in (QUICK if quick else KINDS)]


def dropped(case: Row) -> Row:
    """Memory of a process of its own."""
    scenes, warm_up = SCENES[case["full"]], WARM_UP[case["full"]]
    return memory_row(case["label"], ask(dropped_scenes, case["label"], warm_up + scenes), warm_up)


def long_run(label: str, mbs: Any, settings: ExplicitSettings, steps: int) -> Row:
    """So many steps of a lone cable, looked at after each call.   settings: with a step."""
    (in_scene,) = inner.read_scene(mbs).cables
    cable = in_scene.cable
    force = inner.CableLoads(in_scene).constant.reshape(cable.reference.shape)
    invariants, stepper, looks = Invariants(cable, force), ExplicitStepper(mbs, settings), []

    def look() -> None:
        q, v, _ = stepper.State()
        energies = invariants.kinetic(v), invariants.energy(q, v)
        looks.append((*energies, invariants.violation(q), invariants.rate(q, v)))

    stepper.Start()
    look()
    call = min(CALL, steps // 20)
    survives, seconds = True, time.process_time()
    try:
        for _ in tqdm(range(steps // call), desc=label, unit="call", mininterval=5.0):
            stepper.Step(call)
            look()
    except DivergenceError:
        survives = False
    kinetic, total, violations, rates = np.array(looks).T
    energy = (total - total[0]) / (kinetic.max() or 1.0)  # over the swing
    tenth, every = max(1, len(energy) // 10), max(1, len(energy) // POINTS)
    taken = call * (len(energy) - 1)
    return {
        "label": label,
        "steps": taken,
        "stepSize": stepper.stepSize,
        "survives": survives,
        "hours": taken * stepper.stepSize / 3600.0,
        "cpuSeconds": time.process_time() - seconds,
        "range": float(np.ptp(energy)),
        "drift": float(energy[-tenth:].mean() - energy[:tenth].mean()),
        "violation": float(violations.max()),
        "rate": float(rates.max()),
        "times": (stepper.stepSize * call * np.arange(len(energy)))[::every].tolist(),
        "energies": energy[::every].tolist(),
    }


def memory_row(kind: str, memory: Sequence[int], warm_up: int) -> Row:
    """Growth over the scenes after the warm-up.   memory: [bytes] after each scene."""
    counted = np.array(memory[warm_up:]) / MEGA
    tenth = max(1, len(counted) // 10)
    first, last = float(counted[:tenth].mean()), float(counted[-tenth:].mean())
    return {
        "label": kind,
        "scenes": len(counted),
        "firstMegabytes": first,
        "lastMegabytes": last,
        "kilobytesAScene": 1e3 * float(counted[-1] - counted[0]) / len(counted),
        "growthPercent": 100.0 * (last / first - 1.0),
        "megabytes": [value / MEGA for value in memory],
    }


def drift_of(row: Row) -> float:
    """Change of the mean energy of a run over what the energy varies by anyway."""
    return float(abs(row["drift"]) / (row["range"] or math.inf))
