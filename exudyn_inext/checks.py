"""Checks of single values: each returns what the package works with, or raises InputError."""

from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from .arrays import Array
from .errors import InputError

LARGEST = 1e30  # in SI units; products of a few such numbers are still numbers
SMALLEST = 1e-30
LARGEST_NUMBER_OF_ITEMS = 1_000_000  # elements, or points along a cable, that memory has room for


def as_number(value: Any) -> float:
    """`value` as a float; NaN if it is no real number, infinite beyond the range of floats."""
    if not isinstance(value, Real) or isinstance(value, bool | np.bool_):
        return np.nan
    try:
        return float(value)
    except OverflowError:
        return np.inf


def require_positive(name: str, value: Any) -> float:
    """Return `value` as a float, or raise InputError unless it is a finite number above zero."""
    return _require(name, value, as_number(value) > 0.0, "must be a finite number > 0; check value and units")


def require_not_negative(name: str, value: Any) -> float:
    """Return `value` as a float, or raise InputError unless it is zero or a finite number above it."""
    return _require(name, value, as_number(value) >= 0.0, "must be a finite number >= 0")


def require_finite(name: str, value: Any, unit: str = "-") -> float:
    """Return `value` as a float, or raise InputError unless it is a finite number."""
    return _require(name, value, True, f"must be a finite number [{unit}]")


def _require(name: str, value: Any, is_right: bool, wanted: str) -> float:
    number = as_number(value)
    if not (np.isfinite(number) and is_right):
        raise InputError(f"{name} = {value!r}: {wanted}.")
    if number != 0.0 and not SMALLEST <= abs(number) <= LARGEST:
        raise InputError(
            f"{name} = {value!r}: must lie between {SMALLEST:g} and {LARGEST:g} in size; check its units."
        )
    return number


def require_integer(name: str, value: Any, least: int, most: int, what: str = "") -> int:
    """Return `value` as an int, or raise InputError unless it is an integer from `least` to `most`.

    Args:
        what: said after the limits, for the reader of the message.
    """
    is_integer = isinstance(value, Integral) and not isinstance(value, bool | np.bool_)
    if not (is_integer and least <= value <= most):
        raise InputError(
            f"{name} = {value!r}: must be an integer of at least {least} and at most {most}{what}."
        )
    return int(value)


def require_flag(name: str, value: Any) -> bool:
    """Return `value` as a bool, or raise InputError unless it is True or False, or 1 or 0."""
    is_flag = isinstance(value, bool | np.bool_) or (isinstance(value, Integral) and value in (0, 1))
    if not is_flag:
        raise InputError(f"{name} = {value!r}: must be True or False.")
    return bool(value)


def require_functions(name: str, value: Any) -> bool | Sequence[Any] | None:
    """Return `value`, or raise InputError unless it is True, False, None or a list of functions."""
    is_list = isinstance(value, list | tuple) and all(map(callable, value))
    if not (value is None or isinstance(value, bool) or is_list):
        raise InputError(f"{name} = {value!r}: must be a list of functions, True, False or None.")
    return value


def require_choice(name: str, value: Any, choices: Sequence[str]) -> str:
    """Return `value`, or raise InputError unless it is one of the strings `choices`."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} = {value!r}: choose one of {choices}.")
    return str(value)


def require_finite_array(name: str, values: Any) -> Array:
    """Return `values` as an array of floats, or raise InputError unless all of it is finite numbers."""
    array = _as_floats(values)
    if array is None:
        raise InputError(f"{name} = {values!r}: must be numbers.")
    if not np.isfinite(array).all():
        raise InputError(f"{name} = {array.tolist()}: all numbers must be finite.")
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise InputError(f"{name} = {array.tolist()}: must be at most {LARGEST:g} in size; check its units.")
    return array


def require_vector(name: str, values: Any, unit: str = "") -> Array:
    """(3,) array of `values`; InputError unless they are 3 finite numbers."""
    vector = require_finite_array(name, values)
    if vector.shape != (3,):
        raise InputError(f"{name} = {values!r}: must be a vector of 3 numbers{unit}.")
    return vector


def _as_floats(values: Any) -> Array | None:
    """None if they are no real numbers: strings, complex numbers, truth values, rows of different length."""
    try:
        array = np.asarray(values)
        if array.size and array.dtype.kind not in "iufO":
            return None
        return array.astype(float)
    except (TypeError, ValueError, OverflowError, RecursionError):
        return None
