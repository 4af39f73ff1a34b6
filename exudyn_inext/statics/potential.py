"""Energy, forces, Hessians and constraints of cables under static loads."""

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import accumulate, pairwise

import numpy as np
import scipy

from ..arrays import Array, SparseArray
from ..cable.assembly import add_elastic_force, elastic_energy
from ..cable.cable import Cable, CurvatureMeasure
from ..cable.chain import Chain, build_chain
from ..cable.many_cables import in_one
from ..cable.sparse_forms import assembled, elastic_tangent, left_nodes, masses_of_elements
from ..cable.support_forces import SupportForces
from ..constraints import constraints_of_cable, constraints_of_cables, kinds_of_cable
from ..constraints.kinds import HELD
from ..constraints.prescribed_motion import KINDS as MOTIONS
from ..element.bending import stiffness_matrix
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix
from .static_system import StaticSystem

ROUND_OFF = 10.0 * np.finfo(float).eps  # of places far from the origin, in strains and directions
BOW = 0.3  # slope at the ends of the sag that a taut start is given [-]


class Potential(StaticSystem):
    """Energy, forces and Hessians of cables under given loads, and their constraints at a time.

    Args:
        cables: of one kind, whose nodes follow each other.   external: (n, 2, dim) [N, Nm].   time: [s].
    """

    def __init__(self, cables: Sequence[Cable], external: Array, time: float) -> None:
        self.cables, self.time = cables, time
        self._nodes, self._dim = tuple(len(cable.reference) for cable in cables), cables[0].dimension
        self.shape = (sum(self._nodes), 2, self._dim)
        self.places = [slice(a, b) for a, b in pairwise(accumulate(self._nodes, initial=0))]
        self._chain = in_one([self._build_chain(cable) for cable in cables])
        self._external = external.reshape(self.shape)
        kinds = [kinds_of_cable(cable) for cable in cables]
        self.numbers_of_constraints = [sum(len(kind.constant) for kind in own) for own in kinds]
        self.constraints = constraints_of_cables(cables, kinds)
        self._lengths = np.concatenate([cable.element_lengths for cable in cables])
        self._bending = self._of_cables(lambda cable: cable.section.bending_stiffness)
        self._of_length = self._of_cables(lambda cable: cable.length)
        density = self._of_cables(lambda cable: cable.section.mass_per_length)
        mean_length = self._of_cables(lambda cable: cable.element_lengths.mean())
        masses = np.concatenate([masses_of_elements(cable) for cable in cables])
        bending = forms_of_mesh(stiffness_matrix, self._lengths)
        self.mass = self._assembled(masses)
        self._stiffness = self._assembled(self._in_elements(self._bending) * bending)
        smoothing = self._in_elements(mean_length * self._of_length**3 * density)
        self.metric = self._assembled(masses + smoothing * bending)
        scale = np.ones(self.shape)
        scale[:, 1] = 1.0 / np.repeat(mean_length, self._nodes)[:, None]
        self.scale = scale.ravel()  # of forces: moments count over the element length
        self.order = np.arange(self.scale.size)
        self.length = float(self._of_length.max())
        self.inertia = float((density * self._of_length**2).max())
        self.largest_load = float(self._largest_loads.max())
        self.shift = self.largest_load / self.inertia
        extent = max(float(np.abs(cable.reference[:, 0]).max()) for cable in cables)
        self._of_places = ROUND_OFF * max(0.0, extent - self.length) / float(self._lengths.min())
        self.round_off = self._of_places * float(np.abs(self._external[:, 0]).sum())

    @staticmethod
    def _build_chain(cable: Cable) -> Chain:
        return build_chain(cable)

    def _of_cables(self, value: Callable[[Cable], float]) -> Array:
        """(C,)"""
        return np.array([value(cable) for cable in self.cables])

    def _in_elements(self, values: Array) -> Array:
        """(N, 1, 1) of the cables' values (C,)."""
        return np.repeat(values, np.subtract(self._nodes, 1))[:, None, None]

    def _assembled(self, forms: Array) -> SparseArray:
        return assembled(forms, self._nodes, self._dim)

    @cached_property
    def _largest_loads(self) -> Array:
        """(C,) of the external forces [N], and of bending to a radius of the cable's length."""
        sizes = np.abs(self._external * self.scale.reshape(self.shape)).max(axis=(1, 2))
        firsts = [place.start for place in self.places]
        return np.maximum.reduceat(sizes, firsts) + self._bending / self._of_length**2

    def turn_with(self, q: Array) -> None:
        """The slopes at both ends of a ring are joined across the first one, which may turn."""
        if any(cable.closed for cable in self.cables):
            slopes = [q[place.start, 1] for place in self.places]
            kinds = list(map(kinds_of_cable, self.cables, slopes))
            self.constraints = constraints_of_cables(self.cables, kinds)

    def energy(self, q: Array) -> float:
        """Bending energy less the work of the loads [J]."""
        return float(elastic_energy(self._chain, q)) - float(np.sum(self._external * q))

    def fall(self, q: Array, trial: Array) -> float:
        """How much lower the energy is at `trial` [J]."""
        return self.energy(q) - self.energy(trial)

    def scale_of_energy(self, q: Array) -> float:
        """[J]"""
        return abs(self.energy(q)) + float(self._largest_loads @ self._of_length)

    def turn(self, step: Array) -> float:
        """Largest change of a slope in a step (n, 2, dim)."""
        return float(np.abs(step[:, 1]).max())

    def excursion(self, step: Array) -> float:
        """[m], slopes times the element length."""
        return float(np.abs(step.ravel() / self.scale).max())

    def force(self, q: Array) -> Array:
        """(n_dof,) elastic and external force."""
        force = self._external.copy()
        add_elastic_force(self._chain, q, force)
        return force.ravel()

    def values(self, q: Array) -> Array:
        """(m,) all constraints."""
        return self.constraints.value(q, self.time)

    def jacobian(self, q: Array) -> SparseArray:
        """(m, n_dof) of all constraints."""
        return self.constraints.jacobian(q, self.time)

    def strains(self, q: Array) -> Array:
        """There are none."""
        return np.zeros(0)

    def strain_rows(self, q: Array) -> SparseArray:
        """There are none."""
        return scipy.sparse.csr_array((0, q.size))

    def hessian(self, q: Array, multipliers: Array, is_rough: bool = False) -> SparseArray:
        """Of the Lagrangian."""
        return scipy.sparse.csr_array(self.elastic_tangent(q) + self.constraints.hessian(multipliers))

    def elastic_tangent(self, q: Array) -> SparseArray:
        """-dF/dq (n_dof, n_dof)."""
        is_linear = self.cables[0].measure is not CurvatureMeasure.PRODUCT
        return self._tangent_of_linear_forces if is_linear else elastic_tangent(self._chain, q, self._nodes)

    @cached_property
    def _tangent_of_linear_forces(self) -> SparseArray:
        return elastic_tangent(self._chain, np.zeros(self.shape), self._nodes)

    def convex_model(self, multipliers: Array, shift: float) -> SparseArray:
        """Bending stiffness, mean tension of the elements where it pulls, and shift times the mass."""
        gram = forms_of_mesh(slope_gram_matrix, self._lengths)
        tension = np.maximum(self.mean_tension(multipliers), 0.0)
        geometric = self._assembled(tension[:, None, None] * gram)
        return scipy.sparse.csr_array(self._stiffness + geometric + shift * self.mass)

    def mean_tension(self, multipliers: Array) -> Array:
        """(N,) [N]: 2 lam of the length constraint, and the nodal multipliers' share."""
        rows, tension = self.constraints.rows, np.zeros(len(self._lengths))
        if "length" in rows:
            numbers = accumulate((cable.length_constraints for cable in self.cables), initial=0)
            groups = [
                cable.group_of_element() + first for cable, first in zip(self.cables, numbers, strict=False)
            ]
            tension += 2.0 * multipliers[rows["length"]][np.concatenate(groups)]
        if "nodal inextensibility" in rows:
            nodal, left = np.zeros(self.shape[0]), left_nodes(self._nodes)
            fixed = np.concatenate([cable.fixed for cable in self.cables])
            nodal[~fixed[:, 1]] = multipliers[rows["nodal inextensibility"]]
            tension += (nodal[left + 1] + nodal[left]) / self._lengths
        return tension

    def size(self, force: Array) -> float:
        """Largest component [N], moments over the element length."""
        return float(np.abs(force * self.scale).max(initial=0.0))

    def bowed(self, q: Array) -> Array:
        """q with a sag towards the loads, or anywhere: on a straight line no step makes a cable longer."""
        q = q.copy()
        for cable, place, largest in zip(self.cables, self.places, self._largest_loads, strict=True):
            _bow(cable, q[place], self._external[place, 0].sum(axis=0), 1e-6 * largest)
        return q


