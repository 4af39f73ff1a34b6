"""The cables of a scene as one system, and what joints ask of them: responses, dispatched on its type."""

from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from ..cable.chain import Chain
from ..cable.index_reduction import CableSystem
from ..cable.linear_response import constrained_inverse
from ..cable.linked_cable import LinkedCableSystem
from ..compiled import dispatched, inlined
from ..system import accelerate_and_project, correct_position, implements, index_reduced_rates
from .nodes import set_blocks


class NoCables(NamedTuple):
    """The system of the cables of a scene that has none.   size: 0."""

    size: int = 0


class TwoKinds(NamedTuple):
    """Cables of two kinds, one after the other, each of which may be several; it is not nested.

    dofs, external: of the first one, numbers of coordinates and of what it takes as external force.
    """

    first: Any
    second: Any
    dofs: int
    external: int


class Alike(NamedTuple):
    """Cables of one kind, one after the other, that cannot share records, as they have links of their own.

    systems: one of each.   dofs, external: (k + 1,) where their coordinates and external forces begin.
    """

    systems: tuple[Any, ...]
    dofs: np.ndarray
    external: np.ndarray


def each_chain(system: Any, dofs: int = 0, external: int = 0) -> list[tuple[int, int, Any]]:
    """Systems of one chain, and where their coordinates and external forces begin in those of all."""
    if isinstance(system, NoCables):
        return []
    if isinstance(system, TwoKinds):
        others = each_chain(system.second, dofs + system.dofs, external + system.external)
        return each_chain(system.first, dofs, external) + others
    if isinstance(system, Alike):
        begins = zip(system.dofs.tolist(), system.external.tolist(), system.systems, strict=False)
        return [(dofs + own, external + other, one) for own, other, one in begins]
    return [(dofs, external, system)]


@dispatched
@singledispatch
def respond_with_cables(system, joints, start, end, offset):
    """A^-1 J^T of what the solve holds of cables, see `joints.Holds`, and A of its nodes.

    Args:
        system: of the cables, factorised.   joints: with their Jacobian.   start, end: which holds.
        offset: first coordinate of the system.

    Raises:
        NotImplementedError: no such responses for the type of `system`.
    """
    raise NotImplementedError(f"no responses to joints for {type(system).__name__}")


@implements(respond_with_cables, CableSystem)
def respond_with_chain(system, joints, start, end, offset):
    """Each hold lies on one cable of the chain. Arguments: see `respond_with_cables`."""
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    set_blocks(axes, nodes, elements, joints.nodes, offset)
    size = 2 * len(axes)
    entries, holds = joints.entries, joints.holds
    for h in range(start, end):
        e = holds.entry[h]
        left, number = (entries.dof[e] - offset) // size, entries.width[e] // size
        alone = Chain(axes, nodes[left : left + number], elements[left : left + number - 1])
        shape = (number, 2, len(axes))
        first, last = entries.first[e], entries.first[e] + entries.width[e]
        constrained_inverse(
            CableSystem(alone, system.zeta),
            entries.jacobian[first:last].reshape(shape),
            entries.response[first:last].reshape(shape),
        )


@implements(respond_with_cables, LinkedCableSystem)
def respond_with_linked_cable(system, joints, start, end, offset):
    """Arguments: see `respond_with_cables`."""
    shape = (len(system.chain.nodes), 2, len(system.chain.axes))
    entries, holds = joints.entries, joints.holds
    for h in range(start, end):
        e = holds.entry[h]
        first, last = entries.first[e], entries.first[e] + entries.width[e]
        constrained_inverse(
            system, entries.jacobian[first:last].reshape(shape), entries.response[first:last].reshape(shape)
        )


@inlined
def clear_if_fulfilled(violation, tolerance, correction):
    """Where a violation is below the tolerance, `correct_position` has not set the correction."""
    if violation < tolerance:
        for i in range(len(correction)):
            correction[i] = 0.0


