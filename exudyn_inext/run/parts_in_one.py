"""Cables, bodies and joints as one compiled system, to which Exudyn gives the forces."""

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..arrays import Array
from ..called_system import Bound, called, kernel_behind
from ..compiled import Prepared
from ..integrators.rattle import shake_called
from ..multibody.scene import bodies_energy, subtract_inertia_forces, subtract_joint_forces
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .compiled_scene import CompiledScene


class CompiledParts:
    """The compiled form of cables, bodies and joints, without springs and loads.

    Args:
        form: of them.   others: places of the bodies among the coordinates, and of first order states.

    multipliers: (m,) of the joints at the last evaluation.
    """

    def __init__(self, form: CompiledScene, others: Sequence[slice]) -> None:
        self.form = form
        self._items = form.system.items
        self._others = others
        states = others[-1].stop - others[0].stop  # of first order, last among the records
        self._bodies = self._items.bodies[: len(self._items.bodies) - states]
        self._cables = len(form.system.cable_force)
        self.multipliers = form.multipliers
        self._subtract_inertia = Prepared(subtract_inertia_forces)
        form.given[:] = 0.0

    def _bound(self, protocol: Any) -> Bound:
        self.form.provide((protocol,))
        return Bound(protocol, self.form.system)

    @cached_property
    def _rates(self) -> Bound:
        return self._bound(index_reduced_rates)

    @cached_property
    def _accelerate(self) -> Bound:
        return self._bound(accelerate_and_project)

    @cached_property
    def _correct(self) -> Bound:
        return self._bound(correct_position)

    @cached_property
    def _shake(self) -> Callable[..., None]:
        self.form.provide((correct_position,))
        return partial(Prepared(kernel_behind(shake_called)), called(self.form.system, correct_position))

    @property
    def drift(self) -> Array:
        """(m,) c_t at the last evaluation."""
        result: Array = -self._items.joints.rows["drift"]
        return result

    def subtract_inertia(self, q: Array, v: Array, forces: Array) -> None:
        """See `NativeItems`."""
        self._subtract_inertia(self._bodies, q, v, forces)

    def rates(self, t: float, forces: Sequence[Array], *arrays: Array) -> None:
        """See `index_reduced_rates`.   forces: on all cables, then on the others."""
        self._rates(self._external(t, forces), *arrays)
        self.form.require_independence()

    def accelerate(self, t: float, forces: Sequence[Array], *arguments: Any) -> None:
        """See `accelerate_and_project`."""
        self._accelerate(self._external(t, forces), *arguments)
        self.form.require_independence()

    def correct(self, t: float, *arguments: Any) -> float:
        """See `correct_position`."""
        return float(self._correct(self.form.loads.at(t), *arguments))

    def shake(self, t: float, *arguments: Any) -> None:
        """See `integrators.rattle.shake`."""
        self._shake(self.form.loads.at(t), *arguments)

    def _external(self, t: float, forces: Sequence[Array]) -> Array:
        """As the system takes it; forces on the others are given to them."""
        number = len(forces) - len(self._others)
        for dofs, force in zip(self._others, forces[number:], strict=True):
            self._items.given[dofs] = force
        external = self.form.loads.at(t)
        if number:
            external[: self._cables] = np.concatenate(forces[:number])
        return external

    def joint_force(self, dofs: slice) -> Array:
        """J^T nu on one part, at the last evaluation.   dofs: its place."""
        total = np.zeros(len(self._items.force))
        subtract_joint_forces(self._items.joints, total)
        result: Array = -total[dofs]
        return result

    def kinetic_energy_of_bodies(self, q: Array, v: Array) -> float:
        """[J], with velocities v (n,) at q (n,)."""
        return float(bodies_energy(self._bodies, q, v))
