"""Runs that follow what user functions change between two steps of the time loop."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import starmap
from typing import Any

import numpy as np

from ...errors import SceneError
from ...items.parameters import Parameter
from ...native.native_items import state_kept
from ...run.cable_loads import CableLoads
from ...run.cable_run import CableRun
from ...run.coupled_run import CoupledRun, Run
from ...run.ramp import Line
from ...run.settings import ExplicitSettings
from ...scene.model import Scene
from ..cable_forces import forget_evaluators, take_forces
from ..mbs_state import state_of
from ..scene import read_scene
from ..scene_runs import RunBuilder
from ..time_loop import worst_figures
from .constraints import SteppedReader
from .demand import Demand, demand, same_cables
from .limit import StepLimit
from .log import ChangeLog


@dataclass(eq=False)
class ChangeFollower:
    """Looks after the runs of a scene whose parameters may change.

    mbs: the system.   scene: what it contains, read by `reader`.   log: of its changes.
    builder: of other runs.   limit: of their steps.   sensors: data of those that call functions.
    moves: whether something has moved through the last step.
    is_event: whether the last change was more than that of a parameter which is set step by step.
    """

    mbs: Any
    scene: Scene
    reader: SteppedReader
    log: ChangeLog
    builder: RunBuilder
    limit: StepLimit
    sensors: Sequence[Any]
    moves: bool = False
    is_event: bool = False

    def __post_init__(self) -> None:
        self.reader.nodes = frozenset(node for cable in self.scene.cables for node in cable.item.nodes)
        self.sensors = [data for data in self.sensors if data["sensorType"] == "UserFunction"]
        self._figures: dict[str, float] = {}
        self._jumped = False
        self._jumps = False  # whether values do in the next step
        self._line: Line | None = None  # along which they change there, if it matters
        self._demands: dict[Parameter, Demand] = {}  # of the present runs
        self._sorted: tuple[Any, ...] = ()  # what was asked of these last, see `_sort`
        self._repeated: tuple[Parameter, ...] = ()  # loads that alone have changed before the last step

    def take_step(self, explicit: ExplicitSettings, h: float) -> None:
        """Other runs, and the limit of the step, are for steps of h [s] from now on."""
        self.builder.take_step(explicit, h)
        self.limit.h = h

    def has_news(self, runs: Sequence[Run], time: float) -> bool:
        """Whether something has changed since the last step, until `time` [s], or must stop.

        Raises:
            SceneError: a change was refused in that step, which a user function has caught.
        """
        self.log.require_none_refused()
        is_due = self.limit.is_due(time)
        return self.log.is_pending or self.moves or self._has_jumped(runs, time) or is_due

    def _has_jumped(self, runs: Sequence[Run], time: float) -> bool:
        """Whether functions of the user give joints other places at once, as what they read was changed."""
        coupled = [run for run in runs if isinstance(run, CoupledRun)]
        self._jumped = any(run.mover.has_jumped(time) for run in coupled)
        return self._jumped

    def stored(self) -> dict[str, Any]:
        """All that has been changed so far, as JSON has it, for a restart file; empty if nothing has."""
        if not self.log.changed:
            return {}
        parts = self.log, self.limit, self.reader
        return {"moves": self.moves} | {key: value for part in parts for key, value in part.memory().items()}

    def figures(self) -> dict[str, float]:
        """Extremes of runs that others have taken over from; see `CableRun.figures`."""
        return self._figures

    def follow(self, runs: Sequence[Run], time: float, end: float, jumps: bool = False) -> Sequence[Run]:
        """The runs that go on from `time` to `end` [s], the next step of the time loop.

        Values that are set step by step change along a line in it, unless they shall jump.

        Raises:
            SceneError: a run cannot follow a change.
            StepSizeError: it brings the stability limit below the step.
        """
        changed, is_new = self.log.take(time, end)
        self.is_event = is_new or not changed
        if not (self.is_event or jumps) and self._load_again(runs, changed, time, end):
            return runs
        self._repeated = ()
        may_ramp = all(run.loads.follows for run in _alone(runs))
        self._jumps = self.is_event or jumps or not may_ramp
        self._line = None if self._jumps else self._line_until(runs, time, end)
        for run in runs if changed else ():
            run.control.look_soon()
        self.limit.notice(changed, time, end)
        self._has_jumped(runs, time)
        self.reader.drives.follow(changed, time, end)
        self.reader.begin_step(time, end)
        if self._act_at_once(runs, changed, time, end) or self._moves_at_once(runs, changed, time, end):
            return runs
        with state_kept(self.mbs):
            self.mbs.systemData.SetTime(time)
            runs = self._followed(runs, changed, time, end)
        self.moves = self._is_moving([run for run in runs if isinstance(run, CoupledRun)])
        return runs

    def _line_until(self, runs: Sequence[Run], time: float, end: float) -> Line | None:
        """Along which values get to what was taken last; None: it does not matter."""
        has_mean = all(run.has_mean_forces(end - time) for run in runs)
        return None if has_mean else Line(time, end, self.log.before)

    def _load_again(
        self, runs: Sequence[Run], changed: Mapping[Parameter, Any], time: float, end: float
    ) -> bool:
        """Whether the same loads as before the last step have other values, and nothing else has changed."""
        if tuple(changed) != self._repeated or self.moves or self.limit.is_due(time):
            return False
        if self._has_jumped(runs, time):
            return False
        take_forces(self.sensors, {})
        line = self._line_until(runs, time, end)
        for run in runs:
            run.control.look_soon()
        return all([run.mover.take_values(changed, line) for run in runs if isinstance(run, CoupledRun)])

    def require_all_seen(self, runs: Sequence[Run]) -> None:
        """At the end: mbs must contain what the runs have moved.

        Raises:
            SceneError: it does not, or a change was refused.
        """
        self.log.require_none_refused()
        if self.log.is_pending:  # after the last step
            return
        time = self.mbs.systemData.GetTime()
        for run in runs:
            if isinstance(run, CoupledRun):
                run.mover.require_same_items(time)
        scene, alone = read_scene(self.mbs, self.reader), _alone(runs)
        loads = [CableLoads(cable).constant for cable in scene.cables] if alone else []
        is_same = same_cables(self.scene, scene) and not (alone and scene.foreign)
        if not (is_same and all(map(np.array_equal, (run.loads.constant for run in alone), loads))):
            raise SceneError(
                "supports, loads or properties of a cable were changed during the run without its notice: "
                "by a method of mbs that was bound before the run, or by SetCableDrag or AddPointMass. The "
                "motion is not theirs: call mbs.SetLoadParameter etc. by name, and change properties "
                "before a run."
            )

    def _act_at_once(
        self, runs: Sequence[Run], changed: Mapping[Parameter, Any], time: float, end: float
    ) -> bool:
        """Whether all that has changed are values of loads, springs and masses, or joints that move on."""
        if self.limit.is_due(time) or self.limit.grown(changed):
            return False
        alone = _alone(runs)
        if alone:
            return not (self.moves or self._jumped) and self._load_at_once(alone, changed, time)
        most, items, weights = self._sort(runs, changed)
        if most > Demand.MOVE or not _have_begun(runs):
            return False
        if self.moves or self._jumped or most > Demand.BEGIN:
            return not weights and self._move_on(runs, {key: changed[key] for key in items}, most, time, end)
        if weights or most == Demand.BEGIN:
            forget_evaluators(self.sensors)
        else:
            take_forces(self.sensors, {})
        coupled = [run for run in runs if isinstance(run, CoupledRun)]
        if weights and not _weigh(coupled, {key: changed[key] for key in weights}):
            return False
        values = {key: changed[key] for key in items}
        line = None if most == Demand.BEGIN else self._line  # masses jump, and what changes with them
        if not all([run.mover.take_values(values, line) for run in coupled]):
            return False
        for run in coupled if most == Demand.BEGIN else ():
            start_after_jump(run, run.begin_again, time)
        if items == list(changed) and all(key.kind == "Load" for key in changed):
            self._repeated = tuple(changed)
        return True

    def _move_on(
        self, runs: Sequence[Run], items: Mapping[Parameter, Any], most: Demand, time: float, end: float
    ) -> bool:
        """Whether these have changed in compiled scenes whose joints move, or did in the last step.

        most: that they ask for.
        """
        coupled = [run for run in runs if isinstance(run, CoupledRun)]
        line = None if most == Demand.BEGIN else self._line_of_forces(runs, items)
        values = {key: x for key, x in items.items() if self._demands[key] != Demand.DRIVE}
        if not all([run.completes and run.mover.take_values(values, line) for run in coupled]):
            return False
        forget_evaluators(self.sensors)
        _go_on(runs, time, end, self._jumped or most == Demand.MOVE)
        self.moves = self._is_moving(coupled)
        return True

    def _is_moving(self, coupled: Sequence[CoupledRun]) -> bool:
        return self.reader.moves or any(run.mover.approaches for run in coupled)

    def _sort(self, runs: Sequence[Run], changed: Mapping[Parameter, Any]) -> tuple[Demand, Any, Any]:
        """The most that they ask for, those that ask for anything, and, of neither, weights of cables."""
        keys = tuple(changed)
        if self._sorted[:1] != (keys,):
            asked = {key: it for key in keys if (it := self._demand(runs, key))}
            weights = [key for key, it in asked.items() if it == Demand.WEIGH and _is_force(key)]
            items = [key for key in asked if key not in weights]
            most = max((asked[key] for key in items), default=Demand.NOTHING)
            self._sorted = keys, most, items, weights
        _, most, items, weights = self._sorted
        return most, items, weights

    def _load_at_once(self, runs: Sequence[CableRun], changed: Mapping[Parameter, Any], time: float) -> bool:
        """As `_act_at_once`, for constant forces on nodes, and weights, of cables among nothing else."""
        if any(run.loads.varies for run in runs) or not all(map(_is_force, changed)):
            return False
        values = _components(changed)
        loaded = _loaded(runs, values, self._line)
        if loaded is None:
            return False
        take_forces(self.sensors, values)
        for run in loaded if self._jumps else ():
            start_after_jump(run, run.start_scheme, time)
            run.watch.keep(run.state)
        return True

    def _moves_at_once(
        self, runs: Sequence[Run], changed: Mapping[Parameter, Any], time: float, end: float
    ) -> bool:
        """Whether supports of cables among nothing else have moved on, or constant forces have changed."""
        alone, places = _alone(runs), {key: x for key, x in changed.items() if not _is_force(key)}
        if not (alone and changed and all(starmap(self.reader.aims, places.items()))):
            return False
        loads = _components({key: x for key, x in changed.items() if key not in places})
        if loads and _loaded(alone, loads, self._line) is None:
            return False
        forget_evaluators(self.sensors)
        _go_on(alone, time, end, has_changed=True)
        self.moves = self.reader.moves
        return True

    def _acting(self, runs: Sequence[Run], changed: Mapping[Parameter, Any]) -> dict[Parameter, Any]:
        asked = {key: self._demand(runs, key) for key in changed}
        own = (key for key, it in asked.items() if Demand.NOTHING < it < Demand.WEIGH and it != Demand.DRIVE)
        return {key: changed[key] for key in own}

    def _demand(self, runs: Sequence[Run], key: Parameter) -> Demand:
        if key not in self._demands:
            self._demands[key] = demand(self.mbs, runs, self.scene.own_constraints, key)
        return self._demands[key]

    def _forget_demands(self) -> None:
        self._demands.clear()
        self._sorted = ()

    def _take_over(
        self, runs: Sequence[Run], changed: Mapping[Parameter, Any], asked: Demand, time: float
    ) -> None:
        """See `CoupledRun.take_over`; whoever evaluates a run then may demand something else."""
        items, ways = self._acting(runs, changed), [run.evaluated_by for run in runs]
        line = None if asked == Demand.BEGIN else self._line_of_forces(runs, changed)
        for run in runs:
            if isinstance(run, CoupledRun):
                run.take_over(items, asked <= Demand.WEIGH, time, line)
        if ways != [run.evaluated_by for run in runs]:
            self._forget_demands()

    def _line_of_forces(self, runs: Sequence[Run], changed: Mapping[Parameter, Any]) -> Line | None:
        """The line, without what moves joints: the runs know velocities for these, see `Steered`."""
        if self._line is None:
            return None
        before = self._line.before.items()
        own = {key: x for key, x in before if key in changed and self._demand(runs, key) != Demand.MOVE}
        return self._line._replace(before=own)

    def _followed(
        self, runs: Sequence[Run], changed: Mapping[Parameter, Any], time: float, end: float
    ) -> Sequence[Run]:
        asked = max((self._demand(runs, key) for key in changed), default=Demand.EVALUATE)
        if changed:
            forget_evaluators(self.sensors)
            if asked < Demand.BUILD:
                self._take_over(runs, changed, asked, time)
        if asked < Demand.WEIGH:
            is_stiffer = self.limit.follow_stiffness(runs, changed, time)
            has_moved = self._jumped or asked == Demand.MOVE
            if self.moves or is_stiffer or has_moved or asked >= Demand.BEGIN:
                _go_on(runs, time, end, has_moved)
            elif not _have_begun(runs):
                for run in runs:
                    run.start(time)
            return runs
        self._forget_demands()
        before, scene = self.scene, read_scene(self.mbs, self.reader)
        self.scene = scene
        same_items = same_cables(before, scene) and sorted(before.foreign) == sorted(scene.foreign)
        if asked < Demand.BUILD and same_items and _take_loads(runs, scene):
            _go_on(runs, time, end, has_changed=True)
            return runs
        new = self.builder.build(scene, time, state_of(self.mbs), end)
        self.limit.take_over(runs, new, time, changed)
        for run in new:
            run.start(time)
        self._figures = worst_figures([*runs, self])
        return new


def _alone(runs: Sequence[Run]) -> list[CableRun]:
    """Those of cables among nothing else."""
    return [run for run in runs if isinstance(run, CableRun)]


def _is_force(key: Parameter) -> bool:
    return key.kind == "Load" and key.name in ("load", "loadVector")


def _loaded(
    runs: Sequence[CableRun], values: Mapping[int, Sequence[float]], line: Line | None
) -> list[CableRun] | None:
    """Runs that have taken these values of loads; None if some are no constant loads on these cables.

    values: see `_components`.   line: along which loads get to these; None: they jump.
    """
    taken = [(run, run.ramp_loads(values, *line.step) if line else run.loads.change(values)) for run in runs]
    is_complete = set[int]().union(*(found for _, found in taken)) == values.keys()
    return [run for run, found in taken if found] if is_complete else None


def _weigh(runs: Sequence[CoupledRun], weights: Mapping[Parameter, Any]) -> bool:
    """Whether these are constant weights of cables among others, and act now."""
    values = _components(weights)
    return all(run.set_weights(values) == values.keys() for run in runs)


def _components(changed: Mapping[Parameter, Any]) -> dict[int, list[float]]:
    """(m,) of loads that have been set, by their numbers."""
    return {
        key.number: value if isinstance(value, list) else np.ravel(value).tolist()
        for key, value in changed.items()
    }


def _have_begun(runs: Sequence[Run]) -> bool:
    """Whether steps have been taken: what functions set before the first one is there from the beginning."""
    return any(run.control.steps for run in runs)


def _take_loads(runs: Sequence[Run], scene: Scene) -> bool:
    """Give the runs their present loads; False if one of them needs to be built again."""
    for run, cable in zip(_alone(runs), scene.cables, strict=False):
        loads = CableLoads(cable, run.loads.follows)
        if not loads.has_pattern_of(run.loads):
            return False
        run.loads, run.scene_cable = loads, cable
    return all(run.take_weights(scene.cables) for run in runs if isinstance(run, CoupledRun))


def _go_on(runs: Sequence[Run], time: float, end: float, has_changed: bool) -> None:
    """Begin again at `time` [s] with the present loads and motions.

    What the change did to the energy is no error.

    Args:
        end: of the step [s], at which joints are fulfilled that have changed.
        has_changed: whether joints may have; if not, they rest.
    """
    for run in runs:
        start_after_jump(run, partial(run.move_on, end=end, has_changed=has_changed), time)


def start_after_jump(run: Run, start: Callable[[float], None], time: float) -> None:
    """Start a run at `time` [s] from forces that have jumped.

    A multi-step scheme keeps the differences of its rates of change: a force that jumps has none.

    start: of the run, or of its scheme alone.
    """
    state = run.state
    history = [getattr(state, name) for name in run.integrator.carries if name != "a"]
    differences = [rates - state.a for rates in history]
    start(time)
    for rates, difference in zip(history, differences, strict=True):
        rates[:] = state.a + difference
