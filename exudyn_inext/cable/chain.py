"""The cable in the form that the compiled kernels use: records of nodes and elements."""

from collections.abc import Callable
from functools import cache
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
from ..element.shape_functions import quadrature
from .attached import mass_of_points
from .axial_stiffness import set_axial_step, set_axial_stiffness
from .cable import Cable, CurvatureMeasure
from .implicit_bending import EXPLICIT, ImplicitBending
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


def build_chain(cable: Cable, implicit: ImplicitBending = EXPLICIT) -> Chain:
    """Coefficients of `cable`, from the element formulas of `element/`, and memory for its solves.

    Args:
        cable: the cable.   implicit: see `set_mass`.
    """
    product = cable.measure is CurvatureMeasure.PRODUCT
    dim, number = cable.dimension, cable.number_of_elements
    nodes = np.zeros(number + 1, node_type(dim, cable.stretches))
    section = cable.section
    elements = np.zeros(number, element_type(dim, product, cable.stretches, cable.pressed))
    nodes["free"] = np.where(cable.fixed, 0.0, 1.0)
    nodes["ends_group"] = _ends_group(cable)
    lengths, stiffness = cable.element_lengths, section.bending_stiffness
    if product:
        elements["tensor"] = stiffness * forms_of_mesh(_tensor_over_pairs, lengths)
    else:
        elements["stiffness"] = stiffness * forms_of_mesh(_in_differences(stiffness_matrix), lengths)
    if cable.is_naturally_curved:
        elements["curved"] = True
        elements["natural"] = stiffness * _turning_matrices(cable)
    if section.bending_damping:
        elements["damped"] = True
        elements["damping"] = forms_of_mesh(damping_table, lengths)
        elements["damping"][:, :, 0] *= section.bending_damping
    if cable.drag is not None:
        elements["dragged"] = True
        elements["drag"] = forms_of_mesh(drag_table, lengths)
        elements["drag_law"] = cable.drag.law()
    if cable.length_constraints > 0:
        elements["slope_gram"] = forms_of_mesh(_in_differences(slope_gram_matrix), lengths)
    set_constrained_lengths(cable, elements)
    if cable.stretches:
        set_axial_stiffness(cable, nodes, elements)
    chain = Chain(tuple(range(dim)), nodes, elements)
    set_mass(chain, cable, implicit)
    return chain


def set_constrained_lengths(cable: Cable, elements: Any) -> None:
    """What the length constraints ask for: of all coefficients the only ones that depend on the reference."""
    elements["reference_length"] = cable.constrained_lengths()
    elements["per_length"] = 1.0 / elements["reference_length"]


def _turning_matrices(cable: Cable) -> Array:
    """(N, 3, 3) of all elements, times kappa_0."""
    section, lengths = cable.section, cable.element_lengths
    if not section.strain_is_relative:
        return section.natural_curvature * forms_of_mesh(_in_differences(turning_matrix), lengths)
    natural = [cable.natural_curvature(k, quadrature(1.0)[0]) for k in range(len(lengths))]
    forms = [turning_matrix(*given) for given in zip(lengths.tolist(), natural, strict=True)]
    return np.stack([in_differences(form) for form in forms])


def set_mass(chain: Chain, cable: Cable, implicit: ImplicitBending) -> None:
    """Mass of the chain of `cable`, with what is implicit: M + (theta h^2 EI + h/2 D) int S_xx S_xx^T dx."""
    nodes, elements = chain.nodes, chain.elements
    masses = _element_masses(cable, implicit.factor(cable.section))
    _assemble_mass(masses, nodes["free"], nodes["mass"], elements["mass"])
    elements["lag"] = np.where(elements["damped"], implicit.damping, 0.0)
    if cable.stretches:
        set_axial_step(implicit.step, nodes, elements)


def _tensor_over_pairs(length: float) -> Array:
    return in_pairs(in_differences(stiffness_tensor(length)))


@cache
def _in_differences(form: Callable[[float], Array]) -> Callable[[float], Array]:
    """The same function for the same form, so that `forms_of_mesh` knows it again."""
    return lambda length: in_differences(form(length))


def _ends_group(cable: Cable) -> np.ndarray:
    """(n,) True at the right node of each group's last element."""
    group = cable.group_of_element()
    ends = np.append(group[:-1] != group[1:], cable.length_constraints > 0)
    return np.append(False, ends)


def _element_masses(cable: Cable, of_curvature: float) -> Array:
    """(N, 4, 4) element matrices of the mass [kg, kg m; kg m, kg m^2].

    of_curvature: factor of int S_xx S_xx^T dx beside it [N m^2 s^2].
    """
    section, lengths = cable.section, cable.element_lengths
    masses = section.mass_per_length * forms_of_mesh(mass_matrix, lengths)
    if cable.point_masses:
        masses += mass_of_points(cable.point_masses, lengths)
    if of_curvature:
        masses += of_curvature * forms_of_mesh(stiffness_matrix, lengths)
    return masses


def _assemble_mass(masses, free, of_nodes, of_elements):
    """Bands of the mass matrix, see `records`; where a coordinate is held, those of the unit matrix.

    Args:
        masses: (N, 4, 4) of the elements.   free: (n, 2).
        of_nodes: (n, 3) output.   of_elements: (N, 4) output.
    """
    of_nodes[:, 0], of_nodes[:, 1], of_nodes[:, 2] = 1.0 - free[:, 0], 0.0, 1.0 - free[:, 1]
    for r, nodes in (2, slice(1, None)), (0, slice(-1)):
        of_nodes[nodes, 0] += free[nodes, 0] * masses[:, r, r]
        of_nodes[nodes, 1] += free[nodes].prod(axis=1) * masses[:, r, r + 1]
        of_nodes[nodes, 2] += free[nodes, 1] * masses[:, r + 1, r + 1]
    between = free[:-1, :, np.newaxis] * masses[:, :2, 2:] * free[1:, np.newaxis]
    of_elements[:] = between.reshape(-1, 4)
