"""Coordinates of bodies that native constraints hold to ground: they are left out of the equations."""

from collections.abc import Iterable, Mapping
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..items.arguments import described
from ..run.consistent_start import PLACES, RATES, warn_of_velocities
from ..scene.model import HeldCoordinate
from .bodies import BodyMasses


def holders(mbs: Any, held: Mapping[int, HeldCoordinate]) -> dict[int, int]:
    """Number of the first constraint that holds a coordinate, by its place in the system vector."""
    found: dict[int, int] = {}
    for number, what in held.items():
        place = mbs.systemData.GetNodeLTGODE2(what.node)[what.coordinate]
        found.setdefault(int(place), number)
    return found


class HeldCoordinates:
    """Those that the masses of bodies leave out.

    numbers: of the constraints that hold them.   rows: (k,) their algebraic equations.
    places: (k,) of the coordinates in the system vector.
    """

    def __init__(
        self, mbs: Any, masses: BodyMasses, numbers: Iterable[int], held: Mapping[int, HeldCoordinate]
    ) -> None:
        self._mbs = mbs
        self._masses, self.places = masses, masses.held
        self.numbers = list(numbers)
        rows = [mbs.systemData.GetObjectLTGAE(number)[0] for number in self.numbers]
        self.rows = np.array(rows, dtype=int)
        self._gradients = np.array([held[number].gradient for number in self.numbers])

    def take_hold(self, v: Array, tolerance: float) -> None:
        """Stop them at the start by impulses there, which change the velocities v (n,) of bodies, in place.

        Args:
            v: of coordinates that are not held.   tolerance: see `ExplicitSettings.startTolerance`.

        Raises:
            SceneError: one is not where it is held, or its velocity is not finite.
        """
        data, initial, masses = self._mbs.systemData, exudyn.ConfigurationType.Initial, self._masses
        places = np.asarray(data.GetODE2Coordinates(initial))[masses.held]
        rates = np.asarray(data.GetODE2Coordinates_t(initial))[masses.held]
        if not (places.any() or rates.any()):
            return
        speed = max(1.0, float(np.abs(rates).max()), float(np.abs(v).max(initial=0.0)))
        if said := self._said(PLACES, places, tolerance):
            raise SceneError(f"{said}: correct the initial values of its node.")
        said = self._said(RATES, rates / speed, tolerance)
        if not np.isfinite(rates).all():
            raise SceneError(f"{said}: correct the initial values of its node.")
        before = masses.system.kinetic_energy(v) + float(
            rates @ (masses.coupling @ v + 0.5 * masses.held_mass @ rates)
        )
        v += masses.system.solve(rates @ masses.coupling)
        if said:
            warn_of_velocities(said, before, masses.system.kinetic_energy(v))

    def reactions(self, forces: Array, a: Array) -> Array:
        """Lagrange multipliers (k,) of the constraints.

        Args:
            forces: (k,) on the held coordinates [N, Nm].   a: (n,) accelerations of the other ones.
        """
        return (forces - self._masses.coupling @ a) / self._gradients

    def _said(self, what: str, values: Array, tolerance: float) -> str:
        """Which held coordinate has the largest value, if that is above the tolerance."""
        worst = int(np.argmax(np.abs(values)))
        if abs(values[worst]) <= tolerance:
            return ""
        number = self.numbers[worst]
        name = described(self._mbs.GetObject(number), number)
        return f"the {what} violate {name} by {values[worst]:.3g} (limit {tolerance:g})"
