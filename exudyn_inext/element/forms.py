"""The forms of all elements of a mesh."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array


def forms_of_mesh(form: Callable[[float], Array], lengths: Array) -> Array:
    """(N, ...) values of `form` for the element lengths (N,) [m]; equal lengths are computed once."""
    unique, which = np.unique(lengths, return_inverse=True)
    return np.stack([form(float(length)) for length in unique])[which]
