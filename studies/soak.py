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
    of 5 s to show it: its loss has to be found. Then scenes of each way that a run can take, 200 times each
    in a process of its own: built, run for some steps, dropped; memory counts after the first 20, when
    libraries and kernels are loaded. As a control, scenes that are kept have to be found, too.

What is left out
    Zhai and RK4, which gain or lose energy over long runs by themselves, and memory that a scene in use
    needs (`scaling`).
"""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import exudyn
import numpy as np
from tqdm import tqdm

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, ExplicitStepper, InextensibleCable
from exudyn_inext.chain.cable import Cable
from exudyn_inext.exudyn_binding.scene import read_cables
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.statics.potential import Potential
from reference_models.scenes import load_scene
from reference_models.trajectory import Array

from .harness.benchmark import Benchmark, Figures, Table
from .harness.dropped_scenes import KINDS, memory_of_scenes
from .harness.plot import COLORS, REFERENCE_COLOR, label_axes, new_figure
from .harness.study import Row
from .harness.verdict import at_most, verdict

SCENE = load_scene("planar_pendulum")
GRAVITY = [0.0, -9.81]
ELEMENTS, STEP, CALL = 5, 2.5e-3, 1000  # steps in a compiled call
STEPS, SCENES, WARM_UP = 10_000_000, 200, 20
CONTROL = 1e-10  # bending damping [N m^2 s]
DRIFT, VIOLATION, GROWTH = 0.1, 1e-9, 0.05  # limits, see above
MEGA = 1e6
QUICK = ("joined to bodies", "penaltyMass, native RK44", "control: penaltyMass, kept")
POINTS = 500  # of a curve that is stored


def measure(quick: bool) -> list[Row]:
    """One row for each long run and each kind of scene."""
    steps, scenes, warm_up = (20_000, 6, 3) if quick else (STEPS, SCENES, WARM_UP)
    rows = [
        watched_run("undamped", 0.0, steps),
        watched_run("control, slightly damped", CONTROL, steps // 10),
    ]
    for kind in tqdm(QUICK if quick else KINDS, desc="soak", unit="kind"):
        rows.append(memory_row(kind, memory_of_scenes(kind, warm_up + scenes), warm_up))
    return rows


def _pendulum(damping: float) -> tuple[Any, Any]:
    """mbs and its container."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    section = SCENE.cable.section
    CreateInextensibleCable(
        mbs,
        [0.0, 0.0, 0.0],
        [SCENE.cable.length, 0.0, 0.0],
        ELEMENTS,
        InextensibleCable(section.mass_per_length, section.bending_stiffness, bendingDamping=damping),
        gravity=[*GRAVITY, 0.0],
        groundConstraintsStart=[True, True, False, False],
    )
    mbs.Assemble()
    return mbs, container


class _Watch:
    """Energies [J] and violations of a cable, look by look."""

    def __init__(self, cable: Cable) -> None:
        self._potential = Potential(cable, gravity_force(cable, np.array(GRAVITY)), 0.0)
        self.kinetic: list[float] = []
        self.total: list[float] = []
        self.violation, self.rate = 0.0, 0.0

    def look(self, q: Array, v: Array) -> None:
        speed = v.ravel()
        self.kinetic.append(0.5 * float(speed @ (self._potential.mass @ speed)))
        self.total.append(self.kinetic[-1] + self._potential.energy(q))
        self.violation = _larger(self.violation, self._potential.values(q))
        self.rate = _larger(self.rate, self._potential.jacobian(q) @ speed)

    @property
    def energy(self) -> Array:
        """Change since the first look, over the swing: the largest kinetic energy."""
        total = np.array(self.total)
        change: Array = (total - total[0]) / max(self.kinetic)
        return change


def _larger(worst: float, values: Array) -> float:
    """Also what is no number counts."""
    largest = float(np.abs(values).max(initial=0.0))
    return largest if not largest <= worst else worst


