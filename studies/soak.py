"""Long runs and many scenes: does a simulator that runs for days keep its energy, its lengths, its memory?

Question
    Does the energy of an undamped cable drift over ten million steps, do its constraints, and does the
    memory of a process grow with the scenes that it has built, run and dropped? What lets Zhai's method,
    which gains or loses energy by itself, last as long?

What would refute it
    A mean energy of the last tenth of the run that differs from that of the first by more than a tenth of
    what the energy varies by anyway; a violation of a constraint above 1e-9; a resident memory after the
    last scenes that is more than 5 % above that after the first ones.

Protocol
    The planar pendulum, N = 5, RATTLE, h = 2.5e-3 s: ten million steps in compiled calls of a thousand,
    looked at after each. As a control, a tenth of that with a bending damping that is too small for a swing
    of 5 s to show it: its loss has to be found. The same pendulum under Zhai's method at 0.95 of its limit,
    a million steps, and one change of that at a time; the longest-lived ones over ten million.
    Then scenes of each way that a run can take, 200 times each in a process of its own: built, run for some
    steps, dropped; memory counts after the first 20, when libraries and kernels are loaded. As a control,
    scenes that are kept have to be found, too.

What is left out
    Memory that a scene in use needs (`scaling`).
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from exudyn_inext import DivergenceError, ExplicitSettings, ExplicitStepper, Zhai
from reference_models.inextensible import build
from reference_models.scenes import Line, load_scene

from .harness import Order, Results, Row, Study, inner, judged, tables
from .harness.cases import unguarded
from .harness.joined_scenes import Contents, joined_scene
from .harness.memory import KINDS, dropped_scenes
from .harness.plot import COLORS, REFERENCE_COLOR, Curve, Panel, chart
from .harness.pool import ask
from .stability.motion import Invariants

ELEMENTS, STEP, CALL = 5, 2.5e-3, 1000  # steps in a compiled call
STEPS, SCENES, WARM_UP = 10_000_000, 200, 20
CONTROL = 1e-10  # bending damping [N m^2 s]
CONTROLS = "control"  # how the labels of rows with a fault begin, which has to be found
DRIFT, VIOLATION, GROWTH = 0.1, 1e-9, 0.05  # limits, see above
MEGA = 1e6
QUICK = ("joined to bodies", "penaltyMass, native RK44", "control: penaltyMass, kept")
POINTS = 500  # of a curve that is stored


@dataclass(frozen=True)
class Swing:
    """The pendulum, released that many degrees off the vertical.

    part: of the stability limit.   zeta: stabilisation rate [1/s].   measure: of curvature.
    """

    integrator: str | Zhai = "Zhai"
    part: float = 0.95
    zeta: float = 100.0
    measure: str = "secondDerivative"
    angle: float = 90.0

    def run(self, label: str, steps: int) -> Row:
        """So many steps, or as many as it lasts."""
        scene, angle = load_scene("planar_pendulum"), np.radians(self.angle)
        line = Line(direction=(float(np.sin(angle)), float(-np.cos(angle)), 0.0))
        scene = replace(scene, cable=replace(scene.cable, shape=line))
        model = build(scene, ELEMENTS, self.measure)
        settings = replace(unguarded(self.integrator, None, 0.0, self.zeta), rejectSteps=False)
        h = self.part * ExplicitStepper(model.mbs, settings).bounds.stability_limit
        return long_run(label, model.mbs, replace(settings, stepSize=h), steps) | {"kind": "swing"}


BASE = "base: 0.95 of the limit, zeta = 100"
SWINGS = {
    BASE: Swing(),
    "half the step": Swing(part=0.95 / 2),
    "a quarter of the step": Swing(part=0.95 / 4),
    "an eighth of the step": Swing(part=0.95 / 8),
    "zeta = 10": Swing(zeta=10.0),
    "zeta = 30": Swing(zeta=30.0),
    "zeta = 300": Swing(zeta=300.0),
    "v_n, not the projected rate": Swing(Zhai(projected_rate=False)),
    "measure product": Swing(measure="product"),
    "swing from 30 degrees": Swing(angle=30.0),
    "swing from 10 degrees": Swing(angle=10.0),
    "corrector, psi = phi = 0": Swing(Zhai(psi=0.0, phi=0.0, corrector=True)),
    "RK4": Swing("RK4"),
}
LONGEST = ("an eighth of the step", "RK4")


def measure(order: Order) -> list[Row]:
    """One row for each long run and each kind of scene."""
    steps, scenes, warm_up = (20_000, 6, 3) if order.quick else (STEPS, SCENES, WARM_UP)
    rows = [
        watched_run("undamped", 0.0, steps),
        watched_run("control, slightly damped", CONTROL, steps // 10),
    ]
    swings = [(BASE, steps)] if order.quick else [(name, steps // 10) for name in SWINGS]
    swings += [] if order.quick else [(name, steps) for name in LONGEST]
    rows += [SWINGS[name].run(name, number) for name, number in swings]
    for kind in tqdm(QUICK if order.quick else KINDS, desc="soak", unit="kind"):
        rows.append(memory_row(kind, ask(dropped_scenes, kind, warm_up + scenes), warm_up))
    return rows


def watched_run(label: str, damping: float, steps: int) -> Row:
    """So many steps of the pendulum with that bending damping [N m^2 s]."""
    mbs = joined_scene(Contents(elements=ELEMENTS, damping=damping))
    return long_run(label, mbs, ExplicitSettings("RATTLE", stepSize=STEP), steps)


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
        "kind": "run",
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
        "kind": "memory",
        "label": kind,
        "scenes": len(counted),
        "firstMegabytes": first,
        "lastMegabytes": last,
        "kilobytesAScene": 1e3 * float(counted[-1] - counted[0]) / len(counted),
        "growthPercent": 100.0 * (last / first - 1.0),
        "megabytes": [value / MEGA for value in memory],
    }


def drifts(row: Row) -> bool:
    """Whether the mean energy of a run has changed by more than what it varies by anyway."""
    return not abs(row["drift"]) <= DRIFT * row["range"]


def conclude(results: Results) -> list[str]:
    """Drift, violations, memory, each against its limit; what decides how long Zhai lasts."""
    sentences = []
    for row in results.of_kind("run"):
        found = row | {"drifts": _drift(row, results.quick), "limit": VIOLATION}
        found["side"] = "within" if row["violation"] <= VIOLATION else "ABOVE"
        sentences += [
            "{label}: over {steps:,} steps ({hours:.2g} h of motion) the energy varies by {range:.1e} of the "
            "swing, and its mean {drifts} ({drift:.1e}).".format_map(found),
            "{label}: the largest violation of a constraint is {violation:.1e}, of its rate {rate:.1e} "
            "({side} {limit:g}).".format_map(found),
        ]
    sentences += [
        "{label}: memory {grows} over {scenes} scenes, {firstMegabytes:.1f} MB to {lastMegabytes:.1f} MB "
        "({growthPercent:+.2f} %, {kilobytesAScene:.1f} kB a scene).".format_map(
            row | {"grows": _growth(row, results)}
        )
        for row in results.of_kind("memory")
    ]
    return sentences + [_lasting(row) for row in results.of_kind("swing")]


def _drift(row: Row, quick: bool) -> str:
    """A quick run is too short for a verdict: its tenths are two looks each."""
    if quick:
        return "changes, undecided in so short a run"
    if row["label"].startswith(CONTROLS):
        return "drifts, as it should" if drifts(row) else "does NOT drift, as it should"
    return "DRIFTS" if drifts(row) else "does not drift"


def _growth(row: Row, results: Results) -> str:
    """A quick run has too few scenes for a control to show."""
    is_control = row["label"].startswith(CONTROLS)
    if is_control and results.quick:
        return "undecided"
    words = ("NOT growing, as it should,", "growing, as it should,") if is_control else ("flat", "NOT flat")
    return judged(row["growthPercent"], 100.0 * GROWTH, results.noise, *words)


def _lasting(row: Row) -> str:
    end = "survives" if row["survives"] else "DIVERGES after"
    return (
        "Zhai's pendulum, {label}: {end} {steps:.0e} steps, energy within {range:.1e} of the swing, drift "
        "{drift:.1e}, constraints {violation:.1e}.".format_map(row | {"end": end})
    )


def draw(results: Results, directory: Path) -> list[Path]:
    """Energy over time, and memory over scenes."""
    energies = [
        Curve(np.array(row["times"]) / 3600.0, row["energies"], row["label"], color, "-")
        for row, color in zip(results.of_kind("run"), COLORS, strict=False)
    ]
    sizes = []
    for number, row in enumerate(results.of_kind("memory")):
        relative = np.array(row["megabytes"]) / row["firstMegabytes"]
        look = (REFERENCE_COLOR, "--") if KINDS[row["label"]].keeps else (COLORS[number % len(COLORS)], "-")
        sizes.append(Curve(np.arange(len(relative)), relative, row["label"], *look))
    axes = "scenes built, run, dropped [-]", "resident memory over its start [-]"
    panels = (
        Panel("time of motion [h]", "change of energy over the swing [-]", energies, "plot"),
        Panel(*axes, sizes, "plot", horizontal=(1.0 + GROWTH,)),
    )
    return [chart(directory / "soak.png", *panels, width=10.0)]


TABLES = tables(
    """
    run: Planar pendulum, RATTLE; energies over the swing, the largest kinetic energy:
        run: label | steps | motion [h]: hours | CPU [s]: cpuSeconds | energy varies by: range |
        its mean drifts by: drift | violation | of rates [1/s]: rate
    swing: Planar pendulum under other schemes, one change at a time:
        run: label | steps | h [s]: stepSize | survives | motion [h]: hours | energy varies by: range |
        its mean drifts by: drift | violation | of rates [1/s]: rate
    memory: Resident memory of a process that builds, runs and drops scenes:
        way of the run: label | scenes | first [MB]: firstMegabytes | last [MB]: lastMegabytes |
        kB a scene: kilobytesAScene | growth [%]: growthPercent
    """
)

QUESTION = "Do energy, constraints and memory stay where they are over long runs and many scenes?"
TOO_LONG = "short runs and few scenes decide nothing on drift and memory"
STUDY = Study("soak", QUESTION, measure, conclude, TABLES, draw, not_in_quick_report=TOO_LONG, minutes=4)
