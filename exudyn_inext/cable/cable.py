"""What a cable is: mesh, section, supports. Plain data, checked once, without any solver state."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..arrays import Array
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix
from ..element.natural_curvature import curvature
from ..element.shape_functions import quadrature
from .attached import Drag, PointMass
from .link import Link


class CurvatureMeasure(str, Enum):
    """How the elastic energy measures the curvature, Eq. (4) and its inextensible limit."""

    SECOND_DERIVATIVE = "secondDerivative"
    PRODUCT = "product"


@dataclass(frozen=True)
class Section:
    """Constants of the cross-section.

    mass_per_length: rho_A [kg/m].
    bending_stiffness: EI [N m^2].
    natural_curvature: kappa_0 of the stress-free cable [1/m]; planar cables only.
    bending_damping: D of the moment D kappa_t [N m^2 s].
    axial_stiffness: EA of the tension EA (|r_x| - 1 - axial_strain) [N]; None: the cable is inextensible.
    axial_damping: of the tension that the rate of the strain adds [N s].
    axial_strain: of the stress-free cable [-].
    strain_is_relative: share of the reference configuration's curvature and strain that is stress-free.
    """

    mass_per_length: float
    bending_stiffness: float
    natural_curvature: float = 0.0
    bending_damping: float = 0.0
    axial_stiffness: float | None = None
    axial_damping: float = 0.0
    axial_strain: float = 0.0
    strain_is_relative: float = 0.0


@dataclass(frozen=True, eq=False)
class Cable:
    """An inextensible cable in its reference configuration.

    reference: (n, 2, dim) position r [m] and slope r_x [-] of the n = N + 1 nodes.
    element_lengths: (N,) arc length of each element [m].
    section: constants of the cross-section.
    measure: curvature measure.
    length_constraints: n_bar of Eq. (19), 0 (none) to N; the groups are as equal as possible.
    fixed: (n, 2) whether position and slope of a node are held by a support.
    links: further constraints on its nodes.
    closed: whether the last node is the first one once more.
    straight_lengths: whether the length constraints (19) ask for the element lengths, rather than for
        the values of the discretised reference configuration.
    point_masses: concentrated masses on it.
    drag: of the fluid around it, or None.
    pressed: whether something may touch it, see `contact_mass`.
    """

    reference: Array
    element_lengths: Array
    section: Section
    measure: CurvatureMeasure
    length_constraints: int
    fixed: np.ndarray
    links: tuple[Link, ...] = ()
    closed: bool = False
    straight_lengths: bool = False
    point_masses: tuple[PointMass, ...] = ()
    drag: Drag | None = None
    pressed: bool = False

    @property
    def dimension(self) -> int:
        return int(self.reference.shape[2])

    @property
    def number_of_elements(self) -> int:
        return len(self.element_lengths)

    @property
    def length(self) -> float:
        return float(self.element_lengths.sum())

    @property
    def stretches(self) -> bool:
        """Whether it has an axial stiffness."""
        return self.section.axial_stiffness is not None

    @property
    def is_naturally_curved(self) -> bool:
        """Whether the stress-free cable may be curved."""
        return bool(self.section.natural_curvature or self.section.strain_is_relative) and self.dimension == 2

    def natural_curvature(self, k: int, xi: Array) -> Array:
        """kappa_0 (g,) at abscissae xi (g,) of element k [1/m]."""
        natural = np.full(len(xi), self.section.natural_curvature)
        if self.section.strain_is_relative and self.dimension == 2:
            nodal = np.concatenate([self.reference[k], self.reference[k + 1]])
            natural += self.section.strain_is_relative * curvature(nodal, xi, float(self.element_lengths[k]))
        return natural

    def natural_energy(self) -> float:
        """What a straight cable has from its natural curvature: int EI kappa_0^2 / 2 dx [J]."""
        xi, weight = quadrature(1.0)
        squares = [weight @ self.natural_curvature(k, xi) ** 2 for k in range(self.number_of_elements)]
        return float(0.5 * self.section.bending_stiffness * self.element_lengths @ squares)

    def constrained_lengths(self) -> Array:
        """(N,) value of int |r_x|^2 dx that each element shall keep, Eq. (19) [m]."""
        if self.straight_lengths:
            return self.element_lengths
        return reference_lengths(self.reference, self.element_lengths)

    def group_of_element(self) -> np.ndarray:
        """(N,) index of the length constraint that each element belongs to, or -1."""
        number, groups = self.number_of_elements, self.length_constraints
        if groups == 0:
            return np.full(number, -1)
        return (np.arange(number) * groups) // number


def reference_lengths(reference: Array, element_lengths: Array) -> Array:
    """int |r_x|^2 dx of each element in the discretised reference configuration, Eq. (19).

    Args:
        reference: (n, 2, dim) nodal positions [m] and slopes [-].
        element_lengths: (N,) [m].

    Returns:
        (N,) [m]; equals the element length where the interpolation has unit slope everywhere.
    """
    nodal = np.concatenate([reference[:-1], reference[1:]], axis=1)
    nodal[:, [0, 2]] -= reference[:-1, :1]  # squares of places far from the origin would be round-off
    gram = forms_of_mesh(slope_gram_matrix, element_lengths)
    return np.einsum("eai,eab,ebi->e", nodal, gram, nodal)