def watched_run(label: str, damping: float, steps: int) -> Row:
    """So many steps of the pendulum with that bending damping [N m^2 s], and what the watch saw."""
    mbs, _container = _pendulum(damping)
    (in_scene,) = read_cables(mbs, "soak")
    watch = _Watch(in_scene.cable)
    stepper = ExplicitStepper(mbs, ExplicitSettings("RATTLE", stepSize=STEP))
    stepper.Start()
    q, v, _ = stepper.State()
    watch.look(q, v)
    call = min(CALL, steps // 20)
    seconds = time.process_time()
    for _ in tqdm(range(steps // call), desc=label, unit="call", mininterval=5.0):
        stepper.Step(call)
        q, v, _ = stepper.State()
        watch.look(q, v)
    energy = watch.energy
    tenth = len(energy) // 10
    every = max(1, len(energy) // POINTS)
    return {
        "kind": "run",
        "label": label,
        "steps": steps,
        "hours": steps * STEP / 3600.0,
        "cpuSeconds": time.process_time() - seconds,
        "range": float(np.ptp(energy)),
        "drift": float(energy[-tenth:].mean() - energy[:tenth].mean()),
        "violation": watch.violation,
        "rate": watch.rate,
        "times": (STEP * call * np.arange(len(energy)))[::every].tolist(),
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


def conclude(figures: Figures) -> list[str]:
    """Drift, violations, memory, each against its limit."""
    sentences = []
    for row in figures.of_kind("run"):
        sentences += [
            f"{row['label']}: over {row['steps']:,} steps ({row['hours']:.2g} h of motion) the energy "
            f"varies by {row['range']:.1e} of the swing, and its mean "
            f"{_drift(row, figures.quick)} ({row['drift']:.1e}).",
            f"{row['label']}: the largest violation of a constraint is {row['violation']:.1e}, of its rate "
            f"{row['rate']:.1e} ({'within' if row['violation'] <= VIOLATION else 'ABOVE'} {VIOLATION:g}).",
        ]
    for row in figures.of_kind("memory"):
        sentences.append(
            f"{row['label']}: memory {_growth(row, figures)} over {row['scenes']} scenes, "
            f"{row['firstMegabytes']:.1f} MB to {row['lastMegabytes']:.1f} MB "
            f"({row['growthPercent']:+.2f} %, {row['kilobytesAScene']:.1f} kB a scene)."
        )
    return sentences


def _is_control(row: Row) -> bool:
    """Whether a fault was put in, which has to be found."""
    return bool(row["label"].startswith("control"))


def _drift(row: Row, quick: bool) -> str:
    """A quick run is too short for a verdict: its tenths are two looks each."""
    if quick:
        return "changes, undecided in so short a run"
    if _is_control(row):
        return "drifts, as it should" if drifts(row) else "does NOT drift, as it should"
    return "DRIFTS" if drifts(row) else "does not drift"


def _growth(row: Row, figures: Figures) -> str:
    """A quick run has too few scenes for a control to show."""
    is_flat = at_most(row["growthPercent"], 100.0 * GROWTH, figures.noise)
    if not _is_control(row):
        return verdict(is_flat, "flat", "NOT flat")
    if figures.quick:
        return "undecided"
    return verdict(is_flat, "NOT growing, as it should,", "growing, as it should,")


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Energy over time, and memory over scenes."""
    path = directory / "soak.png"
    with new_figure(path, 10.0, 4.2) as figure:
        energy, memory = figure.subplots(1, 2)
        for row, color in zip(figures.of_kind("run"), COLORS, strict=False):
            hours = np.array(row["times"]) / 3600.0
            energy.plot(hours, row["energies"], color=color, linewidth=0.8, label=row["label"])
        for number, row in enumerate(figures.of_kind("memory")):
            relative = np.array(row["megabytes"]) / row["firstMegabytes"]
            is_control = KINDS[row["label"]].keeps
            color, style = (REFERENCE_COLOR, "--") if is_control else (COLORS[number % len(COLORS)], "-")
            memory.plot(relative, style, color=color, label=row["label"])
        memory.axhline(1.0 + GROWTH, color="black", linestyle=":", linewidth=1.0)
        label_axes(energy, "time of motion [h]", "change of energy over the swing [-]")
        label_axes(memory, "scenes built, run, dropped [-]", "resident memory over its start [-]")
        energy.legend()
        memory.legend()
    return [path]


STUDY = Benchmark(
    name="soak",
    question="Do energy, constraints and memory stay where they are over long runs and many scenes?",
    measure=measure,
    tables=(
        Table(
            "run",
            "Planar pendulum, RATTLE; energies over the swing, the largest kinetic energy:",
            {
                "run": "label",
                "steps": "steps",
                "motion [h]": "hours",
                "CPU [s]": "cpuSeconds",
                "energy varies by": "range",
                "its mean drifts by": "drift",
                "violation": "violation",
                "of rates [1/s]": "rate",
            },
        ),
        Table(
            "memory",
            "Resident memory of a process that builds, runs and drops scenes:",
            {
                "way of the run": "label",
                "scenes": "scenes",
                "first [MB]": "firstMegabytes",
                "last [MB]": "lastMegabytes",
                "kB a scene": "kilobytesAScene",
                "growth [%]": "growthPercent",
            },
        ),
    ),
    conclusions=conclude,
    pictures=draw,
    not_in_quick_report="short runs and few scenes decide nothing on drift and memory",
)
