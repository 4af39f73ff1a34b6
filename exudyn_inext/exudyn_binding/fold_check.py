"""Whether a cable at rest folds back within an element, as ends do that hang without tension."""

import numpy as np

from ..arrays import Array
from ..checks import SMALLEST
from ..run.cable_loads import CableLoads
from ..scene.model import CableInScene

BACKWARDS = -0.5  # cosine between a slope and the line to the next node: no cable turns so far in one element
STRAIGHT = 4.0  # times (EI / w)^(1/3): elements of that length stay straight below their weight w per length


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
