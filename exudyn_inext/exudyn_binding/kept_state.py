"""The state of a run before its last steps, to which it returns if they go wrong."""

from collections.abc import Iterator, Mapping
from typing import Any

import exudyn
import numpy as np

_CONFIGURATIONS = (exudyn.ConfigurationType.Current, exudyn.ConfigurationType.StartOfStep)


class KeptState:
    """Copies of all that the next steps depend on, as it is now, and as `keep` finds it later.

    Args:
        memory: nested dicts of arrays, which stay the same arrays.
        data: mbs.systemData, if its data coordinates (contact, friction) belong to the state.
    """

    def __init__(self, memory: Mapping[str, Any], data: Any = None) -> None:
        self._data: Any = data if data is not None and data.DataSize() else None
        self._arrays = list(_arrays(memory))
        self._copies = [array.copy() for array in self._arrays]
        self._coordinates = self._present_coordinates()

    def keep(self) -> None:
        """Copy the present state."""
        for array, copy in zip(self._arrays, self._copies, strict=True):
            copy[...] = array
        self._coordinates = self._present_coordinates()

    def restore(self) -> None:
        """Return to the state that was kept last."""
        for array, copy in zip(self._arrays, self._copies, strict=True):
            array[...] = copy
        for kind, values in zip(_CONFIGURATIONS, self._coordinates, strict=False):
            self._data.SetDataCoordinates(values, kind)

    def _present_coordinates(self) -> list[Any]:
        return [self._data.GetDataCoordinates(kind) for kind in _CONFIGURATIONS] if self._data else []


def _arrays(memory: Mapping[str, Any]) -> Iterator[np.ndarray]:
    for part in memory.values():
        if isinstance(part, Mapping):
            yield from _arrays(part)
        else:
            yield part
