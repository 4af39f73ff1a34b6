"""Every run of a scene by its family, inextensible ones also by their method; and ratios over the error."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from studies.harness import Results, Row, column, groups
from studies.harness.figures import COST_AXES
from studies.harness.plot import COLORS, Curve, Panel, chart
from studies.harness.ratios import is_usable

from . import fronts
from .fronts import BY_NATIVE_SOLVERS, EXPLICIT, IMPLICIT, INEXTENSIBLE, PEER, front_of, members

_LOOK = {
    INEXTENSIBLE: (COLORS[0], "o"),
    BY_NATIVE_SOLVERS: (COLORS[5], "v"),
    IMPLICIT: (COLORS[1], "s"),
    EXPLICIT: (COLORS[2], "^"),
    PEER: (COLORS[3], "D"),
}
_MARKERS = "osD^v<>PX*h"
POINTS = 200
_RATIO_AXES = "error [m]", "CPU time over the inextensible cable's [-]"


def draw(results: Results, directory: Path) -> list[Path]:
    """One picture a scene, and one of all ratios."""
    usable = groups(filter(is_usable, results.of_kind("run")), "scene")
    known = [(row, usable[row["scene"]]) for row in results.of_kind("reference") if row["scene"] in usable]
    if not known:
        return []
    paths = [_draw_scene(reference, runs, directory) for reference, runs in known]
    panels = [_ratios(reference, runs) for reference, runs in known]
    path = directory / "work_precision_ratios.png"
    return [*paths, chart(path, *panels, width=11.0, height=8.0, rows=2, columns=4)]


def _draw_scene(reference: Row, runs: Sequence[Row], directory: Path) -> Path:
    scene, unknown = reference["scene"], reference["uncertainty"]
    own = [
        row | {"method": fronts.method_of(row)}
        for row in runs
        if fronts.family_of(row) in (INEXTENSIBLE, BY_NATIVE_SOLVERS)
    ]
    methods = dict(sorted(groups(own, "method").items()))
    looks = {name: (COLORS[k % len(COLORS)], _MARKERS[k % len(_MARKERS)]) for k, name in enumerate(methods)}
    families = {family: members(runs, family) for family in _LOOK}
    panels = [
        Panel(*COST_AXES, list(_fronts(rows, unknown, look)), title=title, legend="below", unknown=unknown)
        for rows, look, title in (
            (families, _LOOK, f"{scene}: all formulations"),
            (methods, looks, "inextensible cables by method"),
        )
    ]
    return chart(directory / f"work_precision_{scene}.png", *panels, width=12.0, height=6.4)


def _fronts(
    parts: Mapping[str, Sequence[Row]], uncertainty: float, looks: Mapping[str, tuple[str, str]]
) -> Iterator[Curve]:
    """Rows as markers, fronts as lines."""
    for name, rows in parts.items():
        if rows:
            (color, marker), found = looks[name], front_of(rows, uncertainty)
            faint = {"markersize": 3, "alpha": 0.5}
            yield Curve(column(rows, "cpuSeconds"), column(rows, "errorMax"), None, color, marker, faint)
            yield Curve(found.seconds, found.errors, name, color, marker + "-", {"markersize": 5})


def _ratios(reference: Row, runs: Sequence[Row]) -> Panel:
    """Where both fronts are; ends may leave one by rounding."""
    own = front_of(members(runs, INEXTENSIBLE), reference["uncertainty"])
    curves = []
    for opponent in fronts.OTHERS:
        theirs = front_of(filter(fronts.OPPONENTS[opponent], runs), reference["uncertainty"])
        if not (theirs.rows and own.rows):
            continue
        largest, least = (choose(theirs.errors[k], own.errors[k]) for choose, k in ((min, 0), (max, -1)))
        if largest > least:
            errors = np.geomspace(largest, least, POINTS)[1:-1]
            ratios = [fronts.speed_up(theirs, own, float(bound)) for bound in errors]
            curves.append(Curve(errors, ratios, opponent, _LOOK[opponent][0], "-"))
    title = reference["scene"] + ("" if curves else ": no fronts overlap")
    return Panel(*_RATIO_AXES, curves, title=title, legend=False, horizontal=(1.0,))
