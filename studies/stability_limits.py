"""Stability at the extremes: the largest stable step, which bound it is, and where the rule (37) is safe.

Question
    Does the linear theory (h w_max and h zeta at the scheme's limits) give the largest stable step of every
    scheme, and what rules it: bending, tension, or zeta?

What would refute it
    A bisected limit more than 5 % from the predicted one in the linear regime, of a cable at rest.

Protocol
    Linear regime: an equilibrium is disturbed by 1e-7 (mostly the fastest vibration, a tenth at random and
    off the constraints); a step is stable if the disturbance grows by less than 1000 within 3000 steps. The
    limit is bisected to 0.4 %. Predictions allow that growth, too: it matters only for a scheme that grows
    weakly at all steps (Zhai with its corrector and psi = phi = 1/2).
    A cable that spins has no equilibrium at rest: it is compared with the same steps of an undisturbed one,
    over 500 steps only, as a scheme that gains energy spins the cable up meanwhile. Terms of velocity, which
    w_max leaves out, lower the limits of Zhai there.
    Violent starts: a pinned cable is thrown; a step lasts if all smaller ones that were tried do, the
    constraints hold and the energy stays within 5 %.

What is left out
    Damping, drag, contact and bodies, which bound steps of their own; unequal elements. Axial waves of
    native cables: `stretch`. Long runs: `soak`.
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from .harness import Results, Row, Study, Table, column, groups
from .harness.bars import Bar, conclusions
from .harness.benchmark import Benchmark, Series
from .harness.plot import COLORS, Curve, Panel, chart
from .stability.limits import AGREEMENT
from .stability.linear import MAPS, PLAIN, run_linear
from .stability.motion import SCHEMES
from .stability.violent import run_violent, violent_cases

SERIES = (
    *(Series(kind, one.cases, run_linear) for kind, one in MAPS.items()),
    Series("violent", violent_cases, run_violent),
)

_LIMITS = "predicted h [s]: predicted | found h [s]: found | found/predicted: ratio"
_RULES = "ruled by: ruledBy | rule (37)/found: ruleOverLimit | status"

TABLES = (
    *(
        Table(kind, one.title, f"scheme, cable: label | {one.what}: value | {_LIMITS} | {_RULES}")
        for kind, one in MAPS.items()
    ),
    Table(
        "violent",
        "Thrown cables, N = 10:",
        "scheme: label | speed [m/s]: value | limit at rest [s]: predicted | "
        "limit at the motion's w_max [s]: predictedInMotion | lasting h [s]: found | "
        "lasting/at rest: part | lasting/in motion: partOfMotion | status",
    ),
)


def _linear(results: Results) -> list[Row]:
    """Cables at rest."""
    return [row for kind in MAPS if kind != "spin" for row in results.of_kind(kind)]


def _off(row: Row) -> float | None:
    """How far found and predicted limits differ; infinite, if one of them alone exists (none is null)."""
    if row["status"] != "ok":
        return None
    if row["ratio"] is None:
        return 0.0 if row["found"] is None or math.isinf(row["found"]) else math.inf
    return float(abs(row["ratio"] - 1.0))


def _ruled(results: Results) -> list[Row]:
    """Where the paper's rule applies: without mass scaling."""
    rows = [row for row in _linear(results) if MAPS[row["kind"]].said and row["scheme"] in PLAIN]
    return [row | {"where": f"{row['scheme']}, {row['kind']}"} for row in rows if row["theta"] == 0.0]


AT_REST = "{}, cable at rest: difference of found and predicted limit"
BARS = (
    Bar(_linear, _off, AT_REST, AGREEMENT, "scheme", noise=1.0),
    Bar(_ruled, "ruleOverLimit", "{}: rule (37) with C = 0.7 over the limit", 1.0, "where", noise=1.0),
    Bar("spin", "ratio", "{}, spinning: limit over that of w_max", per="scheme", is_least=True),
    Bar("violent", "part", "thrown, {}: lasting step over the limit at rest", per="label", is_least=True),
    Bar("violent", "partOfMotion", "thrown, {}: over that of the motion", per="label", is_least=True),
)

AXES = {kind: one.axis for kind, one in MAPS.items() if one.axis} | {
    "violent": "largest speed at the start [m/s]"
}
NO_GRAVITY = 1e-1  # shown in place of zero on a logarithmic axis


def draw(results: Results, directory: Path) -> list[Path]:
    """Largest stable steps over what each map varies: predicted, in motion (dashed), found (markers)."""
    finished = Results(results.quick, [row for row in results.rows if row["status"] == "ok"])
    shown = {axis: rows for kind, axis in AXES.items() if (rows := finished.of_kind(kind))}
    panels = [
        Panel(axis, "largest stable step h [s]", list(_curves(rows)), legend=False)
        for axis, rows in shown.items()
    ]
    path = directory / "stability_limits.png"
    return [chart(path, *panels, width=12.0, height=8.0, rows=2, columns=3)] if panels else []


def _curves(rows: Sequence[Row]) -> Iterator[Curve]:
    """Of each method, in the color of its scheme; and what the rule gives."""
    colors = dict(zip(SCHEMES, COLORS, strict=False))
    for own in groups(rows, "label" if rows[0]["kind"] == "violent" else "scheme").values():
        scheme, x = own[0]["scheme"], [row["value"] or NO_GRAVITY for row in own]
        yield Curve(x, column(own, "predicted"), scheme, colors[scheme], "-")
        yield Curve(x, column(own, "found"), None, colors[scheme], "o", {"fillstyle": "none"})
        if "predictedInMotion" in own[0]:
            yield Curve(x, column(own, "predictedInMotion"), None, colors[scheme], "--", {"linewidth": 0.8})
    if "rule" in rows[0]:
        yield Curve(x, column(own, "rule"), "rule (37), C = 0.7", "black", ":")


QUESTION = "Which step is the largest stable one at the extremes, and which bound rules where?"
STUDY = Study("stability_limits", QUESTION, Benchmark(SERIES), conclusions(*BARS), TABLES, draw, minutes=2)
