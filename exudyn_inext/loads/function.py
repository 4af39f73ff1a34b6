"""The user function of a load."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)
class LoadFunction:
    """Of a load at t [s]: its components are scale times function(mbs, t, value).   value: given with it."""

    function: Callable[..., Any]
    mbs: Any
    value: Any
    scale: float = 1.0
