"""The cable in the form that the compiled kernels use: constant coefficients, node by node."""

from typing import Any, NamedTuple

import numpy as np

from ..element.bending import in_pairs, stiffness_matrix, stiffness_tensor
from ..element.difference_coordinates import in_differences
from ..element.inertia import mass_matrix
from ..element.inextensibility import slope_gram_matrix
from ..element.shape_functions import Array
from .cable import Cable, CurvatureMeasure, reference_lengths


class Chain(NamedTuple):
    """Constant coefficients of a chain of N elements and n = N + 1 nodes.

    axes: (0, 1) or (0, 1, 2); its length is the space dimension, known when compiling.
    mass_diagonal: (n, 3) [r-r, r-s, s-s] mass of a node with itself; supports replaced by unity.
    mass_coupling: (N, 4) [r-r, r-s, s-r, s-s] of an element's left with its right node.
    stiffness: (N, 3, 3) bending stiffness in difference coordinates, `secondDerivative`.
    tensor: (N, 6, 6) bending stiffness over pairs, `product`, or None.
    slope_gram: (N, 3, 3) slope Gram matrix in difference coordinates; zero without constraint.
    free: (n, 2) 1.0 where position or slope of a node moves, 0.0 where a support holds it.
    ends_group: (n,) whether a length constraint ends at this node.
    reference_length: (N,) int |r_x|^2 dx in the reference configuration [m].
    """

    axes: tuple[int, ...]
    mass_diagonal: Array
    mass_coupling: Array
    stiffness: Array
    tensor: Any
    slope_gram: Array
    free: Array
    ends_group: np.ndarray
    reference_length: Array


def build_chain(cable: Cable) -> Chain:
    """Coefficients of `cable`, from the element formulas of `element/`."""
    lengths = cable.element_lengths
    section = cable.section
    product = cable.measure is CurvatureMeasure.PRODUCT
    diagonal, coupling = _mass_bands(cable)
    constrained = cable.length_constraints > 0
    return Chain(
        axes=tuple(range(cable.dimension)),
        mass_diagonal=diagonal,
        mass_coupling=coupling,
        stiffness=section.bending_stiffness * _for_each(lengths, stiffness_matrix),
        tensor=section.bending_stiffness
        * np.stack([in_pairs(t) for t in _for_each(lengths, stiffness_tensor)])
        if product
        else None,
        slope_gram=_for_each(lengths, slope_gram_matrix) * float(constrained),
        free=np.where(cable.fixed, 0.0, 1.0),
        ends_group=_ends_group(cable),
        reference_length=reference_lengths(cable.reference, lengths),
    )


def _for_each(lengths: Array, form: Any) -> Array:
    """(N, ...) forms in difference coordinates; equal lengths are computed once."""
    unique, which = np.unique(lengths, return_inverse=True)
    return np.stack([in_differences(form(length)) for length in unique])[which]


def _ends_group(cable: Cable) -> np.ndarray:
    """(n,) True at the right node of each group's last element."""
    group = cable.group_of_element()
    ends = np.append(group[:-1] != group[1:], cable.length_constraints > 0)
    return np.append(False, ends)


def _mass_bands(cable: Cable) -> tuple[Array, Array]:
    """Diagonal (n, 3) and coupling (N, 4) of rho_A M, with held coordinates taken out."""
    element = cable.section.mass_per_length * np.stack(
        [mass_matrix(length) for length in cable.element_lengths]
    )
    diagonal = np.zeros((cable.number_of_elements + 1, 3))
    diagonal[:-1] += element[:, [0, 0, 1], [0, 1, 1]]
    diagonal[1:] += element[:, [2, 2, 3], [2, 3, 3]]
    free = np.where(cable.fixed, 0.0, 1.0)
    diagonal *= np.stack([free[:, 0], free[:, 0] * free[:, 1], free[:, 1]], axis=1)
    diagonal[:, [0, 2]] += 1.0 - free
    pairs = free[:-1, [0, 0, 1, 1]] * free[1:, [0, 1, 0, 1]]
    return diagonal, np.ascontiguousarray(element[:, [0, 0, 1, 1], [2, 3, 2, 3]] * pairs)
