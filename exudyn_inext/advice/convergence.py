"""How far the finest of some solutions is from the limit: Richardson's extrapolation on unequal meshes."""

from collections.abc import Sequence

import numpy as np
import scipy  # its `optimize` is imported where it is used first

ORDERS = (0.5, 8.0)


def observed_order(elements: Sequence[int], differences: Sequence[float]) -> float | None:
    """p of errors C N^-p, from solutions on three meshes; None if they do not converge.

    |x_0 - x_1| / |x_1 - x_2| = (N_0^-p - N_1^-p) / (N_1^-p - N_2^-p); larger orders than 8 count as 8.

    Args:
        elements: N_0 < N_1 < N_2.   differences: |x_0 - x_1| and |x_1 - x_2|, in the same norm.

    Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911), 307-357; P. J. Roache, J. Fluids Eng. 116
    (1994), 405-413.
    """
    coarse, fine = differences
    if not np.isfinite(differences).all():
        return None
    if fine == 0.0:
        return ORDERS[1]
    n0, n1, n2 = elements

    def excess(p: float) -> float:
        return float((n0**-p - n1**-p) / (n1**-p - n2**-p) - coarse / fine)

    if excess(ORDERS[0]) > 0.0:
        return None
    if excess(ORDERS[1]) < 0.0:
        return ORDERS[1]
    return float(scipy.optimize.brentq(excess, *ORDERS))


def remaining_error(coarse: int, fine: int, difference: float, order: float) -> float:
    """Error of the finer of two solutions that converge with that order.

    Args:
        coarse, fine: numbers of elements.   difference: of the solutions.   order: p of C N^-p.
    """
    return difference * fine**-order / (coarse**-order - fine**-order)
