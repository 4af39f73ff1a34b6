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
from dataclasses import replace
from pathlib import Path

import numpy as np

from exudyn_inext import DivergenceError, ExplicitSettings
from reference_models.conventional.settings import Implicit
from reference_models.inextensible import Inextensible, inextensible_case, solved
from reference_models.model import sensor_trajectory
from reference_models.scenes import Scene
from reference_models.trajectory import Case, Trajectory

from .harness import Row, Table
from .harness.cases import paper_case
from .harness.figures import draw_cost_and_accuracy, draw_trajectories
from .harness.on_scene import EACH_STEP, PaperTable, SceneResults
from .harness.plot import COLORS, REFERENCE_COLOR, new_figure
from .harness.ratios import Comparison, by_default, is_explicit, is_implicit
from .harness.reference import distance_to_reference

PAPER_STEP = 2.4842e-4  # s, from Eq. (37) with C = 0.9
PROPOSED = "ours at the paper's settings: Zhai, N = 20, h = 2.48e-4 s, product"
SIMPLER = "the same with secondDerivative"
AROUND_THE_LIMIT = (0.98, 1.03)  # steps over the stability limit that are tried
PAPER = {"source": "section 4.1", "stepSize": PAPER_STEP, "elements": 20, "C": 0.9}
ERRORS = "largest distance to the reference [m]: label | first second: first | whole run: errorMax"
SNAPSHOT_TIMES = tuple(0.25 * k for k in range(9))  # s


def at_paper_settings(scene: Scene, quick: bool) -> list[Case]:
    """The paper's ring, and with the other curvature measure."""
    zhai = ExplicitSettings("Zhai", stepSize=PAPER_STEP)
    return [
        inextensible_case(scene, Inextensible(20, zhai, measure="product"), label=PROPOSED),
        inextensible_case(scene, Inextensible(20, zhai), label=SIMPLER),
        paper_case(scene, Inextensible(20, zhai)),
    ]


def make_figures(results: SceneResults, directory: Path) -> list[Path]:
    """Fig. 2 (radial displacement), Fig. 3 (snapshots), and cost against accuracy."""
    curves = {label: _moved(results.trajectories[label]) for label in (PROPOSED, SIMPLER)}
    reference, label = _moved(results.reference.trajectory), "radial displacement at N1 [m]"
    return [
        draw_trajectories(directory / "ring_radial.png", curves, reference, [label]),
        draw_snapshots(directory / "ring_snapshots.png", results.scene),
        draw_cost_and_accuracy(directory / "ring_cost.png", results.rows),
    ]


def _moved(run: Trajectory) -> Trajectory:
    """From where it began; N1 moves along its radius, which is the x axis."""
    return Trajectory(run.times, run.positions - run.positions[0])


def draw_snapshots(path: Path, scene: Scene) -> Path:
    """The ring at equal intervals, over the undeformed one."""
    elements = 40
    every_node = replace(scene, observe={str(k): k / elements for k in range(elements)})
    model = solved(every_node, Inextensible(elements, ExplicitSettings(stepSize=2.5e-4, massScaling=0.3)))
    runs = [sensor_trajectory(model, str(k % elements)) for k in range(elements + 1)]
    with new_figure(path, 9.0, 9.0) as figure:
        all_axes = figure.subplots(3, 3, sharex=True, sharey=True).flat
        for axes, time in zip(all_axes, SNAPSHOT_TIMES, strict=True):
            for moment, color, style in ((0.0, REFERENCE_COLOR, "--"), (time, COLORS[0], "-")):
                if time <= scene.end_time + 1e-9:
                    nodes = [run.positions[np.argmin(np.abs(run.times - moment)), :2] for run in runs]
                    axes.plot(*np.transpose(nodes), style, color=color)
                    axes.set_title(f"t = {time:g} s", loc="left", fontsize=10)
            axes.set_aspect("equal")
        figure.supxlabel("x [m]")
        figure.supylabel("y [m]")
    return path


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
    """The step-size rule."""
    (limit,) = (row["stepLimit"] for row in results.rows if row["label"] == SIMPLER)
    tried = " ".join(f"At {x:g} of it, Zhai {_outcome(results.scene, x * limit)}." for x in AROUND_THE_LIMIT)
    return [
        f"The paper's step {PAPER_STEP:g} s, Eq. (37) with C = 0.9, is {PAPER_STEP / limit:.3f} of the "
        f"stability limit {limit:.4g} s of the ring at rest; the critical C is "
        f"{0.9 * limit / PAPER_STEP:.3f}. {tried}"
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
    "vibrating_ring",
    at_paper_settings,
    PAPER,
    PROPOSED,
    comparisons=(
        Comparison("implicit row", is_implicit, (2e-3, 5e-4)),
        Comparison("implicit row, default quadrature,", by_default(is_implicit), (2e-3, 5e-4)),
        Comparison("explicit row", is_explicit, (4e-3,)),
    ),
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
    explicit=(
        (16, "velocityVerlet", "lobatto"),
        (20, "velocityVerlet", "lobatto"),
    ),
    meshes=(8, 10, 12, 14, 16, 20, 28),
)

QUESTION = "How accurate is the closed inextensible ring, and is the step-size rule safe (Figs. 2, 3)?"
STUDY = TABLE.study(
    "ring",
    QUESTION,
    tables=[Table("", "", ERRORS, _errors)],
    conclusions=make_conclusions,
    pictures=make_figures,
    not_in_quick_report="the kernels of closed cables, in both curvature measures, take long to compile",
    minutes=1,
)
