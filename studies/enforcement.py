"""Three ways to keep the length of the same cable: what a step costs, and how accurate it is.

Question
    What does a user pay for native solvers, by penalty masses or by exact constraint objects, against the
    plugin's own solver?

What would refute it
    A native solver that moves the inextensible cable at the same error in less CPU time than SolveExplicit.

Protocol
    Planar pendulum over 5 s with the tip at 100 Hz, against the independent reference (good to 5e-5 m).
    The same script with another `enforcement`; each at a step near its largest useful one. CPU time of
    the whole call, as for Table 1. More steps and scenes: `work_precision`.

What is left out
    DOPRI5, whose step control stalls at tight tolerances here, and generalized-alpha without numerical
    damping, whose steps become ever smaller over 5 s.
"""

from pathlib import Path

from exudyn_inext import ExplicitSettings
from reference_models.conventional.settings import Explicit, Implicit
from reference_models.enforced import enforced_case
from reference_models.inextensible import Inextensible, inextensible_case
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case

from .harness import Results, Row, Study, Table
from .harness.bars import Bar, conclusions
from .harness.figures import draw_cost_and_accuracy
from .harness.on_scene import OnScene

MICRO = 1e6
STEPS = {5: (2.5e-3, 2e-3, 2e-4, 2e-3), 10: (6.25e-4, 6.25e-4, 1e-4, 1e-3)}
"""Elements -> steps of RATTLE, native RK44, velocity Verlet, generalized-alpha [s]."""


def make_cases(scene: Scene, quick: bool) -> list[Case]:
    """Each way on each mesh; a quick run has the coarse one."""
    found = []
    for n, (own, runge_kutta, verlet, implicit) in list(STEPS.items())[: 1 if quick else None]:
        solver = Implicit(implicit, relative_tolerance=1e-6, spectral_radius=0.8)
        found += [
            inextensible_case(scene, Inextensible(n, ExplicitSettings(stepSize=own))),
            enforced_case(scene, n, "penaltyMass", Explicit(runge_kutta, "rungeKutta44")),
            enforced_case(scene, n, "penaltyMass", Explicit(verlet)),
            enforced_case(scene, n, "algebraic", solver),
        ]
    return found


def _ways(results: Results) -> list[Row]:
    """With the cost of a step, and CPU time over that of SolveExplicit with as many elements."""
    own = {row["elements"]: row["cpuSeconds"] for row in results.rows if "enforcement" not in row}
    return [
        {"enforcement": "projection"}
        | row
        | {"microseconds": MICRO * seconds / row["steps"], "costRatio": seconds / own[row["elements"]]}
        for row in results.rows
        if (seconds := row["cpuSeconds"]) and own.get(row["elements"])
    ]


def draw(results: Results, directory: Path) -> list[Path]:
    """Error over CPU time."""
    return [draw_cost_and_accuracy(directory / "enforcement_cost.png", results.rows)]


OVER = "{}: CPU time over that of SolveExplicit"
BARS = (
    Bar(_ways, "costRatio", OVER, 1.0, "enforcement", is_least=True),
    Bar(_ways, "errorMax", "{}: error [m]", per="enforcement"),
)
TABLE = Table(
    "",
    "Planar pendulum, tip against the inextensible limit:",
    "solver: integrator | enforcement | N: elements | h [s]: stepSize | us a step: microseconds | "
    "CPU [s]: cpuSeconds | over SolveExplicit: costRatio | error max [m]: errorMax",
    _ways,
)

QUESTION = "What do the three ways to keep a cable's length cost, and how accurate are they?"
MEASURE = OnScene(load_scene("planar_pendulum"), make_cases, quick_end_time=0.1, repeats=2)
STUDY = Study("enforcement", QUESTION, MEASURE, conclusions(*BARS), [TABLE], draw, minutes=0.5)