@implements(respond_with_cables, NoCables)
def respond_with_none(system, joints, start, end, offset):
    """There are no holds on cables."""


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


@implements(respond_with_cables, TwoKinds)
def respond_with_two_kinds(system, joints, start, end, offset):
    """Arguments: see `respond_with_cables`."""
    middle = start
    while middle < end and joints.entries.dof[joints.holds.entry[middle]] < offset + system.dofs:
        middle += 1
    respond_with_cables(system.first, joints, start, middle, offset)
    respond_with_cables(system.second, joints, middle, end, offset + system.dofs)


@implements(index_reduced_rates, TwoKinds)
def rates_of_two_kinds(system, external, q, v, acceleration, rate):
    """Arguments: see `index_reduced_rates`."""
    n, m = system.dofs, system.external
    index_reduced_rates(system.first, external[:m], q[:n], v[:n], acceleration[:n], rate[:n])
    index_reduced_rates(system.second, external[m:], q[n:], v[n:], acceleration[n:], rate[n:])


@implements(accelerate_and_project, TwoKinds)
def accelerate_two_kinds(system, external, q, v, duration, acceleration, end_velocity):
    """Arguments: see `accelerate_and_project`."""
    n, m, h = system.dofs, system.external, duration
    accelerate_and_project(system.first, external[:m], q[:n], v[:n], h, acceleration[:n], end_velocity[:n])
    accelerate_and_project(system.second, external[m:], q[n:], v[n:], h, acceleration[n:], end_velocity[n:])


@implements(correct_position, TwoKinds)
def correct_two_kinds(system, external, q, tolerance, learning, correction):
    """Arguments: see `correct_position`."""
    n, m = system.dofs, system.external
    one = correct_position(system.first, external[:m], q[:n], tolerance, learning, correction[:n])
    other = correct_position(system.second, external[m:], q[n:], tolerance, learning, correction[n:])
    clear_if_fulfilled(one, tolerance, correction[:n])
    clear_if_fulfilled(other, tolerance, correction[n:])
    return other if not other <= one else one  # keeps a NaN


@implements(respond_with_cables, Alike)
def respond_with_alike(system, joints, start, end, offset):
    """Arguments: see `respond_with_cables`."""
    first = start
    for k in range(len(system.systems)):
        last = first
        while last < end and joints.entries.dof[joints.holds.entry[last]] < offset + system.dofs[k + 1]:
            last += 1
        respond_with_cables(system.systems[k], joints, first, last, offset + system.dofs[k])
        first = last


@implements(index_reduced_rates, Alike)
def rates_of_alike(system, external, q, v, acceleration, rate):
    """Arguments: see `index_reduced_rates`."""
    for k in range(len(system.systems)):
        i, j = system.dofs[k], system.dofs[k + 1]
        own = external[system.external[k] : system.external[k + 1]]
        index_reduced_rates(system.systems[k], own, q[i:j], v[i:j], acceleration[i:j], rate[i:j])


@implements(accelerate_and_project, Alike)
def accelerate_alike(system, external, q, v, duration, acceleration, end_velocity):
    """Arguments: see `accelerate_and_project`."""
    for k in range(len(system.systems)):
        i, j = system.dofs[k], system.dofs[k + 1]
        own, one = external[system.external[k] : system.external[k + 1]], system.systems[k]
        accelerate_and_project(one, own, q[i:j], v[i:j], duration, acceleration[i:j], end_velocity[i:j])


@implements(correct_position, Alike)
def correct_alike(system, external, q, tolerance, learning, correction):
    """Arguments: see `correct_position`."""
    worst = 0.0
    for k in range(len(system.systems)):
        i, j = system.dofs[k], system.dofs[k + 1]
        own = external[system.external[k] : system.external[k + 1]]
        one = correct_position(system.systems[k], own, q[i:j], tolerance, learning, correction[i:j])
        clear_if_fulfilled(one, tolerance, correction[i:j])
        if not one <= worst:  # keeps a NaN
            worst = one
    return worst
