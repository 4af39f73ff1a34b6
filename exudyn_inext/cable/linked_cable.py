"""Index reduction of a chain with links: closed rings, hangers, nodes that follow a motion.

The external force is followed by the motions of the anchors: (n_dof + 3 dim M,) numbers, p, p_t, p_tt each.
"""

from typing import Any, NamedTuple

from ..called_system import implements
from ..compiled import inlined
from ..system import (
    POWER,
    VIOLATION,
    accelerate_and_project,
    correct_position,
    index_reduced_rates,
    report_energy,
)
from .assembly import add_lagging_damping, improves_alone, leave_targets
from .axial import aim_at_positions
from .axial_stiffness import MEAN_FORCE
from .cable import Cable
from .chain import Chain, build_chain
from .energy import power_of_motions
from .implicit_bending import EXPLICIT, ImplicitBending
from .index_reduction import (
    ACCELERATION,
    CORRECTION,
    CableSystem,
    assemble_and_factorise,
    report_energy_of_chain,
    set_correction_target,
    set_projection_targets,
    set_stabilised_targets,
)
from .links import (
    LinkSystem,
    all_links,
    apply_links,
    assemble_links,
    build_link_system,
    factorise_links,
    set_link_violations,
)
from .saddle_point import expand_solution, substitute_backward, substitute_forward


class LinkedCableSystem(NamedTuple):
    """A chain, its links and its stabilisation: a `system` of the integrators.

    chain: coefficients and memory.   link_system: links.   zeta: see `CableSystem` [1/s].
    closed: 1 if the last node is the first one once more, else 0.
    """

    chain: Chain
    link_system: LinkSystem
    zeta: float
    closed: int


def cable_system(
    cable: Cable, zeta: float, implicit: ImplicitBending = EXPLICIT
) -> CableSystem | LinkedCableSystem:
    """The index-reduced equations of `cable`; only with links they have to deal with links.

    Args:
        cable: the cable.   zeta: stabilisation rate [1/s].   implicit: see `set_mass`.
    """
    chain = build_chain(cable, implicit)
    if not all_links(cable):
        return CableSystem(chain, zeta)
    return LinkedCableSystem(chain, build_link_system(cable), zeta, int(cable.closed))


def memory_of(system: CableSystem | LinkedCableSystem) -> dict[str, Any]:
    """What earlier steps taught the constraints, by the records that hold them; arrays of the system."""
    records = {"nodes": system.chain.nodes, "elements": system.chain.elements}
    if isinstance(system, LinkedCableSystem):
        records["links"] = system.link_system.links
    memory = {name: held["drift_correction"] for name, held in records.items()}
    for name, held in records.items():
        if name != "links" and held["axial"].size:
            memory[f"axial {name}"] = held["axial"][:, MEAN_FORCE:]
    return memory


@inlined
def _shape_of_motions(axes, external, n_dof):
    """(M, 3, dim) of the motions of the anchors behind the force."""
    return (len(external) - n_dof) // (3 * len(axes)), 3, len(axes)


@inlined
def _assemble(axes, nodes, elements, link_system, external, q, v, lead, a, set_targets, parameter):
    """All of Eq. (29), links included, factorised. Arguments: see `assemble_and_factorise`."""
    shape = (len(nodes), 2, len(axes))
    n_dof = q.size
    known, rates = q.reshape(shape), v.reshape(shape)
    force = external[:n_dof].reshape(shape)
    assemble_and_factorise(
        axes, nodes, elements, force, known, rates, lead, a.reshape(shape), set_targets, parameter
    )
    motions = external[n_dof:].reshape(_shape_of_motions(axes, external, n_dof))
    assemble_links(axes, nodes, link_system.links, known, rates, motions, set_targets, parameter)
    factorise_links(axes, nodes, link_system)


@inlined
def _join_ends(closed, x):
    """Round-off must not separate the two ends of a closed cable.   x: (n, 2, dim)."""
    if closed:
        for i in range(x.shape[2]):
            x[len(x) - 1, 0, i] = x[0, 0, i]
            x[len(x) - 1, 1, i] = x[0, 1, i]


