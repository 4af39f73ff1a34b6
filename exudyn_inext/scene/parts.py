"""What the coupling asks of a part besides the protocols of `system`: its response to joint forces."""

from functools import singledispatch

from ..cable.chain import Chain
from ..cable.index_reduction import CableSystem
from ..cable.linear_response import constrained_inverse
from ..cable.linked_cable import LinkedCableSystem
from ..compiled import kernel


@singledispatch
def respond(system, jacobian, response):
    """response_r = A^-1 J_r^T: acceleration of the part, on its own constraints, under a unit joint force.

    Args:
        system: just evaluated by a protocol of `system`, so that it is factorised.
        jacobian: (rows, n_dof) of joints with respect to the coordinates of the part.
        response: (rows, n_dof) output.

    Raises:
        NotImplementedError: no response for the type of `system`.
    """
    raise NotImplementedError(f"no response to joint forces for {type(system).__name__}")


@kernel
def _respond_as_chain(system, jacobian, response):
    shape = (len(jacobian), len(system.chain.nodes), 2, len(system.chain.axes))
    forces, accelerations = jacobian.reshape(shape), response.reshape(shape)
    for row in range(len(forces)):
        constrained_inverse(system, forces[row], accelerations[row])


@kernel
def respond_in_chain(system, first, width, dof, jacobian, response):
    """As `respond`, for rows on single cables of a chain of many.

    Args:
        system: of all cables.
        first, width: (rows,) where each row begins in `jacobian` and `response`, and how long it is.
        dof: (rows,) the first coordinate of its cable in the chain.
        jacobian, response: (sum of the widths,).
    """
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    size = 2 * len(axes)
    for row in range(len(first)):
        left, number = dof[row] // size, width[row] // size
        alone = Chain(axes, nodes[left : left + number], elements[left : left + number - 1])
        shape = (number, 2, len(axes))
        places = slice(first[row], first[row] + width[row])
        constrained_inverse(
            CableSystem(alone, system.zeta), jacobian[places].reshape(shape), response[places].reshape(shape)
        )


respond.register(CableSystem)(_respond_as_chain)
respond.register(LinkedCableSystem)(_respond_as_chain)
