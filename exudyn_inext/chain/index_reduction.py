"""Index reduction of the chain, Eqs. (23)-(30): the DAE as an ODE, stabilised with rate zeta."""

from typing import NamedTuple

import numpy as np

from ..compiled import inlined
from ..element.shape_functions import Array
from ..system import implements, index_reduced_rates
from .assembly import assemble
from .chain import Chain
from .saddle_point import (
    Factor,
    allocate,
    expand_solution,
    factorise,
    reduce_right_hand_side,
    substitute,
)

RATE, ACCELERATION = 0, 1  # the two right-hand sides of Eq. (29)


class CableSystem(NamedTuple):
    """A chain with its stabilisation and memory: the `system` of the integrators.

    chain: coefficients.
    zeta: stabilisation rate of Eqs. (24)-(28) [1/s].
    factor: of the saddle-point matrix.
    force: (2, n, 2, dim) zero, and the total generalised force [N, Nm].
    nodal, length: (n, 3), (N, 3) value, rate and gamma of the constraints.
    nodal_target, length_target: (2, n), (2, N) right-hand sides of the constraint equations.
    multiplier: (2, N) mu and lam of the length constraints.
    """

    chain: Chain
    zeta: float
    factor: Factor
    force: Array
    nodal: Array
    length: Array
    nodal_target: Array
    length_target: Array
    multiplier: Array


def cable_system(chain: Chain, zeta: float) -> CableSystem:
    """Allocate everything that the right-hand side of `chain` needs."""
    nodes, dim = len(chain.free), len(chain.axes)
    return CableSystem(
        chain=chain,
        zeta=float(zeta),
        factor=allocate(chain),
        force=np.zeros((2, nodes, 2, dim)),
        nodal=np.zeros((nodes, 3)),
        length=np.zeros((nodes - 1, 3)),
        nodal_target=np.zeros((2, nodes)),
        length_target=np.zeros((2, nodes - 1)),
        multiplier=np.zeros((2, nodes - 1)),
    )


@inlined
def _set_targets(zeta, terms, target):
    """Right-hand sides of Eq. (29) for the correction q' - v and for v', from c, c_q v and gamma."""
    for k in range(len(terms)):
        target[RATE, k] = -zeta * terms[k, 0] - terms[k, 1]
        target[ACCELERATION, k] = terms[k, 2] - zeta * terms[k, 1]


@implements(index_reduced_rates, CableSystem)
def cable_rates(system, external, q, v, acceleration, rate):
    """Eq. (30) with one factorisation and one solve for both. Arguments: `index_reduced_rates`.

    q' is found as v plus a correction, M (q' - v) + C_q^T mu = 0: its force is zero.
    """
    chain, factor = system.chain, system.factor
    shape = (len(chain.free), 2, len(chain.axes))
    q_nodes, v_nodes = q.reshape(shape), v.reshape(shape)
    system.force[ACCELERATION] = external.reshape(shape)
    assemble(
        chain, q_nodes, v_nodes, system.force[ACCELERATION], system.nodal, system.length, factor.gradient
    )
    factorise(chain, q_nodes, factor)
    _set_targets(system.zeta, system.nodal, system.nodal_target)
    _set_targets(system.zeta, system.length, system.length_target)
    for column in (RATE, ACCELERATION):
        reduce_right_hand_side(
            chain,
            factor,
            column,
            system.force[column],
            system.nodal_target[column],
            system.length_target[column],
        )
    substitute(chain.axes, (RATE, ACCELERATION), chain.ends_group, factor)
    expand_solution(
        chain.axes, factor, ACCELERATION, acceleration.reshape(shape), system.multiplier[ACCELERATION]
    )
    expand_solution(chain.axes, factor, RATE, rate.reshape(shape), system.multiplier[RATE])
    for i in range(len(v)):
        rate[i] += v[i]
