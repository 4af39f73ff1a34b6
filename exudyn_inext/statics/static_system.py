"""What the search for an equilibrium knows of what it moves: a cable, or a whole scene."""

from typing import Protocol

import numpy as np

from ..arrays import Array, SparseArray


class StaticSystem(Protocol):
    """Energy or work, forces, Hessians and constraints; states are arrays of n coordinates of any shape.

    length: of the longest cable [m].   largest_load: [N].
    shift: of an indefinite Hessian, by the mass [1/s^2].
    mass: (n, n).   metric: (n, n) by which the way back to the constraints is the shortest one.
    order: (n,) place of each coordinate in the order of elimination.
    indifferent: eigenvalue, at most 0, above which an equilibrium counts as stable [1/s^2].
    of_others: (n, n) what items that are no cables add to the last Hessian; None: there are none.
    round_off: force that round-off of strains leaves [N], also of places far from the origin.
    """

    mass: SparseArray
    metric: SparseArray
    order: np.ndarray
    length: float
    largest_load: float
    shift: float
    indifferent: float = 0.0
    of_others: "SparseArray | None" = None
    round_off: float = 0.0

    def turn_with(self, q: Array) -> None:
        """Constraints may follow the configuration from one step to the next."""

    def fall(self, q: Array, trial: Array) -> float:
        """How much lower the energy is at `trial` than at q [J]."""

    def scale_of_energy(self, q: Array) -> float:
        """Relative to which round-off hides a gain [J]."""

    def is_blocked(self, q: Array, trial: Array) -> bool:
        """Whether something lies in the way from q to `trial`, so that the step has to be shorter."""
        return False

    def turn(self, step: Array) -> float:
        """Largest change of a slope, and angle of a body, in a step; long ways of bodies count, too."""

    def excursion(self, step: Array) -> float:
        """Largest change of a coordinate in a step [m]; slopes and turns count times a length."""

    def bowed(self, q: Array) -> Array:
        """q with sagging cables."""

    def force(self, q: Array) -> Array:
        """(n,) of all but the constraints."""

    def size(self, force: Array) -> float:
        """Largest component of a force [N], moments over a length."""

    def values(self, q: Array) -> Array:
        """(m,) of the constraints."""

    def jacobian(self, q: Array) -> SparseArray:
        """(m, n)"""

    def strains(self, q: Array) -> Array:
        """(k,) of cables that stretch, in any measure."""

    def strain_rows(self, q: Array) -> SparseArray:
        """(k, n) derivatives of `strains`."""

    def hessian(self, q: Array, multipliers: Array, is_rough: bool = False) -> SparseArray:
        """(n, n) of the Lagrangian.   is_rough: where it is found by differences, these are one-sided."""

    def convex_model(self, multipliers: Array, shift: float) -> SparseArray:
        """(n, n) positive definite, near to the Hessian but for what other items add to it."""
