"""The forms of all elements of a mesh."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..arrays import Array

_LENGTHS, _MESHES = 4096, 128  # that are remembered


@lru_cache(_LENGTHS)
def _form(form: Callable[[float], Array], length: float) -> Array:
    return form(length)


@lru_cache(_MESHES)
def _forms(form: Callable[[float], Array], lengths: tuple[float, ...]) -> Array:
    return np.stack([_form(form, length) for length in lengths])


def forms_of_mesh(form: Callable[[float], Array], lengths: Array) -> Array:
    """(N, ...) values of `form` for the element lengths (N,) [m]; each length is computed once."""
    return _forms(form, tuple(lengths.tolist())).copy()
