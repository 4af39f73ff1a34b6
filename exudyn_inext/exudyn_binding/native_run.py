"""Native items under the same integrators: right-hand side from Exudyn's C++, one call an evaluation.

This serves comparisons: the paper's middle column steps conventional ANCF cables with its explicit
method. Supported are items of constant mass, with coordinate constraints to ground, which are taken
out of the coupled mass matrix (Exudyn's own explicit solvers zero them after the solve, which is wrong
for ANCF cables).
"""

import math
from typing import Any, ClassVar, NamedTuple

import exudyn
import numpy as np
from scipy.linalg import eigh, inv

from ..arrays import Array
from ..chain.cable import Cable
from ..compiled import plain
from ..coupling.small_vibrations import OVERDAMPED, FastestRates
from ..errors import SceneError
from ..integrators.integrator import Integrator, LoadHistory, advance
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .consistent_start import PLACES, RATES, StartCorrection
from .scene import read_held_coordinate
from .start_velocities import require_finite, warn_of_velocities
from .step_control import StepControl
from .time_grid import TimeGrid

_CONSTANT_MASS = {"ANCFCable", "ANCFCable2D", "MassPoint", "MassPoint2D", "Mass1D"}
_FORCES_ONLY = {
    "Ground",
    "ConnectorSpringDamper",
    "ConnectorCartesianSpringDamper",
    "ConnectorCoordinateSpringDamper",
}


_NOTHING, _TIME = np.zeros(1), np.ones((1, 1))  # the load of native items is the time


class NativeSystem(NamedTuple):
    """Native items of an mbs: the `system` of an integrator that runs in plain Python.

    mbs, solver: of the running time loop.   inverse_mass: (n_dof, n_dof), zero where held.
    """

    mbs: Any
    solver: Any
    inverse_mass: Array


@index_reduced_rates.register(NativeSystem)
def native_rates(system, external, q, v, acceleration, rate):
    """a = M^-1 F with F of all items and loads; the rate is v.   external: (1,) time [s]."""
    data = system.mbs.systemData
    data.SetTime(float(external[0]))
    data.SetODE2Coordinates(q)
    data.SetODE2Coordinates_t(v)
    system.solver.ComputeODE2RHS(system.mbs)
    force = system.solver.GetSystemResidual()[: len(q)]
    np.dot(system.inverse_mass, force, out=acceleration)
    rate[:] = v


@accelerate_and_project.register(NativeSystem)
def accelerate_native(system, external, q, v, duration, acceleration, end_velocity):
    """Native items have no constraints but held coordinates: nothing to project."""
    native_rates(system, external, q, v + duration * acceleration, acceleration, end_velocity)
    end_velocity[:] = v + duration * acceleration


@correct_position.register(NativeSystem)
def correct_native_position(system, external, q, tolerance, learning, correction):
    """Nothing to correct."""
    return 0.0


