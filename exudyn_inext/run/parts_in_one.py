"""Cables, bodies and joints as one compiled system, to which Exudyn gives the forces."""

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..called_system import Bound, called
from ..compiled import Prepared, kernel, plain
from ..integrators.rattle import Rattle, shake
from ..multibody.scene import bodies_energy, subtract_inertia_forces
from ..scene.coupled_system import leap
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .compiled_scene import CompiledScene

_NOTHING = np.zeros(0)
_shake = kernel(plain(shake))


class CompiledParts:
    """The compiled form of cables, bodies and joints, without springs and loads.

    Args:
        form: of them.   states: how many of first order there are, last among the records of bodies.

    multipliers: (m,) of the joints at the last evaluation.   subtract_inertia: see `NativeItems`.
    """

    def __init__(self, form: CompiledScene, states: int) -> None:
        self.form = form
        self._items = form.system.items
        self._bodies = self._items.bodies[: len(self._items.bodies) - states]
        self._states, self._has_states = slice(len(form.given) - states, None), states > 0
        self.multipliers = form.multipliers
        self._subtract_inertia = partial(Prepared(subtract_inertia_forces), self._bodies, self._items.trees)
        changes = form.numbers.changing_masses
        self.subtract_inertia = self._subtract_and_weigh if changes else self._subtract_inertia
        form.given[:] = 0.0

    def _subtract_and_weigh(self, q: Array, v: Array, forces: Array) -> None:
        """Masses that change are those of mbs from then on."""
        self._subtract_inertia(q, v, forces)
        self.form.weigh()

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
        return partial(Prepared(_shake), called(self.form.system, correct_position))

    @property
    def drift(self) -> Array:
        """(m,) c_t at the last evaluation."""
        return -self._items.joints.rows["drift"]

    def rates(self, t: float, forces: Array, *arrays: Array) -> None:
        """See `index_reduced_rates`.   forces: (n,) see `NativeItems.act`."""
        self._rates(self._external(t, forces), *arrays)
        self.form.require_independence()

    def take_step(self, native_items: Any, t: float, h: float, scheme: Rattle, state: Any) -> None:
        """A step of h [s] to t [s], see `advance_rattle`, with forces of Exudyn at its end."""
        external, states, half = self.form.loads.at(t), self._states, 0.5 * h
        self._shake(external, state, h, scheme)
        velocity, rates = state.v_half + half * state.a, _NOTHING
        middle = t, state.q, state.v_half, half, state.a
        if self._has_states:
            rates, velocity[states] = leap(native_items, states, *middle)
        self._items.given[:] = native_items.act(t, state.q, velocity)
        self._items.given[states] = rates
        self._accelerate(external, state.q, state.v_half, half, state.a, state.v)
        state.v[states] = velocity[states]
        self.form.require_independence()

    def accelerate(self, t: float, forces: Array, *arguments: Any) -> None:
        """See `accelerate_and_project`."""
        self._accelerate(self._external(t, forces), *arguments)
        self.form.require_independence()

    def correct(self, t: float, *arguments: Any) -> float:
        """See `correct_position`."""
        return float(self._correct(self.form.loads.at(t), *arguments))

    def _external(self, t: float, forces: Array) -> Array:
        """What the cables' own loads are; the forces are given to all parts."""
        self._items.given[:] = forces
        return self.form.loads.at(t)

    def solve(
        self, cables: Sequence[Cable], native_items: Any, time: float, step: float, state: Any
    ) -> tuple[Array, Array, Array]:
        """Accelerations (n,), multipliers (m,) of the joints, and what items and joints do (n,).

        By the mass as it is, in a state at `time` [s], after a step [s]; the steps are not touched.
        """
        self._items.given[:] = native_items.act(time, state.q, state.v)
        history = np.array([[state.q, state.v, state.a]])
        multipliers, forces = self.form.evaluate(cables, np.array([time]), np.array([step]), history)
        return history[0, 2], multipliers[0], forces[0]

    def joint_force(self, dofs: slice) -> Array:
        """J^T nu on one part, at the last evaluation.   dofs: its place."""
        total = np.zeros(len(self._items.force))
        self.form.subtract_joint_forces(total)
        return -total[dofs]

    def kinetic_energy_of_bodies(self, q: Array, v: Array) -> float:
        """[J], with velocities v (n,) at q (n,)."""
        return float(bodies_energy(self._bodies, self._items.trees, q, v))
