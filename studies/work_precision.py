"""Work and precision: what accuracy costs, for every formulation, integrator, mesh and step, on every scene.

Question
    What does a given error cost in CPU time: by inextensible cables, by native ones, and by what a
    roboticist would take instead, a chain of rigid links; and where does the inextensible cable lose?

What would refute it
    On the planar pendulum, a native front less than 50 times, or one of rigid links less than once, to
    the right of the inextensible one at 5e-3 m or at 7e-4 m.

Protocol
    All cases of a scene are run once untimed, then in turn, alone in one process: five times, three times
    above 0.3 s, once above 3 s; medians of CPU time are compared. What is timed is the solver's call, as for
    Table 1, with sensors at 100 Hz; of MuJoCo its steps alone. Inextensible runs are not ended for their
    energy, since it is the error that is measured. What diverges or fails stays, with its status.
    A scene is one case of the sweep: a run that was killed goes on with the scene that it was at.
    Fronts hold the runs that no other of their family beats, and that gain 5 % of the error at least. The
    cost of an error is read off between neighbours of a front, on logarithmic scales, and never beyond its
    ends.

Reference and tolerance
    Those of the scenes: independent MBDyn models of the inextensible limit (pendulums, ring), a refined
    solution with what refinement changes (power line). Errors below that uncertainty count as large as it;
    below it nothing is said. Native cables stretch: by Table 1, they cannot be expected within some
    3e-4 m of the limit.

How the rows were chosen
    Native: the tuned rows of `table1`, `table2`, `ring`, `table3`, and series beside them; explicit
    ones at their largest stable steps, found by bisection, and some at half of it. Inextensible: every scheme
    at 0.95 and 0.5 of its limit on every mesh, scaled masses over meshes and steps, the tuned rows of the
    tables; penalty masses and algebraic constraints under native solvers near the steps of `enforcement`.
    Rigid links (extra `peers`): RK4 at 0.95 and 0.5 of its stability limit, with the rotary inertia of
    uniform rods and with that of least error on these scenes (3/4 to 3/2 of it were tried); MuJoCo's
    other integrators, which are of first order here, where they are cheap.

What is left out
    Native explicit rows of more than some 20 s; rigid links on the ring and on the power line.
"""

from reference_models.scenes import load_scene

from .harness import Row, Study, tables
from .harness.sweep import Outcome, Sweep
from .harness.timing import OK
from .precision.findings import conclude
from .precision.pictures import draw
from .precision.scene_run import REPEATS, run_scene

SCENES = ("planar_pendulum", "spatial_pendulum", "vibrating_ring", "power_line")
QUICK_MOTION, QUICK_REPEATS = 0.5, 1  # [s]
BRIEF_MOTION = 0.05  # [s]


def make_cases(quick: bool) -> list[Row]:
    """One a scene, timed."""
    return [
        {
            "kind": "scene",
            "scene": name,
            "motion": QUICK_MOTION if quick else load_scene(name).end_time,
            "repeats": QUICK_REPEATS if quick else REPEATS,
            "quick": quick,
            "timed": True,
        }
        for name in SCENES
    ]


def rows_of(case: Row, outcome: Outcome) -> list[Row]:
    """Those that the scene gave; of a scene that failed, one with its status."""
    if outcome.status != OK:
        return [case | {"status": outcome.status}]
    return list(outcome.result["rows"])


TABLES = tables(
    """
    reference: What errors are measured against:
        scene | source | uncertainty [m]: uncertainty | self-convergence: selfConvergence
    speedUp: CPU time over that of the inextensible cable, at equal error:
        scene | opponent | error [m]: bound | ratio | opponent [s]: opponentSeconds |
        inextensible [s]: ownSeconds | opponent's front: opponentOutcome | inextensible front: ownOutcome
    run: All runs:
        case: label | scene | h [s]: stepSize | CPU [s]: cpuSeconds | CPU min [s]: cpuSecondsMin |
        repeats | error max [m]: errorMax | error rms [m]: errorRms | status
    """
)

QUESTION = "What does an accuracy cost in each formulation, and where does the inextensible cable lose?"
STUDY = Study(
    "work_precision",
    QUESTION,
    Sweep(make_cases, run_scene, rows_of, {"motion": BRIEF_MOTION, "repeats": 1}),
    conclude,
    TABLES,
    draw,
    minutes=20,
)
