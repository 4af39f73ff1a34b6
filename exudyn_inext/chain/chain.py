"""The cable in the form that the compiled kernels use: records of nodes and elements."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..element.bending import in_pairs, stiffness_matrix, stiffness_tensor
from ..element.bending_damping import damping_table
from ..element.difference_coordinates import in_differences
from ..element.drag import drag_table
from ..element.forms import forms_of_mesh
from ..element.inertia import mass_matrix
from ..element.inextensibility import slope_gram_matrix
from ..element.natural_curvature import turning_matrix
from .attached import mass_of_points
from .cable import Cable, CurvatureMeasure
from .records import element_type, node_type


class Chain(NamedTuple):
    """A chain of N elements and n = N + 1 nodes.

    axes: (0, 1) or (0, 1, 2); its length is the space dimension, known when compiling.
    nodes: (n,) records of `records.node_type`.
    elements: (N,) records of `records.element_type`.
    """

    axes: tuple[int, ...]
    nodes: Any
    elements: Any

    @property
    def shape(self) -> tuple[int, int, int]:
        """(n, 2, dim): shape of the coordinates."""
        return len(self.nodes), 2, len(self.axes)


def build_chain(cable: Cable, mass_scaling: float = 0.0) -> Chain:
    """Coefficients of `cable`, from the element formulas of `element/`, and memory for its solves.

    Args:
        cable: the cable.
        mass_scaling: theta h^2 [s^2]: the mass matrix becomes M + theta h^2 K with the constant K of
            `secondDerivative`, which makes the bending part of an explicit scheme implicit.
    """
    product = cable.measure is CurvatureMeasure.PRODUCT
    dim, number = cable.dimension, cable.number_of_elements
    nodes = np.zeros(number + 1, node_type(dim))
    section = cable.section
    layout = element_type(
        dim,
        product,
        natural=section.natural_curvature != 0.0,
        damped=section.bending_damping != 0.0,
        dragged=cable.drag is not None,
    )
    elements = np.zeros(number, layout)
    nodes["free"] = np.where(cable.fixed, 0.0, 1.0)
    nodes["ends_group"] = _ends_group(cable)
    nodes["mass"], elements["mass"] = _mass_bands(cable, mass_scaling)
    lengths, stiffness = cable.element_lengths, section.bending_stiffness
    if product:
        tensors = _in_differences(stiffness_tensor, lengths)
        elements["tensor"] = stiffness * np.stack([in_pairs(tensor) for tensor in tensors])
    else:
        elements["stiffness"] = stiffness * _in_differences(stiffness_matrix, lengths)
    if section.natural_curvature:
        elements["natural"] = stiffness * section.natural_curvature * _in_differences(turning_matrix, lengths)
    if section.bending_damping:
        elements["damping"] = forms_of_mesh(damping_table, lengths)
        elements["damping"][:, :, 0] *= section.bending_damping
    if cable.drag is not None:
        elements["drag"] = forms_of_mesh(drag_table, lengths)
        elements["drag_law"] = cable.drag.law()
    if cable.length_constraints > 0:
        elements["slope_gram"] = _in_differences(slope_gram_matrix, lengths)
    elements["reference_length"] = cable.constrained_lengths()
    return Chain(tuple(range(dim)), nodes, elements)


def _in_differences(form: Callable[[float], Array], lengths: Array) -> Array:
    return in_differences(forms_of_mesh(form, lengths))


def _ends_group(cable: Cable) -> np.ndarray:
    """(n,) True at the right node of each group's last element."""
    group = cable.group_of_element()
    ends = np.append(group[:-1] != group[1:], cable.length_constraints > 0)
    return np.append(False, ends)


def _mass_bands(cable: Cable, mass_scaling: float) -> tuple[Array, Array]:
    """Diagonal (n, 3) and coupling (N, 4) of the scaled mass, with held coordinates taken out."""
    section, lengths = cable.section, cable.element_lengths
    element = section.mass_per_length * forms_of_mesh(mass_matrix, lengths)
    element += mass_of_points(cable.point_masses, lengths)
    element += mass_scaling * section.bending_stiffness * forms_of_mesh(stiffness_matrix, lengths)
    diagonal = np.zeros((cable.number_of_elements + 1, 3))
    diagonal[:-1] += element[:, [0, 0, 1], [0, 1, 1]]
    diagonal[1:] += element[:, [2, 2, 3], [2, 3, 3]]
    free = np.where(cable.fixed, 0.0, 1.0)
    diagonal *= np.stack([free[:, 0], free[:, 0] * free[:, 1], free[:, 1]], axis=1)
    diagonal[:, [0, 2]] += 1.0 - free
    pairs = free[:-1, [0, 0, 1, 1]] * free[1:, [0, 1, 0, 1]]
    return diagonal, element[:, [0, 0, 1, 1], [2, 3, 2, 3]] * pairs
