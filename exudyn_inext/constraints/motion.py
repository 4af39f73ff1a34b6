"""A given motion with its first two derivatives, analytic or by differences."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.link import Motion
from ..errors import InputError

STEP = 1e-4  # of the differences [s]
_SMOOTH = 0.75  # a jump of the derivative stays as the step is halved, a smooth change becomes half
_NOTICEABLE = 1e-6
_PLACES = range(-2, 3)  # of values, in steps
FASTEST = 1e3  # speed of supports and joints, beyond which they jump [m/s]
AT_ONCE, MOST = 1e-9, 0.9  # duration of a jump [s], and share of it in the half of a duration that has it
SHORT = 1e-3  # share of the duration that is looked at, which a jump takes at most
_SOON = 1.0 / 64.0  # of a step, after which what begins has moved

Function = Callable[[float], Any]

_SCALE = 12.0 * np.array([[STEP], [STEP**2]])
_CENTRAL = np.array([[1.0, -8.0, 0.0, 8.0, -1.0], [-1.0, 16.0, -30.0, 16.0, -1.0]]) / _SCALE  # of five values
AHEAD = np.array([[-137.0, 300.0, -300.0, 200.0, -75.0, 12.0], [225.0, -770.0, 1070.0, -780.0, 305.0, -50.0]])
AHEAD /= 5.0 * _SCALE


def motion_of(
    position: Function,
    velocity: Function | None = None,
    acceleration: Function | None = None,
    is_pure: bool = True,
) -> Motion:
    """The motion t -> position(t); missing derivatives are differences.

    Args:
        position: t [s] -> (dim,) [m].   velocity: [m/s].   acceleration: [m/s^2].
        is_pure: see `Motion`.
    """

    def at_times(times: Sequence[float]) -> Array:
        if velocity is None:
            values = many_differences(position, times)
        else:
            rates = many_differences(velocity, times) if acceleration is None else _given(velocity, times)
            values = np.concatenate([_given(position, times), rates, rates], axis=1)[:, :3]
        if acceleration is not None:
            values[:, 2:] = _given(acceleration, times)
        values.flags.writeable = False
        return values

    def at(t: float) -> Array:
        return at_times([t])[0]

    if is_pure:
        at = lru_cache(maxsize=2)(at)  # a step asks for the time of its end several times
    given = velocity is not None, acceleration is not None
    return Motion(at, is_pure=is_pure, given=given, at_times=at_times, position=position)


def _given(function: Function, times: Sequence[float]) -> Array:
    """(T, 1, n) its values."""
    return np.array([function(t) for t in times], dtype=float).reshape(len(times), 1, -1)


def _vector(value: Any) -> Array:
    return np.atleast_1d(np.asarray(value, dtype=float))


def differences(function: Function, t: float) -> Array:
    """(3, n) values of a function t [s] -> (n,), or a number, and first two derivatives by differences.

    They are exact up to the fourth power of the time. Where it begins or ends, they are those of one side,
    exact up to the fifth, of which smooth steps are.
    """
    return differences_and_side(function, t)[0]


def differences_and_side(function: Function, t: float) -> tuple[Array, int]:
    """As `differences`; and 1 where the function begins, -1 where it ends, 0 in between."""
    values = _around(function, t)
    value, side, weights = values[2], _side(function, t, values), _CENTRAL
    if side:
        values = np.array([_beside(function, t + k * side * STEP) for k in range(AHEAD.shape[1])])
        weights = AHEAD * [[side], [1.0]]
    return np.concatenate([value[np.newaxis], weights @ (values - value)]), side


def many_differences(
    function: Function, times: Sequence[float], form: Callable[[Array], Array] | None = None
) -> Array:
    """(T, 3, n) `differences` of t -> form(function(t)) at many times [s].

    form: (..., m) -> (..., n), for many values at once; None: they are taken as they are.
    """

    def one(t: float) -> Array:
        value = _vector(function(t))
        return form(value) if form else value

    try:
        values = np.array([[function(t + k * STEP) for k in _PLACES] for t in times], dtype=float)
    except Exception:
        return np.array([differences(one, t) for t in times])
    values = values.reshape(*values.shape[:2], -1)
    values = form(values) if form else values
    value = values[:, 2:3]
    found = np.concatenate([value, _CENTRAL @ (values - value)], axis=1)
    for k in np.flatnonzero(~_is_within(values)).tolist():
        found[k] = differences(one, times[k])
    return found


def _around(function: Function, t: float) -> Array:
    """(5, n) values, of which some are no numbers where the function is not defined."""
    try:
        return np.array([function(t + k * STEP) for k in _PLACES], dtype=float).reshape(5, -1)
    except Exception:
        value = _vector(function(t))
        return np.array([np.broadcast_to(_beside(function, t + k * STEP), value.shape) for k in _PLACES])


def _is_within(values: Array) -> np.ndarray:
    """(...) whether functions surely neither begin nor end there.   values: (..., 5, n) around that time."""
    rests = values[..., 1:4:2, :] == values[..., 2:3, :]
    is_even = (rests[..., 0, :] == rests[..., 1, :]).all(axis=-1)
    return np.isfinite(values).all(axis=(-2, -1)) & is_even


def _side(function: Function, t: float, values: Array) -> int:
    """1 where it begins, -1 where it ends, 0 in between.   values: (5, n) around t."""
    if _is_within(values):
        return 0
    near = np.where(np.isfinite(values[::4]), values[1:4:2], np.nan)  # a value that ends beyond is none
    for side, behind, ahead in ((1, near[0], near[1]), (-1, near[1], near[0])):
        if _begins(function, t, side * STEP, behind, values[2], ahead):
            return side
    return 0


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


class Jump(NamedTuple):
    """number: of the value that jumps.   time: where [s].   size: by how much."""

    number: int
    time: float
    size: float


def find_jump(values: Function, begin: float, end: float) -> Jump | None:
    """The largest jump of values from `begin` to `end` [s], or None: what takes some of that time is none.

    values: t [s] -> (n,) [m, rad].
    """
    low, middle, high = (values(begin + share * (end - begin)) for share in (0.0, 0.5, 1.0))
    halves = np.abs([middle - low, high - middle])
    number = int(np.argmax(np.abs(halves[0] - halves[1])))
    low, high = low[number], high[number]
    longest = max(SHORT * (end - begin), AT_ONCE)
    while end - begin > max(AT_ONCE, 2.0 * np.spacing(end)):
        middle = 0.5 * (begin + end)
        value = values(middle)[number]
        if abs(value - low) > MOST * abs(high - low):
            end, high = middle, value
        elif abs(high - value) > MOST * abs(high - low):
            begin, low = middle, value
        else:
            break
    size = float(abs(high - low))
    is_short = end - begin <= longest
    return Jump(number, end, size) if is_short and size > FASTEST * (end - begin) else None


def require_smooth(motion: Motion, t: float, name: str) -> None:
    """Raise InputError unless the motion has at t [s] the derivatives that it states.

    It may begin there: then they are those after it. Where it ends, its acceleration may jump.

    Args:
        motion: to be checked.   t: time [s].   name: culprit for messages.
    """
    stated = motion.at(t)
    if not np.isfinite(stated).all():
        raise InputError(
            f"{name} is not finite at t = {t:g} s ([p, p_t, p_tt] = {stated.tolist()}): it must be defined "
            "and differentiable twice there."
        )

    side = differences_and_side(lambda s: motion.at(s)[0], t)[1]
    orders = ("velocity", "acceleration") if side >= 0 else ("velocity",)
    for order, what in enumerate(orders):
        _require_derivative(motion, t, order, what, name, begins=side > 0)


def _require_derivative(motion: Motion, t: float, order: int, what: str, name: str, begins: bool) -> None:
    def slope(step: float) -> Array:
        return (motion.at(t + step)[order] - motion.at(t)[order]) / step

    scale = 1.0 + float(np.abs(motion.at(t)[: order + 1]).max())
    step = 8.0 * STEP
    tolerance = _NOTICEABLE * scale / step
    if begins:
        found = 2.0 * slope(0.5 * step) - slope(step)
    else:
        sides = [(slope(s), slope(-s)) for s in (step, 0.5 * step)]
        jumps = [float(np.abs(one - other).max()) for one, other in sides]
        if jumps[1] > max(_SMOOTH * jumps[0], tolerance):
            raise InputError(
                f"{name} is not smooth at t = {t:g} s: its {what} jumps by {jumps[1]:.3g} there; let it be "
                "smooth, or rest before. What vibrates above 500 Hz needs milliseconds as the unit of time."
            )
        wide, near = (0.5 * (one + other) for one, other in sides)
        found = (4.0 * near - wide) / 3.0  # errors of second order cancel
    error = float(np.abs(found - motion.at(t)[order + 1]).max())
    if motion.given[order] and error > max(1e-2 * scale, tolerance):
        raise InputError(
            f"{name}: the given {what} at t = {t:g} s is {motion.at(t)[order + 1].tolist()}, differences "
            f"give {found.tolist()}: correct it, or leave it out."
        )
