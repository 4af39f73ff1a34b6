"""Nasty values, which may stand in any argument, and how they are mixed with valid ones."""

import math
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import NodePoint, ObjectMassPoint
from hypothesis import strategies as st

from exudyn_inext import CableDrag, CableShape, ExplicitSettings, InextensibleCable, StaticSettings

NAN, INF = math.nan, math.inf
CULPRITS = (1, 1, 1, 2, 3)  # how many arguments of a call are nasty, the first ones most often


def nested(depth: int) -> list[Any]:
    """[[[...]]]"""
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


def itself() -> list[Any]:
    """A list that contains itself."""
    value: list[Any] = []
    value.append(value)
    return value


class UserError(Exception):
    """A fault of a user's function, which has to arrive as it is."""


def failing(*arguments: Any) -> Any:
    """A user function with a fault."""
    raise UserError


NOTHING = [None, "", (), [], {}, set(), np.zeros(0), np.zeros((0, 3))]
NUMBERS = [
    *(0, -1, 1, 2, 3, 7, 2**31, -(2**31) - 1, 2**63, 2**64, 10**30, 10**400),
    *(0.0, -0.0, 0.5, -1.5, 2.5, 1e-9, 1e300, -1e300, 1e-300, 5e-324, 1.7e308, 1e30, 1e-30, 1e12, 1e-12),
    *(NAN, INF, -INF, 1j, True, False, np.float32(0.3), np.float64(NAN), np.int8(3), np.uint64(2**63)),
    *(np.bool_(True), np.array(1.0), np.array([1.0]), Decimal("NaN"), Decimal(2), Fraction(1, 3)),
    np.datetime64("2020-01-01"),
]
VECTORS = [
    *([1], [1, 2], [1, 2, 3], [1, 2, 3, 4], [0, 0, 0], [NAN] * 3, [INF, 0, 0], [1e300] * 3, [1e-300, 0, 0]),
    *([-1e300, 1e300, 0], [None] * 3, ["a"] * 3, ["1"] * 3, [True] * 3, [True] * 4, [[1, 2], [3]], [[]]),
    *([1j, 0, 0], [10**400, 0, 0], nested(40), itself(), (1, 2, 3), range(3), {1: 2}, {0, 1, 2}),
]
ARRAYS = [
    np.zeros(3),
    np.zeros((3, 3)),
    np.zeros((2, 2, 2)),
    np.full((3, 2), NAN),
    np.eye(3),
    np.array(["a", "b"]),
    np.array([1, None, {}], dtype=object),
    np.array([True, False, True]),
    np.array([1 + 1j, 0, 0]),
    np.array([1, 2, 3], dtype=np.int8),
    np.array([0.5, 0, 0], dtype=np.float16),
    np.array([(1, 2.0)], dtype=[("a", int), ("b", float)]),
    np.ma.masked_array([1.0, 2.0, 3.0], mask=[0, 1, 0]),
    np.array([1, 2, 3], dtype=">f8"),
]
OBJECTS = [
    *("text", "nan", "0", b"bytes", object(), int, len, math, NotImplemented, ..., slice(3)),
    *(lambda: None, lambda t: t, lambda t: [t, NAN, 0], lambda t: "here", failing),
    *({"elements": []}, {"elements": [99]}, {"elements": [0]}, {"elements": "ab"}, {"elements": 3}),
    *({"elements": [None]}, {"nodes": [0]}, {"elements": [0], "nodes": []}, {"elements": {}}),
    *(exudyn, exudyn.MainSystem, exudyn.NodeIndex(0), exudyn.ObjectIndex(0), exudyn.ObjectIndex(99)),
    *(exudyn.SimulationSettings, ObjectMassPoint(), NodePoint(), ExplicitSettings(), StaticSettings()),
    *(ExplicitSettings, CableShape, InextensibleCable, CableDrag(1, 1, 1, 1), CableShape([[0, 0]], None)),
]
MILD = [  # of the right type, and far from what anyone wants
    *(0, 1, 2, 3, 12, 0.0, 0.5, -1.0, 1e-9, 1e9, 1e-20, 1e20, 1e-30, 1e30, True, False, None),
    *([0, 0, 0], [0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1e9, 0, 0], [1e-9, 0, 0], [0, 1e20, 0]),
    *([True] * 4, [False] * 4, [True] * 6, [[0, 0], [1, 0]], [[1, 0, 0]] * 3, np.eye(3), np.ones(3)),
    *([0.0, 1.8], [1e-20, 1.8], lambda t: [0, 0], lambda t: [1e20 * t, 0], lambda t: np.zeros(3)),
]
NASTY = [*NOTHING, *NUMBERS, *VECTORS, *ARRAYS, *OBJECTS]


class Of:
    """A value that is there only with a scene: of(scene)."""

    def __init__(self, of: Callable[[Any], Any]) -> None:
        self.of = of

    def __repr__(self) -> str:
        return f"Of({self.of.__name__})"


def calls(valid: Mapping[str, Sequence[Any]]) -> st.SearchStrategy[dict[str, Any]]:
    """Arguments of a call, one to three of them nasty.   valid: values of each argument."""

    @st.composite
    def draw_call(draw: Any) -> dict[str, Any]:
        names = sorted(valid)
        number = min(len(names), draw(st.sampled_from(CULPRITS)))
        culprits = draw(st.permutations(names))[:number]
        arguments = {name: draw(st.sampled_from(list(valid[name]))) for name in names}
        return arguments | {name: draw(st.sampled_from(MILD) | st.sampled_from(NASTY)) for name in culprits}

    return draw_call()


def with_scene(arguments: Mapping[str, Any], scene: Any) -> dict[str, Any]:
    """The same arguments, those of the scene filled in."""
    return {name: value.of(scene) if isinstance(value, Of) else value for name, value in arguments.items()}
