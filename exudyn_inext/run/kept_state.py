"""The state of a run before its last steps, to which it returns if they go wrong."""

from collections.abc import Iterator, Mapping
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
        self._copies = [array.copy() for array in self._arrays]
        pairs = zip(self._copies, self._arrays, strict=True)
        self._there = np.concatenate([_blocks(*pair) for pair in pairs])
        self._back = np.ascontiguousarray(self._there[:, [1, 0, 2]])
        self._other = elsewhere and elsewhere.present()

    def keep(self) -> None:
        """Copy the present state."""
        _copy(self._there)
        self._other = self._elsewhere and self._elsewhere.present()

    def restore(self) -> None:
        """Return to the state that was kept last."""
        _copy(self._back)
        if self._elsewhere:
            self._elsewhere.put_back(self._other)


def _blocks(target: np.ndarray, source: np.ndarray) -> np.ndarray:
    """(k, 3) addresses of both, and sizes [bytes], of parts without gaps."""
    arrays = target, source
    if all(array.flags.c_contiguous for array in arrays):
        return np.array([[_address(target), _address(source), source.nbytes]])
    places = [_address(array) + _offsets(array) for array in arrays]
    return np.stack([*places, np.full(source.size, source.itemsize)], axis=1)


def _address(array: np.ndarray) -> int:
    return int(array.__array_interface__["data"][0])


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
