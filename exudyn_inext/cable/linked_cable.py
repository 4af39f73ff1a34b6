"""Index reduction of a chain with links: closed rings, hangers, nodes that follow a motion.

The external force is followed by the motions of the anchors: (n_dof + 3 dim M,) numbers, p, p_t, p_tt each.
"""

from typing import Any, NamedTuple

from ..called_system import accelerates, implements
from ..compiled import inlined
from ..system import (
    POWER,
    VIOLATION,
    correct_position,
    report_energy,
)
from .assembly import ACCELERATION, CORRECTION, add_lagging_damping, improves_alone, leave_targets
from .axial import aim_at_positions
from .axial_stiffness import MEAN_FORCE
from .cable import Cable
from .chain import Chain, build_chain
from .energy import power_of_motions
from .implicit_bending import EXPLICIT, ImplicitBending
from .index_reduction import (
    CableSystem,
    assemble_and_factorise,
    factorise_at,
    report_energy_of_chain,
    set_correction_target,
    set_targets,
    solve_both,
    solve_one,
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


@implements(assemble_and_factorise, LinkedCableSystem)
def assemble_and_factorise_linked(system, external, q, v, lead, a, set_targets, parameter):
    chain, link_system = system.chain, system.link_system
    factorise_at(chain, external[: q.size], q, v, lead, a, set_targets, parameter)
    axes, nodes, shape = chain.axes, chain.nodes, (len(chain.nodes), 2, len(chain.axes))
    motions = external[q.size :].reshape(_shape_of_motions(axes, external, q.size))
    known, rates = q.reshape(shape), v.reshape(shape)
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


@implements(solve_one, LinkedCableSystem)
def solve_one_of_linked_cable(system, column, x):
    _substitute(system, (column,), column)
    _expand(system, column, x)


@implements(solve_both, LinkedCableSystem)
def solve_both_of_linked_cable(system, x, y):
    _substitute(system, (ACCELERATION, CORRECTION), ACCELERATION)
    _expand(system, ACCELERATION, x)
    _expand(system, CORRECTION, y)


@inlined
def _solve(system, q, acceleration, change):
    """Both columns, and one more solve for damping that is in the matrix, but not in the cable: order 2.

    change: (n_dof,) output q' - v.
    """
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    solve_both(system, acceleration.reshape(shape), change.reshape(shape))
    if improves_alone(elements):
        found = acceleration.reshape(shape)
        add_lagging_damping(axes, nodes, elements, q.reshape(shape), found)
        solve_one(system, ACCELERATION, found)


@accelerates(CableSystem, LinkedCableSystem)
def accelerate_cable(system, external, q, v, duration, stabilises, acceleration, rate):
    """Eq. (29) with one factorisation for both columns. Arguments: see `accelerate`.

    q' is found as v plus a correction, M (q' - v) + C_q^T mu = 0: its force is zero.
    """
    aim = system.zeta if stabilises else 0.0, 1.0 - stabilises, duration
    assemble_and_factorise(system, external, q, v, duration, acceleration, set_targets, aim)
    _solve(system, q, acceleration, rate)
    for i in range(len(v)):
        rate[i] += v[i] + duration * acceleration[i]


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
        solve_one(system, CORRECTION, correction.reshape(shape))
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
