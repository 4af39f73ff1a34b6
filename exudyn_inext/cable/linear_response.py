"""What small vibrations and joints need of a system: operators, dispatched on its type as in `system`."""

from typing import Any

from ..called_system import by_address, call_protocol, calls, has_nothing, implements
from ..compiled import inlined, protocol
from ..lowered import COUNT, VECTOR
from .assembly import add_lagging_damping
from .chain import Chain
from .index_reduction import ACCELERATION, CableSystem, solve_one
from .linked_cable import LinkedCableSystem
from .saddle_point import solve_for_force


@protocol
def constrained_inverse(system, force, x):
    """x = constrained M^-1 force: M x + C_q^T lam = force, C_q x = 0.

    Args:
        system: factorised.
        force: (n, 2, dim) [N, Nm].   x: (n, 2, dim) output.
    """


@protocol
def respond(system, first, force, response):
    """`constrained_inverse` of one of the cables that make up a chain: its response to a joint force.

    Args:
        system: of the chain, factorised.   first: coordinate of the cable in it.
        force: (w,) on the w coordinates of the cable [N, Nm].   response: (w,) output.
    """


RESPONSE = by_address(respond, COUNT, VECTOR, VECTOR)


@calls(respond)
def respond_called(system, first, force, response):
    call_protocol(system, RESPONSE, (first, force, response))


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


@protocol
def add_link_stiffness(system, multiplier, x, y):
    """y += sum nu d2c/dq2 x over the links of a system.   multiplier: (m,) nu; x, y: (n, 2, dim)."""


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


@protocol
def _hold_links(system):
    """Targets of zero for the links of a system."""


has_nothing(CableSystem, _hold_links)


@implements(_hold_links, LinkedCableSystem)
def _hold_all_links(system):
    links = system.link_system.links
    for r in range(len(links)):
        links[r].target[ACCELERATION] = 0.0


@implements(constrained_inverse, CableSystem)
def constrained_inverse_of_cable(system, force, x):
    solve_for_force(system.chain.axes, system.chain.nodes, system.chain.elements, force, x)


@implements(constrained_inverse, LinkedCableSystem)
def constrained_inverse_of_linked_cable(system, force, x):
    _set_right_hand_side(system.chain.axes, system.chain.nodes, system.chain.elements, 1.0, force)
    _hold_links(system)
    solve_one(system, ACCELERATION, x)


@implements(improve_damping, CableSystem, LinkedCableSystem)
def improve_damping_of_cable(system, q, x):
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    shape = (len(nodes), 2, len(axes))
    _set_right_hand_side(axes, nodes, elements, 0.0, x.reshape(shape))
    add_lagging_damping(axes, nodes, elements, q.reshape(shape), x.reshape(shape), ACCELERATION)
    _hold_links(system)
    solve_one(system, ACCELERATION, x.reshape(shape))


@implements(respond, CableSystem)
def respond_in_chain(system, first, force, response):
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    left, number = first // (2 * len(axes)), len(force) // (2 * len(axes))
    alone = Chain(axes, nodes[left : left + number], elements[left : left + number - 1])
    shape = (number, 2, len(axes))
    constrained_inverse(CableSystem(alone, system.zeta), force.reshape(shape), response.reshape(shape))


@implements(respond, LinkedCableSystem)
def respond_of_linked_cable(system, first, force, response):
    """Arguments: see `respond`; such a cable is a chain of its own."""
    shape = (len(system.chain.nodes), 2, len(system.chain.axes))
    constrained_inverse(system, force.reshape(shape), response.reshape(shape))


has_nothing(CableSystem, add_link_stiffness)


@implements(add_link_stiffness, LinkedCableSystem)
def add_rod_stiffness(system, multiplier, x, y):
    """d2c/dq2 = w w^T / L. Arguments: see `add_link_stiffness`."""
    links = system.link_system.links
    for r in range(len(links)):
        link = links[r]
        for i in range(x.shape[2]):
            u = 0.0
            for t in range(2):
                k = link.node[t]
                u += link.weight[t, 0] * x[k, 0, i] + link.weight[t, 1] * x[k, 1, i]
            u *= multiplier[r] * link.inverse_length
            for t in range(2):
                k = link.node[t]
                y[k, 0, i] += link.weight[t, 0] * u
                y[k, 1, i] += link.weight[t, 1] * u
