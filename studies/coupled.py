"""Scenes with bodies, joints and several cables: what inextensible cables save, beside native ones.

Question
    What does a motion within 1 % and within 0.1 % cost, with inextensible cables and explicit steps, and with
    native cables and generalized-alpha, both tuned? What does a step of a large net cost?

What would refute it
    A native run that is as accurate and cheaper than every one of ours.

Protocol
    The scenes are those of `harness/coupled_scenes.py`: crane, tethered bodies, drone, slider-crank, capstan
    and net of the examples, overhead contact lines, and nets of square meshes that hang from their corners
    and are released in the shape of a bowl; spherical joints tie their cables, one for each side of a mesh,
    in knots. CPU time of SolveExplicit and of mbs.SolveDynamic, set-up included; overhead lines start from
    their equilibrium, which is found before. Start: the same as far as the first output.
    The error is the root mean square distance of bodies, and of nodes that all meshes have, at all outputs
    from a converged run, over the largest displacement. That run has inextensible cables, of a finer mesh and
    with small steps; a native run of that mesh and step, with the largest axial stiffness, says how far both
    formulations agree.
    Both sides are tuned over elements and step, ours also over mass scaling, and RATTLE or Zhai, natives over
    axial stiffness, quadrature, Newton's method and its tolerance, and linear solver (the dense one for small
    scenes: it took 4 to 5 times as long for nets of 12 cables). Every candidate is run once; smaller steps
    are not tried where errors stay or runs are dear. Solvers are varied for the cheapest candidates within a
    bound, and the cheapest of all are timed again, in turn: the median counts. Default settings are tuned
    over elements alone, and so is one setting for all scenes (`harness/cases.py`).
    Large nets are too dear for that: both sides take steps of the same size, natives with modified Newton,
    the cheapest one; the difference of a long and a short run is the cost of a step. These processes have
    one thread, since those of the linear algebra library spin.

What is left out
    Nets that snap tight: their motion is chaotic, so that there is no error to be measured. Droppers that
    slacken. Larger nets are tuned over the settings that served the smaller one.
"""

from pathlib import Path

from .harness import Results, Row, Study, groups, tables
from .harness.bars import Bar, conclusions
from .harness.benchmark import Benchmark, Series, varied
from .harness.coupled_runs import (
    LARGE_ELEMENTS,
    LARGE_RUNS,
    LARGE_STEP,
    Candidate,
    Inextensible,
    Native,
    by_rule,
    large_net,
)
from .harness.coupled_scenes import SCENES, CoupledScene
from .harness.process import ask
from .harness.ratios import DEFAULT, ONE_SETTING, TUNED
from .harness.tuning import Steps, Tuning, draw_fronts, natives, ours

BOUNDS = (1e-2, 1e-3)
LARGE = (10, 22)  # meshes along a side
SIDES = ("inextensible", "native")
WHO = {
    "ours": (SIDES[0], TUNED),
    "default": (SIDES[0], DEFAULT),
    "setting": (SIDES[0], ONE_SETTING),
    "native": (SIDES[1], TUNED),
}


def _references(scene: CoupledScene) -> tuple[Candidate, Candidate]:
    elements, step = scene.fine
    return Inextensible(elements, step), Native(elements, step, max(scene.axial))


def _ours(scene: CoupledScene) -> Steps:
    """Candidates: one setting for all scenes, and the others."""
    return [[by_rule(scene, n)] for n in scene.meshes] + ours(scene)


TUNING = Tuning(SCENES, dict(zip(SIDES, (_ours, natives), strict=True)), _references, BOUNDS, WHO)
compared = TUNING.compared


def _large(case: Row) -> Row:
    """Start, step and memory, each in a process of its own."""
    meshes, formulation = case["meshes"], case["formulation"]
    cables = 2 * meshes * (meshes + 1)
    found = ask(large_net, formulation, meshes, case["runs"])
    return {"label": f"{cables} cables, {formulation}", "cables": cables, **found}


NETS = varied({"meshes": (2,), "runs": (1,)}, meshes=LARGE, formulation=SIDES, runs=(LARGE_RUNS,))
MEASURE = Benchmark([TUNING.series, Series("large", NETS, _large)])


def conclude(results: Results) -> list[str]:
    """Ratios at equal error, how far both formulations agree, steps of large nets."""
    said = BARS(results)
    for cables, pair in groups(results.of_kind("large"), "cables").items():
        mine, theirs = (row["stepMilliseconds"] for row in pair)
        said.append(
            f"Net of {cables} cables of {LARGE_ELEMENTS} elements, steps of {LARGE_STEP:g} s: "
            f"{mine:.3g} ms a step, native {theirs:.3g} ms, {theirs / mine:.3g} times; ours starts in "
            f"{pair[0]['startSeconds']:.3g} s within {pair[0]['megabytes']:.0f} MB."
        )
    return said


BARS = conclusions(
    Bar(compared, "native/ours", "within {}: native over ours, both tuned", 1.0, "within", is_least=True),
    Bar(
        compared, "native/default", "within {}: native over our default settings", per="within", is_least=True
    ),
    Bar("reference", "error", "difference of converged runs of both formulations"),
)


def draw(results: Results, directory: Path) -> list[Path]:
    """Error over CPU time of the best candidates, and of default settings."""
    return [draw_fronts(results, directory / "coupled_scenes.png", BOUNDS)]


TABLES = tables(
    """
    best: Cheapest runs within a bound [s], and ratios of CPU times; how far converged runs agree:
        scene | within | inextensible: ours | its start: oursStart | default settings: default | native |
        its start: nativeStart | native over inextensible: native/ours |
        over default settings: native/default | over one setting: native/setting | agreement
    settings: Their settings and errors:
        scene | within | inextensible: oursSettings | error: oursError | default: defaultSettings |
        error: defaultError | native: nativeSettings | error: nativeError
    large: Large nets, steps of the same size:
        cables | formulation | start [s]: startSeconds | a step [ms]: stepMilliseconds |
        memory [MB]: megabytes
    """,
    best=compared,
    settings=compared,
)
QUESTION = "What do scenes of cables, bodies and joints cost, inextensible and native, at equal error?"
STUDY = Study("coupled", QUESTION, MEASURE, conclude, TABLES, draw, minutes=9)
