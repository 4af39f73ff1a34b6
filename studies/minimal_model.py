"""What a scene needs: one change of the model or the method at a time, its effect on error and cost.

Question
    Which parts of the formulation may be left out, where, and what does that save?

What would refute it
    A change that is said to be harmless and whose error exceeds the base's by more than a tenth and by more
    than the reference's uncertainty.

Protocol
    The base is Zhai with the projected rate, zeta = 100 1/s, |r_xx| as curvature, one length constraint an
    element, nodal constraints, consistent masses, the smallest dimension. Each variant differs in one
    thing and runs at 0.6 of its own stability limit, as the base does. Base and variant are timed in turn,
    five times after a warm-up, alone in one process; medians of CPU time are compared.

Reference and tolerance
    Those of the scenes; the power line is compared with a refined solution, as in `table3`.

What is left out
    Combinations of changes. Nodal constraints and consistent masses, for which the package has no switches.
"""

import statistics
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from exudyn_inext import Zhai
from reference_models.inextensible import Inextensible
from reference_models.scenes import Scene, load_scene

from .harness import Results, Row, Study, column, groups, number, tables
from .harness.benchmark import Benchmark, Series
from .harness.cases import case_at_limit, unguarded
from .harness.plot import COLORS, Curve, Panel, chart
from .harness.reference import ReferenceSolution
from .harness.timing import OK, measure
from .table3 import reference_of

SCENES = {"planar_pendulum": 8, "spatial_pendulum": 8, "vibrating_ring": 16, "power_line": 16}  # elements
PART = 0.6  # of the stability limit: what a model's own limit costs is a part of its price
QUICK_MOTION = 0.5  # [s]
NOT_QUICK = ("measure: product", "RK4")  # kernels of their own, which take long to compile
REPEATS, QUICK_REPEATS = 5, 2
BASE = "base"


