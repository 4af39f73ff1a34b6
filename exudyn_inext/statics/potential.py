"""Energy, forces, Hessians and constraints of one cable under static loads."""

from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from ..cable.assembly import add_elastic_force, elastic_energy
from ..cable.cable import Cable, CurvatureMeasure
from ..cable.chain import build_chain
from ..cable.sparse_forms import assembled, elastic_tangent, form_of_cable, mass_of_cable
from ..constraints import constraints_of_cable
from ..element.bending import stiffness_matrix
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix
from .static_system import StaticSystem

BOW = 0.3  # slope at the ends of the sag that a taut start is given [-]


class Potential(StaticSystem):
    """Energy, forces and Hessians of one cable under given loads, and its constraints at a time."""

    def __init__(self, cable: Cable, external: Array, time: float) -> None:
        self.cable = cable
        self.time = time
        self._chain = build_chain(cable)
        self._external = external.reshape(cable.reference.shape)
        self.constraints = constraints_of_cable(cable)
        section = cable.section
        self.mass = mass_of_cable(cable)
        self._stiffness = section.bending_stiffness * form_of_cable(cable, stiffness_matrix)
        smoothing = cable.element_lengths.mean() * cable.length**3 * section.mass_per_length
        self.metric = self.mass + smoothing / section.bending_stiffness * self._stiffness
        lengths = np.ones(cable.reference.shape)
        lengths[:, 1] = 1.0 / float(cable.element_lengths.mean())
        self.scale = lengths.ravel()  # of forces: moments count over the element length

    @property
    def length(self) -> float:
        """Of the cable [m]."""
        return self.cable.length

    @property
    def shift(self) -> float:
        """Of an indefinite Hessian, by the mass [1/s^2]."""
        return self.largest_load / (self.cable.section.mass_per_length * self.cable.length**2)

    def turn_with(self, q: Array) -> None:
        """The slopes at both ends of a ring are joined transverse to the first one, which may turn."""
        if self.cable.closed:
            self.constraints = constraints_of_cable(self.cable, slope=q[0, 1])

    def energy(self, q: Array) -> float:
        """Bending energy less the work of the loads [J]."""
        return float(elastic_energy(self._chain, q)) - float(np.sum(self._external * q))

    def fall(self, q: Array, trial: Array) -> float:
        """How much lower the energy is at `trial` [J]."""
        return self.energy(q) - self.energy(trial)

    def scale_of_energy(self, q: Array) -> float:
        """[J]"""
        return abs(self.energy(q)) + self.largest_load * self.length

    def turn(self, step: Array) -> float:
        """Largest change of a slope in a step (n, 2, dim)."""
        return float(np.abs(step[:, 1]).max())

    def force(self, q: Array) -> Array:
        """(n_dof,) elastic and external force."""
        force = self._external.copy()
        add_elastic_force(self._chain, q, force)
        return force.ravel()

    def values(self, q: Array) -> Array:
        """(m,) all constraints."""
        return self.constraints.value(q, self.time)

    def jacobian(self, q: Array) -> csr_array:
        """(m, n_dof) of all constraints."""
        return self.constraints.jacobian(q, self.time)

    def strains(self, q: Array) -> Array:
        """There are none."""
        return np.zeros(0)

    def strain_rows(self, q: Array) -> csr_array:
        """There are none."""
        return csr_array((0, q.size))

    def hessian(self, q: Array, multipliers: Array) -> csr_array:
        """Of the Lagrangian."""
        return csr_array(self.elastic_tangent(q) + self.constraints.hessian(multipliers))

    def elastic_tangent(self, q: Array) -> csr_array:
        """-dF/dq (n_dof, n_dof)."""
        is_linear = self.cable.measure is not CurvatureMeasure.PRODUCT
        return self._tangent_of_linear_forces if is_linear else elastic_tangent(self._chain, q)

    @cached_property
    def _tangent_of_linear_forces(self) -> csr_array:
        return elastic_tangent(self._chain, self.cable.reference)

    def convex_model(self, multipliers: Array, shift: float) -> csr_array:
        """Bending stiffness, mean tension of the elements where it pulls, and shift times the mass."""
        gram = forms_of_mesh(slope_gram_matrix, self.cable.element_lengths)
        tension = np.maximum(self._mean_tension(multipliers), 0.0)
        geometric = assembled(tension[:, None, None] * gram, self.cable.reference.shape)
        return csr_array(self._stiffness + geometric + shift * self.mass)

    def _mean_tension(self, multipliers: Array) -> Array:
        """(N,) [N]: 2 lam of the length constraint, and the nodal multipliers' share."""
        cable, rows = self.cable, self.constraints.rows
        tension = np.zeros(cable.number_of_elements)
        if "length" in rows:
            tension += 2.0 * multipliers[rows["length"]][cable.group_of_element()]
        if "nodal inextensibility" in rows:
            nodal = np.zeros(len(cable.reference))
            nodal[~cable.fixed[:, 1]] = multipliers[rows["nodal inextensibility"]]
            tension += (nodal[1:] + nodal[:-1]) / cable.element_lengths
        return tension

    def size(self, force: Array) -> float:
        """Largest component [N], moments over the element length."""
        return float(np.abs(force * self.scale).max(initial=0.0))

    @property
    def total_force(self) -> Array:
        """(dim,) sum of the external forces [N]."""
        total: Array = self._external[:, 0].sum(axis=0)
        return total

    @property
    def largest_load(self) -> float:
        """Of the external forces [N], and of bending to a radius of the cable's length."""
        section = self.cable.section
        return self.size(self._external.ravel()) + section.bending_stiffness / self.cable.length**2

    def bowed(self, q: Array) -> Array:
        """q with a sag towards the loads, or anywhere: on a straight line no step makes a cable longer."""
        arc = np.append(0.0, np.cumsum(self.cable.element_lengths)) * np.pi / self.cable.length
        chord = q[-1, 0] - q[0, 0]
        chord = chord / max(float(np.linalg.norm(chord)), 1e-300)
        candidates = np.stack([self.total_force, *np.eye(q.shape[2])])
        across = candidates - np.outer(candidates @ chord, chord)
        sizes = np.linalg.norm(across, axis=1)
        chosen = 0 if sizes[0] > 1e-6 * self.largest_load else 1 + int(np.argmax(sizes[1:]))
        sag = BOW * self.cable.length / np.pi * across[chosen] / sizes[chosen]
        result = q.copy()
        result[:, 0] += np.outer(np.sin(arc), sag)
        result[:, 1] += np.outer(np.cos(arc), sag * np.pi / self.cable.length)
        return result
