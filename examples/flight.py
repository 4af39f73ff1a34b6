"""A drone on its way: its controller, and the calls that let a solver object of Exudyn take the steps."""

from dataclasses import dataclass

import exudyn as exu
import numpy as np

OUTPUTS = exu.OutputVariableType.Position, exu.OutputVariableType.Velocity


@dataclass
class Controller:
    """Spring and damper to a smooth way from the origin, and a damper to the load.

    goal: (3,) [m].   duration: of the way [s].   weight: (3,) of all that is carried [N].
    stiffness: [N/m].   damping, swingDamping: [N s/m].
    """

    goal: np.ndarray
    duration: float
    weight: np.ndarray
    stiffness: float = 4.0
    damping: float = 8.0
    swingDamping: float = 9.0

    def thrust(self, mbs, nodes, t):
        """(3,) [N] at t [s].   nodes: of drone and load."""
        (x, _), (v, v_load) = ([mbs.GetNodeOutput(node, output) for node in nodes] for output in OUTPUTS)
        s = min(t / self.duration, 1.0)
        way = self.goal * s**3 * (10 - 15 * s + 6 * s**2)
        rate = self.goal * 30 * (s * (1 - s)) ** 2 / self.duration
        spring_and_damper = self.stiffness * (way - x) + self.damping * (rate - v)
        return spring_and_damper + self.swingDamping * (v_load - v) - self.weight


def settings_of_period(steps=1):
    """exudyn.SimulationSettings for so many steps of a solver in each period of the controller; no files."""
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.file.writeInitialValues = False  # of each period
    return settings


def drive(solver, mbs, settings, period, endTime, steer):
    """Let a solver object take steps until endTime [s]; steer(t) is called every `period` [s].

    Returns its way of computing the steps, if it is an ExplicitSolver.
    """
    solver.InitializeSolver(mbs, settings)
    for k in range(round(endTime / period)):
        steer(k * period)
        settings.timeIntegration.startTime = k * period
        settings.timeIntegration.endTime = (k + 1) * period
        solver.InitializeSolverInitialConditions(mbs, settings)
        solver.SolveSteps(mbs, settings)
        mbs.systemData.SetSystemState(mbs.systemData.GetSystemState(), exu.ConfigurationType.Initial)
    path = getattr(solver, "path", "")
    solver.FinalizeSolver(mbs, settings)
    return path