def changes_of(scene: Scene, elements: int) -> dict[str, Inextensible]:
    """ "base", and label -> the model that differs from it in one thing."""
    base = Inextensible(elements, unguarded("Zhai", None))

    def method(**changes: Any) -> Inextensible:
        return replace(base, settings=replace(base.settings, **changes))

    numbers = {"0": 0, "1": 1, "2": 2, "N / 2": elements // 2, "N - 1": elements - 1}
    return {
        BASE: base,
        "measure: product": replace(base, measure="product"),
        **{f"n_bar = {name}": replace(base, length_constraints=n) for name, n in numbers.items()},
        "v_n, not the projected rate": method(integrator=Zhai(projected_rate=False)),
        "zeta = 10": method(stabilizationRate=10.0),
        "zeta = 300": method(stabilizationRate=300.0),
        "corrector, psi = phi = 0": method(integrator=Zhai(0.0, 0.0, corrector=True)),
        "RATTLE": method(integrator="RATTLE"),
        "RK4": method(integrator="RK4"),
        "half as many elements": replace(base, elements=elements // 2),
        "twice as many elements": replace(base, elements=2 * elements),
        **({"3D, not 2D": replace(base, spatial=True)} if scene.is_planar else {}),
    }


def make_cases(quick: bool) -> list[Row]:
    """Changes, each beside the base."""
    names = ("planar_pendulum",) if quick else tuple(SCENES)
    return [
        {
            "scene": name,
            "label": label,
            "elements": SCENES[name],
            "motion": QUICK_MOTION if quick else load_scene(name).end_time,
            "repeats": QUICK_REPEATS if quick else REPEATS,
        }
        for name in names
        for label in changes_of(load_scene(name), SCENES[name])
        if label != BASE and not (quick and label in NOT_QUICK)
    ]


def run_change(case: Row) -> Row:
    """Errors and CPU times of base and variant, run in turn."""
    scene = replace(load_scene(case["scene"]), end_time=case["motion"])
    models = changes_of(scene, case["elements"])
    cases = [replace(case_at_limit(scene, models[name], PART), label=name) for name in (BASE, case["label"])]
    reference = _reference(case["scene"])
    (first, _), (second, _) = measure(cases, case["repeats"], reference.trajectory)
    return {
        "uncertainty": reference.uncertainty,
        "baseError": first["errorMax"],
        "baseSeconds": first["cpuSeconds"],
        "baseStep": first["stepSize"],
        "baseOutcome": first["status"],
        "error": second["errorMax"],
        "seconds": second["cpuSeconds"],
        "stepSize": second["stepSize"],
        "errorRatio": _ratio(second["errorMax"], first["errorMax"]),
        "costRatio": _ratio(second["cpuSeconds"], first["cpuSeconds"]),
        "outcome": second["status"],
    }


def _ratio(value: float | None, base: float | None) -> float | None:
    return value / base if value is not None and base else None


@lru_cache
def _reference(name: str) -> ReferenceSolution:
    return reference_of(load_scene(name))


HARMLESS = 1.1  # error over that of the base
CHEAPER, DEARER = 0.95, 1.05  # CPU time over that of the base


def summary_of(results: Results) -> list[Row]:
    """One row a change: 'change', 'verdict', 'harmless', 'elsewhere', 'costRatio' (median)."""
    return [_row(label, own) for label, own in groups(results.of_kind("change"), "label").items()]


def is_harmless(row: Row) -> bool:
    """Whether the error stays that of the base, or what the reference cannot tell from it."""
    if row.get("error") is None or row.get("baseError") is None:
        return False
    bound = max(HARMLESS * row["baseError"], row["baseError"] + row["uncertainty"])
    return bool(row["error"] <= bound)


def _row(label: str, own: Sequence[Row]) -> Row:
    harmless = [row["scene"] for row in own if is_harmless(row)]
    elsewhere = [f"{row['scene']} ({_error(row)})" for row in own if not is_harmless(row)]
    costs = [row["costRatio"] for row in own if row.get("costRatio") is not None]
    cost = statistics.median(costs) if costs else None
    return {
        "change": label,
        "verdict": _verdict(len(harmless), len(own), cost),
        "harmless": ", ".join(harmless) or "no scene",
        "elsewhere": ", ".join(elsewhere) or "-",
        "costRatio": cost,
    }


def _verdict(harmless: int, scenes: int, cost: float | None) -> str:
    if not harmless:
        return "harmful everywhere"
    where = "harmless everywhere" if harmless == scenes else "harmless on some scenes"
    if cost is None:
        return f"{where}, cost not measured"
    saves = "cheaper" if cost < CHEAPER else "dearer" if cost > DEARER else "saves nothing"
    return f"{where}, {saves}"


def _error(row: Row) -> str:
    if row.get("errorRatio") is not None:
        return f"{number(row['errorRatio'])} times the error"
    base = row.get("baseOutcome", OK)
    said = str(row.get("outcome", row["status"])) if base == OK else f"the base {base}"
    return said.split(". ")[0]


def conclude(results: Results) -> list[str]:
    """What may be changed where, and what that saves; verdict by verdict."""
    return [
        f"{verdict[0].upper()}{verdict[1:]}: {'; '.join(column(own, 'change'))}."
        for verdict, own in groups(summary_of(results), "verdict").items()
    ]


def draw(results: Results, directory: Path) -> list[Path]:
    """Error and cost over those of the base."""
    rows = [row for row in results.of_kind("change") if row.get("errorRatio") and row.get("costRatio")]
    if not rows:
        return []
    labels, scenes, panels = list(groups(rows, "label")), groups(rows, "scene").items(), []
    for key, what in (("errorRatio", "error"), ("costRatio", "CPU time")):
        curves = [
            Curve(column(own, key), [labels.index(row["label"]) for row in own], scene, color, marker)
            for (scene, own), color, marker in zip(scenes, COLORS, "os^D", strict=False)
        ]
        look = {"legend": False, "vertical": (1.0,), "names": labels}
        panels.append(Panel(f"{what} over that of the base [-]", "", curves, "semilogx", **look))
    height = 1.5 + 0.3 * len(labels)
    return [chart(directory / "minimal_model.png", *panels, width=12.0, height=height, columns=4)]


TABLES = tables(
    """
    summary: What may be left out when (error within a tenth of the base's, or not to be told from it):
        change | verdict | harmless on: harmless | not on: elsewhere | CPU ratio: costRatio
    change: One change at a time:
        change: label | scene | base error [m]: baseError | error [m]: error | error ratio: errorRatio |
        base h [s]: baseStep | h [s]: stepSize | base CPU [s]: baseSeconds | CPU [s]: seconds |
        CPU ratio: costRatio | outcome | status
    """,
    summary=summary_of,
)

QUESTION = "What may be left out of the model when, and what does that save?"
MEASURE = Benchmark([Series("change", make_cases, run_change)])
STUDY = Study("minimal_model", QUESTION, MEASURE, conclude, TABLES, draw, minutes=3)
