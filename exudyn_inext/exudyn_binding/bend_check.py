"""Whether cables bend more sharply than their elements resolve, or fold back at rest."""

import math
import warnings
from collections.abc import Iterable

import numpy as np

from ..arrays import Array
from ..checks import SMALLEST
from ..run.cable_loads import CableLoads
from ..scene.model import CableInScene
from .kept_states import KeptStates

LARGEST_TURN = 2.5  # from one node to the next [rad], see docs/faq.md
BACKWARDS = -0.5  # cosine between a slope and the line to the next node: no cable turns so far in one element
STRAIGHT = 4.0  # times (EI / w)^(1/3): elements of that length stay straight below their weight w per length


def largest_turns(kept: KeptStates) -> list[tuple[float, str]]:
    """Of each cable of a run that is over, its largest turn within an element [rad], and a sentence."""
    if not len(kept):
        return []
    (times, _, states), found = kept.all, []
    for k, cable in enumerate(kept.run.cable_runs):
        cosines = cosines_of_turns(kept.nodes(k, states[:, 0])[:, :, 1])
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


def fold_of(cable: CableInScene, q: Array, time: float) -> str:
    """Where and why the cable folds back at q (n, 2, dim), and what helps; empty if it does not.

    The last element of an end that hangs freely may turn its slope back, with |r_x|^2 still 1 in its mean:
    its weight w l^2 comes down by 0.04 l, while bending takes 5.3 EI / l, and the end comes up by l / 4.

    time: of weights that depend on it [s].
    """
    lines = np.diff(q[:, 0], axis=0)
    lines = lines / np.maximum(np.linalg.norm(lines, axis=1, keepdims=True), SMALLEST)
    cosines = np.einsum("eai,ei->ea", np.stack([q[:-1, 1], q[1:, 1]], axis=1), lines)
    element, end = divmod(int(np.argmin(cosines)), 2)
    if not cosines[element, end] < BACKWARDS:
        return ""
    gravity = float(np.linalg.norm(CableLoads(cable).gravity_at(time), axis=1).max())
    if not gravity:
        return ""
    node = element + end
    is_inner = 0 < node < len(lines)
    remedy = "start nearer to the equilibrium" if is_inner else "load that end by AddPointMass"
    section, length = cable.cable.section, float(cable.cable.element_lengths[element])
    longest = STRAIGHT * (section.bending_stiffness / (section.mass_per_length * gravity)) ** (1.0 / 3.0)
    return (
        f"cable '{cable.name}' folds back at node {cable.item.node_names[node]}, as its bending "
        f"stiffness of {section.bending_stiffness:g} N m^2 is too small for elements of {length:.3g} m below "
        f"their weight (limit {longest:.3g} m): the node is up to {0.25 * length:.2g} m off. Use shorter "
        f"elements there, or {remedy}"
    )
