"""Nets: what inextensible cables save, beside native cables and implicit steps.

Question
    What does the motion of a net within 1 % and within 0.1 % cost, with inextensible cables and explicit
    steps, and with native cables and generalized-alpha, both tuned? What does a step of a large net cost?

What would refute it
    A native run that is as accurate and cheaper than every one of ours.

Protocol
    Nets of square meshes hang from their corners and are released in the shape of a bowl; each side of a mesh
    is a cable of its own in space, spherical joints tie them in knots. CPU time of SolveExplicit and of
    mbs.SolveDynamic, set-up included. The error is the root mean square distance of all knots at all outputs
    from a converged run, over the largest way of a knot. That run has inextensible cables, of a finer mesh
    and with small steps; the most accurate native run says how far natives agree with it. Both sides are
    tuned over elements and step, natives also over axial stiffness and Newton's method, with the sparse
    linear solver: the dense one took 4 to 5 times as long for 12 cables. Every candidate is run once; the
    cheapest ones within a bound are timed again, in turn, and the median counts.
    Large nets are too dear for that: both sides take steps of the same size, natives with modified Newton,
    the cheapest one; the difference of a long and a short run is the cost of a step. These processes have
    one thread, since those of the linear algebra library spin.

What is left out
    Nets that snap tight: their motion is chaotic, so that there is no error to be measured. Contact.
"""

import statistics
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from pathlib import Path

import exudyn
import numpy as np
from tqdm import tqdm

from exudyn_inext import InextensibleError
from exudyn_inext.arrays import Array

from .harness import Order, Results, Row, Study, Table, nets
from .harness.engines import ask
from .harness.nets import LARGE_ELEMENTS, STEP, Candidate, Inextensible, Native, Net, prepare
from .harness.plot import Curve, Panel, chart
from .harness.timing import in_turn

BOUNDS = (1e-2, 1e-3)
END = 0.4  # [s]
TUNED, LARGE = (2, 3), (10, 22)  # meshes along a side
QUICK_END = 0.05
REPETITIONS, PROMISING = 3, 1.5  # of the cheapest runs; times the cheapest one


def ours() -> list[Candidate]:
    """Candidates."""
    steps = (None, 2e-3, 1e-3, 5e-4, 2.5e-4)
    return [Inextensible(elements, step) for elements, step in product((2, 3, 4, 6, 8), steps)]


def natives() -> list[Candidate]:
    """Candidates."""
    newton = ("full", "modified", "modifiedEachStep")
    grid = product((2, 3, 4, 6), (5e-3, 2e-3, 1e-3, 5e-4), (1e4, 1e5, 1e6), newton)
    return [Native(*one) for one in grid]


def measure(order: Order) -> list[Row]:
    """Rows of candidates, of the best ones, and of large nets."""
    rows: list[Row] = []
    for meshes in TUNED[:1] if order.quick else TUNED:
        rows += _tuned(Net(meshes), order.quick)
    for meshes in (2,) if order.quick else LARGE:
        rows += [_large(meshes, formulation) for formulation in ("inextensible", "native")]
    return rows


def _tuned(net: Net, quick: bool) -> Iterator[Row]:
    end = QUICK_END if quick else END
    reference = prepare(net, Inextensible(12, 1e-3 if quick else 1e-4), end)()[1]
    size = float(np.linalg.norm(reference - reference[0], axis=2).max())
    sides = {"inextensible": ours(), "native": natives()}
    if quick:
        sides = {name: some[: 8 if name == "native" else 3] for name, some in sides.items()}
    for formulation, candidates in sides.items():
        found = [_candidate(net, one, formulation, end, reference, size) for one in tqdm(candidates)]
        yield from found
        for bound in BOUNDS:
            yield from _best(net, found, candidates, bound, end)


def _candidate(
    net: Net, candidate: Candidate, formulation: str, end: float, reference: Array, size: float
) -> Row:
    """Error and CPU time of one run; both None if it failed."""
    row: Row = {
        "kind": "candidate",
        "label": f"{net.cables} cables, {formulation}, {candidate.elements} elements, {candidate}",
        "cables": net.cables,
        "formulation": formulation,
        "elements": candidate.elements,
        "settings": str(candidate),
    }
    try:
        seconds, paths = prepare(net, candidate, end)()
    except (InextensibleError, exudyn.ExudynError):
        return row | {"error": None, "seconds": None}
    if paths.shape != reference.shape:
        return row | {"error": None, "seconds": None}
    error = float(np.sqrt(((paths - reference) ** 2).sum(axis=2).mean())) / size
    return row | {"error": error if np.isfinite(error) else None, "seconds": seconds}


