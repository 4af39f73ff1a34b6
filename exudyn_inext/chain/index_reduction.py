"""Index reduction of the chain, Eqs. (23)-(30): the DAE as an ODE, stabilised with rate zeta."""

from typing import NamedTuple

from ..compiled import inlined
from ..system import implements, index_reduced_rates
from .assembly import GAMMA, RATE, VALUE, assemble
from .chain import Chain
from .saddle_point import expand_solution, factorise, reduce_right_hand_side, substitute

ACCELERATION, CORRECTION = 0, 1  # columns of Eq. (29): v' with lam, and q' - v with mu


class CableSystem(NamedTuple):
    """A chain and its stabilisation: the `system` of the integrators.

    chain: coefficients and memory.
    zeta: stabilisation rate of Eqs. (24)-(28) [1/s].
    """

    chain: Chain
    zeta: float


@inlined
def _set_targets(zeta, record):
    """Right-hand sides of the constraint rows of Eq. (29), from c, c_q v and gamma."""
    terms = record.constraint
    record.target[ACCELERATION] = terms[GAMMA] - zeta * terms[RATE]
    record.target[CORRECTION] = -zeta * terms[VALUE] - terms[RATE]


@implements(index_reduced_rates, CableSystem)
def cable_rates(system, external, q, v, acceleration, rate):
    """Eq. (30) with one factorisation for both columns. Arguments: see `index_reduced_rates`.

    q' is found as v plus a correction, M (q' - v) + C_q^T mu = 0: its force is zero.
    """
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    q_nodes, v_nodes, force = q.reshape(shape), v.reshape(shape), external.reshape(shape)
    for k in range(len(nodes)):
        for i in range(len(axes)):
            nodes[k].force[ACCELERATION, 0, i] = force[k, 0, i]
            nodes[k].force[ACCELERATION, 1, i] = force[k, 1, i]
    assemble(axes, nodes, elements, q_nodes, v_nodes, ACCELERATION)
    factorise(axes, nodes, elements, q_nodes)
    for k in range(len(nodes)):
        _set_targets(system.zeta, nodes[k])
    for k in range(len(elements)):
        _set_targets(system.zeta, elements[k])
    reduce_right_hand_side(axes, nodes, elements, ACCELERATION)
    reduce_right_hand_side(axes, nodes, elements, CORRECTION)
    substitute(axes, nodes, (ACCELERATION, CORRECTION))
    expand_solution(axes, nodes, elements, ACCELERATION, acceleration.reshape(shape))
    expand_solution(axes, nodes, elements, CORRECTION, rate.reshape(shape))
    for i in range(len(v)):
        rate[i] += v[i]
