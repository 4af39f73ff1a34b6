"""Whether cables bend more sharply than their elements resolve."""

import math
import warnings
from collections.abc import Iterable

import numpy as np

from ..arrays import Array
from ..checks import SMALLEST
from ..scene.model import CableInScene
from .kept_states import KeptStates

LARGEST_TURN = 2.5  # from one node to the next [rad], see docs/faq.md


def largest_turns(kept: KeptStates) -> list[tuple[float, str]]:
    """Of each cable of a run that is over, its largest turn within an element [rad], and a sentence."""
    if not len(kept):
        return []
    run, (times, _, states) = kept.run, kept.all()
    found = []
    for cable, (dofs, shape) in zip(run.cable_runs, run.places_of_cables, strict=False):
        cosines = cosines_of_turns((states[:, 0, dofs] + run.reference[dofs]).reshape(-1, *shape)[:, :, 1])
        first = int(np.argmax(cosines.min(axis=1) < math.cos(LARGEST_TURN)))
        what = f"from t = {times[first]:.3g} s on its motion may be some per cent off, or more"
        found.append(_largest(cable.scene_cable, cosines, what))
    return found


def turn_at_rest(cable: CableInScene, q: Array) -> str:
    """What is said of a cable that rests at q (n, 2, dim); empty if its elements resolve its bends."""
    turn, said = _largest(
        cable, cosines_of_turns(q[np.newaxis, :, 1]), "with shorter elements it rests elsewhere"
    )
    return said if turn > LARGEST_TURN else ""


def cosines_of_turns(slopes: Array) -> Array:
    """(T, N) of the turns along each element, of slopes (T, N + 1, dim) at its ends."""
    lengths = np.sqrt(np.einsum("tni,tni->tn", slopes, slopes))
    products = np.einsum("tni,tni->tn", slopes[:, :-1], slopes[:, 1:])
    return np.asarray(products / np.maximum(lengths[:, :-1] * lengths[:, 1:], SMALLEST))


def _largest(cable: CableInScene, cosines: Array, what: str) -> tuple[float, str]:
    """Largest turn [rad], and a sentence.   what: follows from too large a one."""
    turn = math.acos(min(1.0, max(-1.0, float(cosines.min()))))
    element = int(np.argmin(cosines.min(axis=0)))
    start, end = cable.item.node_names[element : element + 2]
    return turn, (
        f"cable '{cable.name}' turns by {turn:.2g} rad between nodes {start} and {end}, an element of "
        f"{cable.cable.element_lengths[element]:.3g} m (limit {LARGEST_TURN:g} rad): its mesh does not "
        f"resolve such bends, and {what}"
    )


def warn_of_turns(found: Iterable[tuple[float, str]]) -> None:
    """Of what `largest_turns` says of the runs of a scene, if a turn is too large."""
    too_large = [one for one in found if one[0] > LARGEST_TURN]
    if too_large:
        others = f"; {len(too_large) - 1} more cable(s), too" if len(too_large) > 1 else ""
        remedy = "Take shorter elements, or see what a run of twice as many says."
        warnings.warn(f"{max(too_large)[1]}{others}. {remedy}", stacklevel=5)
