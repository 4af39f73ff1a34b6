"""Energy, forces and Hessians of cables with axial stiffness under static loads."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import scipy

from ..arrays import Array, SparseArray
from ..cable.axial import SHORTEST
from ..cable.axial_energy import static_energy
from ..cable.cable import Cable
from ..cable.chain import Chain, build_chain
from ..cable.sparse_forms import STEP, tangent_of
from ..constraints import constraints_of_cables
from ..constraints.kinds import length, nodal_inextensibility
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix
from .potential import Potential

ROUND_OFF = 100.0 * np.finfo(float).eps  # of strains, summed up


class StretchingPotential(Potential):
    """See `Potential`: axial forces take the place of the constraints (18), (19)."""

    def __init__(self, cables: Sequence[Cable], external: Array, time: float) -> None:
        self._axial = np.array([cable.section.axial_stiffness or 0.0 for cable in cables])
        self._free_strain = np.array([cable.section.axial_strain for cable in cables])
        super().__init__(cables, external, time)
        rigid = [replace(one, section=replace(one.section, axial_stiffness=None)) for one in cables]
        kinds = [[length(cable), nodal_inextensibility(cable)] for cable in rigid]
        self._strains = constraints_of_cables(rigid, kinds)
        self._present = np.concatenate([cable.reference for cable in cables])
        self._shortest = float(self._lengths.min())
        self.round_off += (ROUND_OFF + self._of_places) * float(self._axial.max())
        noise = 0.1 * self.round_off / (STEP * self._shortest)  # of a stiffness by differences [N/m]
        density = self._of_cables(lambda cable: cable.section.mass_per_length)
        self.indifferent = -noise / (float(density.min()) * self._shortest)

    @staticmethod
    def _build_chain(cable: Cable) -> Chain:
        return build_chain(replace(cable, fixed=np.zeros_like(cable.fixed)))

    @property
    def _largest_loads(self) -> Array:
        """See `Potential`; also what the strain of the stress-free cable gives."""
        return super()._largest_loads + self._axial * np.abs(self._free_strain)

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
        firsts = [place.start for place in self.places]
        before, after = (
            np.minimum.reduceat(np.linalg.norm(state[:, 1], axis=1), firsts) for state in (q, trial)
        )
        return bool((after < np.minimum(before, SHORTEST)).any())

    def strains(self, q: Array) -> Array:
        return self._strains.value(q)

    def strain_rows(self, q: Array) -> SparseArray:
        return self._strains.jacobian(q)

    def elastic_tangent(self, q: Array) -> SparseArray:
        """-dF/dq (n_dof, n_dof)."""
        return tangent_of(self._elastic_force, q, self._nodes, length=self._shortest)

    def convex_model(self, multipliers: Array, shift: float) -> SparseArray:
        """Bending and axial stiffness, tension where it pulls, and shift times the mass."""
        stiffness, lengths = self._in_elements(self._axial).ravel(), self._lengths
        rows, jacobian = self._strains.rows, self._strains.jacobian(self._present)
        of_lengths, of_slopes = (jacobian[rows[name]] for name in ("length", "nodal inextensibility"))
        axial = of_lengths.T @ scipy.sparse.diags_array(stiffness / (4.0 * lengths)) @ of_lengths
        mean = self._axial * self._of_cables(lambda cable: cable.element_lengths.mean())
        free = np.concatenate([~cable.fixed[:, 1] for cable in self.cables])
        axial = (
            axial
            + of_slopes.T @ scipy.sparse.diags_array(np.repeat(mean, self._nodes)[free] / 12.0) @ of_slopes
        )
        stretch = self._strains.value(self._present)[rows["length"]]
        strain = stretch / (2.0 * lengths) - self._in_elements(self._free_strain).ravel()
        gram = forms_of_mesh(slope_gram_matrix, lengths)
        geometric = self._assembled((stiffness * np.maximum(strain, 0.0))[:, None, None] * gram)
        return scipy.sparse.csr_array(self._stiffness + axial + geometric + shift * self.mass)


def potential_of(cables: Sequence[Cable], external: Array, time: float) -> Potential:
    """Of cables of one kind; arguments: see `Potential`."""
    return (StretchingPotential if cables[0].stretches else Potential)(cables, external, time)


def potentials_of(cables: Sequence[Cable], external: Sequence[Array], time: float) -> list[Potential]:
    """Of any cables; those that follow each other and are of one kind are put into one.

    external: (n, 2, dim) on each cable.
    """
    pairs = zip(cables, external, strict=True)
    groups = [list(alike) for _, alike in groupby(pairs, key=lambda pair: _kind(pair[0]))]
    return [
        potential_of(
            [cable for cable, _ in alike], np.concatenate([force.ravel() for _, force in alike]), time
        )
        for alike in groups
    ]


def _kind(cable: Cable) -> Any:
    """The same for cables whose records have the same fields."""
    section = cable.section
    features = cable.is_naturally_curved, section.bending_damping != 0.0, cable.drag is None
    return cable.dimension, cable.measure, cable.stretches, cable.length_constraints > 0, *features
