"""The watch over cables, bodies and joints that move together.

Exudyn's items do work along the way, which is counted step by step: that of linear springs exactly. A mass
that depends on the configuration changes the energy, too: the forces of Exudyn contain what its change does
to the momentum, of which the kinetic energy takes one half.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...arrays import Array
from ...integrators.watch import build_watch, judge, judge_after_steps, open_with_gauges
from ...system import AGITATION, KINETIC, POWER, VIOLATION, gauge
from ..cable_run import CableRun
from ..cable_watch import memory_of
from .coupled_scene import CoupledScene

STEPS_BETWEEN = 128  # two inspections at most
STEPS_WITH_POWER = 32  # at most where damping or supports that move change the energy
STEPS_BETWEEN_GLANCES = 4  # at the velocities
CALM = 4.0  # growth of their square since the last inspection that calls for no other one
LENIENCE = 10.0  # of the energy: forces that jump, as those of contact do, have work between two steps
ROUND_OFF = 1e-10  # of the energy, relative to the forces times the extent


class CoupledWatch:
    """Keeps the account of a coupled scene.

    Args:
        scene: the scene.   runs: of its cables.   state: of the integrator.   energy_tolerance: see
            `ExplicitSettings.energyTolerance`.
    """

    def __init__(
        self, scene: CoupledScene, runs: Sequence[CableRun], state: Any, energy_tolerance: float
    ) -> None:
        self._scene = scene
        self._runs = runs
        self._bodies = scene.system.parts[len(runs)]
        number = len(scene.map.indices)
        short = np.zeros(number)
        self.watch = build_watch(state, STEPS_BETWEEN, LENIENCE * energy_tolerance)._replace(
            position=short.copy(),
            force=short.copy(),
            change=short.copy(),
            way=short.copy(),
            force_now=short.copy(),
        )
        self._gravity = np.zeros(number)
        for run, dofs in zip(runs, scene.map.slices, strict=False):
            self._gravity[dofs] = run.loads.constant[: dofs.stop - dofs.start]
        self._last = np.zeros(2)  # inspection: its time [s], and the square of the velocities then
        self._steps = 0  # since then
        self._most_steps = STEPS_BETWEEN
        self._kept_steps = np.zeros(2, int)
        self._rows = np.zeros((STEPS_BETWEEN + 1, 3, len(state.q)))
        self._forces = np.zeros((STEPS_BETWEEN, number))  # without gravity
        self._masses = self._bodies.system.make_room_for_masses(STEPS_BETWEEN + 1)

    @property
    def row(self) -> Array:
        """(1, 3, n) for q, v, a after the next step."""
        return self._rows[self._steps + 1 : self._steps + 2]

    def open(self, t: float, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        self._set_gauges(t, state)
        self._begin(t, state)
        self.watch.force_now[:] = self._scene.surroundings.native_forces + self._gravity
        extent = float(np.abs(state.q).max(initial=0.0))
        open_with_gauges(self.watch, state, ROUND_OFF * extent * float(np.abs(self.watch.force_now).sum()))

    def is_well_after(self, t: float, h: float, state: Any) -> bool:
        """Count a step to t [s], which `row` shows; judge from time to time, and if velocities grow."""
        self._forces[self._steps] = self._scene.surroundings.native_forces
        self._steps = steps = self._steps + 1
        if self._masses:
            self._bodies.system.keep_masses(steps)
        if steps < self._most_steps and (steps % STEPS_BETWEEN_GLANCES or self._is_calm(state.v)):
            return True
        self._set_gauges(t, state)
        trouble = self._judge(h, t - self._last[0], state)
        self._begin(t, state)
        return not trouble

    def give_up(self, state: Any) -> None:
        """The last step could not be taken: the state is that of the last inspection."""
        self.watch.gauges_now[:] = np.nan
        judge(self.watch, state, STEPS_BETWEEN, 0.0)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next inspections depend on, by names."""
        self._kept_steps[:] = self._steps, self._most_steps
        rows = {"rows": self._rows, "forces": self._forces, "masses": self._masses}
        return memory_of(self.watch) | rows | {"last": self._last, "steps": self._kept_steps}

    def resume(self) -> None:
        """Go on with the memory that has been set."""
        self._steps, self._most_steps = (int(number) for number in self._kept_steps)

    def _begin(self, t: float, state: Any) -> None:
        """Count steps from a state at t [s]."""
        self._steps = 0
        self._most_steps = STEPS_WITH_POWER if self.watch.gauges_now[POWER] else STEPS_BETWEEN
        self._last[:] = t, state.v.dot(state.v)
        self._rows[0, 0] = state.q
        self._bodies.system.keep_masses(0)

    def _is_calm(self, v: Array) -> bool:
        return bool(v.dot(v) <= CALM * self._last[1])

    def _judge(self, h: float, duration: float, state: Any) -> int:
        steps = self._steps
        positions = self._rows[: steps + 1, 0, : len(self._gravity)]
        if self._masses:
            rates = np.diff(positions[:, self._bodies.dofs], axis=0) / h
            self.watch.account[0].work += self._bodies.system.energy_of_changes(rates)
        forces = self._forces[:steps] + self._gravity
        return int(judge_after_steps(self.watch, state, positions[1:], forces, duration))

    def _set_gauges(self, t: float, state: Any) -> None:
        total = self.watch.gauges_now
        total[:] = 0.0
        for cable, (run, dofs) in enumerate(zip(self._runs, self._scene.map.slices, strict=False)):
            if len(run.loads.pattern) and self._scene.joints:
                self._scene.set_multipliers(cable, t, state.q, state.v)  # its own solve knows no joints
            mine, force = np.zeros(5), np.zeros(dofs.stop - dofs.start)
            gauge.dispatch(type(run.system))(
                run.system, run.loads.at(t), state.q[dofs], state.v[dofs], state.a[dofs], force, mine
            )
            worst = np.maximum(total[VIOLATION], mine[VIOLATION])
            total += mine
            total[VIOLATION] = worst
        bodies = self._bodies
        total[KINETIC] += bodies.system.kinetic_energy(state.v[bodies.dofs])
        total[AGITATION] += bodies.system.kinetic_energy(state.a[bodies.dofs])
        total[POWER] += self._scene.system.multipliers @ self._scene.system.drift

    @property
    def has_trouble(self) -> bool:
        """Whether the last steps went wrong."""
        return bool(self.watch.account[0].trouble)
