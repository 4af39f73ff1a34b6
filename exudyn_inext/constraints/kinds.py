"""The kinds of constraints (18)-(20) that a cable has, as quadratic forms."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import chain

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.link import Link, rest
from ..cable.links import all_links
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix
from .quadratic import Kind

HELD = {"pin": (0,), "guide": (1,), "clamp": (0, 1)}
"""Supports, and what they hold: 0 the position, 1 the slope."""

_OF_KIND = np.eye(2)[:, None]  # weights of a position, and of a slope
_DIFFERENCES = np.array([[-1.0, 1.0], [1.0, 0.0], [1.0, 0.0]])  # chord, left and right slope of an element
_OF_ELEMENT = np.array([[0, 2], [1, 1], [3, 3]])  # which of its vectors r, r_x left, r, r_x right


def nodal_inextensibility(cable: Cable) -> Kind:
    """Unit slope, Eq. (18), c = r_x . r_x - 1, where no support holds it, unless the cable stretches."""
    nodes = np.flatnonzero(~cable.fixed[:, 1] & (not cable.stretches))
    rows, ones = np.arange(len(nodes)), np.ones(len(nodes))
    points = np.zeros((len(nodes), cable.dimension))
    products = rows, rows, rows, ones
    name = "nodal inextensibility"
    return Kind(
        name,
        lambda row: f"slope of node {{{nodes[row]}}}",
        -ones,
        2 * nodes[:, None] + 1,
        ones[:, None],
        points,
        products,
    )


def length(cable: Cable) -> Kind:
    """Constant length of groups of elements, Eq. (19): the change of int |r_x|^2 dx, unless it stretches."""
    constrained = cable.length_constraints > 0 and not cable.stretches
    count = cable.number_of_elements if constrained else 0
    group = cable.group_of_element()[:count]
    places, weights, left, right = _vectors_of_elements(count)
    gram = forms_of_mesh(slope_gram_matrix, cable.element_lengths)[:count, [[2], [1], [3]], [2, 1, 3]]

    def where(row: int) -> str:
        own = np.flatnonzero(group == row)
        return f"elements between nodes {{{own[0]}}} and {{{own[-1] + 1}}}"

    constant = np.asarray(-np.bincount(group, cable.constrained_lengths()[:count]), dtype=float)
    points = np.zeros((3 * count, cable.dimension))
    products = np.repeat(group, 9), left, right, gram.ravel()
    return Kind("length", where, constant, places, weights, points, products)


@lru_cache(64)
def _vectors_of_elements(count: int) -> tuple[np.ndarray, Array, np.ndarray, np.ndarray]:
    """Places and weights (3 N, 2) of their vectors, and which ones (9 N,) are multiplied with which."""
    places = np.add.outer(2 * np.arange(count), _OF_ELEMENT).reshape(-1, 2)
    own = np.arange(3 * count).reshape(-1, 3)
    return places, np.tile(_DIFFERENCES, (count, 1)), np.repeat(own, 3), np.tile(own, 3).ravel()


def links_by_kind(cable: Cable, slope: Array | None) -> list[Kind]:
    """Supports, links of `cable`, and those that close it, all as links, see `cable.link`.

    slope: (dim,) across which the slopes of a ring's ends coincide; None: that of the reference.
    """
    normals = np.zeros((0, cable.dimension))
    if cable.closed:
        normals = np.linalg.svd((cable.reference[0, 1] if slope is None else slope)[None, :])[2][1:]
    by_kind: dict[str, list[Link]] = {}
    for link in chain(all_links(cable), _supports(cable)):
        by_kind.setdefault(link.kind, []).append(link)
    return [_of_links(name, links, normals) for name, links in by_kind.items()]


def _supports(cable: Cable) -> list[Link]:
    """Of pins, guides and clamps."""
    names, units = {kinds: name for name, kinds in HELD.items()}, np.eye(cable.dimension)
    links = []
    for node in np.flatnonzero(cable.fixed.any(axis=1)).tolist():
        held = tuple(np.flatnonzero(cable.fixed[node]).tolist())
        for kind in held:
            place = rest(cable.reference[node, kind])
            links += [Link(names[held], (node,), _OF_KIND[kind], place, unit) for unit in units]
    return links


def _of_links(name: str, links: Sequence[Link], normals: Array) -> Kind:
    """c = n . u + (u . u - L^2) / (2 L): vectors u, then n.   normals: (k, dim) of those that follow."""
    number = len(links)
    constant, places, weights = np.zeros(number), np.zeros((2 * number, 4), int), np.zeros((2 * number, 4))
    points = np.zeros((2 * number, len(links[0].normal)))
    products = [(k, k, number + k, 1.0) for k in range(number)]
    for k, link in enumerate(links):
        if link.length < np.inf:
            constant[k] = -0.5 * link.length
            products.append((k, k, k, 0.5 / link.length))
        own = 2 * len(link.nodes)
        places[k, :own] = [2 * node + kind for node in link.nodes for kind in (0, 1)]
        weights[k, :own] = link.weights.ravel()
        points[number + k] = -(link.normal if link.follows < 0 else normals[link.follows])
        if link.anchor.rests:
            points[k] = link.anchor.at(0.0)[0]

    def what(row: int) -> str:
        link, axes = links[row], "".join("xyz"[i] for i in np.flatnonzero(points[number + row]))
        kind = ("position", "slope")[int(np.argmax(np.abs(link.weights[0])))]
        return f"{kind} {axes or 'distance'} of node {' and '.join(f'{{{node}}}' for node in link.nodes)}"

    def where(row: int) -> str:
        same = [what(other) for other in range(row)].count(what(row))
        return f"{what(row)} (row {same} there)" if same else what(row)

    moving = [(k, link.anchor) for k, link in enumerate(links) if not link.anchor.rests]
    columns = tuple(map(np.array, zip(*products, strict=True)))
    return Kind(name, where, constant, places, weights, points, columns, moving)
