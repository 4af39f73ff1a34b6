"""Whether cables of native templates, taken as inextensible, should have stretched."""

import math
import warnings
from collections.abc import Sequence

import numpy as np

from ..advice.stretch import Tension, stretch_error
from ..arrays import Array
from ..checks import SMALLEST
from ..errors import InextensibleError
from ..run.coupled_run import Run
from ..run.time_grid import TimeGrid
from ..scene.model import CableInScene
from .kept_states import KeptStates
from .spans import spans_of

LOOKS = 12  # at tensions: at equal intervals, and as many where velocities have changed most
MOST_SOLVES = 300  # of cables in each of both, about: of a large net, few states are looked at
LARGEST_SHARE = 0.005  # of the extent of a cable that stretch may move it by


class StretchCheck(KeptStates):
    """Of runs whose templates tell an axial stiffness that was left out, or whose cables stretch."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        known = [cable.scene_cable.item.leaves_stretch_out for cable in run.cable_runs]
        self._places = np.flatnonzero(known).tolist()
        self._matters = bool(self._places) or run.watch.stretches

    def keep(self, grid: TimeGrid, first: int, history: Array) -> None:
        """See `KeptStates`; other runs cost nothing."""
        if self._matters:
            super().keep(grid, first, history)

    def findings(self) -> list[tuple[float, str]]:
        """What `stretch_of` says of each of these cables; the state of the run is another one then."""
        if not (self._places and self.states):
            return []
        times, _, kept = zip(*self.states.values(), strict=True)
        states = np.array(kept)
        changes = np.linalg.norm(np.diff(states[:, 1], axis=0), axis=1)
        number = max(2, min(LOOKS, MOST_SOLVES // len(self.run.cable_runs)))
        usual = np.linspace(0, len(times) - 1, min(number, len(times))).astype(int)
        looks = [*usual, *(np.argsort(changes)[-number:] + 1)]
        try:
            found = {k: self.run.tensions(times[k], *states[k]) for k in set(looks)}
        except InextensibleError:  # items that were changed do not allow an earlier state any more
            return []
        places, said = self.run.places_of_cables, []
        for k in self._places:
            dofs, shape = places[k]
            q = (states[:, 0, dofs] + self.run.reference[dofs]).reshape(-1, *shape)[:, :, 0]
            largest = np.array([np.abs(found[look][k]).max() for look in looks])
            rms = math.sqrt(float(np.mean(largest[: len(usual)] ** 2)))
            tensions_of_cable = rms, float(largest.max())
            said.append(stretch_of(self.run.cable_runs[k].scene_cable, tensions_of_cable, q, times[-1]))
        return said


def stretch_of(
    cable: CableInScene, tension: tuple[float, float], positions: Array, time: float
) -> tuple[float, str]:
    """How much the stretch that was left out would move a cable, as a share of its extent, and a sentence.

    Args:
        cable: with a stiffness that was left out.
        tension: root mean square and largest one in time, of the largest along it [N].
        positions: (T, n, dim) of its nodes [m].
        time: of its supports [s].
    """
    stiffness, model = cable.item.left_out or math.inf, cable.cable
    spans = [(distance, reach) for _, distance, reach in spans_of(model, time)]
    paths = np.linalg.norm(np.diff(positions, axis=0), axis=2).sum(axis=0)
    farthest = positions[:, int(np.argmax(paths))]
    of_cable = Tension(*tension, model.length, spans)
    moved = stretch_error(of_cable, stiffness, farthest)
    extent = float(np.linalg.norm(np.ptp(positions.reshape(-1, model.dimension), axis=0)))
    share, largest = moved / max(extent, SMALLEST), of_cable.largest
    return share, (
        f"cable '{cable.name}' is inextensible, but its template has axialStiffness = {stiffness:g} N: the "
        f"tension reaches {largest:.3g} N, a strain of {largest / stiffness:.2g}, and stretch would move it "
        f"by some {moved:.2g} m, {share:.1%} of its extent (limit {LARGEST_SHARE:.1%})"
    )


def warn_of_worst(said: Sequence[tuple[float, str]]) -> None:
    """Of what `stretch_of` says of the cables of a scene, if stretch matters."""
    matters = [one for one in said if one[0] > LARGEST_SHARE]
    if matters:
        others = f"; that of {len(matters) - 1} other cables matters, too" if len(matters) > 1 else ""
        remedy = "Give CreateInextensibleCable extensible=True, which takes axialStiffness over."
        warnings.warn(f"{max(matters)[1]}{others}. {remedy}", stacklevel=5)