def _best(
    net: Net, rows: Sequence[Row], candidates: Sequence[Candidate], bound: float, end: float
) -> Iterator[Row]:
    """The cheapest candidate within a bound, timed again; and our default settings, at their best mesh."""
    within = [
        (row, one)
        for row, one in zip(rows, candidates, strict=True)
        if row["error"] is not None and row["error"] < bound
    ]
    for kind in ("tuned", "default"):
        some = [pair for pair in within if kind == "tuned" or pair[0]["settings"] == "default settings"]
        if not some:
            continue
        least = min(row["seconds"] for row, _ in some)
        again = {row["label"]: (row, one) for row, one in some if row["seconds"] < PROMISING * least}
        runs = {label: partial(prepare, net, one, end) for label, (_, one) in again.items()}
        timed = in_turn(runs, REPETITIONS, f"{net.cables} cables, within {bound:g}")
        medians = {label: statistics.median(found.cpu_seconds) for label, found in timed.items()}
        label = min(medians, key=medians.__getitem__)
        yield again[label][0] | {"kind": "best", "bound": bound, "choice": kind, "seconds": medians[label]}


def _large(meshes: int, formulation: str) -> Row:
    """Start, step and memory, each in a process of its own."""
    found = dict(ask(nets.__name__, formulation, meshes, OPENBLAS_NUM_THREADS="1"))
    net = Net(meshes)
    return {
        "kind": "large",
        "label": f"{net.cables} cables, {formulation}",
        "cables": net.cables,
        "formulation": formulation,
        **found,
    }


def compare(results: Results) -> list[Row]:
    """Native over ours, for each net and bound."""
    best = {(r["cables"], r["bound"], r["formulation"], r["choice"]): r for r in results.of_kind("best")}
    rows = []
    for cables, bound in dict.fromkeys((r["cables"], r["bound"]) for r in results.of_kind("best")):
        mine, default, theirs = (
            best.get((cables, bound, *who), {})
            for who in (("inextensible", "tuned"), ("inextensible", "default"), ("native", "tuned"))
        )
        row: Row = {"cables": cables, "within": f"{bound:.1%}"}
        for name, one in (("ours", mine), ("default", default), ("native", theirs)):
            row[name] = one.get("seconds")
            row[f"{name}Error"] = one.get("error")
        row["ratio"] = theirs["seconds"] / mine["seconds"] if mine and theirs else None
        row["defaultRatio"] = theirs["seconds"] / default["seconds"] if default and theirs else None
        rows.append(row)
    return rows


def conclude(results: Results) -> list[str]:
    """Ratios at equal error, of steps of large nets, and how far both formulations agree."""
    said = [
        f"Net of {row['cables']} cables within {row['within']}: native over ours "
        + (f"{row['ratio']:.3g} tuned" if row["ratio"] else "not known, one of both does not get there")
        + (f", {row['defaultRatio']:.3g} at our default settings." if row["defaultRatio"] else ".")
        for row in compare(results)
    ]
    natives_found = [r for r in results.of_kind("candidate") if r["formulation"] == "native" and r["error"]]
    for cables in dict.fromkeys(row["cables"] for row in natives_found):
        least = min(row["error"] for row in natives_found if row["cables"] == cables)
        said.append(f"Net of {cables} cables: the most accurate native run agrees to {least:.2g}.")
    large = {(row["cables"], row["formulation"]): row for row in results.of_kind("large")}
    for cables in dict.fromkeys(cables for cables, _ in large):
        mine, theirs = large[cables, "inextensible"], large[cables, "native"]
        ratio = theirs["stepMilliseconds"] / mine["stepMilliseconds"]
        said.append(
            f"Net of {cables} cables of {LARGE_ELEMENTS} elements, steps of {STEP:g} s: "
            f"{mine['stepMilliseconds']:.3g} ms a step, native {theirs['stepMilliseconds']:.3g} ms, "
            f"{ratio:.3g} times; ours starts in {mine['startSeconds']:.3g} s within "
            f"{mine['megabytes']:.0f} MB."
        )
    return said


def draw(results: Results, directory: Path) -> list[Path]:
    """Error over CPU time of all candidates."""
    rows = [row for row in results.of_kind("candidate") if row["error"] and row["seconds"]]
    panels = []
    for cables in dict.fromkeys(row["cables"] for row in rows):
        own = [row for row in rows if row["cables"] == cables]
        curves = [
            Curve(*_front([row for row in own if row["formulation"] == name]), name)
            for name in ("inextensible", "native")
        ]
        panels.append(Panel("CPU time [s]", "error [-]", curves, title=f"{cables} cables"))
    return [chart(directory / "coupled_nets.png", *panels, width=4.5 * len(panels))]


def _front(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    """CPU times and errors of runs, none of which is dearer and worse than another one."""
    times: list[float] = []
    errors: list[float] = []
    for row in sorted(rows, key=lambda row: row["seconds"]):
        if not errors or row["error"] < errors[-1]:
            times.append(row["seconds"])
            errors.append(row["error"])
    return times, errors


TABLES = [
    Table(
        "best",
        "Cheapest runs within a bound [s], their errors, and ratios of CPU times:",
        "cables | within | ours | error: oursError | default settings: default | error: defaultError | "
        "native | error: nativeError | native over ours: ratio | over default settings: defaultRatio",
        compare,
    ),
    Table(
        "large",
        "Large nets, steps of the same size:",
        "cables | formulation | start [s]: startSeconds | a step [ms]: stepMilliseconds | "
        "memory [MB]: megabytes",
    ),
]
QUESTION = "What do nets of cables cost, inextensible and native, at equal error and step by step?"
STUDY = Study("coupled", QUESTION, measure, conclude, TABLES, draw)
