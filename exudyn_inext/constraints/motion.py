"""A given motion with its first two derivatives, analytic or by differences."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.link import Motion
from ..errors import InputError

STEP = 1e-4  # of the differences [s]
_SMOOTH = 0.75  # a jump of the derivative stays as the step is halved, a smooth change becomes half
_NOTICEABLE = 1e-6
_SOON = 1.0 / 64.0  # of a step, after which what begins has moved

Function = Callable[[float], Any]


def motion_of(
    position: Function,
    velocity: Function | None = None,
    acceleration: Function | None = None,
    is_pure: bool = True,
) -> Motion:
    """The motion t -> position(t); missing derivatives are central differences.

    Args:
        position: t [s] -> (dim,) [m].   velocity: [m/s].   acceleration: [m/s^2].
        is_pure: see `Motion`.
    """

    def at(t: float) -> Array:
        if velocity is None:
            values = differences(position, t)
        else:
            values = np.array([_vector(position(t)), *differences(velocity, t)[:2]])
        if acceleration is not None:
            values[2] = acceleration(t)
        return values

    return Motion(at, is_pure=is_pure)


def _vector(value: Any) -> Array:
    return np.atleast_1d(np.asarray(value, dtype=float))


def differences(function: Function, t: float) -> Array:
    """(3, n) values of a function t [s] -> (n,), or a number, and first two derivatives by differences.

    They are those of one side where it begins or ends.
    """
    return differences_and_side(function, t)[0]


def differences_and_side(function: Function, t: float) -> tuple[Array, int]:
    """As `differences`; and 1 where the function begins, -1 where it ends, 0 in between."""
    value, before, after = _vector(function(t)), _beside(function, t - STEP), _beside(function, t + STEP)
    for side, behind, ahead in ((1, before, after), (-1, after, before)):
        if _begins(function, t, side * STEP, behind, value, ahead):
            return _from_one_side(function, t, side * STEP), side
    return np.array([value, (after - before) / (2.0 * STEP), (after - 2.0 * value + before) / STEP**2]), 0


def _from_one_side(function: Function, t: float, step: float) -> Array:
    value, near, far = (_beside(function, t + k * step) for k in range(3))
    rate, change = (4.0 * near - 3.0 * value - far) / (2.0 * step), (far - 2.0 * near + value) / step**2
    return np.array([value, rate, change])


def _beside(function: Function, t: float) -> Array:
    """Its values, or no numbers where it is not defined, as tables are outside of their range."""
    try:
        return _vector(function(t))
    except Exception:
        return np.array([np.nan])


def _begins(function: Function, t: float, step: float, behind: Array, value: Array, ahead: Array) -> bool:
    """Whether a component is not defined, or rests, behind t, and moves ahead of it; with step < 0: ends."""
    if not np.isfinite(behind).all():
        return bool(np.isfinite(ahead).all())
    rests = (behind == value) & (ahead != value) & np.isfinite(ahead)
    return bool(rests.any() and (rests & (_beside(function, t + _SOON * step) != value)).any())


def jump_of_velocity(motion: Motion, t: float) -> float:
    """By how much the velocity jumps at a kink of the motion near t [s], as tables have them [m/s]; or 0."""

    def change(width: float) -> float:
        places = [_beside(lambda s: motion.at(s)[0], t + k * width) for k in (-2, -1, 1, 2)]
        return float(np.abs(places[3] - places[2] - places[1] + places[0]).max()) / width

    wide, narrow = change(8.0 * STEP), change(4.0 * STEP)
    return narrow if narrow > max(_SMOOTH * wide, _NOTICEABLE) else 0.0


def require_smooth(motion: Motion, t: float, name: str) -> None:
    """Raise InputError unless the motion has at t [s] the derivatives that it states.

    It may begin there: then they are those after it.

    Args:
        motion: to be checked.   t: time [s].   name: culprit for messages.
    """
    stated = motion.at(t)
    if not np.isfinite(stated).all():
        raise InputError(
            f"{name} is not finite at t = {t:g} s ([p, p_t, p_tt] = {stated.tolist()}): it must be defined "
            "and differentiable twice there."
        )

    def place(s: float) -> Array:
        return motion.at(s)[0]

    begins = _begins(place, t, STEP, _beside(place, t - STEP), stated[0], _beside(place, t + STEP))
    for order, what in ((0, "velocity"), (1, "acceleration")):
        _require_derivative(motion, t, order, what, name, begins)


def _require_derivative(motion: Motion, t: float, order: int, what: str, name: str, begins: bool) -> None:
    def slope(step: float) -> Array:
        return (motion.at(t + step)[order] - motion.at(t)[order]) / step

    scale = 1.0 + float(np.abs(motion.at(t)[: order + 1]).max())
    step = 8.0 * STEP
    tolerance = _NOTICEABLE * scale / step
    found = 2.0 * slope(0.5 * step) - slope(step)
    if not begins:
        sides = [(slope(s), slope(-s)) for s in (step, 0.5 * step)]
        jumps = [float(np.abs(one - other).max()) for one, other in sides]
        if jumps[1] > max(_SMOOTH * jumps[0], tolerance):
            raise InputError(
                f"{name} is not smooth at t = {t:g} s: its {what} jumps by {jumps[1]:.3g} there; let it be "
                "smooth, or rest before."
            )
        wide, near = (0.5 * (one + other) for one, other in sides)
        found = (4.0 * near - wide) / 3.0  # errors of second order cancel
    error = float(np.abs(found - motion.at(t)[order + 1]).max())
    if error > max(1e-2 * scale, tolerance):
        raise InputError(
            f"{name}: the given {what} at t = {t:g} s is {motion.at(t)[order + 1].tolist()}, differences "
            f"give {found.tolist()}: correct it, or leave it out."
        )
