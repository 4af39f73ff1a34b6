"""Coefficients of axial stiffness in the records of a chain, see `axial`."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..element.axial_strain import middle_strain
from .cable import Cable, reference_lengths

# Entries of the `axial` of a record:
# D [N m] and d [N m s] of the strain's energy D c^2 / 2 and of the damping d c_t;
# the strain of the stress-free cable [-];
# E = D/2 + d/h [N m] and h^2/2 E [kg m^2] along J, 0 where axial forces are explicit; h [s];
# a constant force instead of all of these [N m], see `frozen`;
# at the last evaluation: c [-], J q [-], force f [N m]; h/2 d [N m s^2] at the start of a run, 0 afterwards;
# of the last step: mean force mu [N m], rho of the one before [-].
STIFFNESS, DAMPING, FREE_STRAIN, IMPLICIT, ADDED_MASS, STEP = range(6)
FROZEN, STRAIN, PLACE, FORCE, FIRST_DAMPING, MEAN_FORCE, REST_BEFORE = range(6, 13)


def set_axial_stiffness(cable: Cable, nodes: Any, elements: Any) -> None:
    """Coefficients of nodes and elements: weights of Simpson's rule times EA and its damping."""
    section, lengths, dim = cable.section, cable.element_lengths, cable.dimension
    nodal = np.linalg.norm(cable.reference[:, 1], axis=1) - 1.0
    means = np.sqrt(reference_lengths(cable.reference, lengths) / cable.constrained_lengths()) - 1.0
    middle, share = middle_strain(means, nodal[:-1], nodal[1:]), section.strain_is_relative
    ends = np.append(lengths, 0.0) + np.append(0.0, lengths)
    for records, weights, strain in ((nodes, ends / 6.0, nodal), (elements, lengths * 4.0 / 6.0, middle)):
        records["axial"][:, STIFFNESS] = (section.axial_stiffness or 0.0) * weights
        records["axial"][:, DAMPING] = section.axial_damping * weights
        records["axial"][:, FREE_STRAIN] = section.axial_strain + share * strain
    nodes["basis"] = np.eye(dim)
    nodes["ends_group"] = True
    elements["bending"][:, 0] = section.bending_stiffness / (3.0 * lengths)


def set_axial_step(h: float, nodes: Any, elements: Any) -> None:
    """Prepare for implicit axial forces in steps of h [s]; 0: explicit ones."""
    for records in (nodes, elements):
        axial = records["axial"]
        axial[:, STEP] = h
        axial[:, IMPLICIT] = 0.5 * axial[:, STIFFNESS] + axial[:, DAMPING] / h if h else 0.0
        axial[:, ADDED_MASS] = 0.5 * h**2 * axial[:, IMPLICIT]


def set_step_of_means(h: float, nodes: Any, elements: Any) -> None:
    """Let evaluations see mean axial forces as steps of h [s] have them, D (c + h^2/4 c_tt) + d c_t."""
    for records in (nodes, elements):
        axial = records["axial"]
        axial[:, STEP] = h
        axial[:, ADDED_MASS] = 0.25 * h**2 * axial[:, STIFFNESS]


@contextmanager
def frozen(nodes: Any, elements: Any) -> Iterator[None]:
    """Axial forces as at the last evaluation, which was explicit, however the strains change.

    For limits of the step: implicit axial forces bound it by their direction, and not by their stiffness.
    """
    arrays = [records["axial"] for records in (nodes, elements)]
    saved = [axial.copy() for axial in arrays]
    for axial in arrays:
        axial[:, FROZEN] = axial[:, FORCE]
        axial[:, [STIFFNESS, DAMPING, IMPLICIT, ADDED_MASS]] = 0.0
    try:
        yield
    finally:
        for axial, before in zip(arrays, saved, strict=True):
            axial[...] = before
