"""Many cables in one set of records: one call of the kernels evaluates all of them.

Between the last node of a cable and the first one of the next lies an element of nothing: without mass,
stiffness and length. The factorisation passes it without coupling the two.
"""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from ..arrays import Array, copy_of
from .cable import Cable
from .chain import Chain, set_constrained_lengths
from .implicit_bending import EXPLICIT, ImplicitBending
from .index_reduction import CableSystem
from .linked_cable import cable_system
from .links import all_links

Systems = tuple[Any, list[Any]]
"""One for all of some cables, and those of the cables, which share its memory."""

MOST_KNOWN = 16
_KNOWN: dict[Any, Any] = {}  # as they were built, by all that decides on them but the lengths


def cable_systems(cables: Sequence[Cable], zeta: float, implicit: ImplicitBending = EXPLICIT) -> list[Any]:
    """As `cable_system`, of each; what cables have in common, also with earlier ones, is computed once."""
    return [_system_of(cable, zeta, implicit) for cable in cables]


def _system_of(cable: Cable, zeta: float, implicit: ImplicitBending) -> Any:
    coefficients = _coefficients(cable)
    if coefficients is None:
        return cable_system(cable, zeta, implicit)
    key = coefficients, zeta, implicit
    if key not in _KNOWN:
        if len(_KNOWN) == MOST_KNOWN:
            _KNOWN.clear()
        _KNOWN[key] = cable_system(cable, zeta, implicit)
    known = _KNOWN[key]
    system = _with(known, copy_of(known.chain.nodes), copy_of(known.chain.elements))
    set_constrained_lengths(cable, system.chain.elements)
    return system


def _coefficients(cable: Cable) -> Any:
    """The same for cables whose systems differ in constrained lengths alone; None: there are no others."""
    section = cable.section
    if section.strain_is_relative or all_links(cable):
        return None
    mesh = cable.dimension, cable.element_lengths.tobytes(), cable.fixed.tobytes()
    attached = cable.point_masses, cable.drag, cable.pressed
    return mesh, section, cable.measure, cable.length_constraints, attached


def in_few_chains(systems: Sequence[Any]) -> list[Systems]:
    """Systems of cables, those that follow each other and are of one kind put into one chain."""
    groups = [list(alike) for _, alike in groupby(systems, key=_kind)]
    return [_in_one_chain(alike) if len(alike) > 1 else (alike[0], alike) for alike in groups]


def _kind(system: Any) -> Any:
    """The same for cables that one chain can hold.

    Drag divides by the length of an element's slope, and a cable without length constraints hands on one that
    is never fulfilled: both remain alone.
    """
    is_alone = not isinstance(system, CableSystem) or system.chain.elements["dragged"][0]
    if is_alone or not system.chain.nodes["ends_group"][-1]:
        return id(system)
    chain = system.chain
    damping = bool(chain.elements["damped"][0]), float(chain.elements["lag"][0])
    return system.zeta, chain.nodes.dtype, chain.elements.dtype, damping


def _in_one_chain(systems: Sequence[CableSystem]) -> Systems:
    chains = [system.chain for system in systems]
    nodes, parts_of_nodes = _side_by_side([chain.nodes for chain in chains], gap=0)
    elements, parts_of_elements = _side_by_side([chain.elements for chain in chains], gap=1)
    parts = zip(systems, parts_of_nodes, parts_of_elements, strict=True)
    first = systems[0]
    return _with(first, nodes, elements[:-1]), [_with(*part) for part in parts]


def in_one(chains: Sequence[Chain]) -> Chain:
    """One chain of all."""
    if len(chains) == 1:
        return chains[0]
    nodes, _ = _side_by_side([chain.nodes for chain in chains], gap=0)
    elements, _ = _side_by_side([chain.elements for chain in chains], gap=1)
    return chains[0]._replace(nodes=nodes, elements=elements[:-1])


def _with(system: CableSystem, nodes: Any, elements: Any) -> CableSystem:
    """The same system with its records elsewhere."""
    return system._replace(chain=system.chain._replace(nodes=nodes, elements=elements))


def _side_by_side(arrays: Sequence[Array], gap: int) -> tuple[Array, list[Array]]:
    """All in one, each followed by a gap of zeros; and their parts of it."""
    total = np.zeros(sum(len(array) + gap for array in arrays), arrays[0].dtype)
    ends = np.cumsum([len(array) + gap for array in arrays])
    parts = [total[end - gap - len(array) : end - gap] for end, array in zip(ends, arrays, strict=True)]
    for part, array in zip(parts, arrays, strict=True):
        part[...] = array
    return total, parts
