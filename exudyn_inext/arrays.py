"""The array type of all public formulas, and that of records."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def record_type(fields: Any) -> np.dtype[Any]:
    """dtype of records whose fields are attributes of each, in kernels and in Python.

    Arrays of them are plain arrays, whose fields are array["name"]. Types are better made once than for each
    array: kernels take time to recognise a new one.
    """
    return np.dtype((np.record, np.dtype(fields, align=True)))
