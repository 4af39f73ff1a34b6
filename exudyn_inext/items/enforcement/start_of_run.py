"""What is looked at as a native solver starts: user functions are all that it calls of a cable."""

from collections.abc import Callable
from typing import Any

import exudyn
import numpy as np

from ...errors import SceneError
from ...scene.model import CableItem
from ..element_weights import elements_by_nodes, read_weight
from ..explicit_traps import WarnOfExplicitTraps


class StartOfRun:
    """Makes checks as a native solver starts, again if another run begins.   checks: called with the mbs."""

    def __init__(self, *checks: Callable[[Any], None]) -> None:
        self._checks = checks
        self._run: tuple[Any, ...] = ()
        self._time = np.inf

    def look(self, mbs: Any, t: float) -> None:
        """Make the checks if t [s] is the first time of a run; call it from a user function."""
        data = mbs.systemData
        run = mbs.sys.get("dynamicSolver"), data.NumberOfObjects(), data.NumberOfLoads()
        is_known = run == self._run and t >= self._time
        self._run, self._time = run, t
        if not is_known:
            for check in self._checks:
                check(mbs)


def warn_of_traps(mbs: Any) -> None:
    """If it is an explicit solver."""
    if isinstance(mbs.sys.get("dynamicSolver"), exudyn.MainSolverExplicit):
        WarnOfExplicitTraps(mbs)


def refuse_weights(item: CableItem) -> Callable[[Any], None]:
    """A check that raises SceneError if companions give the cable a weight, which no native solver feels."""
    elements = elements_by_nodes({0: item})

    def check(mbs: Any) -> None:
        for load in range(mbs.systemData.NumberOfLoads()):
            if read_weight(mbs, load, mbs.GetLoad(load), elements) is not None:
                raise SceneError(
                    f"load {load} '{mbs.GetLoad(load)['name']}' (MassProportional) acts on a companion, "
                    "which has no mass under native solvers: give the inextensible cable its gravity=..., "
                    "or use SolveExplicit."
                )

    return check
