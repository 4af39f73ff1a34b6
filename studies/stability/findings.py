"""Sentences that follow from the rows of the maps."""

import math
from collections.abc import Sequence

from studies.harness.benchmark import Figures
from studies.harness.study import Row

from .bisection import AGREEMENT

LINEAR = ("scheme", "zeta", "stiffness", "elements", "curvature", "gravity")
WEAK_GROWTH = 1e3  # constraint drift that counts as lost, over that of the best run


def conclude(figures: Figures) -> list[str]:
    """All sentences, map by map; a map without rows gives none."""
    makers = (_agreement, _ruling, _rule_37, _spin, _slenderness, _violent, _long, _decisive, _precision)
    return [sentence for make in makers for sentence in make(figures)]


def _off(row: Row) -> bool:
    """Whether prediction and bisection differ by more than AGREEMENT."""
    if math.isinf(row["predicted"]):
        return not math.isinf(row["found"])
    return not abs(row["ratio"] - 1.0) <= AGREEMENT


def _agreement(figures: Figures) -> list[str]:
    rows = [row for row in figures.rows if row["kind"] in LINEAR]
    sentences = []
    for scheme in dict.fromkeys(row["scheme"] for row in rows):
        own = [row for row in rows if row["scheme"] == scheme]
        ratios = [row["ratio"] for row in own if row["ratio"] is not None]
        off = [row for row in own if _off(row)]
        verdict = "kept" if not off else f"MISSED in {len(off)}: " + "; ".join(_place(row) for row in off)
        sentences.append(
            f"{scheme}, linear regime: found over predicted limit {min(ratios):.3f} to {max(ratios):.3f} in "
            f"{len(ratios)} cases, {len(own) - len(ratios)} more without a limit; bar of 5 % {verdict}."
        )
    return sentences


def _place(row: Row) -> str:
    ratio = "no limit predicted" if row["ratio"] is None else f"{row['ratio']:.3g}"
    return f"{row['kind']} {row['value']:g}, {row['cable']}, theta = {row['theta']:g} ({ratio})"


def _ruling(figures: Figures) -> list[str]:
    """Where what rules changes along a map, for the first scheme."""
    sentences = []
    for kind, what in (("zeta", "zeta [1/s]"), ("stiffness", "EI/EI_0"), ("elements", "N"),
                       ("curvature", "curvature"), ("gravity", "g/g_0")):  # fmt: skip
        rows = [row for row in figures.of_kind(kind) if row["scheme"] == "Zhai"]
        rules = list(dict.fromkeys(row["ruledBy"] for row in rows))
        parts = [
            f"{rule} at {_range([row['value'] for row in rows if row['ruledBy'] == rule])}" for rule in rules
        ]
        if parts:
            sentences.append(f"What rules Zhai's step over {what}: {', '.join(parts)}.")
    return sentences


def _range(values: Sequence[float]) -> str:
    return f"{min(values):g}" if len(values) == 1 else f"{min(values):g} to {max(values):g}"


def _rule_37(figures: Figures) -> list[str]:
    """Where the paper's rule is above the limit that was found."""
    rows = [row for row in figures.rows if row["kind"] in LINEAR and row["theta"] == 0.0]
    sentences = []
    for scheme in ("Zhai", "RATTLE", "RK4"):
        for kind in LINEAR[1:]:
            own = [row for row in rows if row["kind"] == kind and row["scheme"] == scheme]
            unsafe = [row for row in own if row["rule"] > row["found"]]
            if unsafe:
                worst = max(unsafe, key=lambda row: row["ruleOverLimit"])
                sentences.append(
                    f"Rule (37) with C = 0.7 is NOT safe for {scheme} over {kind} at "
                    f"{_range([row['value'] for row in unsafe])} ({len(unsafe)} of {len(own)}), up to "
                    f"{worst['ruleOverLimit']:.3g} times the limit ({worst['cable']}, ruled by "
                    f"{worst['ruledBy']})."
                )
            elif own:
                largest = max(row["ruleOverLimit"] for row in own)
                sentences.append(
                    f"Rule (37) with C = 0.7 is safe for {scheme} over {kind}: at most {largest:.2f} of the "
                    "limit."
                )
    return sentences


def _spin(figures: Figures) -> list[str]:
    rows = figures.of_kind("spin")
    sentences = []
    for scheme in dict.fromkeys(row["scheme"] for row in rows):
        own = [row for row in rows if row["scheme"] == scheme]
        worst = min(own, key=lambda row: row["ratio"])
        explained = [row for row in own if abs(row["ratioInMotion"] - 1.0) <= AGREEMENT]
        sooner = [row for row in own if abs(row.get("ratioSooner", 0.0) - 1.0) <= AGREEMENT]
        before = f", and {len(sooner)} more before the cable has spun up" if sooner else ""
        sentences.append(
            f"{scheme}, spinning: the limit falls to {worst['ratio']:.2f} of that of w_max at "
            f"{worst['value']:g} rad/s; the linearised step explains {len(explained)} of {len(own)} within "
            f"5 %{before}. {_weak_growth(own)}"
        )
    return sentences


