"""Links of a chain: the structured solve bordered by a few rows, by Schur complement.

With A the saddle-point matrix of the chain, factorised in O(N), and B the Jacobian of m links,

    [A B^T; B 0] [y; nu] = [f; b]:    S nu = B A^-1 f - b,  S = B A^-1 B^T,  y = A^-1 f - A^-1 B^T nu

costs one more substitution for each link and a small dense Cholesky factorisation. A link whose pivot in S
vanishes depends on the other constraints.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from .assembly import GAMMA, RATE, VALUE
from .cable import Cable
from .link import Link, Motion, rest
from .records import link_type
from .saddle_point import solve_reduced

CLOSURE = "closure"


class LinkSystem(NamedTuple):
    """The links of a chain and the memory of their solve.

    links: (m,) records of `records.link_type`.
    response: (m + 1, n, 2 dim) A^-1 B^T in the reduced unknowns of each node.
    schur: (m, m) lower L of S = L L^T; its diagonal holds L's, not its inverse.
    """

    links: Any
    response: Array
    schur: Array


def all_links(cable: Cable) -> tuple[Link, ...]:
    """The links of `cable`, those that close it included."""
    return (*closure_links(cable), *cable.links)


def closure_links(cable: Cable) -> list[Link]:
    """First and last node coincide: positions, and slopes transverse to the first one.

    Along the slope both nodes fulfil the same constraint (18), or, with axial stiffness, all of it is joined.
    """
    if not cable.closed:
        return []
    last, dim = len(cable.reference) - 1, cable.dimension
    origin = rest(np.zeros(dim))
    on_position = np.array([[1.0, 0.0], [-1.0, 0.0]])
    links = []
    if not cable.fixed[0, 0]:
        links += [Link(CLOSURE, (0, last), on_position, origin, axis) for axis in np.eye(dim)]
    on_slope, unknown = on_position[:, ::-1], np.zeros(dim)
    if not cable.fixed[0, 1] and cable.stretches:
        links += [Link(CLOSURE, (0, last), on_slope, origin, axis) for axis in np.eye(dim)]
    elif not cable.fixed[0, 1]:
        links += [Link(CLOSURE, (0, last), on_slope, origin, unknown, follows=j) for j in range(dim - 1)]
    return links


def motions_of(links: tuple[Link, ...]) -> list[Motion]:
    """The different anchors of the links, in the order of their first use."""
    return list({id(link.anchor): link.anchor for link in links}.values())


def build_link_system(cable: Cable) -> LinkSystem:
    """Coefficients of the links of `cable`, and memory for their solves."""
    links = all_links(cable)
    records = np.zeros(len(links), link_type(cable.dimension))
    places = {id(motion): k for k, motion in enumerate(motions_of(links))}
    for link, record in zip(links, records, strict=True):
        record.node = (*link.nodes, link.nodes[-1])[:2]
        record.weight[: len(link.nodes)] = link.weights
        record.normal = link.normal
        record.inverse_length = 1.0 / link.length
        record.length = link.length if np.isfinite(link.length) else 0.0
        record.follows = link.follows
        record.motion = places[id(link.anchor)]
        record.scale = 1.0 / cable.element_lengths[min(link.nodes[0], cable.number_of_elements - 1)]
    number, size = len(links), 2 * cable.dimension
    response = np.zeros((number + 1, len(cable.reference), size))
    return LinkSystem(records, response, np.zeros((number, number)))


@inlined
def _set_offset(axes, link, q, motions):
    """u of the link at q into its record; returns the value c(q, t)."""
    value = -0.5 * link.length
    for i in range(len(axes)):
        u = -motions[link.motion, 0, i]
        for t in range(2):
            k = link.node[t]
            u += link.weight[t, 0] * q[k, 0, i] + link.weight[t, 1] * q[k, 1, i]
        link.offset[i] = u
        value += u * (link.normal[i] + 0.5 * u * link.inverse_length)
    return value


@inlined
def _set_terms(axes, nodes, link, v, motions):
    """Gradient, rate c_q v + c_t and gamma (27) of a link whose offset is set."""
    rate, gamma = 0.0, 0.0
    for i in range(len(axes)):
        direction = link.normal[i] + link.offset[i] * link.inverse_length
        u_t = -motions[link.motion, 1, i]
        for t in range(2):
            k = link.node[t]
            u_t += link.weight[t, 0] * v[k, 0, i] + link.weight[t, 1] * v[k, 1, i]
            link.gradient[t, 0, i] = nodes[k].free[0] * link.weight[t, 0] * direction
            link.gradient[t, 1, i] = nodes[k].free[1] * link.weight[t, 1] * direction
        rate += direction * u_t
        gamma += direction * motions[link.motion, 2, i] - u_t * u_t * link.inverse_length
    link.constraint[RATE] = rate
    link.constraint[GAMMA] = gamma


@inlined
def assemble_links(axes, nodes, links, q, v, motions, set_targets, parameter):
    """Values, rates, gamma (27), (28) and gradients of all links; the nodes' bases are set.

    Args:
        q, v: (n, 2, dim).   motions: (M, 3, dim) p, p_t, p_tt of the anchors.
        set_targets, parameter: see `assembly.assemble`.
    """
    for r in range(len(links)):
        link = links[r]
        if link.follows >= 0:
            for i in range(len(axes)):
                link.normal[i] = nodes[link.node[0]].basis[i, link.follows]
        link.constraint[VALUE] = _set_offset(axes, link, q, motions)
        _set_terms(axes, nodes, link, v, motions)
        set_targets(parameter, link)


@inlined
def set_link_violations(axes, links, q, motions, set_targets, parameter):
    """Values of the links at q into the records; returns the largest, lengths relative.

    Arguments: see `assemble_links`.
    """
    worst = 0.0
    for r in range(len(links)):
        value = _set_offset(axes, links[r], q, motions)
        links[r].constraint[VALUE] = value
        set_targets(parameter, links[r])
        worst = max(worst, abs(value) * links[r].scale)
    return worst


@inlined
def _times_gradient(axes, nodes, link, y):
    """B_r y of one link.   y: (n, 2 dim) reduced unknowns."""
    dim = len(axes)
    total = 0.0
    for t in range(2):
        k = link.node[t]
        node = nodes[k]
        for i in range(dim):
            total += link.gradient[t, 0, i] * y[k, i]
            for j in range(node.basis.shape[1]):
                total += link.gradient[t, 1, i] * node.basis[i, j] * y[k, dim + j]
    return total


@inlined
def _set_unit_force(axes, nodes, link, column):
    """`solution` of the link's nodes += its row of the Jacobian in reduced unknowns."""
    dim = len(axes)
    for t in range(2):
        node = nodes[link.node[t]]
        for i in range(dim):
            node.solution[column, i] += link.gradient[t, 0, i]
            for j in range(node.basis.shape[1]):
                node.solution[column, dim + j] += link.gradient[t, 1, i] * node.basis[i, j]


