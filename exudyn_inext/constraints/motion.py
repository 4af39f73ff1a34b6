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
    """(3, n) values of a function t [s] -> (n,), or a number, and first two derivatives by differences."""
    before, value, after = (_vector(function(s)) for s in (t - STEP, t, t + STEP))
    return np.array([value, (after - before) / (2.0 * STEP), (after - 2.0 * value + before) / STEP**2])


def require_smooth(motion: Motion, t: float, name: str) -> None:
    """Raise InputError unless the motion has at t [s] the derivatives that it states.

    Args:
        motion: to be checked.   t: time [s].   name: culprit for messages.
    """
    stated = motion.at(t)
    if not np.isfinite(stated).all():
        raise InputError(
            f"{name} is not finite at t = {t:g} s ([p, p_t, p_tt] = {stated.tolist()}): it must be defined "
            f"and differentiable twice there; without given derivatives also {STEP:g} s before."
        )
    for order, what in ((0, "velocity"), (1, "acceleration")):
        _require_derivative(motion, t, order, what, name)


def _require_derivative(motion: Motion, t: float, order: int, what: str, name: str) -> None:
    def after(step: float) -> Array:
        return (motion.at(t + step)[order] - motion.at(t)[order]) / step

    def before(step: float) -> Array:
        return (motion.at(t)[order] - motion.at(t - step)[order]) / step

    scale = 1.0 + float(np.abs(motion.at(t)[: order + 1]).max())
    step = 8.0 * STEP
    sides = [(after(s), before(s)) for s in (step, 0.5 * step)]
    jumps = [float(np.abs(one - other).max()) for one, other in sides]
    tolerance = _NOTICEABLE * scale / step
    if jumps[1] > max(_SMOOTH * jumps[0], tolerance):
        raise InputError(
            f"{name} is not smooth at t = {t:g} s: its {what} jumps by {jumps[1]:.3g} there; let it begin "
            "smoothly, or start the cable with the motion's velocity."
        )
    wide, near = (0.5 * (one + other) for one, other in sides)
    centred = (4.0 * near - wide) / 3.0  # errors of second order cancel
    error = float(np.abs(centred - motion.at(t)[order + 1]).max())
    if error > max(1e-2 * scale, tolerance):
        raise InputError(
            f"{name}: the given {what} at t = {t:g} s is {motion.at(t)[order + 1].tolist()}, differences "
            f"give {centred.tolist()}: correct it, or leave it out."
        )
