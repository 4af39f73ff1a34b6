"""Sparse matrices of a whole cable, for statics and as plain formulas: no kernels."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from ..element.forms import forms_of_mesh
from ..element.inertia import mass_matrix
from ..sparse import Pattern
from .assembly import add_elastic_force
from .attached import mass_of_points
from .cable import Cable
from .chain import Chain
from .constraint_rows import unconstrained_force

STEP = 1e-3  # of differences [-]


def assembled(forms: Array, shape: tuple[int, ...]) -> csr_array:
    """(n_dof, n_dof) matrix of element forms (N, 4, 4) that act alike in every direction."""
    return _pattern_of_forms(shape).matrix(np.repeat(forms.ravel(), shape[2]))


@lru_cache(maxsize=64)
def _pattern_of_forms(shape: tuple[int, ...]) -> Pattern:
    nodes, _, dim = shape
    places = 2 * np.arange(nodes - 1)[:, None] + np.arange(4)
    both = np.broadcast_arrays(places[:, :, None], places[:, None, :])
    rows, columns = ((dim * one[..., None] + np.arange(dim)).ravel() for one in both)
    return Pattern(rows, columns, (2 * nodes * dim, 2 * nodes * dim))


def form_of_cable(cable: Cable, form: Callable[[float], Array]) -> csr_array:
    """`assembled` form of all elements of `cable`."""
    return assembled(forms_of_mesh(form, cable.element_lengths), cable.reference.shape)


def mass_of_cable(cable: Cable) -> csr_array:
    """(n_dof, n_dof) mass matrix, point masses included, without mass scaling."""
    own = cable.section.mass_per_length * form_of_cable(cable, mass_matrix)
    points = mass_of_points(cable.point_masses, cable.element_lengths)
    return csr_array(own + assembled(points, cable.reference.shape))


def elastic_tangent(chain: Chain, q: Array) -> csr_array:
    """-dQ_el/dq (n_dof, n_dof) at q (n, 2, dim); exact: Q_el is cubic in q, long steps do."""

    def elastic_force(at: Array) -> Array:
        force = np.zeros_like(at)
        add_elastic_force(chain, at, force)
        return force

    return tangent_of(elastic_force, q, step=1.0)


def tangent_of(
    force: Callable[[Array], Array], q: Array, step: float = STEP, length: float = 1.0
) -> csr_array:
    """-dF/dq (n_dof, n_dof) of a smooth force (n, 2, dim) at q, by differences of order four.

    step: of slopes [-], and of positions over a length [m].
    """

    def apply(x: Array) -> Array:
        h = step * length if x[:, 0].any() else step
        near = force(q + h * x) - force(q - h * x)
        return (force(q + 2.0 * h * x) - force(q - 2.0 * h * x) - 8.0 * near) / (12.0 * h)

    return _matrix_of(apply, q.shape)


def damping_tangent(chain: Chain, q: Array) -> csr_array:
    """-dQ_damping/dv (n_dof, n_dof) at q (n, 2, dim); exact: Q_damping is linear in v."""
    rest, force, elastic = np.zeros_like(q), np.zeros_like(q), np.zeros_like(q)
    unconstrained_force(chain, rest, q, rest, elastic)

    def apply(x: Array) -> Array:
        unconstrained_force(chain, rest, q, x, force)
        return elastic - force

    return _matrix_of(apply, q.shape)


def _matrix_of(apply: Callable[[Array], Array], shape: tuple[int, ...]) -> csr_array:
    """Matrix (n_dof, n_dof) of x (n, 2, dim) -> apply(x), where only neighbouring nodes interact.

    Nodes three apart do not: all columns are found with 6 dim products.
    """
    directions, exist, pattern = _products(shape)
    images = (apply(direction)[own] for direction, own in zip(directions, exist, strict=True))
    return pattern.matrix(np.concatenate([image.ravel() for image in images]))


@lru_cache(maxsize=64)
def _products(shape: tuple[int, ...]) -> tuple[list[Array], list[np.ndarray], Pattern]:
    """The vectors of `_matrix_of`, nodes that their images have, and the places of these."""
    nodes, _, dim = shape
    numbers, directions, exist, rows, columns = np.arange(2 * nodes * dim).reshape(shape), [], [], [], []
    for colour, kind, axis in np.ndindex(3, 2, dim):
        direction = np.zeros(shape)
        direction[colour::3, kind, axis] = 1.0
        owner = np.clip(3 * ((np.arange(nodes) - colour + 1) // 3) + colour, 0, None)
        exists = owner < nodes
        directions.append(direction)
        exist.append(exists)
        rows.append(numbers[exists].ravel())
        columns.append(np.repeat(numbers[owner[exists], kind, axis], 2 * dim))
    size = numbers.size, numbers.size
    return directions, exist, Pattern(np.concatenate(rows), np.concatenate(columns), size)
