"""Offsets of compiled joints that are set between steps."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array
from .steered import Steered


class MovedOffsets(Steered):
    """What offsets differ by, until the end of a step of the time loop, from where they are to be then.

    joints: numbers of the k joints.   rows: (k,) of these.
    """

    def __init__(
        self, joints: Sequence[int], rows: Sequence[int], given: Sequence[Callable[[], float]]
    ) -> None:
        """given: offset of each joint as it is set at present [m]."""
        super().__init__(len(rows))
        self.joints, self.rows, self._given = joints, np.array(rows, dtype=int), given

    @property
    def given(self) -> list[float]:
        """Offsets as they are set at present [m]."""
        return [one() for one in self._given]

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3 k) what is left at the times, and its derivatives [m, m/s, m/s^2], of one after the other."""
        if not self.moves:
            return np.zeros((len(times), 3 * len(self.rows)))
        return np.array([self.at(t).T.ravel() for t in times])