@inlined
def _set_responses(axes, nodes, link_system):
    """A^-1 B^T, two columns at once."""
    links, response = link_system.links, link_system.response
    size = 2 * len(axes)
    for first in range(0, len(links), 2):
        pair = min(2, len(links) - first)
        for k in range(len(nodes)):
            for c in range(2):
                for i in range(size):
                    nodes[k].solution[c, i] = 0.0
        for c in range(pair):
            _set_unit_force(axes, nodes, links[first + c], c)
        solve_reduced(axes, nodes, (0, 1), response[first : first + 2])


@inlined
def factorise_links(axes, nodes, link_system):
    """S = L L^T; the chain is factorised and the links are assembled. Destroys `solution`."""
    _set_responses(axes, nodes, link_system)
    links, response, schur = link_system.links, link_system.response, link_system.schur
    for r in range(len(links)):
        link = links[r]
        for c in range(r + 1):
            schur[r, c] = _times_gradient(axes, nodes, link, response[c])
    for c in range(len(links)):
        for j in range(c):
            schur[c, c] -= schur[c, j] * schur[c, j]
        schur[c, c] = np.sqrt(schur[c, c])
        for r in range(c + 1, len(links)):
            for j in range(c):
                schur[r, c] -= schur[r, j] * schur[c, j]
            schur[r, c] /= schur[c, c]


@inlined
def _violation_of_solution(axes, nodes, link, column):
    """B x - b of one link, x what the chain does without links, `along` the slopes included."""
    dim = len(axes)
    total = -link.target[column]
    for t in range(2):
        node = nodes[link.node[t]]
        for i in range(dim):
            total += link.gradient[t, 0, i] * node.solution[column, i]
            total += link.gradient[t, 1, i] * node.along[column] * node.slope[i]
            for j in range(node.basis.shape[1]):
                total += link.gradient[t, 1, i] * node.basis[i, j] * node.solution[column, dim + j]
    return total


@inlined
def _set_multipliers(axes, nodes, link_system, column):
    """S nu = B x - b for one column."""
    links, schur = link_system.links, link_system.schur
    number = len(links)
    for r in range(number):
        nu = _violation_of_solution(axes, nodes, links[r], column)
        for j in range(r):
            nu -= schur[r, j] * links[j].multiplier[column]
        links[r].multiplier[column] = nu / schur[r, r]
    for r in range(number - 1, -1, -1):
        nu = links[r].multiplier[column]
        for j in range(r + 1, number):
            nu -= schur[j, r] * links[j].multiplier[column]
        links[r].multiplier[column] = nu / schur[r, r]


@inlined
def apply_links(axes, nodes, link_system, columns, first):
    """Correct the chain's solution so that the links' targets are met.

    columns, first: see `saddle_point.substitute_forward`.
    """
    links, response = link_system.links, link_system.response
    for c in range(len(columns)):
        _set_multipliers(axes, nodes, link_system, first + c)
    for k in range(len(nodes)):
        for r in range(len(links)):
            for c in range(len(columns)):
                for i in range(2 * len(axes)):
                    nodes[k].solution[first + c, i] -= links[r].multiplier[first + c] * response[r, k, i]
