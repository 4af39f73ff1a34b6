"""Checks that the parts of a scene share."""

import math

from exudyn_inext.errors import InputError

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


def require_positive(owner: str, unit: str, name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise InputError(
            f"{owner}: {name} = {value!r} {unit}: must be finite and > 0; check value and units."
        )


def require_fraction(owner: str, value: float) -> None:
    if not 0.0 <= value <= 1.0:
        raise InputError(f"{owner}: {value!r} must be a fraction of the arc length, 0 (start) to 1 (end).")


def require_finite(owner: str, name: str, value: Vector) -> None:
    if len(value) != 3 or not all(math.isfinite(component) for component in value):
        raise InputError(f"{owner}: {name} = {value!r} must be three finite numbers (x, y, z).")
