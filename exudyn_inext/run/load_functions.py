"""User functions of many loads, evaluated together."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..loads.nodal import LoadFunction


class Asked(NamedTuple):
    """A load with a user function.   number: of its components.   name: of the load, for messages.

    is_pure: whether nothing but the time decides on what the function returns.
    """

    function: LoadFunction
    number: int
    name: str
    is_pure: bool = True


class LoadFunctions:
    """Of several loads; a function of the time that they share is called once for all.

    numbers: of the components of each load.
    """

    def __init__(self, loads: Sequence[Asked]) -> None:
        self._loads = loads
        self.numbers = np.array([load.number for load in loads], dtype=int)
        called: dict[Any, LoadFunction] = {}
        keys = list(map(_key, loads))
        for key, load in zip(keys, loads, strict=True):
            called.setdefault(key, load.function)
        places = {key: place for place, key in enumerate(called)}
        self._place = [places[key] for key in keys]
        self._called = list(called.values())
        self._scales = np.repeat(np.array([load.function.scale for load in loads], float), self.numbers)
        self._calls = [(one.function, one.mbs, one.value) for one in self._called]
        self._are_alike = len(set(self.numbers.tolist())) == 1

    def values(self, times: Sequence[float]) -> Array:
        """(T, sum of numbers) the components of all loads, one after the other, at these times [s].

        Raises:
            SceneError: see `as_rows`.
        """
        if not self._loads:
            return np.zeros((len(times), 0))
        returned = [[function(mbs, t, value) for function, mbs, value in self._calls] for t in times]
        if len(self._calls) < len(self._loads):
            returned = [[row[place] for place in self._place] for row in returned]
        rows = self._of_one_kind(returned)
        return self._scales * (self._one_by_one(returned, times) if rows is None else rows)

    def _of_one_kind(self, returned: list[list[Any]]) -> Array | None:
        """All values, if each load has as many components, and all of these are numbers; otherwise None."""
        values, number = _as_array(returned) if self._are_alike else None, len(returned)
        if values is None or values.shape[:2] != (number, len(self._loads)):
            return None
        return values.reshape(number, -1) if values.size == number * len(self._scales) else None

    def _one_by_one(self, returned: list[list[Any]], times: Sequence[float]) -> Array:
        columns = zip(self._loads, zip(*returned, strict=True), strict=True)
        return np.hstack([as_rows(list(own), times, load.number, load.name) for load, own in columns])


class StateFunctions(LoadFunctions):
    """Functions of which some may depend on the state: `values` are those that they had when last looked at.

    bring: (t, q, v): brings mbs to that state.   springs: with functions.
    name: of the first load or spring whose function may depend on it.
    look_at_mbs: whether they may see more than the motion of a spring.
    """

    def __init__(
        self,
        loads: Sequence[Asked],
        bring: Callable[[float, Array, Array], None],
        springs: Any,
    ) -> None:
        super().__init__(loads)
        self.springs = springs
        of_state = [load.name for load in loads if not load.is_pure]
        self.name = of_state[0] if of_state else springs.name
        self._bring, self._time = bring, 0.0
        self.look_at_mbs = bool(of_state) or springs.look_at_mbs
        self._values = np.zeros(self.numbers.sum())

    def values(self, times: Sequence[float]) -> Array:
        self._time = times[-1]
        return self._values[np.newaxis].repeat(len(times), axis=0)

    def look(self, q: Array, v: Array, time: float | None = None) -> Array:
        """The values in the state (q, v), at the time that was asked for last or, if given, `time` [s]."""
        self._time = self._time if time is None else time
        if self.look_at_mbs:
            self._bring(self._time, q, v)
        self.springs.look(self._time, q, v)
        self._values = super().values([self._time])[0]
        return self._values


def _key(load: Asked) -> Any:
    """Equal for loads of which the function may be called once."""
    function = load.function
    return (function.function, *np.ravel(function.value).tolist()) if load.is_pure else id(load)


def as_rows(returned: list[Any], times: Sequence[float], number: int, name: str) -> Array:
    """(T, number) what a user function returned at these times [s]; name: of its load, for messages.

    Raises:
        SceneError: names the first that is not so many finite numbers.
    """
    values = _as_array(returned)
    if values is not None and values.size == number * len(times):
        return values.reshape(len(times), number)
    for value, t in zip(returned, times, strict=True):
        row = _as_array(value)
        if row is None or row.size != number:
            raise SceneError(
                f"the user function of {name} returned {value!r} at "
                f"t = {t:g} s: must return {number} finite number(s)."
            )
    return np.array([np.ravel(value) for value in returned], dtype=float)


def as_array(returned: Any) -> Array | None:
    """Numbers as an array; None if it is something else."""
    try:
        values = np.array(returned)
    except (TypeError, ValueError, OverflowError):
        return None
    return values.astype(float, copy=False) if values.dtype.kind in "fiub" else None


def _as_array(returned: Any) -> Array | None:
    """Finite numbers as an array; None if it is something else."""
    values = as_array(returned)
    if values is None:
        return None
    is_finite = math.isfinite(np.add.reduce(values, axis=None)) or np.isfinite(values).all()
    return values if is_finite else None
