"""Vibrating ring (paper, section 4.1): accuracy of both curvature measures, and the step-size rule.

Question
    How far is the closed inextensible ring from the limit, with |r_xx| and with the paper's |r_x| |r_xx|
    as curvature; does Eq. (37) choose a stable step; and what do native cables pay for the same accuracy?

What would refute it
    A ring that is further from the limit than native cables of as many elements; or a step from
    Eq. (37) with the paper's C = 0.9 that is unstable.

Protocol
    Twenty elements at the paper's step first. CPU time as for Table 1, 2 s of motion inside Exudyn with
    a sensor at 100 Hz. The step limit follows from the largest frequency of the ring at rest; two runs,
    untimed, try steps just below and just beyond it.

Reference and tolerance
    The inextensible, unshearable limit of an independent MBDyn model, good to 5e-5 m at an amplitude of
    0.106 m. Errors are distances of the loaded point N1 over the 2 s; over the first second they are
    stated apart.

How the native rows were chosen
    From some 1200 runs over 6 to 40 elements, steps of 1 to 6 ms, modified and once-a-step modified
    Newton, tolerances 1e-4 and 1e-5, sparse solver, spectral radii 0.8 and 0.9, all three quadratures. Kept
    are the cheapest with Lobatto and with full quadrature; 12 and 14 Lobatto elements are partly luck
    (9.3e-3 m for 12 at h = 1e-3 s). The undeformed ring is stress free; with full quadrature from 12
    elements on, a straight stress-free state gives the same.

What is left out
    The paper gives no CPU times for the ring. Velocity Verlet with full quadrature: 40 elements take
    4 s for 1.5e-3 m, 20 elements lock (3.6e-2 m).
"""

import warnings

from exudyn_inext import DivergenceError, ExplicitSettings
from reference_models.conventional.settings import Implicit
from reference_models.inextensible import Inextensible, inextensible_case, solved
from reference_models.scenes import Scene
from reference_models.trajectory import Case, Trajectory

from .harness import Row, Table
from .harness.cases import paper_case
from .harness.on_scene import EACH_STEP, PaperTable, SceneResults
from .harness.reference import distance_to_reference

PAPER_STEP = 2.4842e-4  # s, from Eq. (37) with C = 0.9
PROPOSED = "ours at the paper's settings: Zhai, N = 20, h = 2.48e-4 s, product"
SIMPLER = "the same with secondDerivative"
AROUND_THE_LIMIT = (0.98, 1.03)  # steps over the stability limit that are tried
ERRORS = "largest distance to the reference [m]: label | first second: first | whole run: errorMax"


def at_paper_settings(scene: Scene, quick: bool) -> list[Case]:
    """The paper's ring, and with the other curvature measure."""
    zhai = ExplicitSettings("Zhai", stepSize=PAPER_STEP)
    return [
        inextensible_case(scene, Inextensible(20, zhai, measure="product"), label=PROPOSED),
        inextensible_case(scene, Inextensible(20, zhai), label=SIMPLER),
        paper_case(scene, Inextensible(20, zhai)),
    ]


def _errors(results: SceneResults) -> list[Row]:
    """Of both measures; over the first second apart."""
    rows, first = [row for row in results.rows if row["label"] in (PROPOSED, SIMPLER)], []
    for row in rows:
        run = results.trajectories[row["label"]]
        kept = run.times <= 1.0 + 1e-9
        part = Trajectory(run.times[kept], run.positions[kept])
        first.append(distance_to_reference(part, results.reference.trajectory).maximum)
    return [row | {"first": error} for row, error in zip(rows, first, strict=True)]


def make_conclusions(results: SceneResults) -> list[str]:
    """The step-size rule; best against best."""
    (limit,) = (row["stepLimit"] for row in results.rows if row["label"] == SIMPLER)
    tried = " ".join(f"At {x:g} of it, Zhai {_outcome(results.scene, x * limit)}." for x in AROUND_THE_LIMIT)
    return [
        f"The paper's step {PAPER_STEP:g} s, Eq. (37) with C = 0.9, is {PAPER_STEP / limit:.3f} of the "
        f"stability limit {limit:.4g} s of the ring at rest; the critical C is "
        f"{0.9 * limit / PAPER_STEP:.3f}. {tried}",
        *TABLE.conclude(results),
    ]


def _outcome(scene: Scene, step_size: float) -> str:
    settings = ExplicitSettings("Zhai", stepSize=step_size, allowUnstableStep=True, rejectSteps=False)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            # an output at each step: its size must not be rounded to fit the sensor's period
            solved(scene, Inextensible(20, settings, output_period=step_size))
    except DivergenceError as error:
        return "diverges " + str(error).partition("diverged ")[2].partition(" s")[0] + " s"
    return f"stays stable over {scene.end_time:g} s"


TABLE = PaperTable(
    "ring",
    "vibrating_ring",
    "vibrating ring, 2 s",
    at_paper_settings,
    {"source": "section 4.1", "stepSize": PAPER_STEP, "elements": 20, "C": 0.9},
    [SIMPLER, PROPOSED],
    bounds=(2e-3, 5e-4),
    inextensible=(
        ("Zhai", 20, 5e-4, 0.26, 300.0),
        ("RATTLE", 20, 5e-4, 0.26),
        ("RATTLE", 10, 1e-3),
        ("RATTLE", 20, 2.5e-4),
        ("Zhai", 10, 2e-3, 0.26, 300.0),
        ("Zhai", 12, 1e-3, 0.26, 300.0),
        ("Zhai", 14, 1e-3, 0.26, 300.0),
        ("Zhai", 14, 5e-4, 0.35, 300.0),
        ("Zhai", 16, 5e-4, 0.35, 300.0),
        ("RATTLE", 14, 1e-3, 0.26),
        ("RATTLE", 40, 2.5e-4, 0.26),
    ),
    implicit=(
        (10, Implicit(6e-3, EACH_STEP, "sparse", 1e-4), "lobatto"),
        (12, Implicit(4e-3, EACH_STEP, "sparse", 1e-4), "lobatto"),
        (14, Implicit(3e-3, "modified", "sparse", 1e-4), "lobatto"),
        (20, Implicit(1.5e-3, "modified", "sparse", 1e-4), "lobatto"),
        (24, Implicit(1e-3, "modified", "sparse", 1e-4), "lobatto"),
        (28, Implicit(3e-3, "modified", "sparse", 1e-4, 0.8)),
        (32, Implicit(3e-3, "modified", "sparse", 1e-4)),
        (32, Implicit(3e-3, "modified", "sparse", 1e-4), "reduced"),
        (36, Implicit(2e-3, "modified", "sparse", 1e-4)),
        (40, Implicit(1.5e-3, "modified", "sparse", 1e-4)),
    ),
    explicit=((16, "velocityVerlet", "lobatto"), (20, "velocityVerlet", "lobatto")),
    meshes=(8, 10, 12, 14, 16, 20, 28),
)

QUESTION = "How accurate is the closed inextensible ring, and is the step-size rule safe (Figs. 2, 3)?"
STUDY = TABLE.study(
    QUESTION,
    tables=[Table("", "", ERRORS, _errors)],
    conclusions=make_conclusions,
    not_in_quick_report="the kernels of closed cables, in both curvature measures, take long to compile",
    minutes=1,
)
