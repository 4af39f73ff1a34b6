"""Table 1 of the paper: CPU time of the planar flexible pendulum (section 4.2), with accuracy.

Question
    How much CPU time does the inextensible formulation save against native ANCF cables, at
    the paper's settings, and against native cables that are tuned as hard?

What would refute it
    A native row that is both as accurate and as cheap as the inextensible one; or inextensible
    results further from the reference than the native ones that they are compared with.

Protocol
    Every case is run once untimed (compilation, caches), then five times (once above 3 s), round robin over
    all cases. CPU time of the process, without building the model; the tip is sampled at 100 Hz as in
    any Exudyn run; no files are written. The median is compared. What steps alone take is
    measured by `kernel` and `scaling`.
    Default settings, watch included, and one setting for all scenes (`harness/cases.py`) run on several
    meshes. Rows that no other one of their kind beats run once more with half the step: if the error grows,
    errors of mesh and step cancel.

Reference and tolerance
    The inextensible, unshearable limit of an independent MBDyn model, good to 5e-5 m. Errors are
    the largest and the root mean square tip distance over 5 s. Native cables stretch: with
    EA and GA a hundred times higher the reference moves by 3.2e-4 m, so that no native row can be
    expected to get much closer than that.

How the native rows were chosen
    From some 9000 runs over 2 to 24 elements, steps of 0.8 to 17 ms, "full", modified and
    once-a-step modified Newton, tolerances 1e-8 to 1e-3, dense and sparse solvers, spectral
    radii 0.6 to 0.97 and all three quadratures of the elastic forces. Kept are Exudyn's defaults,
    the cheapest ones with full and reduced quadrature, and the cheapest ones of all with errors up
    to 6e-3 m and 7e-4 m. The latter use the Lobatto quadrature, which locks far less: it needs 4
    and 10 elements instead of 10 and 20. With four elements the error of the mesh alone is
    1.1e-2 m; that of the time integration cancels a part of it, which is luck, and is kept.

What is left out
    The curvature measure `product` with our predictor, which the ring compares. RK44 with full
    quadrature, which takes three times as long as velocity Verlet for the same error.
    Exudyn's module without range checks (EXUDYN_MODULE=fast, about 10 % quicker native runs; which
    one ran is stored). MBDyn's own time. Energy and long runs: other studies.
"""

from exudyn_inext import ExplicitSettings
from reference_models.conventional.settings import Implicit
from reference_models.inextensible import Inextensible

from .harness.on_scene import EACH_STEP, PaperTable, of_pendulum

PAPER_IMPLICIT = "paper's conventional implicit: generalized-alpha, N = 10, h = 5e-3 s"
PAPER_EXPLICIT = "paper's conventional explicit: Zhai, N = 10, h = 2e-5 s"
PAPER_PROPOSED = "ours at the paper's settings: Zhai, N = 5, C = 0.7"

PAPER_SECONDS = {PAPER_IMPLICIT: 1.649, PAPER_EXPLICIT: 120.9, PAPER_PROPOSED: 0.680}

PROPOSED = Inextensible(5, ExplicitSettings("Zhai"))

TABLE = PaperTable(
    "table1",
    "planar_pendulum",
    "planar pendulum, 5 s",
    of_pendulum(list(PAPER_SECONDS), 5e-3, PROPOSED),
    {"source": "Table 1", "cpuSeconds": PAPER_SECONDS},
    list(PAPER_SECONDS),
    bounds=(6e-3, 7e-4),
    inextensible=(
        ("Zhai", 10, 6e-4),
        ("RATTLE", 5, 2.5e-3),
        ("Zhai", 3, 5e-3),
        ("Zhai", 4, 2e-3),
        ("Zhai", 6, 1.67e-3),
        ("Zhai", 8, 1e-3),
        ("Zhai", 10, 6.7e-4),
        ("Zhai", 20, 1.25e-4),
        ("Zhai", 4, 5e-3, 0.4),
        ("Zhai", 5, 5e-3, 0.3),
        ("Zhai", 8, 2e-3, 0.35),
        ("Zhai", 8, 2.5e-3, 0.3),
        ("Zhai", 10, 2e-3, 0.3),
        ("RATTLE", 5, 5e-3, 0.25),
        ("RATTLE", 7, 2.5e-3, 0.35),
        ("RATTLE", 8, 2.5e-3, 0.25),
        ("RATTLE", 20, 1e-3, 0.25),
    ),
    implicit=(
        (4, Implicit(6e-3, EACH_STEP, "dense", 1e-4, 0.8), "lobatto"),
        (4, Implicit(6e-3, EACH_STEP, "dense", 1e-4), "lobatto"),
        (5, Implicit(6e-3, EACH_STEP, "dense", 1e-5, 0.8), "lobatto"),
        (10, Implicit(7e-3, "full", "dense", 1e-8)),
        (10, Implicit(7e-3, EACH_STEP, "sparse", 1e-5)),
        (10, Implicit(7e-3, EACH_STEP, "sparse", 1e-5), "reduced"),
        (6, Implicit(3.5e-3, EACH_STEP, "dense", 1e-4), "lobatto"),
        (12, Implicit(5e-3, EACH_STEP, "sparse", 1e-5), "reduced"),
        (15, Implicit(2.5e-3, EACH_STEP, "sparse", 1e-5), "reduced"),
        (9, Implicit(2.2e-3, EACH_STEP, "sparse", 1e-5), "lobatto"),
        (10, Implicit(1.6e-3, "modified", "sparse", 1e-4), "lobatto"),
        (10, Implicit(1.8e-3, EACH_STEP, "sparse", 1e-5), "lobatto"),
        (11, Implicit(1.4e-3, "modified", "sparse", 1e-4, 0.8), "lobatto"),
        (18, Implicit(1.5e-3, "modified", "sparse", 1e-5)),
        (18, Implicit(1.5e-3, "modified", "sparse", 1e-5), "reduced"),
        (20, Implicit(1e-3, "modified", "sparse", 1e-5)),
    ),
    explicit=(
        (4, "velocityVerlet", "lobatto"),
        (5, "velocityVerlet", "lobatto"),
        (10, "velocityVerlet"),
        (5, "rungeKutta44", "lobatto"),
    ),
    quick=(3, 4),
)

QUESTION = "How much CPU time does the inextensible cable save on the planar pendulum (Table 1)?"
STUDY = TABLE.study(QUESTION, minutes=2.5)