class NativeRun:
    """All native items of an mbs, moved together by one integrator."""

    name = "native items"
    looks_ahead = False
    reason = "Exudyn evaluates all forces, once for each evaluation"
    cables: ClassVar[list[Cable]] = []
    cable_runs: ClassVar[list[Any]] = []
    lenience = math.inf
    watch = None  # nothing is
    start_corrections: ClassVar[list[StartCorrection]] = []

    def __init__(self, mbs: Any, solver: Any, integrator: Integrator, tolerance: float) -> None:
        names = _held_coordinates(mbs)
        held = list(names)
        size = mbs.systemData.ODE2Size()
        configuration = exudyn.ConfigurationType.Initial
        self._free = np.setdiff1d(np.arange(size), held)
        free = np.ix_(self._free, self._free)
        linearised = mbs.ComputeLinearizedSystem()
        mass, stiffness, damping = (matrix[free] for matrix in linearised)
        inverse_mass = np.zeros((size, size))
        inverse_mass[free] = inv(mass)
        self._rates = _fastest_rates(mass, stiffness, damping)
        self._system = NativeSystem(mbs, solver, inverse_mass)
        self._integrator = integrator
        self._is_started = False
        self.control = StepControl()
        self.indices = np.arange(size)
        self.reference = np.zeros(size)  # coordinates are displacements here
        self.state = integrator.allocate(size, 1)
        self.state.q[:] = mbs.systemData.GetODE2Coordinates(configuration)
        self.state.v[:] = mbs.systemData.GetODE2Coordinates_t(configuration)
        require_finite(mbs, self.indices, self.state.v)
        _take_hold(names, linearised[0], inverse_mass, self.state.q, self.state.v, tolerance)

    def scale_mass(self, theta: float, h: float) -> None:
        """Native items have no mass scaling."""

    def set_step(self, h: float) -> None:
        """Nothing depends on the step."""

    def start(self, time: float) -> None:
        """Begin anew from the present state, as soon as the time loop runs."""
        self._is_started = False

    def accelerations(self, solver: Any) -> Array:
        """(n,) of the present state, at the present time of mbs, as the given solver evaluates it."""
        a, rate = np.zeros((2, self.state.q.size))
        system, time = self._system._replace(solver=solver), np.array([self._system.mbs.systemData.GetTime()])
        native_rates(system, time, self.state.q, self.state.v, a, rate)
        return a

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the initial configuration."""
        return self._rates.frequency

    def damping_ratio(self, frequency: float) -> float:
        """Strongest damping [1/s], as a share of that frequency."""
        return self._rates.damping / frequency if frequency > 0.0 else 0.0

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> int:
        """Advance through len(history) loop steps; see `CableRun.record`."""
        take_step = plain(advance.dispatch(type(scheme)))
        data = self._system.mbs.systemData
        start = grid.time(first)
        if not self._is_started:
            begin = plain(self._integrator.start)
            begin(self._system, np.array([start]), self.state)
            self._is_started = True
        stages = np.array(self._integrator.stages)[:, np.newaxis]
        for step in range(len(history) * grid.substeps):
            times = LoadHistory(_NOTHING, _TIME, start + grid.h * (step + stages[np.newaxis]))
            row = history[step // grid.substeps]
            take_step(scheme, self._system, times, self.state, grid.h, 1, row[None])
        data.SetTime(grid.time(first + len(history)))
        self.control.accept(grid.h, len(history) * grid.substeps)
        finite = np.isfinite(history.sum(axis=(1, 2)))
        return int(np.argmin(np.append(finite, False)))

    def verdict(self, scheme: Any, time: float, h: float) -> str:
        """What to say after a step that went wrong; see `CableRun.verdict`."""
        if np.isfinite(self.state.q).all():
            return ""
        return (
            f"{self.name}: the coordinates are not finite any more. Likely cause: a step above the stability "
            "limit, which falls where items are pulled tight: reduce stepSize."
        )

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on; see `CableRun.memory`."""
        return {"state": self.state._asdict()}

    def resume(self, time: float) -> None:
        """Go on with the memory that has been set."""
        self._is_started = True

    def figures(self) -> dict[str, float]:
        """Nothing is watched."""
        return {}


def _fastest_rates(mass: Array, stiffness: Array, damping: Array) -> FastestRates:
    """Of M a + D v + K q = 0."""
    if not (np.isfinite(stiffness).all() and np.isfinite(damping).all()):
        return FastestRates(np.nan, np.nan)
    squared, rate = (max(0.0, eigh(k, mass, eigvals_only=True)[-1]) for k in (stiffness, damping))
    return FastestRates(max(float(np.sqrt(squared)), rate / OVERDAMPED), float(rate))


def has_only_forces(mbs: Any) -> bool:
    """Whether a NativeRun can move all of mbs: constant masses, forces, coordinates held to ground."""
    if mbs.NumberOfGeneralContacts() or mbs.systemData.ODE1Size():
        return False
    objects = (mbs.GetObject(number) for number in range(mbs.systemData.NumberOfObjects()))
    return all(
        data["objectType"] in _CONSTANT_MASS | _FORCES_ONLY or read_held_coordinate(mbs, data) is not None
        for data in objects
    )


def _held_coordinates(mbs: Any) -> dict[int, str]:
    """System indices of the held coordinates, and what holds them."""
    held = {}
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        if (found := read_held_coordinate(mbs, data)) is not None:
            index = mbs.systemData.GetNodeLTGODE2(found.node)[found.coordinate]
            held[index] = f"object {number} '{data['name']}' ({data['objectType']})"
    return held


def _take_hold(
    names: dict[int, str], mass: Array, inverse_mass: Array, q: Array, v: Array, tolerance: float
) -> None:
    """Stop held coordinates at the start, by impulses there.

    Args:
        names: see `_held_coordinates`.   mass: (n, n).   inverse_mass: see `NativeSystem`.
        q, v: (n,) state, v in place.   tolerance: see `ExplicitSettings.startTolerance`.

    Raises:
        SceneError: a held coordinate is not where it is held.
    """
    held = list(names)
    if not held:
        return
    if said := _said(PLACES, names, q, tolerance):
        raise SceneError(f"{said}: correct the initial values of its node.")
    said = _said(RATES, names, v / max(1.0, float(np.abs(v).max())), tolerance)
    before = 0.5 * float(v @ mass @ v)
    v += inverse_mass @ (mass[:, held] @ v[held])
    v[held] = 0.0
    if said:
        warn_of_velocities(said, before, 0.5 * float(v @ mass @ v))


def _said(what: str, names: dict[int, str], values: Array, tolerance: float) -> str:
    """Which held coordinate has the largest value, if that is above the tolerance."""
    worst = max(names, key=lambda index: abs(values[index]))
    if abs(values[worst]) <= tolerance:
        return ""
    return f"the {what} violate {names[worst]} by {values[worst]:.3g} (limit {tolerance:g})"
