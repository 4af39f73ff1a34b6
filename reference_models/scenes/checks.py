"""What the parts of a scene share: vectors, and a check of fractions."""

from exudyn_inext.errors import InputError

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


def require_fraction(owner: str, value: float) -> None:
    """Raise InputError unless it is one."""
    if not 0.0 <= value <= 1.0:
        raise InputError(f"{owner}: {value!r} must be a fraction of the arc length, 0 (start) to 1 (end).")
