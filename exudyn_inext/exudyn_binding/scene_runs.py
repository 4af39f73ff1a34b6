"""Which runs move a scene: the cheapest way that is valid for what it contains."""

import warnings
from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from typing import Any

from ..cable.implicit_bending import ImplicitBending
from ..cable.many_cables import cable_systems
from ..checks import LARGEST
from ..errors import InextensibleError, InputError, SceneError
from ..garbage import not_collected
from ..items.functions_of_time import functions_at_rest, step_functions, take_word
from ..items.parameters import Parameter, markers_placed_by, objects_at
from ..native.contact_rates import has_circles
from ..native.coupled_scene import CoupledScene
from ..native.evaluated_scene import CoupledCable
from ..native.native_items import switched_off
from ..native.velocity_level import at_position_level
from ..run.cable_run import CableRun, Start
from ..run.consistent_start import are_kept
from ..run.coupled_run import CoupledRun, Run
from ..run.settings import ExplicitSettings
from ..run.step_choice import USUAL_SCALING, StepSizeBounds, step_bounds
from ..scene.model import CableInScene, HeldCoordinate, Scene
from .mbs_state import State, at_start, initial_state
from .scene import initial_states, read_scene, require_assembled
from .time_loop import refuse_step_functions

MOST_NAMED = 3  # items of a scene, in messages


def needs_coupling(scene: Scene) -> bool:
    """Whether there are other items than cables, all moved together by one right-hand side of Exudyn."""
    return bool(scene.foreign) or not scene.cables


@dataclass(eq=False)
class RunBuilder:
    """Makes the runs of a scene: at the start, and again when it has changed.

    mbs: assembled.   changed: parameters, in the course of the run; such constraints become joints.
    explicit: settings.   scaling: step that scales the mass [s]; 0 without mass scaling.
    stack: at its end, cables that were switched off for coupled scenes are switched on again.
    """

    mbs: Any
    changed: Set[Parameter]
    explicit: ExplicitSettings
    scaling: float
    stack: ExitStack
    _is_switched_off: bool = False

    def take_step(self, explicit: ExplicitSettings, h: float) -> None:
        """Build later runs for steps of h [s], with these settings."""
        self.explicit = explicit
        self.scaling = h if explicit.massScaling else 0.0

    def build(
        self,
        scene: Scene,
        time: float,
        state: State | None = None,
        end: float | None = None,
        was_coupled: bool = False,
    ) -> Sequence[Run]:
        """Runs that begin at `time` [s] in a state; None: the initial configuration.

        In a given state, constraints that were switched on may be violated by any velocity.   end: of the
        step in which they are to be fulfilled [s]; None: they are.   was_coupled: whether cables move with
        other items, also if these have been switched off since.
        """
        is_coupled = was_coupled or needs_coupling(scene)
        if not self._is_switched_off and is_coupled:  # by kernels, and not by Exudyn as well
            self.stack.enter_context(switched_off(self.mbs, *scene.evaluated_by_kernels))
            self._is_switched_off = True
        changed = {key.number for key in self.changed if key.kind == "Object"}
        for key in self.changed:
            for marker in markers_placed_by(self.mbs, key) or ():
                changed.update(objects_at(self.mbs, marker))
        held = {number: held for number, held in scene.held.items() if number not in changed}
        scene, explicit = replace(scene, held=held), self.explicit
        given = end, changed, was_coupled
        if state is None:
            return runs_of_scene(self.mbs, scene, time, self.scaling, explicit, *given)
        with initial_state(self.mbs, state):
            lenient = replace(explicit, startTolerance=LARGEST)
            return runs_of_scene(self.mbs, scene, time, self.scaling, lenient, *given)


def runs_of_cables(
    mbs: Any,
    cables: Sequence[CableInScene],
    time: float,
    h: float,
    explicit: ExplicitSettings,
    follows: bool = False,
) -> list[CableRun]:
    """One run for each cable, from the initial configuration; arguments: see `runs_of_scene` and `Start`."""
    start, states = Start(time, h, explicit, follows), initial_states(mbs, cables)
    method = explicit.method
    scaled = ImplicitBending((explicit.massScaling or 0.0) * h**2)
    systems = cable_systems([one.cable for one in cables], explicit.stabilizationRate, scaled)
    is_kept = len(cables) > 1 and are_kept(cables, systems, states)
    return [CableRun(*given, start, method, is_kept) for given in zip(cables, systems, states, strict=True)]


