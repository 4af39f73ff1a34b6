"""Maps of the linear regime: predicted and bisected limits about equilibria, one thing varied at a time."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from studies.harness import Row

from .limits import STEPS, compare_limits
from .motion import CABLES, GRAVITY, SCHEMES, STIFFNESS, settings_of

PLAIN = ("Zhai", "RATTLE", "RK4")
SPIN_STEPS = 500  # few: a scheme that gains energy spins the cable up meanwhile
SLOW_ZETA = 10.0  # [1/s], so that zeta does not rule where it is not asked for
SCENES: tuple[tuple[str, dict[str, float]], ...] = (
    ("straight", {"elements": 10}),
    ("hanging", {"elements": 10, "gravity": GRAVITY}),
    ("sagging", {"elements": 10, "share": 0.9}),
    ("coil", {"elements": 20, "turns": 2.0}),
    ("ring", {"elements": 20}),
)

Point = tuple[float, str, dict[str, Any]]
"""What a map varies, the cable, and its keywords."""


@dataclass(frozen=True)
class Map:
    """One thing that is varied under several schemes.

    title, what: of its table, and of the column of what it varies.   said, axis: the same in sentences and
    in a picture; empty: in none.   points: quick -> points.   method: value -> keywords of `case_of`.
    """

    title: str
    what: str
    said: str
    axis: str
    schemes: Sequence[str]
    points: Callable[[bool], Sequence[Point]]
    method: Callable[[float], dict[str, float]] = field(default=lambda value: {})

    def cases(self, quick: bool) -> list[Row]:
        """All of them; "value" is what is varied."""
        return [
            case_of(cable, scheme, value, given, **self.method(value))
            for scheme in self.schemes
            for value, cable, given in self.points(quick)
        ]


def case_of(cable: str, scheme: str, value: float, given: dict[str, Any], **method: float) -> Row:
    """given: keywords of the cable.   method: zeta [1/s], theta, steps, where they are not the usual ones."""
    usual = {"zeta": SLOW_ZETA, "theta": 0.0, "steps": STEPS}
    names = {"label": f"{scheme}, {cable}", "cable": cable, "scheme": scheme}
    return {**names, "value": value, "given": given, **usual, **method}


def _on(
    cable: str, given: Callable[[Any], dict[str, Any]], quick: Sequence[float], full: Sequence[float]
) -> Callable[[bool], list[Point]]:
    """Points of one cable.   given: value -> its keywords."""
    return lambda is_quick: [(value, cable, given(value)) for value in (quick if is_quick else full)]


def _curvatures(quick: bool) -> list[Point]:
    """Turning of an element [rad], of a sagging cable span over length."""
    turns = (2.0,) if quick else (0.25, 0.5, 1.0, 2.0, 3.0, 4.0)
    shares = (0.8,) if quick else (0.999, 0.99, 0.95, 0.9, 0.8, 0.6, 0.4)
    return [
        (0.0, "straight", {"elements": 20}),
        (2.0 * math.pi / 20, "ring", {"elements": 20}),
        *((2.0 * math.pi * n / 20, "coil", {"elements": 20, "turns": n}) for n in turns),
        *((share, "sagging", {"elements": 20, "share": share}) for share in shares),
    ]


MAPS = {
    "scheme": Map(
        "Every scheme on every cable, by mass scaling:", "theta", "", "",
        tuple(SCHEMES),
        lambda quick: [
            (theta, *scene)
            for scene in (SCENES[:3] if quick else SCENES)
            for theta in ((0.0, 0.3) if quick else (0.0, 0.2, 0.3))
        ],
        lambda theta: {"theta": theta},
    ),
    "zeta": Map(
        "Over the stabilisation rate:", "zeta [1/s]", "zeta [1/s]", "stabilisation rate zeta [1/s]",
        ("Zhai", "Zhai, v_n", "RK4"),
        _on(
            "straight", lambda zeta: {"elements": 10},
            (10.0, 1e3, 1e4), [10.0 ** (k / 3) for k in range(3, 16)],
        ),
        lambda zeta: {"zeta": zeta},
    ),
    "stiffness": Map(
        "Over the bending stiffness, hanging cable with a mass of its own at its end:", "EI/EI_0", "EI/EI_0",
        "EI over its physical value [-]",
        PLAIN,
        _on(
            "hanging", lambda part: {"elements": 10, "gravity": GRAVITY, "stiffness": STIFFNESS * part},
            (1e-8, 1.0, 1e4), [10.0**k for k in range(-8, 5)],
        ),
    ),
    "elements": Map(
        "Over the number of elements:", "N", "N", "elements N [-]",
        PLAIN,
        _on(
            "straight", lambda number: {"elements": number},
            (1, 5, 40), (1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000),
        ),
    ),
    "curvature": Map(
        "Over the curvature; ring and coil: turning of an element [rad], sagging: span/length:", "value",
        "curvature", "",
        ("Zhai", "RATTLE"),
        _curvatures,
    ),
    "gravity": Map(
        "Over gravity, hanging cable with a mass of its own at its end:", "g/g_0", "g/g_0",
        "gravity g/g_0 [-]", PLAIN,
        _on(
            "hanging", lambda part: {"elements": 10, "gravity": part * GRAVITY},
            (0.0, 1e2, 1e4), (0.0, 1.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4),
        ),
    ),
    "spin": Map(
        "Over the rate at which a cable with a mass at its end spins about its start:", "rate [rad/s]",
        "", "rate of spin [rad/s]",
        ("Zhai", "Zhai, v_n", "Zhai, corrector, psi = phi = 0", "RATTLE", "RK4"),
        _on(
            "spinning", lambda rate: {"elements": 10, "rate": rate},
            (3.0, 100.0), (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0),
        ),
        lambda rate: {"steps": SPIN_STEPS},
    ),
}  # fmt: skip


def run_linear(case: Row) -> Row:
    """Predicted and bisected limit."""
    return compare_limits(CABLES[case["cable"]](**case["given"]), settings_of(case), case["steps"])
