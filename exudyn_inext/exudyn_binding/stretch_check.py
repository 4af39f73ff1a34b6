"""Whether cables of native templates, taken as inextensible, should have stretched."""

import math
import warnings
from collections.abc import Sequence

import numpy as np

from ..advice.stretch import Tension, stretch_error
from ..arrays import Array
from ..checks import SMALLEST
from ..errors import InextensibleError
from ..scene.model import CableInScene
from .kept_states import KeptStates
from .spans import spans_of

LOOKS = 12  # at tensions: at equal intervals, and as many where velocities have changed most
MOST_SOLVES = 300  # of cables in each of both, about: of a large net, few states are looked at
OF_MOTION = 0.02  # of a cable, that stretch may move it by; a motion counts as
LEAST_MOTION = 0.02  # of its extent at least
OF_EXTENT = 0.005  # of a cable at rest, that stretch may move it by
AT_REST = 1e-6  # of its extent, that it moves by
LARGEST_STRAIN = 5e-4  # of a cable that begins unstretched: then it bounces, with whatever hangs on it


def left_out_stretch(kept: KeptStates) -> list[tuple[float, str]]:
    """What `stretch_of` says of cables that leave stretch out; the state of the run is another one then."""
    run = kept.run
    known = [k for k, one in enumerate(run.cable_runs) if one.scene_cable.item.leaves_stretch_out]
    if not (known and len(kept)):
        return []
    times, _, states = kept.under_present_forces
    changes = np.linalg.norm(np.diff(states[:, 1], axis=0), axis=1)
    number = max(2, min(LOOKS, MOST_SOLVES // len(run.cable_runs)))
    usual = np.linspace(0, len(times) - 1, min(number, len(times))).astype(int)
    looks = [*usual, *(np.argsort(changes)[-number:] + 1)]
    try:
        found = {k: run.tensions(times[k], *states[k]) for k in set(looks)}
    except InextensibleError:  # items that were changed do not allow an earlier state any more
        return []
    displacements, said = np.vstack([kept.start, kept.all[2][:, 0]]), []
    for k in known:
        q = kept.nodes(k, displacements)[:, :, 0]
        largest = np.array([np.abs(found[look][k]).max() for look in looks])
        rms = math.sqrt(float(np.mean(largest[: len(usual)] ** 2)))
        cable, tension = run.cable_runs[k].scene_cable, (rms, float(largest.max()))
        said.append(stretch_of(cable, tension, q, times[-1], kept.begins_unstretched))
    return said


def stretch_of(
    cable: CableInScene,
    tension: tuple[float, float],
    positions: Array,
    time: float,
    begins_unstretched: bool = False,
) -> tuple[float, str]:
    """How much the stretch that was left out matters, over its limit, and a sentence.

    Args:
        cable: with a stiffness that was left out.
        tension: root mean square and largest one in time, of the largest along it [N].
        positions: (T, n, dim) of its nodes, from the start on [m].
        time: of its supports [s].
        begins_unstretched: whether a native cable would not be stretched at the start.
    """
    stiffness, model = cable.item.left_out or math.inf, cable.cable
    spans = [(distance, reach) for _, distance, reach in spans_of(model, time)]
    paths = np.linalg.norm(np.diff(positions, axis=0), axis=2).sum(axis=0)
    of_cable = Tension(*tension, model.length, spans)
    moved = stretch_error(of_cable, stiffness, positions[:, int(np.argmax(paths))])
    extent = float(np.linalg.norm(np.ptp(positions.reshape(-1, model.dimension), axis=0))) + SMALLEST
    motion, strain = float(np.linalg.norm(positions - positions[0], axis=2).max()), tension[1] / stiffness
    limit = OF_MOTION * max(motion, LEAST_MOTION * extent)
    matters = f"move it by some {moved:.2g} m, while it moves by {motion:.2g} m (limit {limit:.2g} m)"
    if motion < AT_REST * extent:
        limit = OF_EXTENT * extent
        matters = f"move it by some {moved:.2g} m, {moved / extent:.1%} of its extent (limit {OF_EXTENT:.1%})"
    share = moved / limit
    if begins_unstretched and strain / LARGEST_STRAIN > share:
        share = strain / LARGEST_STRAIN
        matters = f"change forces and turns of bodies, as it begins unstretched (limit {LARGEST_STRAIN:g})"
    return share, (
        f"cable '{cable.name}' is inextensible, but its template has axialStiffness = {stiffness:g} N: the "
        f"tension reaches {tension[1]:.3g} N, a strain of {strain:.2g}, and stretch would {matters}"
    )


def warn_of_worst(said: Sequence[tuple[float, str]]) -> None:
    """Of what `stretch_of` says of the cables of a scene, if stretch matters."""
    matters = [one for one in said if one[0] > 1.0]
    if matters:
        others = f"; that of {len(matters) - 1} other cables matters, too" if len(matters) > 1 else ""
        remedy = "Give CreateInextensibleCable extensible=True, which takes axialStiffness over."
        warnings.warn(f"{max(matters)[1]}{others}. {remedy}", stacklevel=5)
