"""The stiffness of a cable about a configuration: of bending, and of the tension in its constraints."""

from ..called_system import called_by_address, implements
from ..compiled import called_kernel, inlined, protocol
from ..element.inextensibility import length_gradient
from ..lowered import VECTOR, local_array
from .assembly import add_elastic_force, add_element_force, differences
from .index_reduction import CableSystem
from .linked_cable import LinkedCableSystem


@called_kernel
def combine(a, x, b, y, result):
    """result = a x + b y."""
    for i in range(len(x)):
        result[i] = a * x[i] + b * y[i]


@called_kernel
def inner(x, y):
    """Inner product."""
    total = 0.0
    for i in range(len(x)):
        total += x[i] * y[i]
    return total


@protocol
def apply_stiffness(system, nodal, length, links, q, x, memory, y):
    """y = H x: the elastic stiffness at q, and the geometric one of the constraints.

    Args:
        system: of a cable.
        nodal, length, links: (n,), (N,), (m,) multipliers of constraints at nodes, of lengths, of links.
        q, x: (n_dof,).   memory: (2 n_dof,).   y: (n_dof,) output.
    """


called_by_address(apply_stiffness, *[VECTOR] * 7)


@inlined
def _set_elastic_part(chain, shape, q, x, memory, y):
    """y = -(dQ_el/dq) x, exact: Q_el is cubic in q, so that two central differences suffice."""
    trial, force = memory[: len(q)], memory[len(q) :]
    combine(0.0, x, 0.0, x, y)
    for difference in range(4):
        step = 1.0 + difference // 2
        sign = 1.0 - 2.0 * (difference % 2)
        weight = -8.0 / 12.0 if difference < 2 else 1.0 / 12.0
        combine(1.0, q, sign * step, x, trial)
        combine(0.0, x, 0.0, x, force)
        add_elastic_force(chain, trial.reshape(shape), force.reshape(shape))
        combine(1.0, y, sign * weight, force, y)


@inlined
def _add_geometric_stiffness(chain, nodal, length, x, y):
    """y += sum lam d2c/dq2 x: the stiffness that the tension gives.   nodal: (n,); length: (N,)."""
    for k in range(len(nodal)):
        for i in range(len(chain.axes)):
            y[k, 1, i] += 2.0 * nodal[k] * x[k, 1, i]
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(length)):
        differences(chain.axes, x, k, e)
        length_gradient(chain.axes, chain.elements[k].slope_gram, e, gradient)
        for a in range(3):
            for i in range(len(chain.axes)):
                gradient[a, i] *= length[k]
        add_element_force(chain.axes, gradient, y[k], y[k + 1])


@inlined
def add_link_stiffness(links, multiplier, x, y):
    """y += sum nu d2c/dq2 x over the links, d2c/dq2 = w w^T / L.   multiplier: (m,) nu; x, y: (n, 2, dim)."""
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


@implements(apply_stiffness, CableSystem)
def apply_stiffness_of_chain(system, nodal, length, links, q, x, memory, y):
    shape = len(nodal), 2, len(system.chain.axes)
    _set_elastic_part(system.chain, shape, q, x, memory, y)
    _add_geometric_stiffness(system.chain, nodal, length, x.reshape(shape), y.reshape(shape))


@implements(apply_stiffness, LinkedCableSystem)
def apply_stiffness_of_linked_cable(system, nodal, length, links, q, x, memory, y):
    shape = len(nodal), 2, len(system.chain.axes)
    _set_elastic_part(system.chain, shape, q, x, memory, y)
    _add_geometric_stiffness(system.chain, nodal, length, x.reshape(shape), y.reshape(shape))
    add_link_stiffness(system.link_system.links, links, x.reshape(shape), y.reshape(shape))
