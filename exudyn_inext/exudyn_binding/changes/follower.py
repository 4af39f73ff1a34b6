"""Runs that follow what user functions change between two steps of the time loop."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import SceneError
from ...items.parameters import Parameter
from ...native.surroundings import state_kept
from ...run.cable_loads import CableLoads
from ...run.cable_run import CableRun
from ...run.coupled_run import CoupledRun
from ...run.run import Run
from ...scene.model import Scene
from ..cable_forces import forget_evaluators
from ..scene import read_scene
from ..time_loop import worst_figures
from .builder import RunBuilder
from .constraints import SteppedReader
from .continuation import go_on_coupled, go_on_with_cable
from .demand import Demand, demand
from .limit import StepLimit
from .log import ChangeLog
from .same_structure import same_cables, same_structure
from .stored import stored_changes


class ChangeFollower:
    """Looks after the runs of a scene whose parameters may change.

    Args:
        mbs: the system.   scene: what it contains, read by `reader`.   log: of its changes.
        builder: of other runs.   limit: of their steps.   sensors: data of all of them.
        moves: whether something has moved through the step before the run, which continues another one.
    """

    def __init__(
        self,
        mbs: Any,
        scene: Scene,
        reader: SteppedReader,
        log: ChangeLog,
        builder: RunBuilder,
        limit: StepLimit,
        sensors: Sequence[Any],
        moves: bool = False,
    ) -> None:
        self._mbs = mbs
        self._scene = scene
        self._reader = reader
        self._log = log
        self._builder = builder
        self._limit = limit
        self._sensors = sensors
        self._reader.nodes = frozenset(node for cable in self._scene.cables for node in cable.item.nodes)
        self._moves = moves
        self._figures: dict[str, float] = {}

    @property
    def has_news(self) -> bool:
        """Whether something has changed since the last step, or must stop."""
        return self._moves or self._log.is_pending

    def stored(self) -> dict[str, Any]:
        """All changes so far, for a restart file."""
        return stored_changes(self._log, self._reader, self._limit, self._moves)

    def figures(self) -> dict[str, float]:
        """Extremes of runs that others have taken over from; see `Run.figures`."""
        return self._figures

    def follow(self, runs: Sequence[Run], time: float, end: float) -> Sequence[Run]:
        """The runs that go on from `time` to `end` [s], the next step of the time loop.

        Raises:
            SceneError: a run cannot follow a change.
            StepSizeError: it brings the stability limit below the step.
        """
        changed = self._log.take()
        self._reader.begin_step(time, end)
        self._log.is_paused = True
        try:
            with state_kept(self._mbs):
                self._mbs.systemData.SetTime(time)
                runs = self._followed(runs, changed, time, end)
        finally:
            self._log.is_paused = False
        coupled = [run for run in runs if isinstance(run, CoupledRun)]
        self._moves = self._reader.moves or any(run.approaches for run in coupled)
        return runs

    def require_all_seen(self, runs: Sequence[Run]) -> None:
        """At the end: mbs must contain what the runs have moved.

        Raises:
            SceneError: it does not.
        """
        if self._log.is_pending:  # after the last step
            return
        scene = read_scene(self._mbs, self._reader)
        alone = all(isinstance(run, CableRun) for run in runs)
        same = same_structure if alone else same_cables
        if not (same(self._scene, scene) and _have_the_loads_of(runs, scene)):
            raise SceneError(
                "supports, loads or properties of a cable were changed during the run without its notice: "
                "by a method of mbs that was bound before the run, or by SetCableDrag or AddPointMass. The "
                "motion is not theirs: call mbs.SetLoadParameter etc. by name, and change properties "
                "before a run."
            )

    def _followed(
        self, runs: Sequence[Run], changed: Sequence[Parameter], time: float, end: float
    ) -> Sequence[Run]:
        own = self._scene.own_constraints
        demands = [demand(self._mbs, runs, own, key) for key in changed]
        asked = max(demands, default=Demand.NOTHING)
        if asked > Demand.NOTHING:
            forget_evaluators(self._sensors)
        if asked < Demand.READ:
            stiffer = self._limit.stiffer(self._mbs, changed)
            if stiffer:
                self._limit.look_again(runs, time, stiffer)
            if self._moves or stiffer or asked == Demand.MOVE:
                self._go_on(runs, time, end, asked == Demand.MOVE)
            return runs
        before, self._scene = self._scene, read_scene(self._mbs, self._reader)
        if asked < Demand.BUILD and same_structure(before, self._scene) and self._take_loads(runs):
            self._go_on(runs, time, end, has_changed=True)
            return runs
        return self._built_again(runs, changed, time, end)

    def _take_loads(self, runs: Sequence[Run]) -> bool:
        """Give the runs their present loads; False if one of them needs to be built again."""
        alone = [run for run in runs if isinstance(run, CableRun)]
        for run, scene_cable in zip(alone, self._scene.cables, strict=False):
            loads = CableLoads(scene_cable)
            if not np.array_equal(loads.pattern, run.loads.pattern):
                return False
            run.loads, run.scene_cable = loads, scene_cable
        among_others = [cable for run in runs if isinstance(run, CoupledRun) for cable in run.cable_runs]
        for run, scene_cable in zip(among_others, self._scene.cables, strict=False):
            loads = CableLoads(replace(scene_cable, loads=[]))
            if not np.array_equal(loads.constant, run.loads.constant):
                return False
        return True

    def _go_on(self, runs: Sequence[Run], time: float, end: float, has_changed: bool) -> None:
        for run in runs:
            if isinstance(run, CableRun):
                go_on_with_cable(run, time)
            elif isinstance(run, CoupledRun):
                go_on_coupled(run, time, end, has_changed)

    def _built_again(
        self, runs: Sequence[Run], changed: Sequence[Parameter], time: float, end: float
    ) -> Sequence[Run]:
        new = self._builder.build_from_present(self._scene, time, end)
        self._limit.take_over(runs, new, time, changed)
        for run in new:
            run.start(time)
        self._figures = worst_figures([*runs, self])
        return new


def _have_the_loads_of(runs: Sequence[Run], scene: Scene) -> bool:
    """Whether runs of cables alone have the constant forces that the scene says."""
    alone = [run for run in runs if isinstance(run, CableRun)]
    loads = [CableLoads(cable) for cable in scene.cables] if alone else []
    return all(
        np.array_equal(run.loads.constant, load.constant) for run, load in zip(alone, loads, strict=False)
    )
