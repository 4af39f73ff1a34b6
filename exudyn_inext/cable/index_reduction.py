"""Index reduction of the chain, Eqs. (23)-(30): the DAE as an ODE, stabilised with rate zeta."""

from typing import NamedTuple

from ..called_system import implements
from ..compiled import inlined, protocol
from ..system import (
    ACCELERATION_ENERGY,
    ELASTIC,
    KINETIC,
    POWER,
    RESOLVED,
    VIOLATION,
    correct_position,
    report_energy,
)
from .assembly import (
    ACCELERATION,
    CORRECTION,
    GAMMA,
    RATE,
    VALUE,
    add_damping,
    add_drag,
    lag_of,
)
from .axial import (
    aim_at_positions,
    assemble_chain,
    axial_power,
    factorise_chain,
    largest_violation,
    resolved_acceleration,
    stored_energy,
)
from .chain import Chain
from .energy import dissipative_power, kinetic_energy, lagging_energy
from .saddle_point import solve_both_columns, solve_column


class CableSystem(NamedTuple):
    """A chain and its stabilisation: the `system` of the integrators.

    chain: coefficients and memory.
    zeta: stabilisation rate of Eqs. (24)-(28) [1/s].
    """

    chain: Chain
    zeta: float


@inlined
def assemble_forces(axes, nodes, elements, external, q, v, lead, a, set_targets, parameter):
    """Forces and all that the constraints but the links need, into the records; see `assemble`.

    lead, a: damping and drag act at v + lead a; implicit damping takes its share of a from the left.
    """
    assemble_chain(axes, nodes, elements, external, q, v, lead, set_targets, parameter)
    add_damping(axes, nodes, elements, q, v, lead - lag_of(elements), a, ACCELERATION)
    add_drag(axes, nodes, elements, q, v, lead, a, ACCELERATION)


@protocol
def assemble_and_factorise(system, external, q, v, lead, a, set_targets, parameter):
    """All of Eq. (29) at (q, v) into the records of a cable; arguments: see `assemble_forces`, (n_dof,) each.

    external: with the motions of links behind it.
    """


@protocol
def solve_one(system, column, x):
    """x (n, 2, dim): the solution for one column of Eq. (29), of a system that is factorised."""


@protocol
def solve_both(system, x, y):
    """The same for both columns at once.   x, y: (n, 2, dim) for v' and for q' - v."""


@inlined
def factorise_at(chain, external, q, v, lead, a, set_targets, parameter):
    """See `assemble_and_factorise`; of the chain alone.   external: (n_dof,)."""
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    shape = (len(nodes), 2, len(axes))
    force, known = external.reshape(shape), q.reshape(shape)
    rates, lacking = v.reshape(shape), a.reshape(shape)
    assemble_forces(axes, nodes, elements, force, known, rates, lead, lacking, set_targets, parameter)
    factorise_chain(axes, nodes, elements, known)


@implements(assemble_and_factorise, CableSystem)
def assemble_and_factorise_cable(system, external, q, v, lead, a, set_targets, parameter):
    factorise_at(system.chain, external, q, v, lead, a, set_targets, parameter)


@implements(solve_one, CableSystem)
def solve_one_of_cable(system, column, x):
    solve_column(system.chain.axes, system.chain.nodes, system.chain.elements, column, x)


@implements(solve_both, CableSystem)
def solve_both_of_cable(system, x, y):
    solve_both_columns(system.chain.axes, system.chain.nodes, system.chain.elements, x, y)


@inlined
def set_targets(aim, record):
    """Right-hand sides of the constraint rows of Eq. (29), from c, c_q v and gamma.

    C_q a = gamma - zeta C_q v, and what the last step taught; C_q d = -zeta c - C_q (v + duration a).

    aim: zeta [1/s], share of what was taught, duration [s].
    """
    zeta, learned, duration = aim
    terms = record.constraint
    record.target[ACCELERATION] = terms[GAMMA] + learned * record.drift_correction - zeta * terms[RATE]
    record.target[CORRECTION] = -zeta * terms[VALUE] - terms[RATE] - duration * record.target[ACCELERATION]


@inlined
def set_correction_target(learning, record):
    """Right-hand side -c of a step back to the manifold; see `correct_position` for what is learned."""
    violation = record.constraint[VALUE]
    record.target[CORRECTION] = -violation
    record.drift_correction -= learning * violation


@implements(correct_position, CableSystem)
def correct_cable_position(system, external, q, tolerance, learning, correction):
    """One solve with the last factor. Arguments: see `correct_position`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    worst = aim_at_positions(axes, nodes, elements, q.reshape(shape), set_correction_target, learning)
    if not worst < tolerance:
        solve_column(axes, nodes, elements, CORRECTION, correction.reshape(shape))
    return worst


@inlined
def report_energy_of_chain(chain, external, q, v, a, force, energy_report):
    """Arguments: see `report_energy`; of the chain alone, links left out."""
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    shape = (len(nodes), 2, len(axes))
    known, rates = q.reshape(shape), v.reshape(shape)
    energy_report[KINETIC] = kinetic_energy(axes, nodes, elements, rates) - lagging_energy(
        axes, elements, rates
    )
    energy_report[ELASTIC] = stored_energy(axes, nodes, elements, chain, known, rates, a.reshape(shape))
    energy_report[ACCELERATION_ENERGY] = kinetic_energy(axes, nodes, elements, a.reshape(shape))
    energy_report[POWER] = dissipative_power(axes, nodes, elements, known, rates)
    energy_report[POWER] += axial_power(axes, nodes, elements, rates)
    energy_report[VIOLATION] = largest_violation(axes, nodes, elements, known)
    resolved = force.reshape(shape)  # as memory
    resolved_acceleration(axes, nodes, elements, a.reshape(shape), resolved)
    energy_report[RESOLVED] = kinetic_energy(axes, nodes, elements, resolved)
    for i in range(len(q)):
        force[i] = external[i]


@implements(report_energy, CableSystem)
def report_energy_of_cable(system, external, q, v, a, force, energy_report):
    report_energy_of_chain(system.chain, external, q, v, a, force, energy_report)
