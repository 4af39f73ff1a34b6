"""Cables, bodies and joints of a scene, moved together: one right-hand side call for each evaluation."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...chain.cable import Cable
from ...coupling.small_vibrations import FastestRates, fastest_rates
from ...errors import DivergenceError
from ...integrators.integrator import Integrator, LoadHistory, advance
from ..cable_run import CableRun
from ..consistent_start import StartCorrection
from ..time_grid import TimeGrid
from .contact_rates import contact_rates, with_contact
from .coupled_scene import CoupledCable, CoupledScene
from .start import consistent_start


class CoupledRun:
    """All of a scene, see `time_loop.Run`.

    cables: models of the inextensible cables.   start_corrections: one for each of them, and for joints.
    """

    looks_ahead = False

    def __init__(
        self,
        mbs: Any,
        cable_runs: Sequence[CableRun],
        own_constraints: frozenset[int],
        integrator: Integrator,
        zeta: float,
        tolerance: float,
        time: float,
        why: str,
    ) -> None:
        self._mbs = mbs
        self._runs = cable_runs
        self._why = why
        self._integrator = integrator
        self._time = time
        cables = [
            CoupledCable(run.scene_cable.number, run.indices, run.reference, run.system, run.loads)
            for run in cable_runs
        ]
        self._scene = CoupledScene(mbs, cables, own_constraints, zeta)
        self.indices, self.reference = self._scene.map.indices, self._scene.map.reference
        self.state: Any = integrator.allocate(self._scene.size, 1)
        self.state.q[:], self.state.v[:] = self._scene.state(exudyn.ConfigurationType.Initial)
        for run, dofs in zip(cable_runs, self._scene.map.slices, strict=False):
            self.state.q[dofs], self.state.v[dofs] = run.state.q, run.state.v
        self.start_correction = consistent_start(
            self._scene.system, time, self.state.q, self.state.v, tolerance
        )

    @property
    def name(self) -> str:
        cables = ", ".join(run.name for run in self._runs)
        joints = len(self._scene.joints)
        others = [f"{joints} joint(s)"] if joints else []
        others += ["bodies"] if self._scene.has_bodies else []
        return " and ".join([cables, *others]) if cables else "native items"

    @property
    def cables(self) -> list[Cable]:
        return [run.scene_cable.cable for run in self._runs]

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [run.start_correction for run in self._runs] + [self.start_correction]

    @cached_property
    def _rates(self) -> FastestRates:
        return fastest_rates(self._scene.system, self._time, self.state.q, self.state.v)

    @property
    def rates_in_contact(self) -> FastestRates:
        """Bounds of the rates if all contacts close at once; zero where there are none."""
        contact = contact_rates(self._mbs, self._runs)
        return with_contact(self._rates, contact) if contact.frequency else FastestRates(0.0, 0.0)

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration, joints included."""
        return self._rates.frequency

    @property
    def reason(self) -> str:
        """What an evaluation needs."""
        joints, bodies = len(self._scene.joints), self._scene.bodies_of_variable_mass
        needs = ["one right-hand side of Exudyn"]
        needs += [f"the mass of {bodies} bodies"] if bodies else ["no mass (all constant, inverted once)"]
        needs += [f"the Jacobians of {joints} joints"] if joints else ["no Jacobian (no joints)"]
        return f"each evaluation takes {', '.join(needs)}, as mbs contains {self._why}"

    def damping_ratio(self, frequency: float) -> float:
        """Strongest damping [1/s], as a share of that frequency."""
        ratio = self._rates.damping / frequency if frequency > 0.0 else 0.0
        return ratio if ratio > 1e-6 else 0.0

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; see `CableRun.start`."""
        self._scene.forget()
        for run in self._runs:
            run.forget()
        begin = _plain(self._integrator.start)
        begin(self._scene.system, np.array([time]), self.state)
        for run in self._runs:
            run.check_pivots()

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> None:
        """Advance through len(history) loop steps; see `CableRun.record`."""
        take_step = _plain(advance.dispatch(type(scheme)))
        number, size = len(self.indices), len(self.state.q)
        row = np.zeros((1, 3, size))
        history[:] = np.nan
        self._scene.surroundings.forget()
        for interval in range(len(history)):
            start = grid.time(first + interval)
            for substep in range(grid.substeps):
                times = start + grid.h * (substep + np.array(self._integrator.stages))
                loads = LoadHistory(np.zeros(1), np.ones((1, 1)), times.reshape(1, -1, 1))
                try:
                    with np.errstate(over="ignore", invalid="ignore"):  # of a run that diverges
                        take_step(scheme, self._scene.system, loads, self.state, grid.h, 1, row)
                    end = start + grid.h * (substep + 1)
                    self._scene.surroundings.finish_step(end, self.state.q, self.state.v)
                except DivergenceError:
                    return
            history[interval] = row[0, :, :number]
            history[interval, 0] -= self.reference
        end = grid.time(first + len(history))
        self._scene.surroundings.show(end, self.state.q, self.state.v, self._scene.system.multipliers)

    def trouble(self, scheme: Any) -> str:
        """What the scheme could not do; see `Integrator`."""
        return self._integrator.trouble(scheme, self.state)

    def is_credible(self, history: Array) -> np.ndarray:
        """(intervals,) whether all is finite and the cables' slopes are those of inextensible ones."""
        credible = np.isfinite(history.sum(axis=(1, 2)))
        for run, dofs in zip(self._runs, self._scene.map.slices, strict=False):
            credible[credible] = run.is_credible(history[credible][:, :, dofs])
        return credible


def _plain(function: Any) -> Any:
    """The Python function behind a kernel."""
    return getattr(function, "py_func", function)
