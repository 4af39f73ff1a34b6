"""Index reduction of the chain, Eqs. (23)-(30): the DAE as an ODE, stabilised with rate zeta."""

from typing import NamedTuple

from ..compiled import inlined, local_array
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
    assemble_elements,
    assemble_nodes,
    elastic_energy,
    set_violations,
)
from .chain import Chain
from .energy import dissipative_power, kinetic_energy
from .saddle_point import (
    clear_front,
    clear_passed_on,
    expand_solution,
    factorise,
    reduce_right_hand_side,
    set_bases,
    set_increments_along,
    solve_column,
    substitute_backward,
    substitute_forward,
)

NODES_AT_ONCE = 32  # whose records stay in the fastest cache while all passes of a step go over them
ACCELERATION, CORRECTION = 0, 1  # columns of Eq. (29): v' with lam, and q' - v with mu


class CableSystem(NamedTuple):
    """A chain and its stabilisation: the `system` of the integrators.

    chain: coefficients and memory.
    zeta: stabilisation rate of Eqs. (24)-(28) [1/s].
    """

    chain: Chain
    zeta: float


@inlined
def _set_external_forces(axes, nodes, external, first, end):
    for k in range(first, end):
        for i in range(len(axes)):
            nodes[k].force[ACCELERATION, 0, i] = external[k, 0, i]
            nodes[k].force[ACCELERATION, 1, i] = external[k, 1, i]


@inlined
def _assemble_elements(axes, nodes, elements, q, v, lead, a, first, end):
    assemble_elements(axes, nodes, elements, q, v, ACCELERATION, first, end)
    add_damping(axes, nodes, elements, q, v, lead, a, ACCELERATION, first, end)
    add_drag(axes, nodes, elements, q, v, lead, a, ACCELERATION, first, end)


@inlined
def assemble_forces(axes, nodes, elements, external, q, v, lead, a):
    """Forces at (q, v) and all terms of the constraints but the links; damping and drag act at v + lead a."""
    _set_external_forces(axes, nodes, external, 0, len(nodes))
    assemble_nodes(axes, nodes, q, v, 0, len(nodes))
    _assemble_elements(axes, nodes, elements, q, v, lead, a, 0, len(elements))


@inlined
def _end_of_block(first, number):
    """(end, done): the nodes from `first` to before `end` come next; those before `done` have neighbours."""
    end = min(first + NODES_AT_ONCE, number)
    return end, end if end == number else end - 1


@inlined
def assemble_and_factorise(axes, nodes, elements, external, q, v, lead, a):
    """All of Eq. (29) but the links, block by block; arguments: see `assemble_forces`."""
    block, w = local_array(6, 6), local_array(6, 6)
    clear_front(axes, block, w)
    start = 0
    for first in range(0, len(nodes), NODES_AT_ONCE):
        end, done = _end_of_block(first, len(nodes))
        _set_external_forces(axes, nodes, external, first, end)
        assemble_nodes(axes, nodes, q, v, first, end)
        set_bases(axes, nodes, q, first, end)
        _assemble_elements(axes, nodes, elements, q, v, lead, a, start, min(done, len(elements)))
        factorise(axes, nodes, elements, block, w, start, done)
        start = done


@inlined
def _eliminate(axes, nodes, elements, external, q, v, lead, a, set_targets, parameter):
    """All of Eq. (29), factorised, and its right-hand sides substituted forward, block by block.

    Arguments: see `assemble_forces`.   set_targets: (parameter, record), of nodes and elements.
    """
    block, w, passed_on = local_array(6, 6), local_array(6, 6), local_array(2, 6)
    clear_front(axes, block, w)
    clear_passed_on(axes, (ACCELERATION, CORRECTION), passed_on)
    start = 0
    for first in range(0, len(nodes), NODES_AT_ONCE):
        end, done = _end_of_block(first, len(nodes))
        elements_end = min(done, len(elements))
        _set_external_forces(axes, nodes, external, first, end)
        assemble_nodes(axes, nodes, q, v, first, end)
        set_bases(axes, nodes, q, first, end)
        for k in range(first, end):
            set_targets(parameter, nodes[k])
        _assemble_elements(axes, nodes, elements, q, v, lead, a, start, elements_end)
        for k in range(start, elements_end):
            set_targets(parameter, elements[k])
        factorise(axes, nodes, elements, block, w, start, done)
        for column in (ACCELERATION, CORRECTION):
            set_increments_along(axes, nodes, column, first, end)
            reduce_right_hand_side(axes, nodes, elements, column, start, done)
        substitute_forward(axes, nodes, (ACCELERATION, CORRECTION), ACCELERATION, passed_on, start, done)
        start = done


@inlined
def _substitute_back(axes, nodes, elements, acceleration, correction):
    """(n, 2, dim) solutions, block by block from the last node on."""
    right = local_array(2, 6)
    clear_passed_on(axes, (ACCELERATION, CORRECTION), right)
    for end in range(len(nodes), 0, -NODES_AT_ONCE):
        first = max(end - NODES_AT_ONCE, 0)
        substitute_backward(axes, nodes, (ACCELERATION, CORRECTION), ACCELERATION, right, first, end)
        expand_solution(axes, nodes, elements, ACCELERATION, acceleration, first, end)
        expand_solution(axes, nodes, elements, CORRECTION, correction, first, end)


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
    force, known, rates = external.reshape(shape), q.reshape(shape), v.reshape(shape)
    _eliminate(axes, nodes, elements, force, known, rates, 0.0, rates, set_stabilised_targets, system.zeta)
    _substitute_back(axes, nodes, elements, acceleration.reshape(shape), rate.reshape(shape))
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
    force, known, rates = external.reshape(shape), q.reshape(shape), v.reshape(shape)
    a = acceleration.reshape(shape)
    _eliminate(axes, nodes, elements, force, known, rates, duration, a, set_projection_targets, duration)
    _substitute_back(axes, nodes, elements, a, end_velocity.reshape(shape))
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
    solve_column(axes, nodes, elements, CORRECTION, correction.reshape(shape))
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
