"""The forms of all elements of a mesh."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..arrays import Array

_REMEMBERED = 4096


@lru_cache(_REMEMBERED)
def _form(form: Callable[[float], Array], length: float) -> Array:
    values = form(length)
    values.setflags(write=False)
    return values


def forms_of_mesh(form: Callable[[float], Array], lengths: Array) -> Array:
    """(N, ...) values of `form` for the element lengths (N,) [m]; each length is computed once."""
    if len(lengths) and (lengths == lengths[0]).all():
        return np.repeat(_form(form, float(lengths[0]))[None], len(lengths), axis=0)
    unique, which = np.unique(lengths, return_inverse=True)
    return np.stack([_form(form, float(length)) for length in unique])[which]
