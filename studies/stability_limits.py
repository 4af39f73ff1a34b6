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

from .harness.benchmark import Figures, Table
from .harness.study import Row
from .harness.sweep.study import SweepStudy
from .stability.findings import conclude
from .stability.linear import linear_cases, run_linear
from .stability.long_runs import long_cases, run_long
from .stability.pictures import draw
from .stability.precision import precision_cases, run_precision
from .stability.slenderness import run_slenderness, slenderness_cases
from .stability.violent import run_violent, violent_cases

_RUNS = {
    "slenderness": run_slenderness,
    "violent": run_violent,
    "long": run_long,
    "precision": run_precision,
}


def make_cases(quick: bool) -> Sequence[Row]:
    """Of all maps; long ones first, so that no core waits for them at the end."""
    makers = (long_cases, linear_cases, slenderness_cases, violent_cases, precision_cases)
    cases = [case for make in makers for case in make(quick)]
    return sorted(cases, key=lambda case: -case["value"] if case["kind"] == "long" else 0.0)


def run_case(case: Row) -> Row:
    """One point of one map."""
    return _RUNS.get(case["kind"], run_linear)(case)


_LIMITS = {"predicted h [s]": "predicted", "found h [s]": "found", "found/predicted": "ratio"}
_RULES = {"ruled by": "ruledBy", "rule (37)/found": "ruleOverLimit", "status": "status"}


def _linear_table(kind: str, title: str, what: str) -> Table:
    return Table(kind, title, {"scheme, cable": "label", what: "value"} | _LIMITS | _RULES)


TABLES = (
    _linear_table("scheme", "Every scheme on every cable, by mass scaling:", "theta"),
    _linear_table("zeta", "Over the stabilisation rate:", "zeta [1/s]"),
    _linear_table(
        "stiffness", "Over the bending stiffness, hanging cable with a mass of its own at its end:", "EI/EI_0"
    ),
    _linear_table("elements", "Over the number of elements:", "N"),
    _linear_table(
        "curvature",
        "Over the curvature; ring and coil: turning of an element [rad], sagging: span/length:",
        "value",
    ),
    _linear_table("gravity", "Over gravity, hanging cable with a mass of its own at its end:", "g/g_0"),
    Table(
        "spin",
        "Over the rate at which a cable with a mass at its end spins about its start:",
        {"scheme, cable": "label", "rate [rad/s]": "value"}
        | _LIMITS
        | {
            "linearised step [s]": "predictedInMotion",
            "found/linearised": "ratioInMotion",
            "over fewer steps": "ratioSooner",
        }
        | {"growth of a step at 0.3 of w_max's limit": "growth", "its order in h": "growthOrder"}
        | _RULES,
    ),
    Table(
        "slenderness",
        "Conventional cables over EA/EI, N = 6:",
        {"integrator": "label", "EA/EI [1/m^2]": "value"}
        | _LIMITS
        | {"ruled by": "ruledBy", "inextensible h [s]": "inextensible", "gain": "gain", "status": "status"},
    ),
    Table(
        "violent",
        "Thrown cables, N = 10:",
        {
            "scheme": "label",
            "speed [m/s]": "value",
            "limit at rest [s]": "predicted",
            "limit at the motion's w_max [s]": "predictedInMotion",
            "lasting h [s]": "found",
            "lasting/at rest": "part",
            "lasting/in motion": "partOfMotion",
            "status": "status",
        },
    ),
    Table(
        "long",
        "Long runs, N = 5, energies over the largest kinetic energy:",
        {
            "run": "label",
            "scene": "scene",
            "steps wanted": "value",
            "steps": "steps",
            "h [s]": "stepSize",
            "t [s]": "seconds",
            "energy, largest change": "energyMax",
            "energy, drift": "energyDrift",
            "constraints": "violation",
            "momentum [N s]": "momentum",
            "angular momentum, relative": "angularMomentum",
            "h w_max/limit": "frequencyOverLimit",
            "status": "status",
        },
    ),
    Table(
        "precision",
        "State rounded to 32 bits against 64 bits, sagging cable:",
        {"scheme": "label", "N": "value"}
        | _LIMITS
        | {"noise at half the limit": "noise", "status": "status"},
    ),
)


def make_conclusions(figures: Figures) -> list[str]:
    """One sentence a finding; cases that failed are named first."""
    failed = [
        f"FAILED: {row['kind']}, {row['label']}, {row['value']:g}: {row['status']}"
        for row in figures.rows
        if row["status"] != "ok"
    ]
    return failed + conclude(_finished(figures))


def make_pictures(figures: Figures, directory: Path) -> list[Path]:
    """One a map, of the cases that did not fail."""
    return draw(_finished(figures), directory)


def _finished(figures: Figures) -> Figures:
    return Figures(figures.quick, [_with_infinities(row) for row in figures.rows if row["status"] == "ok"])


def _with_infinities(row: Row) -> Row:
    """What JSON stored as null is a limit that does not exist."""
    unlimited = {key: math.inf for key in ("predicted", "found", "predictedBending", "predictedZeta")
                 if key in row and row[key] is None}  # fmt: skip
    return row | unlimited


STUDY = SweepStudy(
    name="stability_limits",
    question="Which step is the largest stable one at the extremes, and which bound rules where?",
    cases=make_cases,
    run=run_case,
    tables=TABLES,
    conclusions=make_conclusions,
    pictures=make_pictures,
)
