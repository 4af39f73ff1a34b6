"""Offsets of compiled joints that are set between steps, or given by functions that are steered there."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array
from .steered import Steered


class Sampled:
    """Functions of time, sampled together; samples at the times asked last are kept.

    name: of the joint, for messages.
    """

    def __init__(
        self, name: str, sample: Callable[[Sequence[float]], Array], renew: Callable[[], None]
    ) -> None:
        """sample: times (T,) [s] -> (T, 3, n), with derivatives.   renew: see `forget`."""
        self.name, self._sample, self._renew = name, sample, renew
        self._known: tuple[list[float], Array] = ([], np.zeros((0, 3, 1)))

    def forget(self) -> None:
        """Step functions have been called: what the functions read may be something else."""
        self._renew()
        self._known = ([], self._known[1])

    def part(self, which: int, times: Sequence[float]) -> Array:
        """(T, 3) of one of the functions."""
        if list(times) != self._known[0]:
            self._known = list(times), self._sample(times)
        return self._known[1][:, :, which]


class MovedOffsets(Steered):
    """What offsets differ by, until the end of a step of the time loop, from where they are to be then.

    joints: numbers of the k joints.   rows: (k,) of these.   steered: functions of some.
    """

    def __init__(
        self,
        joints: Sequence[int],
        rows: Sequence[int],
        given: Sequence[Callable[[], float]],
        steered: Sequence[Sampled],
    ) -> None:
        """given: offset of each joint as it is set at present, without its function [m]."""
        super().__init__(len(rows))
        self.joints, self.rows, self._given = joints, np.array(rows, dtype=int), given
        self.steered = steered

    @property
    def given(self) -> list[float]:
        """Offsets as they are set at present [m]."""
        return [one() for one in self._given]

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3 k) what is left at the times, and its derivatives [m, m/s, m/s^2], of one after the other."""
        return self.left_at(times).transpose(0, 2, 1).reshape(len(times), -1)
