"""The state of a run before its last steps, to which it returns if they go wrong."""

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from typing import Any, Protocol

import numpy as np

from ..compiled import kernel
from ..lowered import copy_memory


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
        blocks = _blocks(self._arrays)
        ends = np.cumsum(blocks[:, 1])
        self._copies = np.empty(ends[-1] if len(ends) else 0, np.uint8)
        places = self._copies.ctypes.data + ends - blocks[:, 1]
        self._there = np.column_stack([places, blocks])
        self._back = np.ascontiguousarray(self._there[:, [1, 0, 2]])
        self.keep()

    def keep(self) -> None:
        """Copy the present state."""
        _copy(self._there)
        self._other = self._elsewhere and self._elsewhere.present()

    def restore(self) -> None:
        """Return to the state that was kept last."""
        _copy(self._back)
        if self._elsewhere:
            self._elsewhere.put_back(self._other)


def _blocks(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """(k, 2) addresses and sizes [bytes] of their parts without gaps."""
    whole = [[array.ctypes.data, array.nbytes] for array in arrays if array.flags.c_contiguous]
    blocks = [np.array(whole, dtype=np.int64).reshape(-1, 2)]
    for array in arrays:
        if not array.flags.c_contiguous:
            places = array.ctypes.data + _offsets(array)
            blocks.append(np.column_stack([places, np.full(array.size, array.itemsize)]))
    return np.concatenate(blocks)


def _offsets(array: np.ndarray) -> np.ndarray:
    """(size,) of all entries from the first one [bytes]."""
    along = [stride * np.arange(size) for size, stride in zip(array.shape, array.strides, strict=True)]
    return reduce(np.add.outer, along).ravel()


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
