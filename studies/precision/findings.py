"""Sentences that follow from the rows."""

from collections.abc import Iterator, Sequence
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
    runs, ratios = (groups(results.of_kind(kind), "scene") for kind in ("run", "speedUp"))
    sentences = failed + _bars(results)
    for reference in results.of_kind("reference"):
        scene = reference["scene"]
        sentences += _of_scene(reference, runs.get(scene, []), ratios.get(scene, []))
    return sentences


def _of_scene(reference: Row, runs: Sequence[Row], ratios: Sequence[Row]) -> Iterator[str]:
    """Reference; which methods make up the inextensible front; ratios; where it loses; what failed."""
    scene, uncertainty = reference["scene"], reference["uncertainty"]
    how = " (no independent one exists: self-convergence)" if reference["selfConvergence"] else ""
    yield (
        f"{scene}, {reference['motion']:g} s: errors are distances to {reference['source']}{how}, good to "
        f"{number(uncertainty, 2)} m; smaller errors count as large as that."
    )
    own = front_of(members(runs, INEXTENSIBLE), uncertainty)
    if own.rows:
        ends = [f"{number(own.errors[k], 2)} m in {number(own.seconds[k], 2)} s" for k in (0, -1)]
        methods = ", ".join(dict.fromkeys(map(fronts.method_of, own.rows)))
        yield f"{scene}: the inextensible front reaches from {ends[0]} to {ends[1]}; on it: {methods}."
    else:
        yield f"{scene}: no inextensible run succeeded."
    for opponent, rows in groups(ratios, "opponent").items():
        found = ", ".join(f"{_ratio(row)} at {row['bound']:g} m" for row in rows)
        yield f"{scene}, CPU time of {opponent} over that of the cable: {found}."
    for opponent in fronts.OTHERS:
        if theirs := [row for row in runs if fronts.OPPONENTS[opponent](row)]:
            losses = fronts.losses(front_of(theirs, uncertainty), own)
            where = "; ".join(f"{_range(loss)} ({loss.why})" for loss in losses) or "nowhere"
            yield f"{scene}: against {opponent}, the inextensible cable loses {where}."
    lost = [row for row in runs if row["status"] != "ok"]
    if lost:
        counts = {family: len(members(lost, family)) for family in fronts.FAMILIES}
        parts = [f"{n} of {len(members(runs, family))} {family}" for family, n in counts.items() if n]
        yield f"{scene}: runs that failed or diverged, kept with their status: {', '.join(parts)}."
    if scene in LINKED_SCENES and not members(runs, PEER):
        yield f"{scene}: {NOT_INSTALLED}"


def _ratio(row: Row) -> str:
    """A ratio, or why there is none."""
    if row["ratio"] is not None:
        return f"{row['ratio']:.0f}" if row["ratio"] >= 10.0 else f"{row['ratio']:.1f}"
    if row["opponentOutcome"] == BELOW:
        return f"nothing ({BELOW})"
    who = "opponent" if row["opponentSeconds"] is None else "cable"
    return f"none ({who}: {row['opponentOutcome'] if who == 'opponent' else row['ownOutcome']})"


def _range(loss: Loss) -> str:
    if loss.least == loss.largest:
        return f"at {number(loss.least, 2)} m"
    return f"from {number(loss.least, 2)} to {number(loss.largest, 2)} m"


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
