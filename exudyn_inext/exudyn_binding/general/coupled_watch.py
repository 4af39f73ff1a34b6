"""The watch over cables, bodies and joints that move together.

Exudyn's items do work along the way, which is counted step by step: that of linear springs exactly. A mass
that depends on the configuration changes the energy, too: the forces of Exudyn contain what its change does
to the momentum, of which the kinetic energy takes one half.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from ...integrators.path_work import WAY, begin_path, build_path, follow, take_sums
from ...integrators.watch import (
    VIOLENT,
    Watch,
    build_watch,
    glance,
    go_on_with_gauges,
    judge,
    judge_after_work,
    open_with_gauges,
)
from ...system import AGITATION, KINETIC, POWER, VIOLATION, gauge
from ..cable_run import CableRun
from ..run_watch import RunWatch
from .coupled_scene import CoupledScene

STEPS_BETWEEN = 1024  # two inspections at most
FIRST_STEPS = 4  # two inspections, which are further and further apart
STEPS_WITH_POWER = 32  # at most where damping or supports that move change the energy
STEPS_BETWEEN_GLANCES = 32  # at the velocities, at most; outputs are looked at, too
CALM = 16.0  # growth of their square since the last inspection that calls for another one
LENIENCE = 10.0  # of the energy: forces that jump, as those of contact do, have work between two steps
ROUND_OFF = 1e-10  # of the energy, relative to the forces times the extent


class CoupledWatch(RunWatch):
    """Keeps the account of a coupled scene.

    Args:
        scene: the scene.   runs: of its cables.   state: of the integrator.   evaluations: in a step.
        energy_tolerance: see `ExplicitSettings.energyTolerance`.

    path_of_evaluations: for `NativeSurroundings.path` during steps.
    after_each_step: what to call then.
    is_close: whether the end of each interval is judged, as where joints are moved step by step.
    """

    is_close = False

    def __init__(
        self,
        scene: CoupledScene,
        runs: Sequence[CableRun],
        state: Any,
        evaluations: int,
        energy_tolerance: float,
        gains_energy: bool,
    ) -> None:
        self._scene = scene
        self._surroundings = scene.surroundings
        self._runs = runs
        self._bodies = scene.system.parts[len(runs)]
        tolerance = LENIENCE * energy_tolerance
        most = VIOLENT * tolerance if gains_energy else np.inf
        self.watch = build_watch(state, STEPS_BETWEEN, tolerance, most=most)
        self._gravity = np.zeros(len(state.q))
        for run, dofs in zip(runs, scene.map.slices, strict=False):
            self._gravity[dofs] = run.loads.constant[: dofs.stop - dofs.start]
        self._path = build_path(len(scene.map.indices))  # the work of all but gravity
        self._changes = np.zeros(1)  # of masses since the last inspection, see `count_changes`
        self.path_of_evaluations = self._path if evaluations == 1 else None
        self.after_each_step: list[Callable[[], None]] = []
        if evaluations > 1:
            self.after_each_step += [partial(follow, self._path, state.q, self._surroundings.varying_forces)]
        if scene.bodies_of_variable_mass:
            way = self._path[WAY, self._bodies.dofs]
            self.after_each_step += [partial(self._bodies.system.count_changes, way, self._changes)]
        self._scale = 1.0  # of violated joints [m, -]
        self._step = 0.0  # last one [s]
        self._last = np.zeros(2)  # inspection: its time [s], and the square of the velocities then
        self._calm = 0.0  # largest square of velocities that calls for no other one
        self._counts = np.zeros(2, int)  # of steps since then, and until the next one at most

    @property
    def _steps(self) -> int:
        return int(self._counts[0])

    @property
    def _most_steps(self) -> int:
        return int(self._counts[1])

    def open(self, t: float, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        forces = self._begin_work(t, state)
        self._counts[1] = FIRST_STEPS
        self._begin(t, state)
        extent = float(np.abs(state.q).max(initial=0.0))
        self._scale = max(1.0, extent)
        size = float(np.abs(forces + self._gravity[: len(forces)]).sum())
        open_with_gauges(self.watch, state, ROUND_OFF * extent * size)

    def _begin_work(self, t: float, state: Any) -> Any:
        """Count work from a state on; returns the forces of Exudyn's items in it."""
        self._set_gauges(t, state)
        forces = self._surroundings.varying_forces
        begin_path(self._path, state.q, forces)
        self._bodies.system.begin_changes()
        self._changes[:] = 0.0
        return forces

    def go_on(self, t: float, state: Any) -> None:
        """With another step, from a state that the integrator has just started from, at t [s]."""
        if self._steps:  # what has gone on since the last inspection counts, and is not judged any more
            self._set_gauges(t, state)
            indifferent = self.watch._replace(tolerance=np.inf, most=np.inf, phase=np.inf)
            self._judge(indifferent, self._step, t - self._last[0], state)
        self._begin_work(t, state)
        self._begin(t, state)
        go_on_with_gauges(self.watch, state)

    @property
    def steps_ahead(self) -> int:
        """That may be taken before the next `is_well_at`."""
        return min(STEPS_BETWEEN_GLANCES, self._most_steps - self._steps)

    def count(self, steps: int) -> None:
        """These steps have been taken."""
        self._counts[0] += steps

    def is_well_at(self, t: float, h: float, state: Any, at_once: bool = False) -> bool:
        """Judge the steps of h [s] until t [s] from time to time, and `at_once`, or if velocities grow."""
        self._step = h
        few = self._steps < self._most_steps and not (self.is_close or at_once)
        if few and glance(state.q, state.v, state.a) <= self._calm:
            return True
        self._set_gauges(t, state)
        trouble = self._judge(self.watch, h, t - self._last[0], state)
        self._begin(t, state)
        return not trouble

    def give_up(self, state: Any) -> None:
        """The last step could not be taken: the state is that of the last inspection."""
        self.watch.gauges_now[:] = np.nan
        judge(self.watch, state, self._most_steps, 0.0)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next inspections depend on, by names."""
        path = {"path": self._path, "changes": self._changes}
        masses = {"masses": self._bodies.system.masses_before()}
        return super().memory() | path | masses | {"last": self._last, "steps": self._counts}

    def resume(self) -> None:
        """Go on with the memory that has been set."""
        self._calm = CALM * float(self._last[1])

    def _begin(self, t: float, state: Any) -> None:
        """Count steps from a state at t [s]."""
        most = STEPS_WITH_POWER if self.watch.gauges_now[POWER] else STEPS_BETWEEN
        self._counts[:] = 0, min(2 * self._counts[1], most)
        self._last[:] = t, state.v.dot(state.v)
        self._calm = CALM * float(self._last[1])

    def _judge(self, watch: Watch, h: float, duration: float, state: Any) -> int:
        work, scatter = take_sums(self._path)
        work += 0.5 * float(self._changes[0]) / h**2
        self._changes[:] = 0.0
        return int(judge_after_work(watch, state, self._gravity, work, scatter, self._steps, duration))

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
        if self._scene.joints:
            worst_of_joints = np.abs(self._surroundings.violations(t, state.q)).max() / self._scale
            total[VIOLATION] = np.maximum(total[VIOLATION], worst_of_joints)
        bodies = self._bodies
        total[KINETIC] += bodies.system.kinetic_energy(state.v[bodies.dofs])
        total[AGITATION] += bodies.system.kinetic_energy(state.a[bodies.dofs])
        total[POWER] += self._scene.system.multipliers @ self._scene.system.drift
