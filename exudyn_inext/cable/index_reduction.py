"""Index reduction of the chain, Eqs. (23)-(30): the DAE as an ODE, stabilised with rate zeta."""

from typing import NamedTuple

from ..called_system import implements
from ..compiled import inlined, kernel
from ..system import (
    ACCELERATION_ENERGY,
    ELASTIC,
    KINETIC,
    POWER,
    RESOLVED,
    VIOLATION,
    accelerate_and_project,
    correct_position,
    index_reduced_rates,
    report_energy,
)
from .assembly import (
    GAMMA,
    RATE,
    VALUE,
    add_damping,
    add_drag,
    add_lagging_damping,
    improves_alone,
    lag_of,
    leave_targets,
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
from .saddle_point import free_force, solve_both_columns, solve_column

ACCELERATION, CORRECTION = 0, 1  # columns of Eq. (29): v' with lam, and q' - v with mu


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


@kernel
def force_in_motion(chain, external, q, v, force):
    """force (n, 2, dim) of all but inertia and constraints at (q, v) [N, Nm].

    Args:
        chain: of a cable without supports; its axial forces, if it has any, are explicit.
        external: (n, 2, dim).   q, v: (n, 2, dim).
    """
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    assemble_forces(axes, nodes, elements, external, q, v, 0.0, v, leave_targets, 0.0)
    for k in range(len(nodes)):
        free_force(axes, nodes, elements, k, ACCELERATION, force[k])


@inlined
def assemble_and_factorise(axes, nodes, elements, external, q, v, lead, a, set_targets, parameter):
    """All of Eq. (29) but the links; arguments: see `assemble_forces`."""
    assemble_forces(axes, nodes, elements, external, q, v, lead, a, set_targets, parameter)
    factorise_chain(axes, nodes, elements, q)


@inlined
def _improve_damping(axes, nodes, elements, q, acceleration):
    """One more solve for the damping that is in the matrix on the left, but not in the cable: order 2.

    acceleration: (n, 2, dim), of a solve that took all of it.
    """
    if improves_alone(elements):
        add_lagging_damping(axes, nodes, elements, q, acceleration, ACCELERATION)
        solve_column(axes, nodes, elements, ACCELERATION, acceleration)


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
        axes,
        nodes,
        elements,
        external.reshape(shape),
        q.reshape(shape),
        known,
        0.0,
        acceleration.reshape(shape),
        set_stabilised_targets,
        system.zeta,
    )
    solve_both_columns(axes, nodes, elements, acceleration.reshape(shape), rate.reshape(shape))
    _improve_damping(axes, nodes, elements, q.reshape(shape), acceleration.reshape(shape))
    for i in range(len(v)):
        rate[i] += v[i]


@inlined
def set_projection_targets(duration, record):
    """C_q a = gamma, corrected by the last step; C_q d = -C_q (v + duration a) leads to the manifold."""
    terms = record.constraint
    record.target[ACCELERATION] = terms[GAMMA] + record.drift_correction
    record.target[CORRECTION] = -terms[RATE] - duration * record.target[ACCELERATION]


@inlined
def set_correction_target(learning, record):
    """Right-hand side -c of a step back to the manifold; see `correct_position` for what is learned."""
    violation = record.constraint[VALUE]
    record.target[CORRECTION] = -violation
    record.drift_correction -= learning * violation


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
        set_projection_targets,
        duration,
    )
    solve_both_columns(axes, nodes, elements, acceleration.reshape(shape), end_velocity.reshape(shape))
    _improve_damping(axes, nodes, elements, q.reshape(shape), acceleration.reshape(shape))
    for i in range(len(v)):
        end_velocity[i] += v[i] + duration * acceleration[i]


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
