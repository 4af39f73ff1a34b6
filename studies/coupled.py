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

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, get_args

import exudyn

from exudyn_inext import InextensibleError
from exudyn_inext.arrays import Array
from reference_models.conventional.cable import Quadrature

from .harness import Order, Results, Row, Study, Table, announce, groups, judged, large_nets
from .harness.cases import DEFAULT, ONE_SETTING, TUNED
from .harness.coupled_runs import PERIOD, Candidate, Inextensible, Native, by_rule, distance, prepare
from .harness.coupled_scenes import SCENES, CoupledScene
from .harness.engines import ask
from .harness.plot import Curve, Panel, chart
from .harness.tuning import Attempt, choose, search, vary

BOUNDS = (1e-2, 1e-3)
QUADRATURES = [name for name in get_args(Quadrature) if name != "reduced"]
LARGE = (10, 22)  # meshes along a side
QUICK: dict[str, Any] = {"end_time": 0.06, "steps": (5e-3, 2e-3)}  # [s]
REPETITIONS = 3
TICKS = [digit * 10.0**power for power in range(-4, 3) for digit in (1, 3)]  # [s]
SIDES = ("inextensible", "native")
WHO = {
    "ours": (SIDES[0], TUNED),
    "default": (SIDES[0], DEFAULT),
    "setting": (SIDES[0], ONE_SETTING),
    "native": (SIDES[1], TUNED),
}

Series = list[list[Any]]


def ours(scene: CoupledScene) -> Series:
    """Candidates: default settings, one setting for all scenes, and series of steps."""
    untuned: Series = [[Inextensible(n, choice=DEFAULT)] for n in scene.meshes]
    untuned += [[by_rule(scene, n)] for n in scene.meshes]
    return untuned + [[Inextensible(n, h) for h in scene.steps] for n in scene.meshes]


def natives(scene: CoupledScene) -> Series:
    """Candidates: series of steps."""
    grid = product(scene.meshes, scene.axial, QUADRATURES)
    return [[Native(n, h, axial, quadrature) for h in scene.steps] for n, axial, quadrature in grid]


def measure(order: Order) -> list[Row]:
    """Rows of candidates, of the best ones, and of large nets."""
    rows: list[Row] = []
    for scene in SCENES:
        if not order.quick:
            rows += _tuned(scene, REPETITIONS)
        elif scene.is_quick:
            rows += _tuned(_brief(scene), 1)
    for meshes in (2,) if order.quick else LARGE:
        rows += [_large(meshes, formulation) for formulation in SIDES]
    return rows


def _brief(scene: CoupledScene) -> CoupledScene:
    meshes = scene.meshes[:2]
    return replace(scene, meshes=meshes, axial=scene.axial[-1:], fine=(meshes[-1], 1e-3), **QUICK)


def _tuned(scene: CoupledScene, repetitions: int) -> Iterator[Row]:
    announce("coupled", scene.name)
    run = partial(prepare, scene, end_time=scene.end_time)
    elements, step = scene.fine
    reference = run(Inextensible(elements, step))()[1]
    attempt = partial(_attempt, scene, reference)
    twin = attempt(Native(elements, step, max(scene.axial)))
    yield {"kind": "reference", "label": scene.name, "scene": scene.name, "error": twin.error}
    for side, series in zip(SIDES, (ours(scene), natives(scene)), strict=True):
        found = search(series, attempt, BOUNDS, side)
        found += vary(found, attempt, BOUNDS, lambda candidate: candidate.variants(scene))
        yield from (_row("candidate", scene, one) for one in found)
        untuned = {name: [one for one in found if _choice(one) == name] for name in (DEFAULT, ONE_SETTING)}
        for bound, (choice, some) in product(BOUNDS, {TUNED: found, **untuned}.items()):
            if best := choose(some, bound, run, repetitions):
                start = choose([best], math.inf, partial(prepare, scene, end_time=PERIOD), repetitions)
                row = _row("best", scene, best) | {"bound": bound, "choice": choice}
                yield row | {"startSeconds": start and start.seconds}


def _choice(one: Attempt) -> str:
    return getattr(one.candidate, "choice", TUNED)


def _attempt(scene: CoupledScene, reference: Array, candidate: Candidate) -> Attempt:
    """One that fails with modified Newton steps is run with full ones."""
    try:
        seconds, paths = prepare(scene, candidate, scene.end_time)()
    except (InextensibleError, exudyn.ExudynError):
        if isinstance(candidate, Native) and candidate.newton == "modified":
            return _attempt(scene, reference, replace(candidate, newton="full"))
        return Attempt(candidate, None, 0.0)
    return Attempt(candidate, distance(paths, reference), seconds)


def _row(kind: str, scene: CoupledScene, one: Attempt) -> Row:
    candidate = one.candidate
    side = SIDES[isinstance(candidate, Native)]
    return {
        "kind": kind,
        "label": f"{scene.name}, {side}, {candidate.elements} elements, {candidate}",
        "scene": scene.name,
        "formulation": side,
        "elements": candidate.elements,
        "settings": str(candidate),
        "error": one.error,
        "cpuSeconds": one.seconds,
    }


