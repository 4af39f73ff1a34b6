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

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from exudyn_inext import ExplicitSettings, SolveExplicit
from reference_models.conventional.settings import Explicit, Implicit
from reference_models.enforced import enforced_case
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, sensor_trajectory, silence
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case, Trajectory

from .harness.plot import COLORS, Curve, Panel, chart
from .harness.reference import from_data
from .harness.store import Row
from .harness.study import Order, Results, Study
from .harness.table import Table, column, groups
from .harness.timing import measure as measure_cases

SCENE = load_scene("planar_pendulum")
MICRO = 1e6
PROJECTION, PENALTY, ALGEBRAIC = "projection", "penaltyMass", "algebraic"

# label -> enforcement; native solver, with the step [s] for five and for ten elements
WAYS: dict[str, tuple[str, Any, tuple[float, float]]] = {
    "SolveExplicit, RATTLE": (PROJECTION, None, (2.5e-3, 6.25e-4)),
    "native RK44": (PENALTY, partial(Explicit, integrator="rungeKutta44"), (2e-3, 6.25e-4)),
    "native VelocityVerlet": (PENALTY, Explicit, (2e-4, 1e-4)),
    "generalized-alpha": (
        ALGEBRAIC,
        partial(Implicit, relative_tolerance=1e-6, spectral_radius=0.8),
        (2e-3, 1e-3),
    ),
}


def measure(order: Order) -> list[Row]:
    """One row for each way and mesh."""
    scene, meshes, repeats = (replace(SCENE, end_time=0.1), 1, 1) if order.quick else (SCENE, 2, 2)
    cases = [_case(scene, label, mesh) for mesh in range(meshes) for label in WAYS]
    reference = from_data(SCENE).trajectory
    found = [measure_cases([case], repeats, reference, case.label) for case in cases]  # each by itself
    return [_row(row) for ((row, _),) in found]


def _case(scene: Scene, label: str, mesh: int) -> Case:
    enforcement, solver, steps = WAYS[label]
    elements, h = (5, 10)[mesh], steps[mesh]
    if solver is None:
        case = _own_case(scene, elements, h)
    else:
        case = enforced_case(scene, elements, enforcement, solver(h))
    details = {"way": label, "enforcement": enforcement, "h": h}
    return replace(case, label=f"{label}, N = {elements}", details=details)


def _own_case(scene: Scene, elements: int, h: float) -> Case:
    """The whole call of SolveExplicit, in one step of Exudyn's loop."""
    steps = round(scene.end_time / h)
    return Case(
        "", "inextensible", "RATTLE", elements, h, steps, lambda: partial(_solve, build(scene, elements), h)
    )


def _solve(model: Model, h: float) -> Trajectory:
    with silence():
        SolveExplicit(model.mbs, quiet_settings(model.scene.end_time, 1), ExplicitSettings(stepSize=h))
    return sensor_trajectory(model, model.scene.main_point)


def _row(row: Row) -> Row:
    """The best of the repeats.

    Raises:
        ArithmeticError: the run failed.
    """
    if row["cpuSecondsMin"] is None:
        raise ArithmeticError(f"{row['label']}: {row['status']}")
    return {
        "kind": "way",
        "label": row["way"],
        "enforcement": row["enforcement"],
        "elements": row["elements"],
        "stepSize": row["h"],
        "steps": row["steps"],
        "microseconds": MICRO * row["cpuSecondsMin"] / row["steps"],
        "cpuSeconds": row["cpuSecondsMin"],
        "errorMax": row["errorMax"],
    }


def conclude(results: Results) -> list[str]:
    """Each native way against the plugin's solver with the same elements."""
    rows = results.of_kind("way")
    own = {row["elements"]: row for row in rows if row["enforcement"] == PROJECTION}
    return [
        f"{row['label']} ({row['enforcement']}), N = {row['elements']}: "
        f"{row['cpuSeconds'] / own[row['elements']]['cpuSeconds']:.0f} times the CPU time of SolveExplicit, "
        f"{row['errorMax']:.1e} m against {own[row['elements']]['errorMax']:.1e} m."
        for row in rows
        if row["enforcement"] != PROJECTION
    ]


def draw(results: Results, directory: Path) -> list[Path]:
    """Error over CPU time."""
    named = [row | {"way": "{enforcement}: {label}".format_map(row)} for row in results.of_kind("way")]
    curves = [
        Curve(column(rows, "cpuSeconds"), column(rows, "errorMax"), label, color)
        for (label, rows), color in zip(groups(named, "way").items(), COLORS, strict=False)
    ]
    panel = Panel("CPU time of 5 s of motion [s]", "largest error of the tip [m]", curves)
    return [chart(directory / "enforcement_cost.png", panel, width=6.4, height=4.2)]


TABLE = Table(
    "way",
    "Planar pendulum, tip against the inextensible limit:",
    "solver: label | enforcement | N: elements | h [s]: stepSize | us a step: microseconds | "
    "CPU [s]: cpuSeconds | error max [m]: errorMax",
)

STUDY = Study(
    name="enforcement",
    question="What do the three ways to keep a cable's length cost, and how accurate are they?",
    measure=measure,
    tables=[TABLE],
    conclusions=conclude,
    pictures=draw,
)
