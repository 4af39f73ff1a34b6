"""The array types of all public formulas, that of records, and places in arrays."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.int_]
SparseArray: TypeAlias = "scipy.sparse.csr_array"
"""Modules say `import scipy` alone: parts of it take long to import, and only where they are used first."""


def as_slice(indices: Places) -> Any:
    """The same places as a slice, if they follow each other: it is copied several times faster."""
    first = int(indices[0])
    in_a_row = np.arange(first, first + len(indices), dtype=indices.dtype)
    return slice(first, first + len(indices)) if indices.tobytes() == in_a_row.tobytes() else indices


def record_type(fields: Any) -> np.dtype[Any]:
    """dtype of records whose fields are attributes of each, in kernels and in Python.

    Arrays of them are plain arrays, whose fields are array["name"]. Types are better made once than for each
    array: kernels take time to recognise a new one.
    """
    return np.dtype((np.record, np.dtype(fields, align=True)))


def copy_of(array: Any) -> Any:
    """NumPy copies records field by field, which takes ten times as long."""
    if array.dtype.names is None:
        return array.copy()
    return np.frombuffer(bytearray(array.tobytes()), array.dtype).reshape(array.shape)


def copies_of(record: Any) -> Callable[[], Any]:
    """Makes records like this one, see `copy_of`."""
    kind, content = record.dtype, record.tobytes()
    return lambda: np.frombuffer(bytearray(content), kind)[0]


def collected(kind: np.dtype[Any], records: Any) -> Any:
    """An array of these records of one type."""
    result = np.zeros(len(records), kind)
    for k, record in enumerate(records):
        result[k] = record
    return result
