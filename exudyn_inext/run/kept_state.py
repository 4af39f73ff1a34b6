"""The state of a run before its last steps, to which it returns if they go wrong."""

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np

from ..compiled import kernel
from ..lowered import copy_memory, place_of


class KeptState:
    """Copies of all that the next steps depend on, as it is now, and as `keep` finds it later.

    Args:
        memory: nested dicts of arrays, which stay the same arrays.
        elsewhere: state that lies in no array: `present` copies it, `put_back` sets it to a copy; or None.
    """

    def __init__(self, memory: Mapping[str, Any], elsewhere: Any = None) -> None:
        arrays = list(_arrays(memory))
        self._copy_of(arrays, np.array([part for array in arrays for part in _parts(array)], np.int64))
        self._elsewhere = elsewhere
        self.keep()

    def _copy_of(self, arrays: Sequence[np.ndarray], parts: np.ndarray) -> None:
        """Memory for copies of these parts of the arrays.   parts: (k, 2) addresses and sizes [bytes]."""
        self._arrays, self._parts = arrays, parts.reshape(-1, 2)
        sizes = self._parts[:, 1]
        ends = np.cumsum(sizes)
        self._copies = np.empty(sizes.sum(), np.uint8)
        self._there = np.column_stack([place_of(self._copies) + ends - sizes, self._parts])
        self._back = self._there[:, [1, 0, 2]].copy()

    def another(self) -> "KeptState":
        """Copies of the same memory, as it is now."""
        result = copy(self)
        result._copy_of(self._arrays, self._parts)
        result.keep()
        return result

    def keep(self) -> None:
        """Copy the present state."""
        _copy(self._there)
        self._other = self._elsewhere and self._elsewhere.present()

    def restore(self) -> None:
        """Return to the state that was kept last."""
        _copy(self._back)
        if self._elsewhere:
            self._elsewhere.put_back(self._other)


def _parts(array: np.ndarray) -> list[tuple[int, int]]:
    """Addresses and sizes [bytes] of its parts without gaps."""
    if array.flags.c_contiguous:
        return [(place_of(array), array.nbytes)]
    if array.ndim > 1 and not array[0].flags.c_contiguous:
        return [part for row in array for part in _parts(row)]
    first, step, size = place_of(array), array.strides[0], array.nbytes // len(array)
    return [(first + step * k, size) for k in range(len(array))]


@kernel
def _copy(blocks):
    """Many small arrays at once: NumPy takes longer to begin than to copy one.

    blocks: (k, 3) addresses, where to and where from, and sizes [bytes].
    """
    for b in range(len(blocks)):
        copy_memory(blocks[b, 0], blocks[b, 1], blocks[b, 2])


def _arrays(memory: Mapping[str, Any]) -> Iterator[np.ndarray]:
    for part in memory.values():
        if isinstance(part, Mapping):
            yield from _arrays(part)
        else:
            yield part
