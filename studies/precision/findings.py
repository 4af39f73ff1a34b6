"""Sentences that follow from the rows."""

from collections.abc import Sequence
from itertools import product

from studies.harness import Results, Row, groups, number, verdict

from . import fronts
from .cases import LINKED_SCENES, NOT_INSTALLED
from .fronts import EXPLICIT, IMPLICIT, INEXTENSIBLE, PEER, Loss, front_of, members
from .scene_run import BELOW

BAR = 50.0
BAR_SCENE, BAR_BOUNDS = "planar_pendulum", (5e-3, 7e-4)


def conclude(results: Results) -> list[str]:
    """References, bars, ratios, losses, failures: scene by scene."""
    failed = [f"FAILED: {row['scene']}: {row['status']}" for row in results.of_kind("scene")]
    sentences = failed + _bars(results)
    for reference in results.of_kind("reference"):
        scene = reference["scene"]
        runs, ratios = (
            [row for row in results.of_kind(kind) if row["scene"] == scene] for kind in ("run", "speedUp")
        )
        sentences += [_reference(reference), _best(reference, runs)]
        sentences += _ratios(ratios) + _losses(reference, runs) + _failures(runs)
        if scene in LINKED_SCENES and not members(runs, PEER):
            sentences.append(f"{scene}: {NOT_INSTALLED}")
    return sentences


def _reference(row: Row) -> str:
    how = " (no independent one exists: self-convergence)" if row["selfConvergence"] else ""
    return (
        f"{row['scene']}, {row['motion']:g} s: errors are distances to {row['source']}{how}, good to "
        f"{number(row['uncertainty'], 2)} m; smaller errors count as large as that."
    )


def _best(reference: Row, runs: Sequence[Row]) -> str:
    """Which methods make up the inextensible front."""
    found = front_of(members(runs, INEXTENSIBLE), reference["uncertainty"])
    if not found.rows:
        return f"{reference['scene']}: no inextensible run succeeded."
    methods = list(dict.fromkeys(fronts.method_of(row) for row in found.rows))
    return (
        f"{reference['scene']}: the inextensible front reaches from {number(found.errors[0], 2)} m in "
        f"{number(found.seconds[0], 2)} s to {number(found.errors[-1], 2)} m in "
        f"{number(found.seconds[-1], 2)} s; on it: {', '.join(methods)}."
    )


def _ratios(rows: Sequence[Row]) -> list[str]:
    return [
        f"{own[0]['scene']}, CPU time of {opponent} over that of the cable: "
        + ", ".join(f"{_ratio(row)} at {row['bound']:g} m" for row in own)
        + "."
        for opponent, own in groups(rows, "opponent").items()
    ]


def _ratio(row: Row) -> str:
    """A ratio, or why there is none."""
    if row["ratio"] is not None:
        return f"{row['ratio']:.0f}" if row["ratio"] >= 10.0 else f"{row['ratio']:.1f}"
    if row["opponentOutcome"] == BELOW:
        return f"nothing ({BELOW})"
    who = "opponent" if row["opponentSeconds"] is None else "cable"
    return f"none ({who}: {row['opponentOutcome'] if who == 'opponent' else row['ownOutcome']})"


def _losses(reference: Row, runs: Sequence[Row]) -> list[str]:
    """Where the inextensible front loses, against every opponent."""
    own = front_of(members(runs, INEXTENSIBLE), reference["uncertainty"])
    sentences = []
    for opponent in fronts.OTHERS:
        if theirs := [row for row in runs if fronts.OPPONENTS[opponent](row)]:
            found = fronts.losses(front_of(theirs, reference["uncertainty"]), own)
            where = "; ".join(f"{_range(loss)} ({loss.why})" for loss in found) or "nowhere"
            sentences.append(
                f"{reference['scene']}: against {opponent}, the inextensible cable loses {where}."
            )
    return sentences


def _range(loss: Loss) -> str:
    if loss.least == loss.largest:
        return f"at {number(loss.least, 2)} m"
    return f"from {number(loss.least, 2)} to {number(loss.largest, 2)} m"


def _failures(runs: Sequence[Row]) -> list[str]:
    lost = [row for row in runs if row["status"] != "ok"]
    if not lost:
        return []
    counts = {family: len(members(lost, family)) for family in fronts.FAMILIES}
    parts = [f"{count} of {len(members(runs, family))} {family}" for family, count in counts.items() if count]
    return [f"{lost[0]['scene']}: runs that failed or diverged, kept with their status: {', '.join(parts)}."]


def _bars(results: Results) -> list[str]:
    """What the study has to show, on the whole motion of the planar pendulum."""
    if results.quick:
        return []
    rows = {(row["scene"], row["bound"], row["opponent"]): row for row in results.of_kind("speedUp")}
    asked = product([BAR_SCENE], BAR_BOUNDS, (IMPLICIT, EXPLICIT, PEER))
    return [_verdict(rows[one], 1.0 if one[-1] == PEER else BAR) for one in asked if one in rows]


def _verdict(row: Row, bar: float) -> str:
    left = f"bar: {row['scene']} at {row['bound']:g} m, {row['opponent']}, at least {bar:g} times"
    if row["ratio"] is not None:
        return f"{left}: {verdict(row['ratio'] >= bar)}, {number(row['ratio'])}."
    return f"{left}: {_ratio(row)}."
