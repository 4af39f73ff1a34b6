"""The watch over cables, bodies and joints that move together.

Exudyn's items do work along the way, which is counted step by step: that of linear springs exactly. A mass
that depends on the configuration changes the energy, too: the forces of Exudyn contain what its change does
to the momentum, of which the kinetic energy takes one half.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...arrays import Array
from ...integrators.watch import build_watch, judge, judge_after_steps, open_with_gauges
from ...system import AGITATION, KINETIC, POWER, VIOLATION, gauge
from ..cable_run import CableRun
from ..cable_watch import memory_of
from .coupled_scene import CoupledScene

STEPS_BETWEEN = 512  # two inspections at most
ROOM = 2**21  # coordinates, and as many forces, of the steps that are remembered: 16 MB each
STEPS_WITH_POWER = 32  # at most where damping or supports that move change the energy
STEPS_BETWEEN_GLANCES = 32  # at the velocities
CALM = 16.0  # growth of their square since the last inspection that calls for another one
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
        self._surroundings = scene.surroundings
        self._runs = runs
        self._longest = max(STEPS_WITH_POWER, min(STEPS_BETWEEN, ROOM // max(len(state.q), 1)))
        self._bodies = scene.system.parts[len(runs)]
        number = len(scene.map.indices)
        self.watch = build_watch(state, self._longest, LENIENCE * energy_tolerance)
        self._gravity = np.zeros(number)
        for run, dofs in zip(runs, scene.map.slices, strict=False):
            self._gravity[dofs] = run.loads.constant[: dofs.stop - dofs.start]
        self._last = np.zeros(2)  # inspection: its time [s], and the square of the velocities then
        self._calm = 0.0  # largest square of velocities that calls for no other one
        self._steps = 0  # since then
        self._next = 0  # number of them at which to look
        self._most_steps = self._longest
        self._kept_steps = np.zeros(2, int)
        # one step before the last inspection, then, and after each step since:
        self._positions = np.zeros((self._longest + 4, len(state.q)))
        self._forces = np.zeros((self._longest + 2, number))  # without gravity
        self._rows = list(sliding_window_view(self._positions[2:], (3, len(state.q)), writeable=True))
        self._rows_of_forces = list(self._forces[2:])
        self._masses = self._bodies.system.make_room_for_masses(self._longest + 1)

    def open(self, t: float, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        self._set_gauges(t, state)
        self._steps = 0
        self._positions[0] = state.q
        self._forces[:2] = forces = self._surroundings.native_forces.copy()
        self._begin(t, state)
        extent = float(np.abs(state.q).max(initial=0.0))
        size = float(np.abs(forces + self._gravity).sum())
        open_with_gauges(self.watch, state, ROUND_OFF * extent * size)

    @property
    def keeps_masses(self) -> bool:
        """Whether there are masses that change."""
        return bool(self._masses)

    @property
    def steps_ahead(self) -> int:
        """That may be taken before the next `is_well_at`."""
        return self._next - self._steps

    def memory_of_steps(self, steps: int) -> Iterable[tuple[Array, Array]]:
        """Of each of the next steps: (1, 3, n) for q, v, a after it, and (n,) for Exudyn's forces then.

        v and a lie where the next ones' q will be.
        """
        following = slice(self._steps, self._steps + steps)
        return zip(self._rows[following], self._rows_of_forces[following], strict=True)

    def keep_masses(self, step: int) -> None:
        """Remember the masses after that one of the next steps."""
        self._bodies.system.keep_masses(self._steps + step + 1)

    def count(self, steps: int) -> None:
        """These steps have been taken."""
        self._steps += steps

    def is_well_at(self, t: float, h: float, state: Any) -> bool:
        """Judge the steps of h [s] until t [s] from time to time, and if velocities grow."""
        steps = self._steps
        if steps < self._next:
            return True
        if steps < self._most_steps and state.v.dot(state.v) <= self._calm:
            self._next = min(steps + STEPS_BETWEEN_GLANCES, self._most_steps)
            return True
        self._set_gauges(t, state)
        trouble = self._judge(h, t - self._last[0], state)
        self._begin(t, state)
        return not trouble

    def give_up(self, state: Any) -> None:
        """The last step could not be taken: the state is that of the last inspection."""
        self.watch.gauges_now[:] = np.nan
        judge(self.watch, state, self._longest, 0.0)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next inspections depend on, by names."""
        self._kept_steps[:] = self._steps, self._most_steps
        rows = {"positions": self._positions, "forces": self._forces, "masses": self._masses}
        return memory_of(self.watch) | rows | {"last": self._last, "steps": self._kept_steps}

    def resume(self) -> None:
        """Go on with the memory that has been set."""
        self._steps, self._most_steps = (int(number) for number in self._kept_steps)
        self._calm = CALM * float(self._last[1])
        self._look_again()

    def _begin(self, t: float, state: Any) -> None:
        """Count steps from a state at t [s]."""
        steps, self._steps = self._steps, 0
        self._positions[0], self._positions[1] = self._positions[steps], state.q
        self._forces[:2] = self._forces[steps : steps + 2]
        self._most_steps = STEPS_WITH_POWER if self.watch.gauges_now[POWER] else self._longest
        self._last[:] = t, state.v.dot(state.v)
        self._calm = CALM * float(self._last[1])
        self._look_again()
        self._bodies.system.keep_masses(0)

    def _look_again(self) -> None:
        passed = self._steps - self._steps % STEPS_BETWEEN_GLANCES
        self._next = min(passed + STEPS_BETWEEN_GLANCES, self._most_steps)

    def _judge(self, h: float, duration: float, state: Any) -> int:
        rows = self._steps + 2
        positions, forces = self._positions[:rows], self._forces[:rows]
        if self.keeps_masses:
            rates = np.diff(positions[1:, self._bodies.dofs], axis=0) / h
            self.watch.account[0].work += self._bodies.system.energy_of_changes(rates)
        return int(judge_after_steps(self.watch, state, self._gravity, positions, forces, duration))

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
