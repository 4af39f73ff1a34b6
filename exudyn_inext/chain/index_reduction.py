"""Index reduction of the chain, Eqs. (23)-(30): the DAE as an ODE, stabilised with rate zeta."""

from typing import NamedTuple

from ..compiled import inlined
from ..system import (
    AGITATION,
    ELASTIC,
    KINETIC,
    POWER,
    VIOLATION,
    accelerate_and_project,
    correct_position,
    gauge,
    implements,
    index_reduced_rates,
)
from .assembly import (
    GAMMA,
    RATE,
    VALUE,
    add_damping,
    add_drag,
    assemble,
    elastic_energy,
    set_violations,
)
from .chain import Chain
from .energy import dissipative_power, kinetic_energy
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
def assemble_forces(axes, nodes, elements, external, q, v, lead, a):
    """Forces at (q, v) and all terms of the constraints but the links; damping and drag act at v + lead a."""
    for k in range(len(nodes)):
        for i in range(len(axes)):
            nodes[k].force[ACCELERATION, 0, i] = external[k, 0, i]
            nodes[k].force[ACCELERATION, 1, i] = external[k, 1, i]
    assemble(axes, nodes, elements, q, v, ACCELERATION)
    add_damping(axes, nodes, elements, q, v, lead, a, ACCELERATION)
    add_drag(axes, nodes, elements, q, v, lead, a, ACCELERATION)


@inlined
def assemble_and_factorise(axes, nodes, elements, external, q, v, lead, a):
    """All of Eq. (29) but the links; arguments: see `assemble_forces`."""
    assemble_forces(axes, nodes, elements, external, q, v, lead, a)
    factorise(axes, nodes, elements, q)


@inlined
def _solve_both(axes, nodes, elements, acceleration, correction):
    reduce_right_hand_side(axes, nodes, elements, ACCELERATION)
    reduce_right_hand_side(axes, nodes, elements, CORRECTION)
    substitute(axes, nodes, (ACCELERATION, CORRECTION), ACCELERATION)
    expand_solution(axes, nodes, elements, ACCELERATION, acceleration)
    expand_solution(axes, nodes, elements, CORRECTION, correction)


@inlined
def set_stabilised_targets(zeta, record):
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
    known = v.reshape(shape)
    assemble_and_factorise(
        axes, nodes, elements, external.reshape(shape), q.reshape(shape), known, 0.0, known
    )
    for k in range(len(nodes)):
        set_stabilised_targets(system.zeta, nodes[k])
    for k in range(len(elements)):
        set_stabilised_targets(system.zeta, elements[k])
    _solve_both(axes, nodes, elements, acceleration.reshape(shape), rate.reshape(shape))
    for i in range(len(v)):
        rate[i] += v[i]


@inlined
def set_projection_targets(duration, record):
    """C_q a = gamma, corrected by the last step; C_q d = -C_q (v + duration a) leads to the manifold."""
    terms = record.constraint
    record.target[ACCELERATION] = terms[GAMMA] + record.foresight
    record.target[CORRECTION] = -terms[RATE] - duration * record.target[ACCELERATION]


@inlined
def set_correction_target(learning, record):
    """Right-hand side -c of a step back to the manifold; see `correct_position` for what is learned."""
    violation = record.constraint[VALUE]
    record.target[CORRECTION] = -violation
    record.foresight -= learning * violation


@implements(accelerate_and_project, CableSystem)
def accelerate_and_project_cable(system, external, q, v, duration, acceleration, end_velocity):
    """One factorisation for both columns. Arguments: see `accelerate_and_project`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    assemble_and_factorise(
        axes,
        nodes,
        elements,
        external.reshape(shape),
        q.reshape(shape),
        v.reshape(shape),
        duration,
        acceleration.reshape(shape),
    )
    for k in range(len(nodes)):
        set_projection_targets(duration, nodes[k])
    for k in range(len(elements)):
        set_projection_targets(duration, elements[k])
    _solve_both(axes, nodes, elements, acceleration.reshape(shape), end_velocity.reshape(shape))
    for i in range(len(v)):
        end_velocity[i] += v[i] + duration * acceleration[i]


@implements(correct_position, CableSystem)
def correct_cable_position(system, external, q, tolerance, learning, correction):
    """One solve with the last factor. Arguments: see `correct_position`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    worst = set_violations(axes, nodes, elements, q.reshape(shape))
    for k in range(len(nodes)):
        set_correction_target(learning, nodes[k])
    for k in range(len(elements)):
        set_correction_target(learning, elements[k])
    if worst < tolerance:
        return worst
    reduce_right_hand_side(axes, nodes, elements, CORRECTION)
    substitute(axes, nodes, (0,), CORRECTION)
    expand_solution(axes, nodes, elements, CORRECTION, correction.reshape(shape))
    return worst


@inlined
def gauge_chain(chain, external, q, v, a, force, gauges):
    """Arguments: see `gauge`; of the chain alone, links left out."""
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    shape = (len(nodes), 2, len(axes))
    known, rates = q.reshape(shape), v.reshape(shape)
    for i in range(len(q)):
        force[i] = external[i]
    gauges[KINETIC] = kinetic_energy(axes, nodes, elements, rates)
    gauges[ELASTIC] = elastic_energy(chain, known)
    gauges[AGITATION] = kinetic_energy(axes, nodes, elements, a.reshape(shape))
    gauges[POWER] = dissipative_power(axes, nodes, elements, known, rates)
    gauges[VIOLATION] = set_violations(axes, nodes, elements, known)


@implements(gauge, CableSystem)
def gauge_cable(system, external, q, v, a, force, gauges):
    """Arguments: see `gauge`."""
    gauge_chain(system.chain, external, q, v, a, force, gauges)
