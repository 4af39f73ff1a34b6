"""ExplicitSolver: explicit steps for whoever drives a solver object of Exudyn, call by call."""

from collections.abc import Sequence
from contextlib import ExitStack, nullcontext, suppress
from typing import Any
from weakref import finalize

import exudyn

from ..checks import require_positive
from ..errors import InputError
from ..items.arguments import explicit_settings, simulation_settings
from ..items.functions_of_time import take_word
from ..native.velocity_level import at_position_level
from ..run.output_files import require_writable_outputs
from ..run.settings import ExplicitSettings
from ..run.step_choice import MOST_DURATION, choose_step, shorten_for_stretch, warn_of_damping
from .cable_forces import forget_evaluators
from .changes.constraints import SteppedReader
from .changes.follower import ChangeFollower
from .changes.limit import StepLimit
from .changes.log import ChangeLog, listening
from .console import compile_notice, header_of, initialized
from .idle_integrator import idle_integrator, nothing
from .mbs_state import at_start
from .restart import Restarts
from .scene import read_scene, require_assembled
from .scene_runs import RunBuilder, bounds_if_scaled
from .sensors import observed_derivatives, warn_of_empty_sensors
from .stepping_loop import Portion, SteppingLoop
from .time_loop import refuse_newton_functions, warn_of_findings
from .unseen_outputs import warn_of_unseen_outputs

_NativeSolver: Any = exudyn.MainSolverImplicitSecondOrder


