"""What a run needs to know of cables, bodies and joints that move together, whoever evaluates them."""

from typing import Any, Protocol

import numpy as np

from ..arrays import Array


class EvaluatedScene(Protocol):
    """A scene by whom evaluates it: Exudyn, or compiled code.

    forces: (n,) all but gravity on the coordinates at the last evaluation [N, Nm].
    """

    @property
    def forces(self) -> Array: ...

    def report_energy(self, t: float, state: Any, energy_report: Array, scale: float = np.inf) -> None:
        """Of all but the items' work, as `system.report_energy`; the state at t [s] was evaluated last.

        scale: of violated joints [m, -]; infinite: nobody looks at them.
        """

    def kinetic_energy(self, q: Array, v: Array) -> float:
        """With velocities v (n,) at q (n,), the state of the last evaluation [J]."""

    def energies_of_spins(self, duration: float) -> Array:
        """(size,) what a . M a / 2 lacks where bodies turn in space, at the last evaluation [J/s^2].

        (0,) where none do.   duration: of the run [s].
        """

    @property
    def fastest_turn(self) -> float:
        """Largest rate of springs that count turns, at the last evaluation [rad/s]; 0 where Exudyn does."""

    def leave_out_turns(self, way: Array) -> None:
        """Take whole turns off the angles of bodies in space, in place.   way: (n,)."""

    def violations(self, t: float, q: Array) -> Array:
        """(m,) of the rows of joints [m, -]."""

    def set_multipliers(self, cable: int, t: float, q: Array, v: Array) -> Array:
        """Accelerations of a cable, whose system then holds its multipliers.

        The scene has been evaluated at (t, q, v).
        """
