"""The tables and sentences of pages, by name; each ends with where its figures come from."""

from collections.abc import Iterator

from studies import ring, table1, table2, table3
from studies.coupled import BOUNDS, compared
from studies.harness import Results, Row, groups
from studies.harness.cases import PAPER_METHOD, RULE
from studies.harness.ratios import (
    BY_NATIVE_SOLVERS,
    DEFAULT,
    EXPLICIT,
    IMPLICIT,
    OURS,
    PEER,
    TUNED,
    best,
    time_ratio,
)
from studies.harness.table import markdown_table, percent
from studies.speed.scene_cost import size_of

from .results import COMPARISONS, Block, Figures

SCENES = {
    table.name: (table.title, table.bounds)
    for table in (table1.TABLE, table2.TABLE, ring.TABLE, table3.TABLE)
}
"""Study -> scene, and the errors at which runs are compared [m]."""
Chosen = dict[str, Row | None]


def short(value: float | None, unit: float = 1.0) -> str:
    """Two digits, or all before the point; a hyphen where there is none."""
    if value is None:
        return "-"
    return f"{value / unit:.2g}" if value < 99.5 * unit else f"{value / unit:.0f}"


def milliseconds(row: Row | None) -> str:
    return short(row and row["cpuSeconds"], 1e-3)


def cancels(row: Row | None, bound: float) -> bool:
    """Whether the row is within the bound only as errors of mesh and step cancel."""
    return row is not None and (row.get("errorHalved") or 0.0) > bound


def headline(figures: Figures) -> str:
    """All scenes, those where native cables win too, at the largest and the smallest error."""
    lines, marked = [], []
    for name, (scene, bounds) in SCENES.items():
        for bound in (bounds[0], bounds[-1]):
            chosen = best(figures.rows(name), bound)
            lines.append([f"{scene}; {bound:g} m", *_cells(chosen, bound)])
            marked.append(_neighbours(f"{scene.partition(',')[0]} at {bound:g} m", chosen, bound))
    coupled = [line for line in _among_bodies(figures) if line[0].endswith(f"; {percent(BOUNDS[0])}")]
    lines += [[case, implicit, "-", *own] for case, implicit, *own in coupled]
    header = ["scene; error", *(f"{who} [ms]" for who in (IMPLICIT, EXPLICIT, *OURS))]
    notes = [
        f"One setting: {RULE}.",
        f"\\* Errors of mesh and step cancel; with half the step: {'; '.join(filter(None, marked)) or '-'}.",
        figures.origin(*SCENES, "coupled"),
    ]
    return "\n\n".join([markdown_table(header, lines), *notes])


def _cells(chosen: Chosen, bound: float) -> Iterator[str]:
    for who in (IMPLICIT, EXPLICIT, *OURS):
        row = chosen[who]
        star = r"\*" if cancels(row, bound) else ""
        ratio = time_ratio(chosen[IMPLICIT], row) if who in OURS else None
        yield milliseconds(row) + star + (f" ({short(ratio)})" if ratio else "")


def _neighbours(case: str, chosen: Chosen, bound: float) -> str:
    """Errors with half the step [m] of rows whose errors cancel; empty if there are none."""
    shown = {who: chosen[who] for who in (IMPLICIT, EXPLICIT, *OURS)}
    found = [
        f"{who} {short(row['errorHalved'])}" for who, row in shown.items() if row and cancels(row, bound)
    ]
    return f"{case}: {', '.join(found)}" if found else ""


def _among_bodies(figures: Figures) -> Iterator[list[str]]:
    """Scene and bound; native cables; ours."""
    for row in compared(Results(False, figures.rows("coupled"))):
        ours = [(row.get(key), row.get(f"native/{key}")) for key in ("default", "setting", "ours")]
        cells = [short(seconds, 1e-3) + (f" ({short(ratio)})" if ratio else "") for seconds, ratio in ours]
        yield [f"{row['scene']}; {row['within']}", short(row.get("native"), 1e-3), *cells]


