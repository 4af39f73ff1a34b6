"""A link: one scalar constraint on nodes of a cable that the chain's structure does not hold, Eq. (20).

    c(q, t) = n . u + (u . u - L^2) / (2 L),    u = sum of weighted nodal vectors - p(t)

covers a rod of length L (n = 0), and a coordinate that follows a motion (L infinite).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array


@dataclass(frozen=True, eq=False)
class Motion:
    """A point that moves as given, or rests.

    at: t [s] -> (3, dim): p [m], p_t [m/s], p_tt [m/s^2].
    rests: whether it does not depend on the time.
    is_pure: whether `at` depends on nothing but the time, so that it may be asked ahead of time.
    is_smooth: whether it can be differentiated twice; if not, velocities jump between steps.
    given: whether p_t and p_tt are, and not found by differences.
    at_times: (T,) t [s] -> (T, 3, dim), `at` of many times at once; None: they are asked for one by one.
    position: t [s] -> (dim,) p alone, which takes fewer calls where its derivatives are differences.
    """

    at: Callable[[float], Array]
    rests: bool = False
    is_pure: bool = True
    is_smooth: bool = True
    given: tuple[bool, bool] = (True, True)
    at_times: Callable[[Sequence[float]], Array] | None = None
    position: Callable[[float], Array] | None = None

    def place(self, t: float) -> Array:
        """(dim,) p at t [s]."""
        return np.atleast_1d(self.position(t)) if self.position else self.at(t)[0]

    def sample(self, times: Sequence[float]) -> Array:
        """(T, 3, dim) `at` of many times [s]."""
        if self.at_times is None or len(times) == 1:
            return np.array([self.at(t) for t in times])
        return self.at_times(times)


def rest(point: Array) -> Motion:
    """A fixed point (dim,) [m]."""
    values = np.zeros((3, len(point)))
    values[0] = point
    return Motion(lambda t: values, rests=True)


@dataclass(frozen=True, eq=False)
class Link:
    """One constraint.

    kind: what it is called.
    nodes: (k,) one or two node indices.
    weights: (k, 2) of position and slope of each node in u [-, m].
    anchor: p(t).
    normal: (dim,) n [-].
    length: L [m]; infinite for a linear constraint.
    follows: the column of the basis transverse to the first node's slope that n follows, or -1.
    """

    kind: str
    nodes: tuple[int, ...]
    weights: Array
    anchor: Motion
    normal: Array
    length: float = np.inf
    follows: int = -1