def _bow(cable: Cable, q: Array, load: Array, smallest: float) -> None:
    """Give a cable a sag.   q: (n, 2, dim) output.   load: (dim,).   smallest: load that counts [N]."""
    arc = np.append(0.0, np.cumsum(cable.element_lengths)) * np.pi / cable.length
    chord = q[-1, 0] - q[0, 0]
    chord = chord / max(float(np.linalg.norm(chord)), 1e-300)
    candidates = np.stack([load, *np.eye(q.shape[2])])
    across = candidates - np.outer(candidates @ chord, chord)
    sizes = np.linalg.norm(across, axis=1)
    chosen = 0 if sizes[0] > smallest else 1 + int(np.argmax(sizes[1:]))
    sag = BOW * cable.length / np.pi * across[chosen] / sizes[chosen]
    q[:, 0] += np.outer(np.sin(arc), sag)
    q[:, 1] += np.outer(np.cos(arc), sag * np.pi / cable.length)


def support_forces(cable: Cable, q: Array, multipliers: Array, time: float) -> SupportForces:
    """What supports and links do to a cable at rest, at q (n, 2, dim).

    multipliers: (m,) of its constraints.   time: of its motions [s].
    """
    constraints = constraints_of_cable(cable)
    of_links, held = np.zeros(len(cable.links)), np.zeros(constraints.number)
    for kind in {link.kind for link in cable.links}:
        of_links[[link.kind == kind for link in cable.links]] = multipliers[constraints.rows[kind]]
    for kind in constraints.rows.keys() & {*HELD, *MOTIONS}:
        held[constraints.rows[kind]] = multipliers[constraints.rows[kind]]
    on_coordinates: Array = (constraints.jacobian(q, time).T @ held).reshape(q.shape)
    if cable.closed:
        on_coordinates[0] += on_coordinates[-1]
    return SupportForces(on_coordinates[np.newaxis], of_links[np.newaxis], np.zeros((1, q.size)))