def bodies(figures: Figures) -> str:
    """Scenes among bodies, joints and other cables, within both bounds."""
    header = ["scene; error", f"{IMPLICIT} [ms]", *(f"{who} [ms]" for who in OURS)]
    table = markdown_table(header, _among_bodies(figures))
    return f"{table}\n\nOne setting: {RULE}.\n\n{figures.origin('coupled')}"


COLUMNS = (
    "cheapest run", "N", "h [ms]", "CPU [ms]", "error [m]", "with half the step", "over default settings",
    "over tuned",
)  # fmt: skip


def comparison(figures: Figures) -> str:
    """What each run is, its error, and that of the same with half the step."""
    parts = []
    for name, (scene, bounds) in SCENES.items():
        lines = [line for bound in bounds for line in _compared(best(figures.rows(name), bound), bound)]
        parts.append(markdown_table([f"{scene}; error", *COLUMNS], lines))
    closest = _closest(figures)
    note = r"\* within the bound only as errors of mesh and step cancel."
    return "\n\n".join([*parts, f"One setting: {RULE}. {note}", closest, figures.origin(*SCENES)])


def _compared(chosen: Chosen, bound: float) -> Iterator[list[str]]:
    for who, row in chosen.items():
        if row is None and who.endswith("quadrature"):
            continue
        if row is None:
            yield [f"{bound:g} m", f"{who}: none", *["-"] * 7]
            continue
        ratios = [short(time_ratio(row, chosen[other])) for other in (DEFAULT, TUNED)]
        star = r"\*" if cancels(row, bound) else ""
        found = (short(row["errorMax"]) + star, short(row.get("errorHalved")), *ratios)
        run = f"{who}: {_what(row)}{_python(row)}"
        size = (str(row["elements"]), short(row["stepSize"], 1e-3), milliseconds(row))
        yield [f"{bound:g} m", run, *size, *found]


def _what(row: Row) -> str:
    """The label without what other columns say."""
    label = row["label"].partition(": ")[2] or row["label"]
    parts = label.removeprefix("inextensible ").removeprefix("native ").split(", ")
    return ", ".join(part for part in parts if not part.startswith(("N = ", "h = ")))


def _closest(figures: Figures) -> str:
    """The least ratio of all, of ours as tuned and at default settings."""
    found: dict[str, list[tuple[float, str]]] = {TUNED: [], DEFAULT: []}
    for name, (scene, bounds) in SCENES.items():
        for bound in bounds:
            chosen = best(figures.rows(name), bound)
            for who, ratios in found.items():
                if ratio := time_ratio(chosen[IMPLICIT], chosen[who]):
                    ratios.append((ratio, f"{scene.partition(',')[0]} at {bound:g} m"))
    said = [f"{short(min(some)[0])} ({who}, {min(some)[1]})" for who, some in found.items() if some]
    return f"The closest comparisons with native implicit runs: {', '.join(said)}."


def paper(figures: Figures) -> str:
    """The paper's settings: native runs, ours, and the paper's method, beside the paper's times."""
    lines = []
    for name in COMPARISONS:
        seconds = dict(figures[name].get("paper", {}).get("cpuSeconds", {}))
        rows = {row["label"]: row for row in figures.rows(name)}
        method = rows.get(PAPER_METHOD)
        own = next((row for label, row in rows.items() if label.startswith("ours at the paper's")), None)
        for label in dict.fromkeys([*seconds, *(row["label"] for row in (own, method) if row)]):
            if row := rows.get(label):
                ratios = [short(time_ratio(row, other)) for other in (method, own)]
                over_method = short(seconds[label] / list(seconds.values())[-1]) if label in seconds else ""
                run = f"{SCENES[name][0]}: {label}{_python(row)}"
                error = short(row["errorMax"]) if row.get("errorMax") else row["status"].partition(":")[0]
                lines.append([run, milliseconds(row), error, *ratios, over_method])
    header = ("run", "CPU [ms]", "error [m]", "over the paper's method", "over ours", "in the paper")
    return f"{markdown_table(header, lines)}\n\n{figures.origin(*COMPARISONS)}"


