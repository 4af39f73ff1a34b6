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
    Nothing is timed, so that all cores work at once.

What is left out
    Damping, drag, contact and bodies, which bound steps of their own; unequal elements. Axial waves of
    native cables: `stretch`. Long runs: `soak`.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

from .harness import Results, Row, Study, Table, column, groups, largest
from .harness.plot import COLORS, Curve, Panel, chart
from .harness.pool import Sweep
from .stability.limits import AGREEMENT
from .stability.linear import MAPS, linear_cases, run_linear
from .stability.motion import SCHEMES
from .stability.violent import run_violent, violent_cases


def make_cases(quick: bool) -> Sequence[Row]:
    """Of all maps."""
    return [*linear_cases(quick), *violent_cases(quick)]


def run_case(case: Row) -> Row:
    """One point of one map."""
    return (run_violent if case["kind"] == "violent" else run_linear)(case)


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


def _finished(results: Results) -> Results:
    """What JSON stored as null is a limit that does not exist."""
    limits = ("predicted", "found", "predictedBending", "predictedZeta")
    return Results(
        results.quick,
        [
            row | {key: math.inf for key in limits if key in row and row[key] is None}
            for row in results.rows
            if row["status"] == "ok"
        ],
    )


def conclude(given: Results) -> list[str]:
    """All sentences, map by map; a map without rows gives none; cases that failed are named first."""
    results = _finished(given)
    failed = [
        "FAILED: {kind}, {label}, {value:g}: {status}".format_map(row)
        for row in given.rows
        if row["status"] != "ok"
    ]
    linear = [row for row in results.rows if row["kind"] in MAPS and row["kind"] != "spin"]
    sentences = [_agreement(*one) for one in groups(linear, "scheme").items()]
    sentences += _ruling(linear) + _rule_37([row for row in linear if row["theta"] == 0.0])
    sentences += [_spin(*one) for one in groups(results.of_kind("spin"), "scheme").items()]
    return (
        failed + sentences + [_violent(*one) for one in groups(results.of_kind("violent"), "label").items()]
    )


def _is_near(ratio: float) -> bool:
    return abs(ratio - 1.0) <= AGREEMENT


def _agreement(scheme: str, rows: Sequence[Row]) -> str:
    """Where prediction and bisection differ by more than AGREEMENT."""
    ratios, off = [row["ratio"] for row in rows if row["ratio"] is not None], []
    for row in rows:
        known = math.isfinite(row["predicted"])
        if not (_is_near(row["ratio"]) if known else math.isinf(row["found"])):
            ratio = "no limit predicted" if row["ratio"] is None else f"{row['ratio']:.3g}"
            off.append("{kind} {value:g}, {cable}, theta = {theta:g}".format_map(row) + f" ({ratio})")
    verdict = f"MISSED in {len(off)}: {'; '.join(off)}" if off else "kept"
    return (
        f"{scheme}, linear regime: found over predicted limit {min(ratios):.3f} to {max(ratios):.3f} in "
        f"{len(ratios)} cases, {len(rows) - len(ratios)} more without a limit; bar of 5 % {verdict}."
    )


def _ruling(rows: Sequence[Row]) -> list[str]:
    """Where what rules changes along a map, for the first scheme."""
    maps = groups([row for row in rows if row["scheme"] == "Zhai" and MAPS[row["kind"]].said], "kind")
    sentences = []
    for kind in sorted(maps, key=list(MAPS).index):
        parts = [f"{rule} at {_range(own)}" for rule, own in groups(maps[kind], "ruledBy").items()]
        sentences.append(f"What rules Zhai's step over {MAPS[kind].said}: {', '.join(parts)}.")
    return sentences


def _range(rows: Sequence[Row]) -> str:
    """Of what the map varies."""
    values = column(rows, "value")
    return f"{min(values):g}" if len(values) == 1 else f"{min(values):g} to {max(values):g}"


def _rule_37(rows: Sequence[Row]) -> list[str]:
    """Where the paper's rule is above the limit that was found."""
    sentences = []
    for scheme, kind in product(("Zhai", "RATTLE", "RK4"), [kind for kind, one in MAPS.items() if one.said]):
        own = [row for row in rows if row["kind"] == kind and row["scheme"] == scheme]
        unsafe = [row for row in own if row["rule"] > row["found"]]
        where = f"safe for {scheme} over {kind}"
        if unsafe:
            worst = "{ruleOverLimit:.3g} times the limit ({cable}, ruled by {ruledBy})"
            sentences.append(
                f"Rule (37) with C = 0.7 is NOT {where} at {_range(unsafe)} ({len(unsafe)} of {len(own)}), "
                f"up to {worst.format_map(largest(unsafe, 'ruleOverLimit'))}."
            )
        elif own:
            most = max(column(own, "ruleOverLimit"))
            sentences.append(f"Rule (37) with C = 0.7 is {where}: at most {most:.2f} of the limit.")
    return sentences


def _spin(scheme: str, rows: Sequence[Row]) -> str:
    worst, near = min(rows, key=lambda row: float(row["ratio"])), sum(_is_near(row["ratio"]) for row in rows)
    return (
        f"{scheme}, spinning: the limit falls to {worst['ratio']:.2f} of that of w_max at {worst['value']:g} "
        f"rad/s; it is within 5 % of it for {near} of {len(rows)} rates."
    )


def _violent(label: str, rows: Sequence[Row]) -> str:
    parts = ", ".join("{part:.2f} at {value:g} m/s".format_map(row) for row in rows)
    return (
        f"Violent starts, {label}: the lasting step is {parts}, in parts of the limit at rest; at worst "
        f"{min(column(rows, 'partOfMotion')):.2f} of what the motion's own w_max and zeta allow."
    )


AXES = {kind: one.axis for kind, one in MAPS.items() if one.axis} | {
    "violent": "largest speed at the start [m/s]"
}
NO_GRAVITY = 1e-1  # shown in place of zero on a logarithmic axis


def draw(results: Results, directory: Path) -> list[Path]:
    """Largest stable steps over what each map varies: predicted, in motion (dashed), found (markers)."""
    finished = _finished(results)
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
STUDY = Study(
    "stability_limits",
    QUESTION,
    Sweep(make_cases, run_case),
    conclude,
    TABLES,
    draw,
    minutes=2,
)
