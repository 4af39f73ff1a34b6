"""Sparse matrices of a whole cable, for statics and as plain formulas: no kernels."""

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, kron

from ..arrays import Array
from ..element.forms import forms_of_mesh
from ..element.inertia import mass_matrix
from .assembly import add_elastic_force
from .attached import mass_of_points
from .cable import Cable
from .chain import Chain
from .constraint_rows import unconstrained_force

STEP = 1e-3  # of differences [m, -]


def assembled(forms: Array, shape: tuple[int, ...]) -> csr_array:
    """(n_dof, n_dof) matrix of element forms (N, 4, 4) that act alike in every direction."""
    nodes, _, dim = shape
    places = 2 * np.arange(len(forms))[:, None] + np.arange(4)
    rows = np.broadcast_to(places[:, :, None], forms.shape)
    columns = np.broadcast_to(places[:, None, :], forms.shape)
    entries = (forms.ravel(), (rows.ravel(), columns.ravel()))
    return csr_array(kron(coo_array(entries, shape=(2 * nodes, 2 * nodes)), eye_array(dim)))


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


def tangent_of(force: Callable[[Array], Array], q: Array, step: float = STEP) -> csr_array:
    """-dF/dq (n_dof, n_dof) of a smooth force (n, 2, dim) at q, by differences of order four."""

    def apply(x: Array) -> Array:
        near = force(q + step * x) - force(q - step * x)
        return (force(q + 2.0 * step * x) - force(q - 2.0 * step * x) - 8.0 * near) / (12.0 * step)

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
    nodes, _, dim = shape
    rows, columns, values = [], [], []
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    for colour in range(3):
        chosen = np.arange(colour, nodes, 3)
        for kind in range(2):
            for axis in range(dim):
                direction = np.zeros(shape)
                direction[chosen, kind, axis] = 1.0
                image = apply(direction)
                owner = np.clip(3 * ((np.arange(nodes) - colour + 1) // 3) + colour, 0, None)
                exists = owner < nodes
                rows.append(numbers[exists].ravel())
                of_owner = numbers[owner[exists], kind, axis]
                columns.append(np.repeat(of_owner, 2 * dim))
                values.append(image[exists].ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(coo_array(entries, shape=(numbers.size, numbers.size)))