def _weak_growth(rows: Sequence[Row]) -> str:
    """What a step well below the limit does, at the fastest spin."""
    row = max(rows, key=lambda row: row["growth"])
    if row["growthOrder"] is None:
        return f"Steps of 0.3 of w_max's limit grow by {row['growth']:.0e} at most, which is none."
    return (
        f"Steps of 0.3 of w_max's limit still grow, by up to {row['growth']:.0e} each ({row['value']:g} "
        f"rad/s), with the power {row['growthOrder']:.1f} of h."
    )


def _slenderness(figures: Figures) -> list[str]:
    rows = figures.of_kind("slenderness")
    sentences = []
    for scheme in dict.fromkeys(row["scheme"] for row in rows):
        own = [row for row in rows if row["scheme"] == scheme]
        ratios = [row["ratio"] for row in own]
        bending = [row["value"] for row in own if row["ruledBy"] == "bending"]
        axial = [row["value"] for row in own if row["ruledBy"] != "bending"]
        off = sum(abs(ratio - 1.0) > AGREEMENT for ratio in ratios)
        sentences.append(
            f"Conventional cable, {scheme}: found over predicted {min(ratios):.3f} to {max(ratios):.3f} "
            f"({'bar of 5 % kept' if not off else f'bar of 5 % MISSED in {off}'}); "
            + (f"bending rules at EA/EI = {_range(bending)}, " if bending else "")
            + (f"axial waves at {_range(axial)} 1/m^2; " if axial else "")
            + f"the inextensible step is up to {max(row['gain'] for row in own):.3g} times larger."
        )
    return sentences


def _violent(figures: Figures) -> list[str]:
    rows = figures.of_kind("violent")
    sentences = []
    for label in dict.fromkeys(row["label"] for row in rows):
        own = [row for row in rows if row["label"] == label]
        parts = ", ".join(f"{row['part']:.2f} at {row['value']:g} m/s" for row in own)
        tension = min(row["partOfMotion"] for row in own)
        sentences.append(
            f"Violent starts, {label}: the lasting step is {parts}, in parts of the limit at rest; at worst "
            f"{tension:.2f} of what the motion's own w_max and zeta allow."
        )
    return sentences


def _long(figures: Figures) -> list[str]:
    sentences = []
    for row in figures.of_kind("long"):
        end = "survives" if row["survives"] else f"DIVERGES after {row['seconds']:.3g} s"
        momentum = ""
        if row["angularMomentum"] is not None:
            momentum = f", angular momentum within {row['angularMomentum']:.1e}"
        sentences.append(
            f"Long run, {row['scene']}, {row['label']}: {end} ({row['steps']:.0e} steps), energy within "
            f"{row['energyMax']:.1e} of the swing, drift {row['energyDrift']:.1e}, constraints "
            f"{row['violation']:.1e}{momentum}."
        )
    return sentences


def _decisive(figures: Figures) -> list[str]:
    """Which single change lets Zhai's pendulum survive, or last longer."""
    rows = [row for row in figures.of_kind("long") if row["scene"] == "pendulum"]
    shortest = min((row["value"] for row in rows), default=0)
    rows = [row for row in rows if row["value"] == shortest and row["scheme"].startswith("Zhai")]
    base = next((row for row in rows if row["label"].startswith("base")), None)
    if base is None or len(rows) < 3:
        return []
    surviving = [row["label"] for row in rows if row["survives"]]
    longer = [
        f"{row['label']} ({row['seconds'] / base['seconds']:.2g} times as long)"
        for row in rows
        if not row["survives"] and row is not base
    ]
    beyond = [row["label"] for row in rows if not row["survives"] and row["frequencyOverLimit"] > 1.0]
    return [
        f"What decides whether Zhai's pendulum survives {shortest:.0e} steps, one change at a time: "
        f"surviving with {', '.join(surviving) or 'none'}; diverging with {', '.join(longer) or 'none'}.",
        "At their end or before, h w_max was above the limit in "
        f"{', '.join(beyond) or 'none of the runs that diverged'}.",
    ]


def _precision(figures: Figures) -> list[str]:
    rows = figures.of_kind("precision")
    sentences = []
    for scheme in dict.fromkeys(row["scheme"] for row in rows):
        single = [row for row in rows if row["scheme"] == scheme and row["bits"] == 32]
        usable = [row["value"] for row in single if abs(row["ratio"] - 1.0) <= AGREEMENT]
        worst = max(single, key=lambda row: row["value"])
        doubles = {
            row["value"]: row["noise"] for row in rows if row["scheme"] == scheme and row["bits"] == 64
        }
        sentences.append(
            f"Single precision, {scheme}: the limit stays within 5 % of the predicted one for N = "
            f"{_range(usable) if usable else 'none'}; noise at N = {worst['value']}: "
            f"{_noise(worst['noise'])} against {_noise(doubles.get(worst['value']))} in double precision."
        )
    return sentences


def _noise(value: float | None) -> str:
    return "none (diverged)" if value is None or math.isinf(value) else f"{value:.1e}"
