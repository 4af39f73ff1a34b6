"""Maps of the linear regime: predicted and bisected limits about equilibria, one thing varied at a time."""

import math
from collections.abc import Iterator
from typing import Any

from studies.harness import Row

from .limits import AGREEMENT, STEPS, compare_limits, limit_in_motion, spectral_radius
from .motion import (
    GRAVITY,
    SCHEMES,
    STIFFNESS,
    Equilibrium,
    Method,
    coil,
    hanging,
    ring,
    sagging,
    spinning,
    straight,
)

CABLES = {
    "straight": straight,
    "hanging": hanging,
    "sagging": sagging,
    "coil": coil,
    "ring": ring,
    "spinning": spinning,
}
PLAIN = ("Zhai", "RATTLE", "RK4")
SPIN_STEPS = 500  # few: a scheme that gains energy spins the cable up meanwhile
FEWER_SPIN_STEPS = 200  # where the limits differ: whether that is why
WEAK_PART = 0.3  # of the limit of w_max, where weak growth is looked at
NO_GROWTH = 1e-5  # that rigid rotation, a double eigenvalue of one, hides
SLOW_ZETA = 10.0  # [1/s], so that zeta does not rule where it is not asked for
SCENES: tuple[tuple[str, dict[str, float]], ...] = (
    ("straight", {"elements": 10}),
    ("hanging", {"elements": 10, "gravity": GRAVITY}),
    ("sagging", {"elements": 10, "share": 0.9}),
    ("coil", {"elements": 20, "turns": 2.0}),
    ("ring", {"elements": 20}),
)


def _case(kind: str, cable: str, scheme: str, value: float, given: dict[str, Any], **method: float) -> Row:
    return {
        "kind": kind,
        "label": f"{scheme}, {cable}",
        "cable": cable,
        "scheme": scheme,
        "value": value,
        "given": given,
        "zeta": method.get("zeta", SLOW_ZETA),
        "theta": method.get("theta", 0.0),
        "steps": int(method.get("steps", STEPS)),
    }


def linear_cases(quick: bool) -> list[Row]:
    """All of them; "value" is what a map varies."""
    maps = (_schemes, _zeta, _stiffness, _elements, _curvature, _gravity, _spin)
    return [case for make in maps for case in make(quick)]


def _schemes(quick: bool) -> Iterator[Row]:
    """Every scheme, with and without mass scaling, on every cable.   value: theta."""
    for cable, given in SCENES[:3] if quick else SCENES:
        for scheme in SCHEMES:
            for theta in (0.0, 0.3) if quick else (0.0, 0.2, 0.3):
                yield _case("scheme", cable, scheme, theta, given, theta=theta)


def _zeta(quick: bool) -> Iterator[Row]:
    """value: zeta [1/s]."""
    for scheme in ("Zhai", "Zhai, v_n", "RK4"):
        for zeta in (10.0, 1e3, 1e4) if quick else [10.0 ** (k / 3) for k in range(3, 16)]:
            yield _case("zeta", "straight", scheme, zeta, {"elements": 10}, zeta=zeta)


def _stiffness(quick: bool) -> Iterator[Row]:
    """value: EI over its physical value [-]."""
    for scheme in PLAIN:
        for power in (-8, 0, 4) if quick else range(-8, 5):
            given = {"elements": 10, "gravity": GRAVITY, "stiffness": STIFFNESS * 10.0**power}
            yield _case("stiffness", "hanging", scheme, 10.0**power, given)


def _elements(quick: bool) -> Iterator[Row]:
    """value: N."""
    for scheme in PLAIN:
        for number in (1, 5, 40) if quick else (1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000):
            yield _case("elements", "straight", scheme, number, {"elements": number})


def _curvature(quick: bool) -> Iterator[Row]:
    """value: turning of an element [rad], at most."""
    shares = (0.8,) if quick else (0.999, 0.99, 0.95, 0.9, 0.8, 0.6, 0.4)
    turns = (2.0,) if quick else (0.25, 0.5, 1.0, 2.0, 3.0, 4.0)
    shapes = [("straight", {"elements": 20}, 0.0), ("ring", {"elements": 20}, 2.0 * math.pi / 20)]
    shapes += [("coil", {"elements": 20, "turns": n}, 2.0 * math.pi * n / 20) for n in turns]
    shapes += [("sagging", {"elements": 20, "share": share}, math.nan) for share in shares]
    for scheme in ("Zhai", "RATTLE"):
        for cable, given, turning in shapes:
            value = float(given.get("share", 0.0)) if math.isnan(turning) else turning
            yield _case("curvature", cable, scheme, value, given)


def _gravity(quick: bool) -> Iterator[Row]:
    """value: gravity over that of the earth [-]."""
    for scheme in PLAIN:
        for factor in (0.0, 1e2, 1e4) if quick else (0.0, 1.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4):
            yield _case("gravity", "hanging", scheme, factor, {"elements": 10, "gravity": factor * GRAVITY})


def _spin(quick: bool) -> Iterator[Row]:
    """value: rate [rad/s]."""
    for scheme in ("Zhai", "Zhai, v_n", "Zhai, corrector, psi = phi = 0", "RATTLE", "RK4"):
        for rate in (3.0, 100.0) if quick else (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0):
            given = {"elements": 10, "rate": rate}
            yield _case("spin", "spinning", scheme, rate, given, steps=SPIN_STEPS)


def run_linear(case: Row) -> Row:
    """Predicted and bisected limit; of a cable in motion, also the limit of the linearised step itself."""
    start: Equilibrium = CABLES[case["cable"]](**case["given"])
    method, steps = Method.of(case), case["steps"]
    found = compare_limits(start, method, steps)
    if case["kind"] == "spin":
        found |= _in_motion(start, method, found, steps)
        if abs(found["ratioInMotion"] - 1.0) > AGREEMENT:
            sooner = compare_limits(start, method, FEWER_SPIN_STEPS)
            found["ratioSooner"] = _in_motion(start, method, sooner, FEWER_SPIN_STEPS)["ratioInMotion"]
        found |= _weak_growth(start, method, WEAK_PART * found["predicted"])
    return found


def _in_motion(start: Equilibrium, method: Method, found: Row, steps: int) -> Row:
    predicted = limit_in_motion(start, method, found["predicted"], steps)
    return {"predictedInMotion": predicted, "ratioInMotion": found["found"] / predicted}


def _weak_growth(start: Equilibrium, method: Method, h: float) -> Row:
    """What a step of the spinning cable grows by well below the limit, and its order in h."""
    growth, finer = (max(spectral_radius(start, method, step) - 1.0, NO_GROWTH) for step in (h, 0.5 * h))
    is_seen = growth > 3.0 * NO_GROWTH and finer > NO_GROWTH
    return {"growth": growth, "growthOrder": math.log2(growth / finer) if is_seen else None}
