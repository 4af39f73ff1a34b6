"""Native solvers do not feel the weight that companions give a cable: it is refused, not ignored."""

from typing import Any

import numpy as np

from ...errors import SceneError
from ..cable_data import CableItem
from ..element_weights import elements_by_nodes, read_weight


class WeightWatch:
    """Looks for weights on the elements of a cable as a native solver starts, again if another run begins."""

    def __init__(self, item: CableItem) -> None:
        self._elements = elements_by_nodes({0: item})
        self._number = -1
        self._time = np.inf

    def look(self, mbs: Any, t: float) -> None:
        """Raise SceneError if there are any; first at the time t [s] of a run."""
        number = mbs.systemData.NumberOfLoads()
        is_known = number == self._number and t >= self._time
        self._number, self._time = number, t
        if not is_known:
            for load in range(number):
                self._refuse(mbs, load)

    def _refuse(self, mbs: Any, load: int) -> None:
        if read_weight(mbs, load, self._elements) is not None:
            raise SceneError(
                f"load {load} '{mbs.GetLoad(load)['name']}' (MassProportional) acts on a companion, which "
                "has no mass under native solvers: give the inextensible cable its gravity=..., or use "
                "SolveExplicit."
            )
