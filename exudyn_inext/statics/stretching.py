"""Energy, forces and Hessians of a cable with axial stiffness under static loads."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array, diags_array

from ..arrays import Array
from ..cable.axial import SHORTEST
from ..cable.axial_energy import static_energy
from ..cable.cable import Cable
from ..cable.chain import build_chain
from ..cable.sparse_forms import STEP, assembled, tangent_of
from ..constraints import Constraints
from ..constraints.kinds import length, nodal_inextensibility
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix
from .potential import Potential

ROUND_OFF = 100.0 * np.finfo(float).eps  # of strains, summed up


class StretchingPotential(Potential):
    """See `Potential`: axial forces take the place of the constraints (18), (19)."""

    def __init__(self, cable: Cable, external: Array, time: float) -> None:
        super().__init__(cable, external, time)
        self._chain = build_chain(replace(cable, fixed=np.zeros_like(cable.fixed)))
        rigid = replace(cable, section=replace(cable.section, axial_stiffness=None))
        self._strains = Constraints([length(rigid), nodal_inextensibility(rigid)], cable.reference.shape)
        self._present = cable.reference
        self.round_off = ROUND_OFF * (cable.section.axial_stiffness or 0.0)
        shortest = float(cable.element_lengths.min())
        noise = 0.1 * self.round_off / (STEP * shortest)  # of a stiffness by differences [N/m]
        self.indifferent = -noise / (cable.section.mass_per_length * shortest)

    def turn_with(self, q: Array) -> None:
        """The convex model is that of the present state."""
        super().turn_with(q)
        self._present = q

    def energy(self, q: Array) -> float:
        """Bending and axial energy less the work of the loads [J]."""
        return float(static_energy(self._chain, q, np.zeros(q.shape))) - float(np.sum(self._external * q))

    def force(self, q: Array) -> Array:
        """(n_dof,) elastic and external force."""
        return self._external.ravel() + self._elastic_force(q).ravel()

    def _elastic_force(self, q: Array) -> Array:
        force = np.zeros(q.shape)
        static_energy(self._chain, q, force)
        return force

    def is_blocked(self, q: Array, trial: Array) -> bool:
        """Whether an element would be about to turn inside out."""
        before, after = (float(np.linalg.norm(state[:, 1], axis=1).min()) for state in (q, trial))
        return after < min(before, SHORTEST)

    def strains(self, q: Array) -> Array:
        """See `StaticSystem`."""
        return self._strains.value(q)

    def strain_rows(self, q: Array) -> csr_array:
        """See `StaticSystem`."""
        return self._strains.jacobian(q)

    @property
    def largest_load(self) -> float:
        """Of the external forces, bending, and what the strain of the stress-free cable gives [N]."""
        section = self.cable.section
        return super().largest_load + (section.axial_stiffness or 0.0) * abs(section.axial_strain)

    def elastic_tangent(self, q: Array) -> csr_array:
        """-dF/dq (n_dof, n_dof)."""
        return tangent_of(self._elastic_force, q, length=float(self.cable.element_lengths.min()))

    def convex_model(self, multipliers: Array, shift: float) -> csr_array:
        """Bending and axial stiffness, tension where it pulls, and shift times the mass."""
        stiffness, lengths = self.cable.section.axial_stiffness or 0.0, self.cable.element_lengths
        rows, jacobian = self._strains.rows, self._strains.jacobian(self._present)
        of_lengths, of_slopes = (jacobian[rows[name]] for name in ("length", "nodal inextensibility"))
        axial = of_lengths.T @ diags_array(stiffness / (4.0 * lengths)) @ of_lengths
        axial = axial + stiffness * lengths.mean() / 12.0 * (of_slopes.T @ of_slopes)
        stretch = self._strains.value(self._present)[rows["length"]]
        strain = stretch / (2.0 * lengths) - self.cable.section.axial_strain
        gram = forms_of_mesh(slope_gram_matrix, lengths)
        geometric = assembled(
            (stiffness * np.maximum(strain, 0.0))[:, None, None] * gram, self._present.shape
        )
        return csr_array(self._stiffness + axial + geometric + shift * self.mass)


def potential_of(cable: Cable, external: Array, time: float) -> Potential:
    """Of a cable that stretches, or does not; arguments: see `Potential`."""
    return (StretchingPotential if cable.stretches else Potential)(cable, external, time)
