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

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

from exudyn_inext import ExplicitSettings, SolveExplicit
from reference_models.conventional.settings import Explicit, Implicit, Solver
from reference_models.enforced import enforced_case
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, sensor_trajectory, silence
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case, Trajectory

from .harness import Order, Results, Row, Study, Table, groups
from .harness.plot import Panel, chart, curves_of
from .harness.reference import from_data
from .harness.timing import measure as measure_cases

SCENE = load_scene("planar_pendulum")
MICRO = 1e6
MakeCase = Callable[[Scene, int, str, float], Case]
PROJECTION, PENALTY, ALGEBRAIC = "projection", "penaltyMass", "algebraic"


def _own(scene: Scene, elements: int, enforcement: str, h: float) -> Case:
    """The whole call of SolveExplicit, in one step of Exudyn's loop."""
    steps = round(scene.end_time / h)

    def solve(model: Model) -> Trajectory:
        with silence():
            SolveExplicit(model.mbs, quiet_settings(scene.end_time, 1), ExplicitSettings(stepSize=h))
        return sensor_trajectory(model, scene.main_point)

    prepare = lambda: partial(solve, build(scene, elements))  # noqa: E731
    return Case("own", "inextensible", "RATTLE", elements, h, steps, prepare)


def _native(solver: Callable[[float], Solver]) -> MakeCase:
    """Under a native solver with that step."""
    return lambda scene, elements, enforcement, h: enforced_case(scene, elements, enforcement, solver(h))


# label -> enforcement; makes a case; its step [s] for five and for ten elements
WAYS: dict[str, tuple[str, MakeCase, tuple[float, float]]] = {
    "SolveExplicit, RATTLE": (PROJECTION, _own, (2.5e-3, 6.25e-4)),
    "native RK44": (PENALTY, _native(partial(Explicit, integrator="rungeKutta44")), (2e-3, 6.25e-4)),
    "native VelocityVerlet": (PENALTY, _native(Explicit), (2e-4, 1e-4)),
    "generalized-alpha": (
        ALGEBRAIC,
        _native(partial(Implicit, relative_tolerance=1e-6, spectral_radius=0.8)),
        (2e-3, 1e-3),
    ),
}


def measure(order: Order) -> list[Row]:
    """One row for each way and mesh, of the best of the repeats.

    Raises:
        ArithmeticError: a run failed.
    """
    scene, meshes, repeats = (replace(SCENE, end_time=0.1), 1, 1) if order.quick else (SCENE, 2, 2)
    reference, rows = from_data(SCENE).trajectory, []
    for mesh, label in product(range(meshes), WAYS):
        enforcement, solver, steps = WAYS[label]
        elements, h = (5, 10)[mesh], steps[mesh]
        case = solver(scene, elements, enforcement, h)
        ((row, _),) = measure_cases([case], repeats, reference, case.label)  # each by itself
        if row["cpuSecondsMin"] is None:
            raise ArithmeticError(f"{label}, N = {elements}: {row['status']}")
        rows.append(
            {
                "kind": "way",
                "label": label,
                "enforcement": enforcement,
                "elements": elements,
                "stepSize": h,
                "steps": row["steps"],
                "microseconds": MICRO * row["cpuSecondsMin"] / row["steps"],
                "cpuSeconds": row["cpuSecondsMin"],
                "errorMax": row["errorMax"],
            }
        )
    return rows


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
    ways = groups([row | {"way": "{enforcement}: {label}".format_map(row)} for row in results.rows], "way")
    curves = curves_of(ways, "cpuSeconds", "errorMax")
    panel = Panel("CPU time of 5 s of motion [s]", "largest error of the tip [m]", curves)
    return [chart(directory / "enforcement_cost.png", panel, width=6.4, height=4.2)]


TABLE = Table(
    "way",
    "Planar pendulum, tip against the inextensible limit:",
    "solver: label | enforcement | N: elements | h [s]: stepSize | us a step: microseconds | "
    "CPU [s]: cpuSeconds | error max [m]: errorMax",
)

QUESTION = "What do the three ways to keep a cable's length cost, and how accurate are they?"
STUDY = Study("enforcement", QUESTION, measure, conclude, [TABLE], draw, minutes=0.3)