@inlined
def _substitute(system, columns, first):
    """`solution` of the chain with its links; arguments: see `saddle_point.substitute_forward`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    substitute_forward(axes, nodes, elements, columns, first)
    substitute_backward(axes, nodes, columns, first)
    apply_links(axes, nodes, system.link_system, columns, first)


@inlined
def _expand(system, column, x):
    expand_solution(system.chain.axes, system.chain.nodes, system.chain.elements, column, x)
    _join_ends(system.closed, x)


@inlined
def solve_linked_column(system, column, x):
    """`saddle_point.solve_column` with links, for a system that is factorised."""
    _substitute(system, (column,), column)
    _expand(system, column, x)


@inlined
def _solve_both_linked_columns(system, x, y):
    """The same for both columns at once.   x, y: (n, 2, dim) solutions for columns 0 and 1."""
    _substitute(system, (ACCELERATION, CORRECTION), ACCELERATION)
    _expand(system, ACCELERATION, x)
    _expand(system, CORRECTION, y)


@inlined
def _improve_damping(axes, nodes, elements, system, q, acceleration):
    """As `index_reduction._improve_damping`, with links."""
    if improves_alone(elements):
        add_lagging_damping(axes, nodes, elements, q, acceleration, ACCELERATION)
        solve_linked_column(system, ACCELERATION, acceleration)


@implements(index_reduced_rates, LinkedCableSystem)
def linked_rates(system, external, q, v, acceleration, rate):
    """Eq. (30). Arguments: see `index_reduced_rates`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    link_system = system.link_system
    shape = (len(nodes), 2, len(axes))
    targets = set_stabilised_targets
    _assemble(axes, nodes, elements, link_system, external, q, v, 0.0, acceleration, targets, system.zeta)
    _solve_both_linked_columns(system, acceleration.reshape(shape), rate.reshape(shape))
    _improve_damping(axes, nodes, elements, system, q.reshape(shape), acceleration.reshape(shape))
    for i in range(len(v)):
        rate[i] += v[i]


@implements(accelerate_and_project, LinkedCableSystem)
def accelerate_and_project_linked(system, external, q, v, duration, acceleration, end_velocity):
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    link_system = system.link_system
    shape = (len(nodes), 2, len(axes))
    _assemble(
        axes,
        nodes,
        elements,
        link_system,
        external,
        q,
        v,
        duration,
        acceleration,
        set_projection_targets,
        duration,
    )
    _solve_both_linked_columns(system, acceleration.reshape(shape), end_velocity.reshape(shape))
    _improve_damping(axes, nodes, elements, system, q.reshape(shape), acceleration.reshape(shape))
    for i in range(len(v)):
        end_velocity[i] += v[i] + duration * acceleration[i]


@implements(correct_position, LinkedCableSystem)
def correct_linked_position(system, external, q, tolerance, learning, correction):
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    links = system.link_system.links
    shape = (len(nodes), 2, len(axes))
    known = q.reshape(shape)
    worst = aim_at_positions(axes, nodes, elements, known, set_correction_target, learning)
    motions = external[q.size :].reshape(_shape_of_motions(axes, external, q.size))
    of_links = set_link_violations(axes, links, known, motions, set_correction_target, learning)
    worst = max(worst, of_links)
    if not worst < tolerance:
        solve_linked_column(system, CORRECTION, correction.reshape(shape))
    return worst


@implements(report_energy, LinkedCableSystem)
def report_energy_linked(system, external, q, v, a, force, energy_report):
    axes, links = system.chain.axes, system.link_system.links
    report_energy_of_chain(system.chain, external, q, v, a, force, energy_report)
    motions = external[q.size :].reshape(_shape_of_motions(axes, external, q.size))
    known = q.reshape((len(system.chain.nodes), 2, len(axes)))
    of_links = set_link_violations(axes, links, known, motions, leave_targets, 0.0)
    energy_report[VIOLATION] = max(energy_report[VIOLATION], of_links)
    energy_report[POWER] += power_of_motions(axes, links, motions)
