"""Sparse matrices of a whole cable, for statics and as plain formulas: no kernels."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..arrays import Array, SparseArray
from ..element.forms import forms_of_mesh
from ..element.inertia import mass_matrix
from ..sparse import Entries, Pattern
from .assembly import add_elastic_force
from .attached import mass_of_points
from .cable import Cable
from .chain import Chain
from .constraint_rows import unconstrained_force

STEP = 1e-3  # of differences [-]


def assembled(forms: Array, nodes: tuple[int, ...], dim: int) -> SparseArray:
    """(n_dof, n_dof) matrix of element forms (N, 4, 4) that act alike in every direction.

    nodes: numbers of them, of cables that follow each other.
    """
    return _pattern_of_forms(nodes, dim).matrix(np.repeat(forms.ravel(), dim))


def left_nodes(nodes: tuple[int, ...]) -> np.ndarray:
    """(N,) of all elements of cables that follow each other."""
    return np.delete(np.arange(sum(nodes)), np.cumsum(nodes) - 1)


@lru_cache(maxsize=64)
def _pattern_of_forms(nodes: tuple[int, ...], dim: int) -> Pattern:
    places = 2 * left_nodes(nodes)[:, None] + np.arange(4)
    both = np.broadcast_arrays(places[:, :, None], places[:, None, :])
    rows, columns = ((dim * one[..., None] + np.arange(dim)).ravel() for one in both)
    return Pattern(rows, columns, (2 * sum(nodes) * dim, 2 * sum(nodes) * dim))


def form_of_cable(cable: Cable, form: Callable[[float], Array]) -> SparseArray:
    """`assembled` form of all elements of `cable`."""
    return assembled(forms_of_mesh(form, cable.element_lengths), (len(cable.reference),), cable.dimension)


def masses_of_elements(cable: Cable) -> Array:
    """(N, 4, 4) point masses included, without mass scaling."""
    own = cable.section.mass_per_length * forms_of_mesh(mass_matrix, cable.element_lengths)
    return own + mass_of_points(cable.point_masses, cable.element_lengths)


def mass_of_cable(cable: Cable) -> SparseArray:
    """(n_dof, n_dof) mass matrix, point masses included, without mass scaling."""
    return assembled(masses_of_elements(cable), (len(cable.reference),), cable.dimension)


def mass_entries(cable: Cable) -> Entries:
    """Those of `mass_of_cable`."""
    pattern = _pattern_of_forms((len(cable.reference),), cable.dimension)
    return pattern.entries(np.repeat(masses_of_elements(cable).ravel(), cable.dimension))


def elastic_tangent(chain: Chain, q: Array, nodes: tuple[int, ...] = ()) -> SparseArray:
    """-dQ_el/dq (n_dof, n_dof) at q (n, 2, dim); exact: Q_el is cubic in q, long steps do.

    nodes: numbers of them, of cables in one chain; (): it is one cable.
    """

    def elastic_force(at: Array) -> Array:
        force = np.zeros_like(at)
        add_elastic_force(chain, at, force)
        return force

    return tangent_of(elastic_force, q, nodes, step=1.0)


def tangent_of(
    force: Callable[[Array], Array],
    q: Array,
    nodes: tuple[int, ...] = (),
    step: float = STEP,
    length: float = 1.0,
) -> SparseArray:
    """-dF/dq (n_dof, n_dof) of a smooth force (n, 2, dim) at q, by differences of order four.

    nodes: see `elastic_tangent`.   step: of slopes [-], and of positions over a length [m].
    """

    def apply(x: Array) -> Array:
        h = step * length if x[:, 0].any() else step
        near = force(q + h * x) - force(q - h * x)
        return (force(q + 2.0 * h * x) - force(q - 2.0 * h * x) - 8.0 * near) / (12.0 * h)

    return _matrix_of(apply, nodes or (len(q),), q.shape[2])


def damping_tangent(chain: Chain, q: Array) -> SparseArray:
    """-dQ_damping/dv (n_dof, n_dof) at q (n, 2, dim); exact: Q_damping is linear in v."""
    rest, force, elastic = np.zeros_like(q), np.zeros_like(q), np.zeros_like(q)
    unconstrained_force(chain, rest, q, rest, elastic)

    def apply(x: Array) -> Array:
        unconstrained_force(chain, rest, q, x, force)
        return elastic - force

    return _matrix_of(apply, (len(q),), q.shape[2])


def _matrix_of(apply: Callable[[Array], Array], nodes: tuple[int, ...], dim: int) -> SparseArray:
    """Matrix (n_dof, n_dof) of x (n, 2, dim) -> apply(x), where only neighbouring nodes of a cable interact.

    Nodes three apart do not: all columns are found with 6 dim products.
    """
    directions, exist, pattern = _products(nodes, dim)
    images = (apply(direction)[own] for direction, own in zip(directions, exist, strict=True))
    return pattern.matrix(np.concatenate([image.ravel() for image in images]))


@lru_cache(maxsize=64)
def _products(nodes: tuple[int, ...], dim: int) -> tuple[list[Array], list[np.ndarray], Pattern]:
    """The vectors of `_matrix_of`, nodes that their images have, and the places of these."""
    number = sum(nodes)
    cable = np.append(np.repeat(np.arange(len(nodes)), nodes), -1)
    numbers = np.arange(2 * number * dim).reshape(-1, 2, dim)
    directions, exist, rows, columns = [], [], [], []
    for colour, kind, axis in np.ndindex(3, 2, dim):
        direction = np.zeros(numbers.shape)
        direction[colour::3, kind, axis] = 1.0
        owner = np.clip(3 * ((np.arange(number) - colour + 1) // 3) + colour, 0, number)
        exists = cable[owner] == cable[:-1]
        directions.append(direction)
        exist.append(exists)
        rows.append(numbers[exists].ravel())
        columns.append(np.repeat(numbers[owner[exists], kind, axis], 2 * dim))
    size = numbers.size, numbers.size
    return directions, exist, Pattern(np.concatenate(rows), np.concatenate(columns), size)
