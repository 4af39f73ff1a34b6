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
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from exudyn_inext import DivergenceError, ExplicitSettings
from reference_models.conventional.cases import largest_step_case, native_case
from reference_models.conventional.settings import Implicit, Newton
from reference_models.inextensible import Inextensible, inextensible_case, solved
from reference_models.model import sensor_trajectory
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case, Trajectory

from .harness.cases import explicit_case
from .harness.error import distance_to_reference
from .harness.figures import TIME, draw_cost_and_accuracy
from .harness.front import is_explicit, is_implicit, is_implicit_by_default
from .harness.plot import COLORS, REFERENCE_COLOR, label_axes, new_figure
from .harness.ratios import Comparison, ratios
from .harness.study import Ratio, Results, Study
from .harness.table import TextTable, number

PAPER_STEP = 2.4842e-4  # s, from Eq. (37) with C = 0.9
PROPOSED = "paper's proposed: inextensible, Zhai, N = 20, h = 2.48e-4 s, product"
SIMPLER = "the same with secondDerivative"
AROUND_THE_LIMIT = (0.98, 1.03)  # steps over the stability limit that are tried
SNAPSHOT_TIMES = tuple(0.25 * k for k in range(9))  # s

COMPARISONS = (
    Comparison("implicit row", is_implicit, 2e-3),
    Comparison("implicit row", is_implicit, 5e-4),
    Comparison("implicit row, default quadrature,", is_implicit_by_default, 2e-3),
    Comparison("implicit row, default quadrature,", is_implicit_by_default, 5e-4),
    Comparison("explicit row", is_explicit, 4e-3),
)


def make_cases(scene: Scene, quick: bool) -> list[Case]:
    """All rows; a quick run leaves out the costly ones."""
    inextensible, implicit = inextensible_cases(scene), implicit_cases(scene)
    if quick:
        return [*_paper_cases(scene), *islice(inextensible, 2), *implicit[:2]]
    return [*_paper_cases(scene), *inextensible, *implicit, *explicit_cases(scene)]


def _paper_cases(scene: Scene) -> list[Case]:
    zhai = ExplicitSettings("Zhai", stepSize=PAPER_STEP)
    return [
        inextensible_case(scene, Inextensible(20, zhai, measure="product"), label=PROPOSED),
        inextensible_case(scene, Inextensible(20, zhai), label=SIMPLER),
    ]


def inextensible_cases(scene: Scene) -> Iterator[Case]:
    """Near the largest stable steps, then the front of cost and accuracy with scaled mass."""
    yield explicit_case(scene, "Zhai", 20, 5e-4, 0.26, zeta=300.0)
    yield explicit_case(scene, "RATTLE", 20, 5e-4, 0.26)
    yield explicit_case(scene, "RATTLE", 10, 1e-3)
    yield explicit_case(scene, "RATTLE", 20, 2.5e-4)
    yield explicit_case(scene, "Zhai", 10, 2e-3, 0.26, zeta=300.0)
    yield explicit_case(scene, "Zhai", 12, 1e-3, 0.26, zeta=300.0)
    yield explicit_case(scene, "Zhai", 14, 1e-3, 0.26, zeta=300.0)
    yield explicit_case(scene, "Zhai", 14, 5e-4, 0.35, zeta=300.0)
    yield explicit_case(scene, "Zhai", 16, 5e-4, 0.35, zeta=300.0)
    yield explicit_case(scene, "RATTLE", 14, 1e-3, 0.26)
    yield explicit_case(scene, "RATTLE", 40, 2.5e-4, 0.26)


def implicit_cases(scene: Scene) -> list[Case]:
    """Generalized-alpha, cheapest at its accuracy, see the head of this file; coarse ones first."""
    each_step: Newton = "modifiedEachStep"
    return [
        native_case(scene, 10, Implicit(6e-3, each_step, "sparse", 1e-4), "lobatto"),
        native_case(scene, 12, Implicit(4e-3, each_step, "sparse", 1e-4), "lobatto"),
        native_case(scene, 14, Implicit(3e-3, "modified", "sparse", 1e-4), "lobatto"),
        native_case(scene, 20, Implicit(1.5e-3, "modified", "sparse", 1e-4), "lobatto"),
        native_case(scene, 24, Implicit(1e-3, "modified", "sparse", 1e-4), "lobatto"),
        native_case(scene, 28, Implicit(3e-3, "modified", "sparse", 1e-4, 0.8)),
        native_case(scene, 32, Implicit(3e-3, "modified", "sparse", 1e-4)),
        native_case(scene, 32, Implicit(3e-3, "modified", "sparse", 1e-4), "reduced"),
        native_case(scene, 36, Implicit(2e-3, "modified", "sparse", 1e-4)),
        native_case(scene, 40, Implicit(1.5e-3, "modified", "sparse", 1e-4)),
    ]


def explicit_cases(scene: Scene) -> list[Case]:
    """Native velocity Verlet at its largest stable steps."""
    return [
        largest_step_case(scene, 16, "velocityVerlet", "lobatto"),
        largest_step_case(scene, 20, "velocityVerlet", "lobatto"),
    ]


