"""ExplicitSteps: Exudyn's own classes that step an mbs, with explicit steps."""

from collections.abc import Callable, Sized
from typing import Any

import exudyn
import numpy as np

from ..errors import InputError
from ..run.settings import ExplicitSettings
from .explicit_solver import ExplicitSolver

_INITIAL = exudyn.ConfigurationType.Initial


class ExplicitSteps:
    """Mixin that gives an `ExplicitSolver` to subclasses of `OpenAIGymInterfaceEnv` and `InteractiveDialog`.

    It is named before Exudyn's class. In an environment, `reset` begins anew from the initial values of mbs
    and returns what `Output2StateAndDone` makes of them; each `step` goes on from the present coordinates and
    velocities. `State2InitialValues` need not be given: a cable has more coordinates than an agent sees. If
    it is, its values are taken, after a reset those of the state that Exudyn has drawn at random; they must
    fulfil the constraints.

    Attributes:
        explicitSettings: as for SolveExplicit.

    Example:
        class SlungLoad(ExplicitSteps, OpenAIGymInterfaceEnv):
            explicitSettings = ExplicitSettings(stepSize=2e-3, massScaling=0.3)

            def CreateMBS(self, SC, mbs, simulationSettings):  # and so on, as for Exudyn's class
                ...
    """

    explicitSettings: ExplicitSettings | None = None
    mbs: Any
    simulationSettings: Any
    state: Any
    doTimeIntegration: bool
    Output2StateAndDone: Callable[[], bool]

    def PreInitializeSolver(self) -> None:
        """Of an environment: put the solver in place, and keep the initial values."""
        self._initial_state = self.mbs.systemData.GetSystemState(_INITIAL)
        self.dynamicSolver = ExplicitSolver(self.explicitSettings)
        self.dynamicSolver.InitializeSolver(self.mbs, self.simulationSettings)

    def State2InitialValues(self) -> list[Any]:
        """Of an environment: [coordinates, velocities] from which the next step goes on; the present ones."""
        data = self.mbs.systemData
        return [data.GetODE2Coordinates(), data.GetODE2Coordinates_t()]

    def reset(self, **options: Any) -> Any:
        """Of an environment: begin anew.   options: see Exudyn's class.

        Raises:
            InputError: `State2InitialValues` returns more or fewer values than mbs has coordinates.
        """
        data = self.mbs.systemData
        data.SetSystemState(self._initial_state, _INITIAL)
        self.simulationSettings.timeIntegration.startTime = 0.0
        result = super().reset(**options)  # type: ignore[misc]
        coordinates, velocities = self.State2InitialValues()
        _require_all(coordinates, velocities, data.ODE2Size())
        for configuration in (_INITIAL, exudyn.ConfigurationType.Current):
            data.SetODE2Coordinates(coordinates, configuration)
            data.SetODE2Coordinates_t(velocities, configuration)
        self.Output2StateAndDone()
        state = np.array(self.state, dtype=np.float32)
        return (state, *result[1:]) if isinstance(result, tuple) else state

    def InitializeSolver(self) -> None:
        """Of a dialog: put the solver in place."""
        if self.doTimeIntegration:
            self.mbs.sys["solver"] = solver = ExplicitSolver(self.explicitSettings)
            solver.InitializeSolver(self.mbs, self.simulationSettings)


def _require_all(coordinates: Sized, velocities: Sized, wanted: int) -> None:
    """What `State2InitialValues` returned; InputError if these are not all there are."""
    if len(coordinates) != wanted or len(velocities) != wanted:
        raise InputError(
            f"State2InitialValues returned {len(coordinates)} coordinates and {len(velocities)} velocities, "
            f"of {wanted} each: begin with super().State2InitialValues() and change entries of its lists "
            "(cables that share a node have coordinates of their own there), or leave it out."
        )
