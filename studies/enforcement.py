"""Three ways to keep the length of the same cable: what a step costs, and how accurate it is.

Question
    What does a user pay for native solvers, by penalty masses or by exact constraint objects, against the
    plugin's own solver?

What would refute it
    A native solver that moves the inextensible cable at the same error in less CPU time than SolveExplicit.

Protocol
    Planar pendulum over 5 s with the tip at 100 Hz, against the independent reference (good to 5e-5 m).
    The same script with another `enforcement`; each at a step near its largest useful one. CPU time of
    the whole call, best of the repeats.

What is left out
    DOPRI5, whose step control stalls at tight tolerances here, and generalized-alpha without numerical
    damping, whose steps become ever smaller over 5 s.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import exudyn
from exudyn.itemInterface import SensorNode
from tqdm import tqdm

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, InextensibleCable, SolveExplicit
from reference_models.model import SENSOR_PERIOD, quiet_settings, silence
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Trajectory

from .harness.benchmark import Benchmark, Figures, Table
from .harness.error import distance_to_reference
from .harness.plot import COLORS, label_axes, new_figure
from .harness.reference import from_data
from .harness.study import Row

SCENE = load_scene("planar_pendulum")
MICRO = 1e6
_Solver = exudyn.DynamicSolverType


@dataclass(frozen=True)
class Way:
    """One row.   solver: native one, or None for SolveExplicit.   h: step [s]."""

    label: str
    enforcement: str
    solver: Any
    elements: int
    h: float


def _ways(elements: int, h: dict[str, float]) -> list[Way]:
    return [
        Way("SolveExplicit, RATTLE", "projection", None, elements, h["projection"]),
        Way("native RK44", "penaltyMass", _Solver.RK44, elements, h["RK44"]),
        Way("native VelocityVerlet", "penaltyMass", _Solver.VelocityVerlet, elements, h["Verlet"]),
        Way("generalized-alpha", "algebraic", _Solver.GeneralizedAlpha, elements, h["algebraic"]),
    ]


WAYS = [
    *_ways(5, {"projection": 2.5e-3, "RK44": 2e-3, "Verlet": 2e-4, "algebraic": 2e-3}),
    *_ways(10, {"projection": 6.25e-4, "RK44": 6.25e-4, "Verlet": 1e-4, "algebraic": 1e-3}),
]


def measure(quick: bool) -> list[Row]:
    """One row for each way."""
    scene, ways, repeats = (replace(SCENE, end_time=0.1), WAYS[:4], 1) if quick else (SCENE, WAYS, 2)
    _run(replace(SCENE, end_time=0.02), ways[0])
    return [_row(scene, way, repeats) for way in tqdm(ways, desc="enforcement", unit="way")]


def _row(scene: Scene, way: Way, repeats: int) -> Row:
    _run(replace(scene, end_time=0.02), way)
    runs = [_run(scene, way) for _ in range(repeats)]
    seconds, trajectory, steps = min(runs, key=lambda run: run[0])
    error = distance_to_reference(trajectory, from_data(SCENE).trajectory)
    return {
        "kind": "way",
        "label": way.label,
        "enforcement": way.enforcement,
        "elements": way.elements,
        "stepSize": way.h,
        "steps": steps,
        "microseconds": MICRO * seconds / steps,
        "cpuSeconds": seconds,
        "errorMax": error.maximum,
    }


def _run(scene: Scene, way: Way) -> tuple[float, Trajectory, int]:
    """CPU seconds, path of the tip, number of steps."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    section = scene.cable.section
    cable = CreateInextensibleCable(
        mbs,
        [0, 0, 0],
        [scene.cable.length, 0, 0],
        way.elements,
        InextensibleCable(section.mass_per_length, section.bending_stiffness),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True, True, False, False],
        enforcement=way.enforcement,
    )
    kind = exudyn.OutputVariableType.Position
    tip = mbs.AddSensor(
        SensorNode(nodeNumber=cable["nodes"][-1], storeInternal=True, outputVariableType=kind)
    )
    mbs.Assemble()
    start = time.process_time()
    steps = _solve(mbs, scene.end_time, way)
    seconds = time.process_time() - start
    stored = mbs.GetSensorStoredData(tip)
    return seconds, Trajectory(stored[:, 0].copy(), stored[:, 1:4].copy()), steps


def _solve(mbs: Any, end_time: float, way: Way) -> int:
    steps = 1 if way.solver is None else round(end_time / way.h)
    settings = quiet_settings(end_time, steps, SENSOR_PERIOD)
    with silence():
        if way.solver is None:
            return int(SolveExplicit(mbs, settings, ExplicitSettings(stepSize=way.h))["steps"])
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
        settings.timeIntegration.newton.useModifiedNewton = True
        settings.timeIntegration.newton.relativeTolerance = 1e-6
        mbs.SolveDynamic(settings, solverType=way.solver)
    return steps


def conclude(figures: Figures) -> list[str]:
    """Each native way against the plugin's solver with the same elements."""
    rows = figures.of_kind("way")
    own = {row["elements"]: row for row in rows if row["enforcement"] == "projection"}
    return [
        f"{row['label']} ({row['enforcement']}), N = {row['elements']}: "
        f"{row['cpuSeconds'] / own[row['elements']]['cpuSeconds']:.0f} times the CPU time of SolveExplicit, "
        f"{row['errorMax']:.1e} m against {own[row['elements']]['errorMax']:.1e} m."
        for row in rows
        if row["enforcement"] != "projection"
    ]


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Error over CPU time."""
    path = directory / "enforcement_cost.png"
    with new_figure(path, 6.4, 4.2) as figure:
        axes = figure.subplots()
        labels: Sequence[str] = list(dict.fromkeys(row["label"] for row in figures.of_kind("way")))
        for label, color in zip(labels, COLORS, strict=False):
            rows = [row for row in figures.of_kind("way") if row["label"] == label]
            times, errors = [row["cpuSeconds"] for row in rows], [row["errorMax"] for row in rows]
            axes.loglog(times, errors, "o-", color=color, label=f"{rows[0]['enforcement']}: {label}")
        label_axes(axes, "CPU time of 5 s of motion [s]", "largest error of the tip [m]")
        axes.legend()
    return [path]


STUDY = Benchmark(
    name="enforcement",
    question="What do the three ways to keep a cable's length cost, and how accurate are they?",
    measure=measure,
    tables=(
        Table(
            "way",
            "Planar pendulum, tip against the inextensible limit:",
            {
                "solver": "label",
                "enforcement": "enforcement",
                "N": "elements",
                "h [s]": "stepSize",
                "us a step": "microseconds",
                "CPU [s]": "cpuSeconds",
                "error max [m]": "errorMax",
            },
        ),
    ),
    conclusions=conclude,
    pictures=draw,
)