def runs_of_scene(
    mbs: Any,
    scene: Scene,
    time: float,
    h: float,
    explicit: ExplicitSettings,
    end_of_step: float | None = None,
    moved: Set[int] = frozenset(),
    is_coupled: bool = False,
) -> Sequence[Run]:
    """One run for each cable, or one for cables, bodies and joints together.

    Args:
        mbs: the system; the user functions of its cables are switched off if it needs coupling.
        scene: what it contains.   time: of the start [s].
        h: step that scales the mass [s]; 0 without mass scaling.   explicit: settings.
        end_of_step: see `CoupledRun`.   moved: see `CoupledScene`.
        is_coupled: whether it needs coupling in any case.

    Raises:
        SceneError: nothing moves.
        InputError: massScaling without an inextensible cable.
    """
    if mbs.systemData.ODE2Size() == 0:
        raise SceneError("mbs has nothing that moves: add a cable with CreateInextensibleCable.")
    if explicit.massScaling and not scene.cables:
        raise InputError(
            f"massScaling = {explicit.massScaling!r}: only inextensible cables have it; set it to zero."
        )
    if not (is_coupled or needs_coupling(scene)):
        return runs_of_cables(mbs, scene.cables, time, h, explicit, bool(step_functions(mbs)))
    pressed = has_circles(mbs) or mbs.NumberOfGeneralContacts() > 0
    unloaded = [  # Exudyn evaluates the loads
        replace(cable.among_others, cable=replace(cable.cable, pressed=pressed)) for cable in scene.cables
    ]
    runs = runs_of_cables(mbs, unloaded, time, h, explicit)
    cables = [CoupledCable(run.scene_cable, run.system, run.loads) for run in runs]
    start, why = Start(time, h, explicit), _shortened(scene.foreign)

    def coupled_run(held: Mapping[int, HeldCoordinate]) -> CoupledRun:
        own, zeta = scene.own_constraints, explicit.stabilizationRate
        with functions_at_rest(mbs):
            joined = CoupledScene(mbs, cables, own, zeta, held, moved)
            return CoupledRun(joined, runs, explicit.method, start, why, end_of_step)

    run: CoupledRun | None = None
    why_not = ""
    if scene.held:  # compiled forms take them as joints
        with suppress(InextensibleError), warnings.catch_warnings(record=True) as recorded:
            warnings.simplefilter("always")  # whether they are shown is decided below
            run = coupled_run({})
            why_not = run.why_not
        if run and run.is_compiled:
            for each in recorded:
                warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
            return [run]
    run = coupled_run(scene.held)
    run.why_not = why_not or run.why_not
    return [run]


def compiled_runs(
    mbs: Any, time: float, h: float, explicit: ExplicitSettings, who: str, where: str
) -> Sequence[Run]:
    """As `runs_of_scene`, of runs that do without mbs from then on; it stays as it was.

    who: asks.   where: step functions would not be called.

    Raises:
        SceneError: Exudyn has to evaluate items of the scene, or there are step functions, or no cables.
    """
    require_assembled(mbs)
    refuse_step_functions(mbs, where)
    take_word(mbs, explicit.dependsOnTimeOnly)
    with not_collected(), at_start(mbs, time), at_position_level(mbs, time):
        scene = read_scene(mbs)
        if not scene.cables:
            raise SceneError(
                "mbs has no inextensible cable to step: add one with CreateInextensibleCable, make native "
                "elements one by ReplaceNativeCables, or use SolveExplicit for native items."
            )
        if not needs_coupling(scene):
            return runs_of_cables(mbs, scene.cables, time, h, explicit)
        with switched_off(mbs, *scene.evaluated_by_kernels):
            runs: Sequence[Any] = runs_of_scene(mbs, scene, time, h, explicit)
        for run in runs:
            run.leave_mbs(who)
        return runs


def bounds_if_scaled(
    mbs: Any, scene: Scene, time: float, h: float, explicit: ExplicitSettings
) -> Callable[[], StepSizeBounds] | None:
    """Bounds of the step h [s] with the usual mass scaling, to advise it; None if it is set, or cannot be.

    Args: see `runs_of_scene`.
    """
    if explicit.massScaling or not scene.cables:
        return None

    def bounds() -> StepSizeBounds:
        scaled = replace(explicit, massScaling=USUAL_SCALING)
        return step_bounds(runs_of_scene(mbs, scene, time, h, scaled), time, scaled)

    return bounds


def _shortened(items: Sequence[str]) -> str:
    rest = f" and {len(items) - MOST_NAMED} more" if len(items) > MOST_NAMED else ""
    return ", ".join(items[:MOST_NAMED]) + rest if items else "bodies or joints"
