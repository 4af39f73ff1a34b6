"""One cable during a run: its compiled system, its state, and its place in the mbs."""

from typing import Any

import numpy as np

from ..chain.chain import build_chain
from ..chain.frequency import largest_frequency
from ..chain.index_reduction import CableSystem
from ..constraints import constraints_of_cable
from ..element.shape_functions import Array
from ..errors import RedundantConstraintError, SceneError
from ..integrators.integrator import Integrator
from .cable_loads import CableLoads
from .scene import CableInScene

CONSISTENCY_TOLERANCE = 1e-6  # of constraint values [-, m] and, relative to the speed, their rates
PIVOT_TOLERANCE = 1e-10


class CableRun:
    """A cable that an integrator moves.

    system: the index-reduced equations.   loads: external force.   state: of the integrator.
    """

    def __init__(
        self, scene_cable: CableInScene, initial: tuple[Array, Array], zeta: float, integrator: Integrator
    ) -> None:
        self.scene_cable = scene_cable
        self.integrator = integrator
        self.loads = CableLoads(scene_cable)
        self.system: CableSystem = CableSystem(build_chain(scene_cable.cable), zeta)
        self.state: Any = integrator.allocate(scene_cable.cable.reference.size)
        self._reference = scene_cable.cable.reference.ravel()
        self.set_coordinates(initial[0].ravel(), initial[1].ravel())
        check_consistency(scene_cable, *initial)

    @property
    def name(self) -> str:
        return f"cable '{self.scene_cable.name}'"

    def set_coordinates(self, q: Array, v: Array) -> None:
        """Take over total coordinates and velocities, (n_dof,) each."""
        self.state.q[:] = q
        self.state.v[:] = v

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; the history of a multi-step scheme begins here.

        Raises:
            RedundantConstraintError: length constraints and supports depend on each other.
        """
        self.integrator.start(self.system, self.loads.at(time), self.state)
        self._check_pivots()

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration."""
        shape = self.scene_cable.cable.reference.shape
        external, q = self.loads.at(time), self.state.q
        return largest_frequency(self.system, external.reshape(shape), q.reshape(shape).copy())

    def advance(self, scheme: Any, time: float, h: float, steps: int) -> None:
        """Take `steps` steps of size h [s] from `time` in one compiled call."""
        loads = self.loads.sample(time, h, steps, self.integrator.stages)
        self.integrator.advance(self.system, loads, scheme, self.state, h, steps)

    def is_finite(self) -> bool:
        """Whether the state is made of finite numbers."""
        return bool(np.isfinite(self.state.q.sum() + self.state.v.sum() + self.state.a.sum()))

    def displacements(self) -> Array:
        """(n_dof,) coordinates without reference values."""
        return self.state.q - self._reference

    def _check_pivots(self) -> None:
        """Each length multiplier's pivot must be negative, clear of round-off."""
        nodes = self.system.chain.nodes
        ends = np.flatnonzero(nodes.ends_group)
        pivots = 1.0 / nodes.inverse_pivot[ends, -1]
        mass = self.scene_cable.cable.section.mass_per_length * self.scene_cable.cable.element_lengths
        dependent = ~(pivots < -PIVOT_TOLERANCE * 8.0 / mass[ends - 1])
        if dependent.any():
            k = int(ends[np.argmax(dependent)])
            raise RedundantConstraintError(
                f"the length constraint of the element between nodes {k - 1} and {k} of {self.name} is not "
                "independent of the other constraints (a straight cable between two supports as far apart "
                "as it is long, or an element clamped at both ends): let the cable sag, free a support, "
                "or use a smaller numberOfLengthConstraints."
            )


def check_consistency(scene_cable: CableInScene, q: Array, v: Array) -> None:
    """Initial coordinates and velocities (n, 2, dim) must satisfy all constraints.

    Raises:
        SceneError: names the worst constraint and by how much it is violated.
    """
    speed = max(1.0, float(np.abs(v).max()))
    for constraint in constraints_of_cable(scene_cable.cable):
        value = constraint.value(q)
        rate = constraint.jacobian(q) @ v.ravel() / speed
        for what, violation in (("initial coordinates", value), ("initial velocities", rate)):
            worst = int(np.argmax(np.abs(violation)))
            if not abs(violation[worst]) <= CONSISTENCY_TOLERANCE:
                raise SceneError(
                    f"the {what} of cable '{scene_cable.name}' violate the {constraint.name} constraint at "
                    f"the {constraint.describe(worst)} by {violation[worst]:.3g} (limit "
                    f"{CONSISTENCY_TOLERANCE:g}): correct initialCoordinates or initialVelocities of its nodes."
                )
