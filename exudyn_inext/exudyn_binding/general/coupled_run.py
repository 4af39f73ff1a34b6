"""Cables, bodies and joints of a scene, moved together: one right-hand side call for each evaluation."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...chain.cable import Cable
from ...coupling.bodies import BodiesSystem, MassBlock
from ...coupling.coupled_system import CoupledSystem, Part
from ...coupling.small_vibrations import FastestRates, fastest_rates
from ...errors import DivergenceError, SceneError
from ...integrators.integrator import Integrator, LoadHistory, advance
from ..cable_run import CableRun
from ..consistent_start import StartCorrection
from ..time_grid import TimeGrid
from .bodies import BodyMasses, read_bodies, read_quaternions, system_mass
from .contact_rates import contact_rates, with_contact
from .coordinates import CoordinateMap, PartCoordinates
from .joint_items import read_joints
from .joint_rows import JointRows
from .start import consistent_start
from .surroundings import NativeSurroundings, evaluator


class CoupledRun:
    """All of a scene, see `time_loop.Run`.

    cables: models of the inextensible cables.   start_corrections: one for each of them.
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
    ) -> None:
        self._mbs = mbs
        self._time = time
        self._runs = cable_runs
        self._integrator = integrator
        numbers = [run.scene_cable.number for run in cable_runs]
        on_cables = np.concatenate([np.zeros(0, int), *(run.indices for run in cable_runs)])
        quaternions = read_quaternions(mbs)
        solver = evaluator(mbs)
        total = system_mass(mbs, solver)
        masses = BodyMasses(mbs, solver, read_bodies(mbs, numbers, on_cables, total), quaternions, total)
        places = [PartCoordinates(run.indices, run.reference) for run in cable_runs]
        bodies = masses.coordinates
        places.append(PartCoordinates(bodies, np.zeros(len(bodies))))
        self._map = CoordinateMap(mbs.systemData.ODE2Size(), places)
        _require_mass(mbs, self._map)
        systems = [*(run.system for run in cable_runs), masses.system]
        parts = [Part(system, dofs) for system, dofs in zip(systems, self._map.slices, strict=True)]
        parts += self._first_order_states()
        self.joints = read_joints(mbs, own_constraints)
        rows = JointRows(self.joints, quaternions, parts, self._map)
        loads = [run.loads for run in cable_runs]
        surroundings = NativeSurroundings(mbs, solver, parts, self._map, loads, masses, rows)
        self._surroundings = surroundings
        self._system = CoupledSystem(parts, surroundings, zeta)
        self.indices, self.reference = self._map.indices, self._map.reference
        size = parts[-1].dofs.stop
        self.state = integrator.allocate(size, 1)
        self._set_initial_state()
        self.start_correction = consistent_start(
            self._system, time, self.state.q, self.state.v, tolerance, self._map
        )

    def _first_order_states(self) -> list[Part]:
        """y of y' = f as velocities of unit masses: every scheme then integrates them as it does v."""
        number = self._mbs.systemData.ODE1Size()
        if not number:
            return []
        start = len(self._map.indices)
        unit = BodiesSystem(number, [MassBlock(np.arange(number), np.eye(number))])
        return [Part(unit, slice(start, start + number))]

    def _set_initial_state(self) -> None:
        data, initial = self._mbs.systemData, exudyn.ConfigurationType.Initial
        number = len(self.indices)
        q = np.asarray(data.GetODE2Coordinates(initial))[self.indices]
        self.state.q[:number] = q + self.reference
        self.state.v[:number] = np.asarray(data.GetODE2Coordinates_t(initial))[self.indices]
        self.state.v[number:] = data.GetODE1Coordinates(initial)
        for run, dofs in zip(self._runs, self._map.slices, strict=False):
            self.state.q[dofs], self.state.v[dofs] = run.state.q, run.state.v

    @property
    def name(self) -> str:
        cables = ", ".join(run.name for run in self._runs)
        others = [f"{len(self.joints)} joint(s)"] if self.joints else []
        others += ["bodies"] if len(self._map.indices) > sum(len(run.indices) for run in self._runs) else []
        return " and ".join([cables, *others]) if cables else "native items"

    @property
    def cables(self) -> list[Cable]:
        return [run.scene_cable.cable for run in self._runs]

    @property
    def start_corrections(self) -> list[StartCorrection]:
        return [run.start_correction for run in self._runs] + [self.start_correction]

    @cached_property
    def _rates(self) -> FastestRates:
        rates = fastest_rates(self._system, self._time, self.state.q)
        return with_contact(rates, contact_rates(self._mbs, self._runs))

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration, joints included."""
        return self._rates.frequency

    def damping_ratio(self, frequency: float) -> float:
        """Strongest damping [1/s], as a share of that frequency."""
        ratio = self._rates.damping / frequency if frequency > 0.0 else 0.0
        return ratio if ratio > 1e-6 else 0.0

    def start(self, time: float) -> None:
        """Evaluate the initial accelerations; see `CableRun.start`."""
        self._system.foresight[:] = 0.0
        for run in self._runs:
            run.forget()
        begin = _plain(self._integrator.start)
        begin(self._system, np.array([time]), self.state)
        for run in self._runs:
            run.check_pivots()

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> None:
        """Advance through len(history) loop steps; see `CableRun.record`."""
        take_step = _plain(advance.dispatch(type(scheme)))
        number, size = len(self.indices), len(self.state.q)
        row = np.zeros((1, 3, size))
        history[:] = np.nan
        for interval in range(len(history)):
            start = grid.time(first + interval)
            for substep in range(grid.substeps):
                times = start + grid.h * (substep + np.array(self._integrator.stages))
                loads = LoadHistory(np.zeros(1), np.ones((1, 1)), times.reshape(1, -1, 1))
                try:
                    take_step(scheme, self._system, loads, self.state, grid.h, 1, row)
                    end = start + grid.h * (substep + 1)
                    self._surroundings.finish_step(end, self.state.q, self.state.v)
                except DivergenceError:
                    return
            history[interval] = row[0, :, :number]
            history[interval, 0] -= self.reference
        self._surroundings.show_reactions(self._system.multipliers)

    def is_credible(self, history: Array) -> np.ndarray:
        """(intervals,) whether all is finite and the cables' slopes are those of inextensible ones."""
        credible = np.isfinite(history.sum(axis=(1, 2)))
        for run, dofs in zip(self._runs, self._map.slices, strict=False):
            credible[credible] = run.is_credible(history[credible][:, :, dofs])
        return credible


def _plain(function: Any) -> Any:
    """The Python function behind a kernel."""
    return getattr(function, "py_func", function)


def _require_mass(mbs: Any, coordinates: CoordinateMap) -> None:
    missing = coordinates.missing()
    if not len(missing):
        return
    data = mbs.systemData
    for number in range(data.NumberOfNodes()):
        if np.isin(missing, data.GetNodeLTGODE2(number)).any():
            node = mbs.GetNode(number)
            raise SceneError(
                f"node {number} '{node['name']}' ({node['nodeType']}) has coordinates without mass, whose "
                "accelerations are not determined: put a body on it, or remove it."
            )
