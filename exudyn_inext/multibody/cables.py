"""What joints ask of the cables of a scene: their responses, dispatched on their system's type."""

from functools import singledispatch
from typing import NamedTuple

from ..cable.chain import Chain
from ..cable.index_reduction import CableSystem
from ..cable.linear_response import constrained_inverse
from ..cable.linked_cable import LinkedCableSystem
from ..compiled import dispatched
from ..system import accelerate_and_project, correct_position, implements, index_reduced_rates


class NoCables(NamedTuple):
    """The system of the cables of a scene that has none.   size: 0."""

    size: int = 0


@dispatched
@singledispatch
def respond_with_cables(system, joints):
    """A^-1 J^T of all entries on cables, see `joints.Joints`.

    Args:
        system: of all cables, factorised.   joints: with their Jacobian.

    Raises:
        NotImplementedError: no such responses for the type of `system`.
    """
    raise NotImplementedError(f"no responses to joints for {type(system).__name__}")


@implements(respond_with_cables, CableSystem)
def respond_with_chain(system, joints):
    """Each row lies on one cable of the chain. Arguments: see `respond_with_cables`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    size = 2 * len(axes)
    for e in range(joints.on_cables):
        left, number = joints.dof[e] // size, joints.width[e] // size
        alone = Chain(axes, nodes[left : left + number], elements[left : left + number - 1])
        shape = (number, 2, len(axes))
        first, end = joints.first[e], joints.first[e] + joints.width[e]
        constrained_inverse(
            CableSystem(alone, system.zeta),
            joints.jacobian[first:end].reshape(shape),
            joints.response[first:end].reshape(shape),
        )


@implements(respond_with_cables, LinkedCableSystem)
def respond_with_linked_cable(system, joints):
    """Arguments: see `respond_with_cables`."""
    shape = (len(system.chain.nodes), 2, len(system.chain.axes))
    for e in range(joints.on_cables):
        first, end = joints.first[e], joints.first[e] + joints.width[e]
        constrained_inverse(
            system, joints.jacobian[first:end].reshape(shape), joints.response[first:end].reshape(shape)
        )


@implements(respond_with_cables, NoCables)
def respond_with_none(system, joints):
    """There are no entries on cables."""


@implements(index_reduced_rates, NoCables)
def rates_of_none(system, external, q, v, acceleration, rate):
    """Nothing moves."""


@implements(accelerate_and_project, NoCables)
def accelerate_none(system, external, q, v, duration, acceleration, end_velocity):
    """Nothing moves."""


@implements(correct_position, NoCables)
def correct_none(system, external, q, tolerance, learning, correction):
    """Nothing is violated."""
    return 0.0