def _large(meshes: int, formulation: str) -> Row:
    """Start, step and memory, each in a process of its own."""
    found = dict(ask(large_nets.__name__, formulation, meshes, OPENBLAS_NUM_THREADS="1"))
    cables = 2 * meshes * (meshes + 1)
    label = f"{cables} cables, {formulation}"
    return {"kind": "large", "label": label, "cables": cables, "formulation": formulation, **found}


def compare(results: Results) -> list[Row]:
    """Native over ours, for each scene and bound."""
    best = {(r["scene"], r["bound"], r["formulation"], r["choice"]): r for r in results.of_kind("best")}
    rows = []
    for reference, bound in product(results.of_kind("reference"), BOUNDS):
        row: Row = {"scene": reference["scene"], "within": f"{bound:.1%}", "agreement": reference["error"]}
        for name, side in WHO.items():
            one = best.get((reference["scene"], bound, *side), {})
            row[name], row[f"{name}Error"] = one.get("cpuSeconds"), one.get("error")
            row[f"{name}Start"] = one.get("startSeconds")
            row[f"{name}Settings"] = f"{one['elements']} elements, {one['settings']}" if one else None
        for name, own in (("ratio", "ours"), ("defaultRatio", "default"), ("settingRatio", "setting")):
            row[name] = row["native"] / row[own] if row["native"] and row[own] else None
        rows.append(row)
    return rows


def conclude(results: Results) -> list[str]:
    """Ratios at equal error, of steps of large nets, and how far both formulations agree."""
    said = [_sentence(row, results.noise) for row in compare(results)]
    for row in results.of_kind("reference"):
        agreement = f"agree to {row['error']:.2g}" if row["error"] else "can NOT be compared"
        said.append(f"{row['scene']}: converged runs of both formulations {agreement}.")
    for cables, pair in groups(results.of_kind("large"), "cables").items():
        mine, theirs = (row["stepMilliseconds"] for row in pair)
        said.append(
            f"Net of {cables} cables of {large_nets.ELEMENTS} elements, steps of {large_nets.STEP:g} s: "
            f"{mine:.3g} ms a step, native {theirs:.3g} ms, {theirs / mine:.3g} times; ours starts in "
            f"{pair[0]['startSeconds']:.3g} s within {pair[0]['megabytes']:.0f} MB."
        )
    return said


def _sentence(row: Row, noise: float) -> str:
    what = f"{row['scene']} within {row['within']}:"
    if row["ratio"] is None:
        missing = [side for side, key in zip(SIDES, ("ours", "native"), strict=True) if row[key] is None]
        return f"{what} no {' and no '.join(missing)} run gets there."
    verdict = judged(1.0, row["ratio"], noise, "ours is cheaper", "ours is NOT cheaper")
    default = f", {row['defaultRatio']:.3g} at our default settings" if row["defaultRatio"] else ""
    return f"{what} {verdict}: native over ours {row['ratio']:.3g} tuned{default}."


def draw(results: Results, directory: Path) -> list[Path]:
    """Error over CPU time of the best candidates, and of default settings."""
    known = [row for row in results.of_kind("candidate") if row["error"] and row["cpuSeconds"]]
    panels = []
    for scene, rows in groups(known, "scene").items():
        default = [row for row in rows if row["settings"] == "default"]
        sides = {name: [row for row in rows if row["formulation"] == name] for name in SIDES}
        shown = {**sides, "default settings": default}.items()
        curves = [Curve(*_front(some), name) for name, some in shown]
        times = [seconds for curve in curves for seconds in curve.x]
        ticks = [x for x in TICKS if 0.7 * min(times) < x < 1.4 * max(times)]
        axes = {"title": scene, "legend": False, "horizontal": BOUNDS, "ticks": ticks}
        panels.append(Panel("CPU time [s]", "error [-]", curves, **axes))
    rows_of_panels = -(-len(panels) // 4)
    width, height = 3.4 * -(-len(panels) // rows_of_panels), 0.5 + 2.9 * rows_of_panels
    path = directory / "coupled_scenes.png"
    return [chart(path, *panels, width=width, height=height, rows=rows_of_panels, columns=3)]


def _front(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    """CPU times and errors of runs, none of which is dearer and worse than another one."""
    times: list[float] = []
    errors: list[float] = []
    for row in sorted(rows, key=lambda row: row["cpuSeconds"]):
        if not errors or row["error"] < errors[-1]:
            times.append(row["cpuSeconds"])
            errors.append(row["error"])
    return times, errors


TABLES = [
    Table(
        "best",
        "Cheapest runs within a bound [s], and ratios of CPU times; how far converged runs agree:",
        "scene | within | inextensible: ours | its start: oursStart | default settings: default | native | "
        "its start: nativeStart | native over inextensible: ratio | over default settings: defaultRatio | "
        "over one setting: settingRatio | "
        "agreement",
        compare,
    ),
    Table(
        "settings",
        "Their settings and errors:",
        "scene | within | inextensible: oursSettings | error: oursError | default: defaultSettings | "
        "error: defaultError | native: nativeSettings | error: nativeError",
        compare,
    ),
    Table(
        "large",
        "Large nets, steps of the same size:",
        "cables | formulation | start [s]: startSeconds | a step [ms]: stepMilliseconds | "
        "memory [MB]: megabytes",
    ),
]
QUESTION = "What do scenes of cables, bodies and joints cost, inextensible and native, at equal error?"
STUDY = Study("coupled", QUESTION, measure, conclude, TABLES, draw, minutes=9)
