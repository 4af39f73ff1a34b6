"""Sentences that follow from the rows of the maps."""

import math
from collections.abc import Callable, Sequence
from itertools import product

from studies.harness import Results, Row, column, groups, largest

from .limits import AGREEMENT
from .linear import MAPS


def conclude(results: Results) -> list[str]:
    """All sentences, map by map; a map without rows gives none."""
    linear = [row for row in results.rows if row["kind"] in MAPS and row["kind"] != "spin"]
    sentences = [_agreement(*one) for one in groups(linear, "scheme").items()]
    sentences += _ruling(linear) + _rule_37([row for row in linear if row["theta"] == 0.0])
    for kind, key, make in BY_GROUP:
        sentences += [make(label, own) for label, own in groups(results.of_kind(kind), key).items()]
    long = results.of_kind("long")
    sentences += [_long(row) for row in long] + _decisive(long)
    return sentences + [_precision(*one) for one in groups(results.of_kind("precision"), "scheme").items()]


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
    worst = min(rows, key=lambda row: row["ratio"])
    explained = sum(_is_near(row["ratioInMotion"]) for row in rows)
    sooner = sum(_is_near(row.get("ratioSooner", 0.0)) for row in rows)
    before = f", and {sooner} more before the cable has spun up" if sooner else ""
    row = largest(rows, "growth")  # what a step well below the limit does, at the fastest spin
    weak = "grow by {growth:.0e} at most, which is none."
    if row["growthOrder"] is not None:
        weak = (
            "still grow, by up to {growth:.0e} each ({value:g} rad/s), with the power {growthOrder:.1f} of h."
        )
    return (
        f"{scheme}, spinning: the limit falls to {worst['ratio']:.2f} of that of w_max at "
        f"{worst['value']:g} rad/s; the linearised step explains {explained} of {len(rows)} within "
        f"5 %{before}. Steps of 0.3 of w_max's limit {weak.format_map(row)}"
    )


def _slenderness(scheme: str, rows: Sequence[Row]) -> str:
    ratios = column(rows, "ratio")
    bending = [row for row in rows if row["ruledBy"] == "bending"]
    axial = [row for row in rows if row["ruledBy"] != "bending"]
    off = sum(not _is_near(ratio) for ratio in ratios)
    return (
        f"Native cable, {scheme}: found over predicted {min(ratios):.3f} to {max(ratios):.3f} "
        f"({'bar of 5 % kept' if not off else f'bar of 5 % MISSED in {off}'}); "
        + (f"bending rules at EA/EI = {_range(bending)}, " if bending else "")
        + (f"axial waves at {_range(axial)} 1/m^2; " if axial else "")
        + f"the inextensible step is up to {max(column(rows, 'gain')):.3g} times larger."
    )


def _violent(label: str, rows: Sequence[Row]) -> str:
    parts = ", ".join("{part:.2f} at {value:g} m/s".format_map(row) for row in rows)
    return (
        f"Violent starts, {label}: the lasting step is {parts}, in parts of the limit at rest; at worst "
        f"{min(column(rows, 'partOfMotion')):.2f} of what the motion's own w_max and zeta allow."
    )


BY_GROUP: tuple[tuple[str, str, Callable[[str, Sequence[Row]], str]], ...] = (
    ("spin", "scheme", _spin),
    ("slenderness", "scheme", _slenderness),
    ("violent", "label", _violent),
)


def _long(row: Row) -> str:
    end = "survives" if row["survives"] else f"DIVERGES after {row['seconds']:.3g} s"
    kept = row["angularMomentum"]
    momentum = "" if kept is None else f", angular momentum within {kept:.1e}"
    return (
        "Long run, {scene}, {label}: {end} ({steps:.0e} steps), energy within {energyMax:.1e} of the swing, "
        "drift {energyDrift:.1e}, constraints {violation:.1e}{momentum}.".format_map(
            row | {"end": end, "momentum": momentum}
        )
    )


def _decisive(rows: Sequence[Row]) -> list[str]:
    """Which single change lets Zhai's pendulum survive, or last longer."""
    rows = [row for row in rows if row["scene"] == "pendulum"]
    shortest = min(column(rows, "value"), default=0)
    rows = [row for row in rows if row["value"] == shortest and row["scheme"].startswith("Zhai")]
    base = next((row for row in rows if row["label"].startswith("base")), None)
    if base is None or len(rows) < 3:
        return []
    surviving = [row["label"] for row in rows if row["survives"]]
    diverging = [row for row in rows if not row["survives"]]
    longer = [
        f"{row['label']} ({row['seconds'] / base['seconds']:.2g} times as long)"
        for row in diverging
        if row is not base
    ]
    beyond = [row["label"] for row in diverging if row["frequencyOverLimit"] > 1.0]
    return [
        f"What decides whether Zhai's pendulum survives {shortest:.0e} steps, one change at a time: "
        f"surviving with {', '.join(surviving) or 'none'}; diverging with {', '.join(longer) or 'none'}.",
        "At their end or before, h w_max was above the limit in "
        f"{', '.join(beyond) or 'none of the runs that diverged'}.",
    ]


def _precision(scheme: str, rows: Sequence[Row]) -> str:
    single = [row for row in rows if row["bits"] == 32]
    usable = [row for row in single if _is_near(row["ratio"])]
    worst = largest(single, "value")
    doubles = {row["value"]: row["noise"] for row in rows if row["bits"] == 64}
    noises = (worst["noise"], doubles.get(worst["value"]))
    here, double = ("none (diverged)" if x is None or math.isinf(x) else f"{x:.1e}" for x in noises)
    return (
        f"Single precision, {scheme}: the limit stays within 5 % of the predicted one for N = "
        f"{_range(usable) if usable else 'none'}; noise at N = {worst['value']}: "
        f"{here} against {double} in double precision."
    )