def make_figures(results: Results, directory: Path) -> list[Path]:
    """Fig. 2 (radial displacement), Fig. 3 (snapshots), and cost against accuracy."""
    curves = {label: results.trajectories[label] for label in (PROPOSED, SIMPLER)}
    return [
        draw_radial_displacement(directory / "ring_radial.png", curves, results.reference.trajectory),
        draw_snapshots(directory / "ring_snapshots.png", results.scene),
        draw_cost_and_accuracy(directory / "ring_cost.png", results.rows),
    ]


def draw_radial_displacement(path: Path, curves: dict[str, Trajectory], reference: Trajectory) -> Path:
    """N1 moves along its radius, which is the x axis; and its distance to the reference."""
    end = max(curve.times[-1] for curve in curves.values())
    shown = reference.times <= end + 1e-9
    with new_figure(path, 8.0, 6.0) as figure:
        top, bottom = figure.subplots(2, 1, sharex=True)
        top.plot(
            reference.times[shown],
            reference.positions[shown, 0] - reference.positions[0, 0],
            color=REFERENCE_COLOR,
            linewidth=4,
            label="reference",
        )
        for style, (label, curve) in zip(("--", ":"), curves.items(), strict=True):
            top.plot(curve.times, curve.positions[:, 0] - curve.positions[0, 0], style, label=label)
            rows = np.searchsorted(reference.times, curve.times - 1e-9)
            error = np.linalg.norm(curve.positions - reference.positions[rows], axis=1)
            bottom.semilogy(curve.times[1:], error[1:], linewidth=1.0)
        label_axes(top, "", "radial displacement at N1 [m]")
        label_axes(bottom, TIME, "distance to the reference [m]")
        figure.legend(*top.get_legend_handles_labels(), loc="outside upper left")
    return path


def draw_snapshots(path: Path, scene: Scene) -> Path:
    """The ring at equal intervals, over the undeformed one."""
    elements = 40
    every_node = replace(scene, observe={str(k): k / elements for k in range(elements)})
    model = solved(every_node, Inextensible(elements, ExplicitSettings(stepSize=2.5e-4, massScaling=0.3)))
    runs = [sensor_trajectory(model, str(k)) for k in range(elements)]
    times = [t for t in SNAPSHOT_TIMES if t <= scene.end_time + 1e-9]
    with new_figure(path, 9.0, 9.0) as figure:
        for axes, time in zip(figure.subplots(3, 3, sharex=True, sharey=True).flat, times, strict=False):
            _draw_ring(axes, runs, time)
        figure.supxlabel("x [m]")
        figure.supylabel("y [m]")
    return path


def _draw_ring(axes: Axes, runs: Sequence[Trajectory], time: float) -> None:
    for moment, color, style in ((0.0, REFERENCE_COLOR, "--"), (time, COLORS[0], "-")):
        rows = [int(np.argmin(np.abs(run.times - moment))) for run in runs]
        nodes = np.array([run.positions[row, :2] for run, row in zip(runs, rows, strict=True)])
        closed = np.vstack([nodes, nodes[:1]])
        axes.plot(*closed.T, style, color=color)
    axes.set_aspect("equal")
    axes.set_title(f"t = {time:g} s", loc="left", fontsize=10)


def make_tables(results: Results) -> list[TextTable]:
    """Errors of both measures."""
    rows = {row["label"]: row for row in results.rows}
    lines = [
        (label, number(_error_until(results, label, 1.0)), number(rows[label]["errorMax"]))
        for label in (PROPOSED, SIMPLER)
    ]
    header = ("largest distance to the reference [m]", "first second", "whole run")
    return [TextTable("", header, lines)]


def make_ratios(results: Results) -> list[Ratio]:
    """At equal accuracy: the paper gives no times."""
    return ratios(results.rows, {}, PROPOSED, COMPARISONS)


def make_conclusions(results: Results) -> list[str]:
    """The step-size rule."""
    (limit,) = (row["stepLimit"] for row in results.rows if row["label"] == SIMPLER)
    return [
        f"The paper's step {PAPER_STEP:g} s, Eq. (37) with C = 0.9, is {PAPER_STEP / limit:.3f} of the "
        f"stability limit {limit:.4g} s of the ring at rest; the critical C is "
        f"{0.9 * limit / PAPER_STEP:.3f}. {_tried_around(results.scene, limit)}"
    ]


def _tried_around(scene: Scene, limit: float) -> str:
    """What becomes of runs just below and just beyond the limit [s]."""
    return " ".join(f"At {x:g} of it, Zhai {_outcome(scene, x * limit)}." for x in AROUND_THE_LIMIT)


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


def _error_until(results: Results, label: str, end: float) -> float:
    run = results.trajectories[label]
    kept = run.times <= end + 1e-9
    part = Trajectory(run.times[kept], run.positions[kept])
    return distance_to_reference(part, results.reference.trajectory).maximum


STUDY = Study(
    name="ring",
    question="How accurate is the closed inextensible ring, and is the step-size rule safe (Figs. 2, 3)?",
    scene=load_scene("vibrating_ring"),
    paper={"source": "section 4.1", "stepSize": PAPER_STEP, "elements": 20, "C": 0.9},
    cases=make_cases,
    figures=make_figures,
    conclusions=make_conclusions,
    ratios=make_ratios,
    tables=make_tables,
    not_in_quick_report="the kernels of closed cables, in both curvature measures, take long to compile",
)
