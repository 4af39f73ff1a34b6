"""Cables, bodies and joints of a scene, moved together: one right-hand side call for each evaluation."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...chain.cable import Cable
from ...compiled import plain
from ...coupling.closed_contacts import rates_in_contact
from ...coupling.small_vibrations import FastestRates, fastest_rates
from ...errors import DivergenceError, RedundantConstraintError
from ...integrators.integrator import Integrator, LoadHistory, advance
from ...integrators.linear_stability import frequency_limit
from ..cable_run import CableRun
from ..cable_watch import figures, finding
from ..consistent_start import StartCorrection
from ..divergence import explanation
from ..time_grid import TimeGrid
from .contact_rates import OpenContacts, open_contacts
from .coupled_scene import CoupledCable, CoupledScene
from .coupled_watch import CoupledWatch
from .start import consistent_start

_NOTHING, _TIME = np.zeros(1), np.ones((1, 1))  # the load of a coupled system is the time


class CoupledRun:
    """All of a scene, see `time_loop.Run`.

    evaluations: in a step, see `Integrator`.
    cables: models of the inextensible cables.   start_corrections: one for each of them, and for joints.
    """

    looks_ahead = False

    def __init__(
        self,
        mbs: Any,
        cable_runs: Sequence[CableRun],
        own_constraints: frozenset[int],
        integrator: Integrator,
        evaluations: int,
        zeta: float,
        tolerance: float,
        time: float,
        why: str,
        energy_tolerance: float,
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
        self._unsolvable = ""  # what was said of joints that could not be solved for
        self._output = np.zeros((1, 3, self._scene.size))
        self.watch = CoupledWatch(self._scene, cable_runs, self.state, evaluations, energy_tolerance)

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

    @cached_property
    def contacts(self) -> OpenContacts | None:
        """Contacts that are open at the start, if there are any."""
        return open_contacts(self._mbs, self._scene.map, self._scene.size)

    @property
    def rates_in_contact(self) -> FastestRates:
        """The rates if all of these contacts close at once; zero where there are none."""
        if self.contacts is None:
            return FastestRates(0.0, 0.0)
        return rates_in_contact(
            self._scene.system, self.contacts.closed, self._time, self.state.q, self.state.v
        )

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
        begin = plain(self._integrator.start)
        begin(self._scene.system, np.array([time]), self.state)
        for run in self._runs:
            run.require_independence()
        self.watch.open(time, self.state)

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on; see `CableRun.memory`."""
        cables = {str(k): run.memory()["foresight"] for k, run in enumerate(self._runs)}
        return {
            "state": self.state._asdict(),
            "scene": self._scene.memory(),
            "cables": cables,
            "watch": self.watch.memory(),
        }

    def resume(self, time: float) -> None:
        """Go on at `time` [s] with the memory that has been set; data coordinates are those of mbs."""
        self._scene.surroundings.forces(time, self.state.q, self.state.v)
        plain(self._integrator.resume)(self._scene.system, np.array([time]), self.state)
        self.watch.resume()

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> int:
        """Advance through len(history) loop steps; see `CableRun.record`."""
        number = len(self.indices)
        self._scene.surroundings.forget()
        for interval in range(len(history)):
            start = grid.time(first + interval)
            with np.errstate(over="ignore", invalid="ignore"):  # of a run that diverges
                if not self._is_well_through(scheme, start, grid):
                    return interval
            for place, values in enumerate((self.state.q, self.state.v, self.state.a)):
                history[interval, place] = values[:number]
            history[interval, 0] -= self.reference
        end = grid.time(first + len(history))
        self._scene.surroundings.show(end, self.state.q, self.state.v, self._scene.system.multipliers)
        return len(history)

    def _is_well_through(self, scheme: Any, start: float, grid: TimeGrid) -> bool:
        """Take the steps of one interval."""
        steps, h = np.arange(grid.substeps)[:, np.newaxis], grid.h
        times: Array = start + h * (steps + np.array(self._integrator.stages))
        ends = (start + h * (steps + 1)).ravel().tolist()
        done = 0
        try:
            while done < grid.substeps:
                ahead = slice(done, done + self.watch.steps_ahead)
                self._take_steps(scheme, times[ahead], ends[ahead], h)
                done = min(ahead.stop, grid.substeps)
                if not self.watch.is_well_at(ends[done - 1], h, self.state):
                    return False
        except (DivergenceError, RedundantConstraintError) as error:
            self._unsolvable = str(error) if isinstance(error, RedundantConstraintError) else ""
            self.watch.give_up(self.state)
            return False
        return True

    def _take_steps(self, scheme: Any, times: Array, ends: Sequence[float], h: float) -> None:
        """Steps of h [s].   times: (steps, stages) of their evaluations [s].   ends: of the steps [s]."""
        take_step = plain(advance.dispatch(type(scheme)))
        system, state, watch = self._scene.system, self.state, self.watch
        surroundings = self._scene.surroundings
        surroundings.path = watch.path_of_evaluations
        surroundings.settles = surroundings.path is not None  # one evaluation in each step
        try:
            for factors, end in zip(times[:, np.newaxis, :, np.newaxis], ends, strict=True):
                take_step(scheme, system, LoadHistory(_NOTHING, _TIME, factors), state, h, 1, self._output)
                surroundings.finish_step(end, state.q, state.v)
                for call in watch.after_each_step:
                    call()
        finally:
            surroundings.path, surroundings.settles = None, False
        watch.count(len(ends))

    def figures(self) -> dict[str, float]:
        """How well constraints and energy were kept."""
        return figures(self.watch.watch)

    def verdict(self, scheme: Any, time: float, h: float) -> str:
        """What went wrong in the last steps; see `CableRun.verdict`."""
        if not self.watch.has_trouble:
            return ""
        if self._unsolvable:
            return f"{self.name}: {self._unsolvable} If the motion before that is wrong, reduce stepSize."
        trouble = self._integrator.trouble(scheme, self.watch.watch.kept)
        limit = self._limit_now(scheme, time)
        said = explanation(self._integrator, trouble, h, limit, scaled=True)
        return f"{self.name}: {finding(self.watch.watch)}. {said}"

    def _limit_now(self, scheme: Any, time: float) -> float:
        """Stability limit [s] in the state of the last inspection; infinite if there is none."""
        rates = fastest_rates(self._scene.system, time, self.state.q, self.state.v)
        if not rates.frequency > 0.0:
            return np.inf
        return frequency_limit(self._integrator, scheme, rates.damping / rates.frequency) / rates.frequency
