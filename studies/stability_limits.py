"""Stability at the extremes: the largest stable step, which bound it is, and where the rule (37) is safe.

Question
    Does the linear theory (h w_max and h zeta at the scheme's limits) give the largest stable step of every
    scheme, and what rules it: bending, tension, zeta, or axial waves?

What would refute it
    A bisected limit more than 5 % from the predicted one in the linear regime, without an explanation that
    was tested.

Protocol
    Linear regime: an equilibrium is disturbed by 1e-7 (mostly the fastest vibration, a tenth at random and
    off the constraints); a step is stable if the disturbance grows by less than 1000 within 3000 steps. The
    limit is bisected to 0.4 %. Predictions allow that growth, too: it matters only for a scheme that grows
    weakly at all steps (Zhai with its corrector and psi = phi = 1/2).
    A cable that spins has no equilibrium at rest: it is compared with the same steps of an undisturbed one.
    The step itself is linearised, too, in a frame that turns with the cable: this tests whether a smaller
    limit is the scheme's answer to terms of velocity. Growth is followed over 500 steps only,
    and over 200 where the limits differ: a scheme that gains energy spins the cable up meanwhile.
    Violent starts: a pinned cable is thrown; a step lasts if all smaller ones that were tried do, the
    constraints hold and the energy stays within 5 %.
    Long runs: the undamped pendulum, released 90 degrees off the vertical, N = 5, and the free flight of a
    bent cable; one change at a time.
    Single precision: coordinates and velocities are rounded to float32 after each step; the structured solves
    stay in double precision.
    Nothing is timed, so that all cores work at once.

What is left out
    Damping, drag, contact and bodies, which bound steps of their own; unequal elements.
"""

import math
from collections.abc import Sequence
from pathlib import Path

from .harness import Results, Row, Study, Table
from .harness.sweep import Sweep
from .stability import extremes
from .stability.findings import conclude
from .stability.linear import MAPS, linear_cases, run_linear
from .stability.long_runs import long_cases, run_long
from .stability.pictures import draw

_RUNS = {
    "slenderness": extremes.run_slenderness,
    "violent": extremes.run_violent,
    "long": run_long,
    "precision": extremes.run_precision,
}


def make_cases(quick: bool) -> Sequence[Row]:
    """Of all maps; long ones first, so that no core waits for them at the end."""
    long = sorted(long_cases(quick), key=lambda case: -case["value"])
    return [*long, *linear_cases(quick), *extremes.cases(quick)]


def run_case(case: Row) -> Row:
    """One point of one map."""
    return _RUNS.get(case["kind"], run_linear)(case)


_LIMITS = "predicted h [s]: predicted | found h [s]: found | found/predicted: ratio"
_RULES = "ruled by: ruledBy | rule (37)/found: ruleOverLimit | status"
_SPIN = (
    "linearised step [s]: predictedInMotion | found/linearised: ratioInMotion | "
    "over fewer steps: ratioSooner | growth of a step at 0.3 of w_max's limit: growth | "
    "its order in h: growthOrder | "
)

TABLES = (
    *(
        Table(kind, one.title, f"scheme, cable: label | {one.what}: value | {_LIMITS} | {extra}{_RULES}")
        for kind, one in MAPS.items()
        for extra in [_SPIN if kind == "spin" else ""]
    ),
    Table(
        "slenderness",
        "Native cables over EA/EI, N = 6:",
        f"integrator: label | EA/EI [1/m^2]: value | {_LIMITS} | ruled by: ruledBy | "
        "inextensible h [s]: inextensible | gain | status",
    ),
    Table(
        "violent",
        "Thrown cables, N = 10:",
        "scheme: label | speed [m/s]: value | limit at rest [s]: predicted | "
        "limit at the motion's w_max [s]: predictedInMotion | lasting h [s]: found | "
        "lasting/at rest: part | lasting/in motion: partOfMotion | status",
    ),
    Table(
        "long",
        "Long runs, N = 5, energies over the largest kinetic energy:",
        "run: label | scene | steps wanted: value | steps | h [s]: stepSize | t [s]: seconds | "
        "energy, largest change: energyMax | energy, drift: energyDrift | constraints: violation | "
        "momentum [N s]: momentum | angular momentum, relative: angularMomentum | "
        "h w_max/limit: frequencyOverLimit | status",
    ),
    Table(
        "precision",
        "State rounded to 32 bits against 64 bits, sagging cable:",
        f"scheme: label | N: value | {_LIMITS} | noise at half the limit: noise | status",
    ),
)


def make_conclusions(results: Results) -> list[str]:
    """One sentence a finding; cases that failed are named first."""
    failed = [
        "FAILED: {kind}, {label}, {value:g}: {status}".format_map(row)
        for row in results.rows
        if row["status"] != "ok"
    ]
    return failed + conclude(_finished(results))


def make_pictures(results: Results, directory: Path) -> list[Path]:
    """One a map, of the cases that did not fail."""
    return draw(_finished(results), directory)


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


QUESTION = "Which step is the largest stable one at the extremes, and which bound rules where?"
STUDY = Study(
    "stability_limits",
    QUESTION,
    Sweep(make_cases, run_case),
    make_conclusions,
    TABLES,
    make_pictures,
    minutes=2,
)
