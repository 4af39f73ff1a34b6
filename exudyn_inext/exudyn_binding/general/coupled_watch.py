"""The watch over cables, bodies and joints that move together.

Exudyn's items do work along the way, which is counted at each step: that of linear springs exactly. A mass
that depends on the configuration changes the energy, too: the forces of Exudyn contain what its change does
to the momentum, of which the kinetic energy takes one half.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...arrays import Array
from ...integrators.watch import add_work, build_watch, judge, open_with_gauges
from ...system import AGITATION, KINETIC, POWER, VIOLATION, gauge
from ..cable_run import CableRun
from ..cable_watch import memory_of
from .coupled_scene import CoupledScene

STEPS_BETWEEN = 16
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
        self._since = np.zeros(2)  # the last inspection: steps, and its time [s]

    def open(self, t: float, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        self._take_forces()
        self._set_gauges(t, state)
        self._bodies.system.energy_of_change(state.v[self._bodies.dofs])
        self._since[:] = 0.0, t
        extent = float(np.abs(state.q).max(initial=0.0))
        open_with_gauges(self.watch, state, ROUND_OFF * extent * float(np.abs(self.watch.force_now).sum()))

    def is_well_after(self, t: float, h: float, state: Any) -> bool:
        """Count the work of a step that has ended at t [s], and judge from time to time."""
        self._take_forces()
        self._add_change_of_mass(h, state.q)
        add_work(self.watch, state.q)
        self._since[0] += 1
        if self._since[0] < STEPS_BETWEEN:
            return True
        self._set_gauges(t, state)
        trouble = judge(self.watch, state, STEPS_BETWEEN, t - self._since[1])
        self._since[:] = 0.0, t
        return not trouble

    def give_up(self, state: Any) -> None:
        """The last step could not be taken: the state is that of the last inspection."""
        self.watch.gauges_now[:] = np.nan
        judge(self.watch, state, STEPS_BETWEEN, 0.0)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next inspections depend on, by names."""
        return memory_of(self.watch) | {"since": self._since}

    def resume(self, state: Any) -> None:
        """Go on with the memory that has been set; the scene has been evaluated."""
        self._bodies.system.energy_of_change(state.v[self._bodies.dofs])

    def _take_forces(self) -> None:
        np.add(self._scene.surroundings.native_forces, self._gravity, out=self.watch.force_now)

    def _add_change_of_mass(self, h: float, q: Array) -> None:
        dofs = self._bodies.dofs
        mean = (q[dofs] - self.watch.position[dofs]) / h
        self.watch.account[0].work += self._bodies.system.energy_of_change(mean)

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