def _python(row: Row) -> str:
    """Which share of a native Zhai run is Exudyn's; the rest is Python, which drives it."""
    if not (row["integrator"].lower() == "zhai" and row.get("forceSeconds") and row.get("cpuSeconds")):
        return ""
    share = row["forceSeconds"] * row["steps"] / row["cpuSeconds"]
    return f" (driven from Python: {percent(share)} of the time in Exudyn's forces)"


READ_OFF = (5e-3, 7e-4)  # errors [m]
OTHERS = (PEER, BY_NATIVE_SOLVERS)


def everything(figures: Figures) -> str:
    """Of `work_precision`: opponents that `comparison` has not, at equal error, read off the fronts."""
    rows = [row for row in figures.rows("work_precision") if row["bound"] in READ_OFF]
    lines = []
    for scene, bound in dict.fromkeys((row["scene"], row["bound"]) for row in rows):
        ratios = {r["opponent"]: r.get("ratio") for r in rows if (r["scene"], r["bound"]) == (scene, bound)}
        lines.append([f"{scene.replace('_', ' ')}; {bound:g} m", *(short(ratios.get(one)) for one in OTHERS)])
    return f"{markdown_table(['scene; error', *OTHERS], lines)}\n\n{figures.origin('work_precision')}"


STEPS = {
    "cables alone": ("cables, loads known ahead", "cable of 10 elements"),
    "elements, cable alone": ("one cable, loads known ahead", "element"),
    "elements, watched": ("one cable, user functions at each step", "element"),
    "elements, with a spring": ("with a spring", "element"),
    "springs": ("with springs, dampers", "spring"),
    "mass points on joints": ("with mass points on joints", "point and joint"),
    "elements, with a body": ("with a rigid body on a joint", "element"),
    "bodies on joints": ("with rigid bodies on joints", "body and joint"),
    "joined cables": ("cables joined to each other, from two on", "cable and joint"),
}
"""Series of `scene_cost` -> scene, and what there is one more of."""


def step_cost(figures: Figures) -> str:
    """What a step costs, and what one more of something adds."""
    series = groups(figures.rows("scene_cost"), "label")
    lines = []
    for name, (scene, more) in STEPS.items():
        first, last = series[name][0], series[name][-1]
        slope = (last["microseconds"] - first["microseconds"]) / (size_of(last) - size_of(first))
        starts = [row["startMilliseconds"] for row in series[name]]
        start = f"{short(min(starts))} to {short(max(starts))}"
        lines.append([scene, short(first["microseconds"]), f"{short(slope)} us: {more}", start])
    header = ("scene", "us a step", "one more costs", "start [ms]")
    return f"{markdown_table(header, lines)}\n\n{figures.origin('scene_cost')}"


def _sentences(*names: str, containing: str = "", first: int | None = None) -> Block:
    """Conclusions of studies that contain a text; of each the first ones."""

    def block(figures: Figures) -> str:
        said = [
            s for name in names for s in [s for s in figures[name]["conclusions"] if containing in s][:first]
        ]
        return "\n".join(f"- {sentence}" for sentence in said) + f"\n\n{figures.origin(*names)}"

    return block


def noise(figures: Figures) -> str:
    """How far repeated studies differ."""
    said = [
        f"`{name}`, repeated {one['runs']} times: CPU times differ by {percent(one['median'])} in the "
        f"median, by {percent(one['largest'])} at most."
        for name, document in figures.all.items()
        if (one := document.get("repeated"))
    ]
    rest = "How far repeated studies differ is not measured yet: `python -m studies remake table1 --times 3`."
    return "\n".join(f"- {sentence}" for sentence in said) or rest


BLOCKS: dict[str, Block] = {
    "headline": headline,
    "comparison": comparison,
    "paper": paper,
    "bodies": bodies,
    "nets": _sentences("coupled", containing="et of "),
    "everything": everything,
    "step_cost": step_cost,
    "steps": _sentences("kernel", "scaling", "realtime", "ensemble", first=1),
    "stretch": _sentences("stretch"),
    "noise": noise,
}
