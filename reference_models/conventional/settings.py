"""What an Exudyn solver is told: small settings objects, turned into exudyn.SimulationSettings."""

from dataclasses import dataclass
from typing import Any, Literal

import exudyn

from exudyn_inext.checks import require_positive

from ..model import quiet_settings

Newton = Literal["full", "modified", "modifiedEachStep"]
LinearSolver = Literal["dense", "sparse"]
ImplicitIntegrator = Literal["generalizedAlpha", "trapezoidal"]
ExplicitIntegrator = Literal["velocityVerlet", "rungeKutta44"]

_SOLVER_TYPES = {
    "generalizedAlpha": exudyn.DynamicSolverType.GeneralizedAlpha,
    "trapezoidal": exudyn.DynamicSolverType.TrapezoidalIndex2,
    "velocityVerlet": exudyn.DynamicSolverType.VelocityVerlet,
    "rungeKutta44": exudyn.DynamicSolverType.RK44,
}
_LINEAR_SOLVERS = {
    "dense": exudyn.LinearSolverType.EXUdense,
    "sparse": exudyn.LinearSolverType.EigenSparse,
}


@dataclass(frozen=True)
class Implicit:
    """An implicit native integrator.   step_size [s].

    newton: "full", "modified" (new Jacobian when convergence is slow), "modifiedEachStep".
    relative_tolerance: Newton residual; with 1e-8, Exudyn's default, the step size collapses
        from about 30 elements on.
    spectral_radius: of generalized-alpha, 1 undamped, 0 strongest damping of high frequencies.
    """

    step_size: float
    newton: Newton = "modified"
    linear_solver: LinearSolver = "dense"
    relative_tolerance: float = 1e-6
    spectral_radius: float = 0.9
    integrator: ImplicitIntegrator = "generalizedAlpha"


@dataclass(frozen=True)
class Explicit:
    """An explicit native integrator with constant steps.   step_size [s].

    linear_solver: of the mass matrix; the dense one is quicker below some 10 spatial elements.
    """

    step_size: float
    integrator: ExplicitIntegrator = "velocityVerlet"
    linear_solver: LinearSolver = "dense"


Solver = Implicit | Explicit


def number_of_steps(step_size: float, end_time: float) -> int:
    """Steps of equal size, as near to step_size [s] as the end time [s] allows."""
    return max(1, round(end_time / require_positive("step_size", step_size)))


def simulation_settings(solver: Solver, end_time: float) -> Any:
    """exudyn.SimulationSettings for `solver`: silent, no files, sensors every SENSOR_PERIOD."""
    settings = quiet_settings(end_time, number_of_steps(solver.step_size, end_time))
    time = settings.timeIntegration
    time.solverType = _SOLVER_TYPES[solver.integrator]
    settings.linearSolver.solverType = _LINEAR_SOLVERS[solver.linear_solver]
    if isinstance(solver, Implicit):
        _set_implicit(settings, solver)
    return settings


def _set_implicit(settings: Any, solver: Implicit) -> None:
    time = settings.timeIntegration
    time.generalizedAlpha.spectralRadius = solver.spectral_radius
    time.newton.useModifiedNewton = solver.newton != "full"
    time.newton.modifiedNewtonJacUpdatePerStep = solver.newton == "modifiedEachStep"
    time.newton.relativeTolerance = solver.relative_tolerance
