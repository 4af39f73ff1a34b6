"""The state of a run before its last steps, to which it returns if they go wrong."""

from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np


class Elsewhere(Protocol):
    """State that lies in no array of a run."""

    def present(self) -> Any:
        """A copy of it."""

    def put_back(self, copy: Any) -> None:
        """Set it to what `present` gave."""


class KeptState:
    """Copies of all that the next steps depend on, as it is now, and as `keep` finds it later.

    Args:
        memory: nested dicts of arrays, which stay the same arrays.
        elsewhere: what else belongs to the state.
    """

    def __init__(self, memory: Mapping[str, Any], elsewhere: Elsewhere | None = None) -> None:
        self._elsewhere = elsewhere
        self._arrays = list(_arrays(memory))
        self._copies = [array.copy() for array in self._arrays]
        self._other = elsewhere and elsewhere.present()

    def keep(self) -> None:
        """Copy the present state."""
        for array, copy in zip(self._arrays, self._copies, strict=True):
            copy[...] = array
        self._other = self._elsewhere and self._elsewhere.present()

    def restore(self) -> None:
        """Return to the state that was kept last."""
        for array, copy in zip(self._arrays, self._copies, strict=True):
            array[...] = copy
        if self._elsewhere:
            self._elsewhere.put_back(self._other)


def _arrays(memory: Mapping[str, Any]) -> Iterator[np.ndarray]:
    for part in memory.values():
        if isinstance(part, Mapping):
            yield from _arrays(part)
        else:
            yield part
