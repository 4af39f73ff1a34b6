"""The state of a coupled run before its last steps, to which it returns if they go wrong."""

from collections.abc import Iterator, Mapping
from typing import Any

import exudyn
import numpy as np

_CONFIGURATIONS = (exudyn.ConfigurationType.Current, exudyn.ConfigurationType.StartOfStep)


class KeptState:
    """Copies of all that the next steps depend on.

    Args:
        mbs: whose data coordinates (contact, friction) belong to it.
        memory: nested dicts of arrays, which stay the same arrays.
    """

    def __init__(self, mbs: Any, memory: Mapping[str, Any]) -> None:
        self._data = mbs.systemData
        self._arrays = list(_arrays(memory))
        self._copies = [array.copy() for array in self._arrays]
        self._coordinates: list[Any] = []

    def keep(self) -> None:
        """Copy the present state."""
        for array, copy in zip(self._arrays, self._copies, strict=True):
            copy[...] = array
        if self._data.DataSize():
            self._coordinates = [self._data.GetDataCoordinates(kind) for kind in _CONFIGURATIONS]

    def restore(self) -> None:
        """Return to the state that was kept last."""
        for array, copy in zip(self._arrays, self._copies, strict=True):
            array[...] = copy
        for kind, values in zip(_CONFIGURATIONS, self._coordinates, strict=False):
            self._data.SetDataCoordinates(values, kind)


def _arrays(memory: Mapping[str, Any]) -> Iterator[np.ndarray]:
    for part in memory.values():
        if isinstance(part, Mapping):
            yield from _arrays(part)
        else:
            yield part