class ExplicitSolver(_NativeSolver):
    """A solver object of Exudyn whose steps are those of SolveExplicit.

    For programs that drive such an object call by call: `OpenAIGymInterfaceEnv` has it as `dynamicSolver`,
    `InteractiveDialog` as mbs.sys["solver"]; the mixin `ExplicitSteps` puts it there. The scene is read and
    its step chosen once. Between two calls of `SolveSteps`, methods of mbs may change loads and other
    parameters, and states may be set; a state must fulfil the constraints, as at the start of SolveExplicit.

    Each step of Exudyn's loop (numberOfSteps between startTime and endTime) is cut into equal steps of the
    integrator; beside cables that stretch, automatic ones are shorter than those of SolveExplicit, as forces
    to come may let them vibrate along their axes. A force that was changed before a call jumps at its
    beginning. Sensors, solution files, pre- and post-step user functions work as with SolveExplicit. Until
    FinalizeSolver, Exudyn's own solvers find cables among other items switched off.

    Args:
        explicitSettings: as for SolveExplicit.
        duration: how long the motion will be, as far as it is known [s]: the longer, the smaller must be the
            error of each step that is chosen by accuracy.

    Attributes:
        stepSize: largest step of the integrator [s].   massScaling: theta.   bounds: StepSizeBounds.
        path: which way the steps are computed, and why.

    Raises:
        InputError: arguments out of their limits.

    Example:
        solver = ExplicitSolver(ExplicitSettings(stepSize=1e-3))
        solver.InitializeSolver(mbs, settings)
        while running:
            mbs.SetLoadParameter(load, "loadVector", thrust)
            settings.timeIntegration.startTime = settings.timeIntegration.endTime
            settings.timeIntegration.endTime += 0.02
            solver.InitializeSolverInitialConditions(mbs, settings)
            solver.SolveSteps(mbs, settings)
            mbs.systemData.SetSystemState(mbs.systemData.GetSystemState(), exu.ConfigurationType.Initial)
        solver.FinalizeSolver(mbs, settings)
    """

    def __init__(
        self, explicitSettings: ExplicitSettings | None = None, duration: float = MOST_DURATION
    ) -> None:
        super().__init__()
        self._given = explicit_settings(explicitSettings)
        self._duration = require_positive("duration", duration)
        self._loop: SteppingLoop | None = None
        self._open = ExitStack()  # until the end: changes are noted, cables are switched off in Exudyn
        finalize(self, self._open.close)

    def InitializeSolver(self, mbs: Any, simulationSettings: Any) -> bool:
        """Begin, or begin anew, from the initial configuration.

        The scene is read at the first time, and after an error.

        Raises:
            InputError, SceneError, StepSizeError, RedundantConstraintError: see SolveExplicit.
        """
        settings = simulation_settings(simulationSettings)
        _require_no_restart(settings)
        require_assembled(mbs)
        refuse_newton_functions(mbs)
        take_word(mbs, self._given.dependsOnTimeOnly)
        sensors = [mbs.GetSensor(number) for number in range(mbs.systemData.NumberOfSensors())]
        require_writable_outputs(settings, sensors)
        loop = self._loop
        if loop is None or loop.mbs is not mbs or loop.error is not None or not loop.is_as_built:
            self._close()
            loop = self._build(mbs, settings, sensors)
        else:
            loop.require_all_seen()
            loop.begin_anew()
        self._observed = observed_derivatives(settings, sensors)
        self._loop = loop
        initialize = super().InitializeSolver
        with idle_integrator(settings):
            return initialized(self, lambda: bool(initialize(mbs, settings)), settings, self._header)

    def InitializeSolverInitialConditions(self, mbs: Any, simulationSettings: Any) -> None:
        """The initial configuration becomes the current one; times are read from the settings."""
        self._loop_of(mbs)
        with idle_integrator(simulationSettings):
            super().InitializeSolverInitialConditions(mbs, simulationSettings)

    def SolveSteps(self, mbs: Any, simulationSettings: Any) -> bool:
        """Take the steps of Exudyn's loop until endTime; see InitializeSolverInitialConditions.

        Raises:
            InputError: not initialised, or no time is left.
            SceneError: a state that violates constraints, or a change that cannot be followed.
            DivergenceError: mbs holds the last good state; InitializeSolver begins anew.
        """
        loop = self._loop_of(mbs)
        if loop.error is not None:
            raise loop.error
        function = loop.prepared(Portion.next_of(self), self._observed)
        self.SetUserFunctionDiscontinuousIteration(mbs, function)
        try:
            with compile_notice(simulationSettings, self):
                return bool(super().SolveSteps(mbs, simulationSettings))
        except Exception as error:
            cause = loop.cause_of(error, loop.changes.log)
            if cause is loop.changes.log.refusal:
                loop.error = cause
            raise cause from cause.__cause__
        finally:
            self.SetUserFunctionDiscontinuousIteration(mbs, nothing)
            loop.finish_portion()

    def FinalizeSolver(self, mbs: Any, simulationSettings: Any) -> None:
        """End: files are closed, and changes of mbs are not followed any more; a second end does nothing.

        Raises:
            InputError: initialised for another mbs.
            SceneError: something has been changed in a way that the steps could not notice.
        """
        if self._loop is None:
            return
        self._loop_of(mbs)
        super().FinalizeSolver(mbs, simulationSettings)
        try:
            if self._loop.error is None:
                self._loop.require_all_seen()
                warn_of_findings(self._loop.runs, self._given.energyTolerance)
        finally:
            self._close()

    @property
    def path(self) -> str:
        """Which way the steps are computed, and why."""
        return self._loop.path if self._loop else "not initialised"

    def _loop_of(self, mbs: Any) -> SteppingLoop:
        loop = self._loop
        if loop is None or loop.mbs is not mbs:
            raise InputError("the solver has not been initialised for this mbs: call InitializeSolver first.")
        return loop

    def _close(self) -> None:
        loop, self._loop = self._loop, None
        if loop is not None:
            forget_evaluators(loop.changes.sensors)
        items_are_gone = loop is not None and loop.changes.log.is_outdated
        with suppress(Exception) if items_are_gone else nullcontext():
            self._open.close()

    def _build(self, mbs: Any, settings: Any, sensors: Sequence[Any]) -> SteppingLoop:
        """Read the scene, and choose the step."""
        log, explicit, start = ChangeLog(mbs), self._given, float(settings.timeIntegration.startTime)
        scaling = explicit.stepSize or 0.0 if explicit.massScaling else 0.0
        with ExitStack() as stack, compile_notice(settings), at_start(mbs, start):
            reader = SteppedReader(mbs, stack.enter_context(at_position_level(mbs, start)))
            scene = read_scene(mbs, reader)
            warn_of_empty_sensors(mbs, sensors, scene.enforcing)
            warn_of_unseen_outputs(mbs, scene, sensors)
            builder = RunBuilder(mbs, log.changed.keys(), explicit, scaling, stack)
            runs = builder.build(scene, start)
            scaled = bounds_if_scaled(mbs, scene, start, explicit.stepSize or 0.0, explicit)
            choice = choose_step(runs, start, self._duration, explicit, scaling, scaled)
            choice = shorten_for_stretch(runs, choice)
            warn_of_damping(choice, self._duration)
            limit = StepLimit(choice.h, choice.bounds.stability_limit, choice.explicit)
            changes = ChangeFollower(mbs, scene, reader, log, builder, limit, sensors)
            restarts = Restarts(mbs, settings, explicit)
            taken = choice.h, self._duration, choice.explicit
            loop = SteppingLoop(mbs, runs, start, *taken, restarts, changes)
            stack.enter_context(listening(log))
            log.is_idle = True
            self._open.push(stack.pop_all())
        self._header = header_of(choice.explicit, choice.h, choice.decided_by)
        self.stepSize, self.massScaling, self.bounds = choice.h, choice.theta, choice.bounds
        return loop


def _require_no_restart(settings: Any) -> None:
    options = settings.solution.restart
    if options.write or options.continueIfAvailable:
        raise InputError(
            "solution.restart: ExplicitSolver neither writes restart files nor continues from one: switch "
            "write and continueIfAvailable off, or use SolveExplicit."
        )
