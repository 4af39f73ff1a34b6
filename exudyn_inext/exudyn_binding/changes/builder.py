"""The runs of a scene: at the start, and again when it has changed."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import Any

import exudyn

from ...checks import LARGEST
from ...native.surroundings import switched_off
from ...run.run import Run
from ...run.settings import ExplicitSettings
from ...scene.model import Scene
from ..restart import Restarts
from ..scene_runs import needs_coupling, runs_of_scene
from .log import ChangeLog


class RunBuilder:
    """Makes runs.

    Args:
        mbs: assembled.   log: of changes; constraints that have changed become joints.   explicit: settings.
        scaling: step that scales the mass [s]; 0 without mass scaling.
        stack: at its end, cables that were switched off for coupled scenes are switched on again.
    """

    def __init__(
        self, mbs: Any, log: ChangeLog, explicit: ExplicitSettings, scaling: float, stack: ExitStack
    ) -> None:
        self._mbs = mbs
        self._log = log
        self._explicit = explicit
        self._scaling = scaling
        self._stack = stack
        self._is_switched_off = False

    def take_step(self, explicit: ExplicitSettings, h: float) -> None:
        """Build later runs for steps of h [s], with these settings."""
        self._explicit = explicit
        self._scaling = h if explicit.massScaling else 0.0

    def _switch_off(self, scene: Scene) -> None:
        """Keep Exudyn from evaluating cables, if it evaluates what else there is."""
        if not self._is_switched_off and needs_coupling(scene):
            self._stack.enter_context(switched_off(self._mbs, *scene.evaluated_by_kernels))
            self._is_switched_off = True

    def build(self, scene: Scene, time: float) -> Sequence[Run]:
        """Runs from the initial configuration, at `time` [s]."""
        self._switch_off(scene)
        return self._runs(scene, time, self._explicit)

    def build_from_present(self, scene: Scene, time: float, end: float) -> Sequence[Run]:
        """Runs that take over in the present state, before a step from `time` to `end` [s].

        Constraints that have been switched on may be violated by any velocity.
        """
        self._switch_off(scene)
        lenient = replace(self._explicit, startTolerance=LARGEST)
        with _present_as_initial(self._mbs):
            return self._runs(scene, time, lenient, end)

    def build_after_changes(self, scene: Scene, restarts: Restarts) -> Sequence[Run]:
        """Runs of a scene that had been changed when the restart file was written."""
        self._switch_off(scene)
        lenient = replace(self._explicit, startTolerance=LARGEST)
        with restarts.initial_state():
            return self._runs(scene, restarts.time, lenient)

    def _runs(
        self, scene: Scene, time: float, explicit: ExplicitSettings, end: float | None = None
    ) -> Sequence[Run]:
        changed = {key.number for key in self._log.first if key.kind == "Object"}
        held = {number: held for number, held in scene.held.items() if number not in changed}
        scene = replace(scene, held=held)
        return runs_of_scene(self._mbs, scene, time, self._scaling, explicit, end)


@contextmanager
def _present_as_initial(mbs: Any) -> Iterator[None]:
    """Runs begin from the initial configuration: meanwhile it is the present one."""
    data, initial = mbs.systemData, exudyn.ConfigurationType.Initial
    state = data.GetSystemState(initial)
    data.SetSystemState(data.GetSystemState(exudyn.ConfigurationType.Current), initial)
    try:
        yield
    finally:
        data.SetSystemState(state, initial)
