"""What small vibrations and joints need of a system: operators, dispatched on its type as in `system`."""

from typing import Any

from ..called_system import by_address, call_protocol, called_by_address, calls, implements
from ..compiled import inlined, protocol
from ..lowered import COUNT, VECTOR
from .assembly import ACCELERATION, add_lagging_damping
from .index_reduction import CableSystem, solve_one
from .linked_cable import LinkedCableSystem
from .saddle_point import solve_for_force


@protocol
def respond(system, first, force, response):
    """x = constrained M^-1 force: M x + C_q^T lam = force, C_q x = 0, of one of the cables of a chain.

    Args:
        system: of the chain, factorised.   first: coordinate of the cable in it.
        force: (w,) on the w coordinates of the cable [N, Nm].   response: (w,) output, x.
    """


called_by_address(respond, COUNT, VECTOR, VECTOR)


@protocol
def improve_damping(system, q, x):
    """What accelerations lack, as the bending damping of a chain is not all that is in its matrix.

    The second solve of `index_reduction`, for a chain on which joints act: they belong to the first one, and
    have to act on the second one, too.

    Args:
        system: factorised, see `leave_to_joints`.   q: (n,).
        x: (n,) accelerations with joints, and output: what has to be added to them.
    """


DAMPING = by_address(improve_damping, VECTOR, VECTOR)


@calls(improve_damping)
def improve_damping_called(system, q, x):
    call_protocol(system, DAMPING, (q, x))


def leave_to_joints(system: Any) -> bool:
    """Whether a part of a scene, on which joints act, needs `improve_damping`, from now on."""
    elements = system.chain.elements if hasattr(system, "chain") else None
    if elements is None or not elements["damped"][0] or elements["axial"].size:
        return False
    elements["joined"] = True
    return True


@inlined
def _set_right_hand_side(axes, nodes, elements, share, force):
    """That share of `force` (n, 2, dim), and targets of zero."""
    for k in range(len(nodes)):
        nodes[k].target[ACCELERATION] = 0.0
        for i in range(len(axes)):
            nodes[k].force[ACCELERATION, 0, i] = share * force[k, 0, i]
            nodes[k].force[ACCELERATION, 1, i] = share * force[k, 1, i]
    for k in range(len(elements)):
        elements[k].target[ACCELERATION] = 0.0


@inlined
def _hold_links(links):
    """Targets of zero for all links."""
    for r in range(len(links)):
        links[r].target[ACCELERATION] = 0.0


@inlined
def _aim_at_lagging_damping(chain, q, x):
    """Right-hand side of what accelerations x (n,) lack at q (n,)."""
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    shape = (len(nodes), 2, len(axes))
    _set_right_hand_side(axes, nodes, elements, 0.0, x.reshape(shape))
    add_lagging_damping(axes, nodes, elements, q.reshape(shape), x.reshape(shape))


@implements(improve_damping, CableSystem)
def improve_damping_of_cable(system, q, x):
    _aim_at_lagging_damping(system.chain, q, x)
    solve_one(system, ACCELERATION, x.reshape((len(system.chain.nodes), 2, len(system.chain.axes))))


@implements(improve_damping, LinkedCableSystem)
def improve_damping_of_linked_cable(system, q, x):
    _aim_at_lagging_damping(system.chain, q, x)
    _hold_links(system.link_system.links)
    solve_one(system, ACCELERATION, x.reshape((len(system.chain.nodes), 2, len(system.chain.axes))))


@implements(respond, CableSystem)
def respond_in_chain(system, first, force, response):
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    left, number = first // (2 * len(axes)), len(force) // (2 * len(axes))
    alone = axes, nodes[left : left + number], elements[left : left + number - 1]
    shape = (number, 2, len(axes))
    solve_for_force(*alone, force.reshape(shape), response.reshape(shape))


@implements(respond, LinkedCableSystem)
def respond_of_linked_cable(system, first, force, response):
    """Arguments: see `respond`; such a cable is a chain of its own."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    _set_right_hand_side(axes, nodes, elements, 1.0, force.reshape(shape))
    _hold_links(system.link_system.links)
    solve_one(system, ACCELERATION, response.reshape(shape))
