"""SolveEquilibrium: the stable static equilibrium of a scene with inextensible cables."""

import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

import exudyn
import numpy as np

from ..arrays import Array
from ..cable.axial import SHORTEST
from ..cable.cable import Cable
from ..cable.many_cables import cable_systems
from ..checks import require_finite, require_functions, require_integer, require_positive
from ..errors import EquilibriumError, InputError, SceneError
from ..items.arguments import refuse_others, settings_of, simulation_settings
from ..items.functions_of_time import take_word
from ..loads.weight import ElementWeight
from ..native.coupled_scene import CoupledScene
from ..native.evaluated_scene import CoupledCable
from ..native.native_items import state_kept, switched_off
from ..native.static_scene import StaticScene, put_data, require_held, rest_at
from ..native.velocity_level import at_position_level
from ..run.cable_loads import CableLoads
from ..run.redundancy import held_straight
from ..scene.model import CableInScene, Scene, put_reactions
from ..scene.redundant_rows import PIVOT_TOLERANCE, not_independent, shares_of_pivots
from ..statics import (
    GROWS,
    Equilibrium,
    JoinedPotential,
    Potential,
    find_equilibrium,
    potential_of,
    potentials_of,
    support_forces,
)
from ..statics.small_motions import small_motions
from .bend_check import fold_of, turn_at_rest
from .mbs_state import at_start
from .reports import StaticReport
from .scene import assemble, initial_states, read_scene
from .scene_runs import needs_coupling
from .sensors import warn_of_empty_sensors
from .spans import spans_of
from .stretch_check import stretch_of, warn_of_worst
from .unseen_outputs import warn_of_unseen_outputs

REACH_TOLERANCE = 1e-9
TAUT = 1.0 - 1e-6  # distance of supports over the reach of the cable between them
SKEW = 0.01  # part of the stiffness of other items, of loads without a potential [-]
NEARLY = 1.5  # times the shortest |r_x|
NO_TENSION = "where no tension holds it against forces across: give it its axialStiffness, or let it sag"
NO_POTENTIAL = (
    "put constant forces in the place of bodyFixed ones, of torques in space and of functions that look at "
    "the state, or let SolveExplicit move it: dampers between its nodes and the ground "
    "(CartesianSpringDamper), if they are strong enough, bring it to rest"
)
REACH = "bring what holds the cables within their reach"


def hint(scene_cable: CableInScene, q: Array, time: float) -> str:
    """Why a search may have failed at q (n, 2, dim), and what helps; empty if that is not known."""
    cable, names = scene_cable.cable, scene_cable.item.node_names
    shortest = np.linalg.norm(q[:, 1], axis=1)
    if cable.stretches and shortest.min() < NEARLY * SHORTEST:
        where = names[int(np.argmin(shortest))]
        return (
            f"cable '{scene_cable.name}' is compressed at node {where} to {shortest.min():.2g} of its "
            "length, so that it is about to turn inside out: let it be stiffer along its axis, or start "
            "nearer to the equilibrium"
        )
    if folded := fold_of(scene_cable, q, time):
        return folded
    if not cable.stretches and (taut := _taut(cable, time)):
        ends = " and ".join(str(names[k]) for k in taut)
        return f"cable '{scene_cable.name}' is straight between the supports of nodes {ends}, {NO_TENSION}"
    return ""


def _taut(cable: Cable, time: float) -> tuple[int, ...]:
    """Nodes whose supports are as far apart as the cable between them reaches."""
    return next((nodes for nodes, distance, reach in spans_of(cable, time) if distance > TAUT * reach), ())


def require_reach(cable: Cable, time: float, scene_cable: CableInScene) -> None:
    """Raise SceneError if supports are farther apart than cable and rods between them reach."""
    if cable.stretches:
        return
    names = scene_cable.item.node_names
    for (a, b), distance, reach in spans_of(cable, time):
        if distance > reach * (1.0 + REACH_TOLERANCE):
            raise SceneError(
                f"the supports of nodes {names[a]} and {names[b]} of cable '{scene_cable.name}' are "
                f"{distance:.9g} m apart, but the cable between them reaches {reach:.9g} m only: lengthen "
                "the cable, move the supports together, or give it its axialStiffness."
            )


MOST_ITERATIONS = 1_000_000
MOST_ROWS = 1000  # of constraints, that are looked through for those that depend on others


@dataclass(frozen=True)
class StaticSettings:
    """How SolveEquilibrium searches.

    Args:
        tolerance: of the forces that are not balanced, relative to the largest one on a cable [-].
        maxIterations: largest number of Newton steps for each load step.
        loadSteps: the loads, gravity included, are applied in that many equal parts; 1 among bodies, springs
            and joints.
        dependsOnTimeOnly: user functions of weights that do not depend on the state, see ExplicitSettings.
    """

    tolerance: float = 1e-9
    maxIterations: int = 500
    loadSteps: int = 1
    dependsOnTimeOnly: bool | Sequence[Any] | None = None

    def __post_init__(self) -> None:
        """Check all numbers.

        Raises:
            InputError: a number out of range.
        """
        require_positive("tolerance", self.tolerance)
        for name in ("maxIterations", "loadSteps"):
            require_integer(name, getattr(self, name), 1, MOST_ITERATIONS)
        require_functions("dependsOnTimeOnly", self.dependsOnTimeOnly)


def SolveEquilibrium(
    mbs: Any,
    simulationSettings: Any = None,
    staticSettings: StaticSettings | None = None,
    autoAssemble: bool = True,
    **others: Any,
) -> dict[str, Any]:
    """Static equilibrium of a scene with inextensible cables; the counterpart of mbs.SolveStatic.

    The search runs downhill on the constraints from the initial configuration, which need not fulfil them,
    to a stable equilibrium, and writes it into mbs as the initial and the present state, at rest: a
    following SolveExplicit starts from it, after loads were changed, for example. Initial velocities are
    lost, with a warning that says how to keep them. Bodies, springs, joints, torques and contact come to rest
    together with the cables; what a constraint at velocity level drives stays where it is. Multipliers
    of joints and supports go into mbs, too, so that outputs and sensors show their forces, with the sign of
    mbs.SolveStatic, which is opposite to that of mbs.SolveDynamic.

    Args:
        mbs: system.
        simulationSettings: exudyn.SimulationSettings; used are timeIntegration.startTime, at which loads and
            moving supports are taken, and what is written: the equilibrium in the solution file and sensors,
            at the time staticSolver.loadStepStart + loadStepDuration, for which sensors ask user functions of
            the time; None: nothing is written.
        staticSettings: tolerances and load steps.
        autoAssemble: whether mbs.Assemble() is called if mbs is not assembled, as mbs.SolveStatic does.
        others: arguments of mbs.SolveStatic that have no counterpart; they are refused by name.

    Returns:
        dict, which prints as a summary, with 'success', 'residual' [N], 'violation' of constraints [-, m],
        'iterations', 'time' [s] at which functions of loads and supports were asked,
        'smallestEigenvalue' of the constrained Hessian over the mass [1/s^2] (its root is the lowest
        natural frequency), each the worst of all cables, and 'cables' (the same for each one, with its
        'coordinates'); among bodies and joints the figures are those of the whole scene. A body that is free
        to turn about an axis has an eigenvalue of zero there, within round-off. Of loads without a potential,
        as bodyFixed ones, 'smallestEigenvalue' contains the symmetric part alone, unless that is negative;
        ComputeEigenvalues refuses them where they matter.

    Raises:
        InputError: arguments of another kind, or more than one load step among bodies, springs and joints.
        SceneError: mbs cannot be assembled, or shall not, contains what is not supported, supports farther
            apart than the cable between them is long, or something that nothing connects to the ground.
        EquilibriumError: no stable equilibrium within reach, or small vibrations grow there; mbs is
            unchanged, the error's `report` has the figures and the last coordinates.

    Example:
        SolveEquilibrium(mbs)
        mbs.SetLoadParameter(ice, "loadVector", [0, 0, 0])
        SolveExplicit(mbs, simulationSettings)
    """
    refuse_others("SolveEquilibrium", others)
    settings = simulation_settings(simulationSettings)
    static: StaticSettings = settings_of(StaticSettings, "staticSettings", staticSettings)
    assemble(mbs, "SolveEquilibrium", autoAssemble)
    take_word(mbs, static.dependsOnTimeOnly)
    time = require_finite("timeIntegration.startTime", settings.timeIntegration.startTime, "s")
    with scene_of(mbs, time, "mbs.SolveStatic") as scene:
        sensors = [mbs.GetSensor(number) for number in range(mbs.systemData.NumberOfSensors())]
        warn_of_empty_sensors(mbs, sensors, scene.enforcing)
        warn_of_unseen_outputs(mbs, scene, sensors, at_rest=True)
        solve = _solve_scene if needs_coupling(scene) else _solve_cables
        report = solve(mbs, scene, time, static)
    if simulationSettings is not None:
        _write_equilibrium(mbs, settings, scene.evaluated_by_kernels[0])
    return report


@contextmanager
def scene_of(mbs: Any, time: float, native: str) -> Iterator[Scene]:
    """What mbs contains; meanwhile, its drives hold positions.   native: what to use if there is no cable.

    Raises:
        SceneError: there is none.
    """
    with ExitStack() as stack:
        with at_start(mbs, time):
            stack.enter_context(at_position_level(mbs, time))
            scene = read_scene(mbs)
        if not scene.cables:
            raise SceneError(f"mbs has no inextensible cable: use {native} for native items.")
        yield scene


def _write_equilibrium(mbs: Any, settings: Any, cables: Sequence[int]) -> None:
    """Write the present state of mbs, where settings ask for it, as mbs.SolveStatic does its last load step.

    Args:
        mbs: at rest.   settings: exudyn.SimulationSettings.   cables: see `switched_off`.
    """
    current, static = exudyn.ConfigurationType.Current, settings.staticSolver
    end = static.loadStepStart + static.loadStepDuration
    with switched_off(mbs, cables), state_kept(mbs):
        found = mbs.systemData.GetSystemState(current)
        solver: Any = exudyn.MainSolverStatic()
        solver.InitializeSolver(mbs, settings)
        mbs.systemData.SetSystemState(found, current)
        mbs.systemData.SetTime(end)
        solver.it.currentTime = end
        solver.FinishStep(mbs, settings)
        solver.output.finishedSuccessfully = True
        solver.FinalizeSolver(mbs, settings)


def _solve_cables(mbs: Any, scene: Scene, time: float, static: StaticSettings) -> dict[str, Any]:
    """Each cable by itself; arguments: see `_solve_cable`."""
    cables = scene.cables
    found = [_solve_cable(mbs, cable, time, static) for cable in cables]
    report = _report(cables, found, time)
    failed = [(c, e) for c, e in zip(cables, found, strict=True) if not e.converged]
    if failed:
        cable, equilibrium = failed[0]
        said = _failure(f"cable '{cable.name}'", equilibrium, "loadSteps or maxIterations", failed[:1], time)
        raise EquilibriumError(said, StaticReport(report, success=False))
    displacements, reactions = np.zeros(mbs.systemData.ODE2Size()), np.zeros(mbs.systemData.AEsize())
    for cable, equilibrium in zip(cables, found, strict=True):
        displacements[cable.indices] = (equilibrium.q - cable.cable.reference).ravel()
        _put_reactions(cable, equilibrium.q, equilibrium.multipliers, time, reactions)
    rest_at(mbs, displacements, reactions)
    _warn_of_stretch(cables, [one.q for one in found], [one.multipliers for one in found], time)
    _warn_of_folds(cables, found, time)
    return report


def _solve_cable(mbs: Any, scene_cable: CableInScene, time: float, static: StaticSettings) -> Equilibrium:
    ((q, _),) = initial_states(mbs, [scene_cable])
    for step in range(1, static.loadSteps + 1):
        potential = cable_at_rest(scene_cable, time, step / static.loadSteps)
        equilibrium = find_equilibrium(potential, q, static.tolerance, static.maxIterations)
        q = equilibrium.q
    return equilibrium


def cable_at_rest(scene_cable: CableInScene, time: float, share: float = 1.0) -> Potential:
    """A cable among nothing else, under its loads at a time [s].   share: of the loads [-]."""
    cable = scene_cable.cable
    _require_still_fluid(scene_cable)
    require_reach(cable, time, scene_cable)
    external = CableLoads(scene_cable).at(time)[: cable.reference.size]
    return potential_of([cable], external * share, time)


class SceneAtRest(NamedTuple):
    """All of a scene.

    joined: evaluated by Exudyn.   others: all but its cables.   potential: of all.   start: (n,) of mbs.
    cables: of the scene, without the loads that Exudyn evaluates.
    """

    joined: CoupledScene
    others: StaticScene
    potential: JoinedPotential
    start: Array
    cables: list[CableInScene]


@contextmanager
def scene_at_rest(mbs: Any, scene: Scene, time: float) -> Iterator[SceneAtRest]:
    """A scene with bodies, joints or springs, at a time [s]; meanwhile, Exudyn may be asked."""
    unloaded = [cable.among_others for cable in scene.cables]
    for cable in unloaded:
        _require_still_fluid(cable)
        _require_known_weight(cable)
        require_reach(cable.cable, time, cable)
    with at_start(mbs, time), switched_off(mbs, *scene.evaluated_by_kernels):
        loads = [CableLoads(cable) for cable in unloaded]
        systems = cable_systems([cable.cable for cable in unloaded], 0.0)
        parts = list(map(CoupledCable, unloaded, systems, loads))
        joined = CoupledScene(mbs, parts, scene.own_constraints, 0.0, scene.held)
        require_held(joined, [bool(cable.cable.fixed.any() or cable.cable.links) for cable in unloaded])
        others = StaticScene(joined, time)
        cables = [cable.cable for cable in unloaded]
        external = [own.at(time)[: cable.reference.size] for cable, own in zip(cables, loads, strict=True)]
        start, _ = joined.initial_state
        potential = JoinedPotential(potentials_of(cables, external, time), others, start)
        yield SceneAtRest(joined, others, potential, start, unloaded)


def _solve_scene(mbs: Any, scene: Scene, time: float, static: StaticSettings) -> dict[str, Any]:
    """All of a scene at once; arguments: see `_solve_cable`."""
    if static.loadSteps > 1:
        raise InputError(
            f"loadSteps = {static.loadSteps!r}: among bodies, springs and joints the loads are applied at "
            "once; set it to 1, and start nearer to the equilibrium."
        )
    with scene_at_rest(mbs, scene, time) as (joined, others, potential, start, unloaded):
        equilibrium = find_equilibrium(potential, start, static.tolerance, static.maxIterations)
        q = equilibrium.q
        reactions = others.reactions(q, _last(len(others.values(q)), equilibrium.multipliers))
        data = others.data(q)
        where, taut, redundant = "", list[str](), ""
        if np.isfinite(equilibrium.residual) and not equilibrium.converged:
            largest = potential.least_balanced(q, equilibrium.multipliers)
            where = f", largest at {joined.coordinate_name(joined.map.indices[largest])}"
            places = zip(scene.cables, joined.map.slices, strict=False)
            there = [f"cable '{one.name}'" for one, dofs in places if dofs.start <= largest < dofs.stop]
            taut = [one for one in held_straight(joined, q, 1.0 - TAUT) if one in there]
            redundant = _redundant(potential, q, joined.native_items.joints)
            redundant = redundant or _without_potential(potential, equilibrium)
    multipliers = potential.multipliers_of_cables(equilibrium.multipliers)
    of_cables = [
        replace(equilibrium, q=q[dofs].reshape(cable.cable.reference.shape))
        for cable, dofs in zip(scene.cables, joined.map.slices, strict=False)
    ]
    report = _report(scene.cables, of_cables, time)
    if not equilibrium.converged:
        pairs = zip(scene.cables, of_cables, strict=True)
        said = _failure("the scene", equilibrium, "maxIterations", pairs, time, where, taut, redundant)
        raise EquilibriumError(said, StaticReport(report, success=False))
    for k, own in enumerate(multipliers):
        _put_reactions(scene.cables[k], of_cables[k].q, own, time, reactions)
    _warn_of_stretch(unloaded, [one.q for one in of_cables], multipliers, time)
    _warn_of_folds(unloaded, of_cables, time)
    rest_at(mbs, joined.displacements(q), reactions)
    put_data(mbs, data)
    return report


def _last(number: int, rows: Array) -> Array:
    """The last `number` of all rows, which are those of joints."""
    return rows[len(rows) - number :]


def _redundant(potential: JoinedPotential, q: Array, joints: Sequence[str]) -> str:
    """What is said of joints that depend on other constraints at q; empty if none does.

    joints: names of their rows, which are the last ones of all constraints.
    """
    jacobian = potential.jacobian(q)
    if jacobian.shape[0] > MOST_ROWS:
        return ""
    pivots = _last(len(joints), shares_of_pivots((jacobian @ jacobian.T).toarray()))
    found = [name for name, pivot in zip(joints, pivots, strict=True) if pivot <= PIVOT_TOLERANCE]
    return str(not_independent(found)).rstrip(".") if found else ""


def _without_potential(potential: JoinedPotential, found: Equilibrium) -> str:
    """What helps where other items have no symmetric stiffness; empty if they have."""
    skew = small_motions(potential, found.q, found.multipliers).skew
    others = potential.of_others
    is_skew = others is not None and abs(skew).max() > SKEW * abs(others).max()
    return NO_POTENTIAL if is_skew else ""


def _put_reactions(cable: CableInScene, q: Array, multipliers: Array, time: float, reactions: Array) -> None:
    """Those of its supports, into the multipliers of all algebraic equations; see `support_forces`."""
    if cable.reactions and len(multipliers):
        forces = support_forces(cable.cable, q, multipliers, time)
        put_reactions(cable.reactions, forces, reactions[np.newaxis])


def _warn_of_stretch(
    cables: Sequence[CableInScene], states: Sequence[Array], multipliers: Sequence[Array], time: float
) -> None:
    """Where templates tell an axial stiffness that was left out, and matters.   states: (n, 2, dim)."""
    said = []
    for cable, q, own in zip(cables, states, multipliers, strict=False):
        if cable.item.leaves_stretch_out:
            potential = potential_of([cable.cable], np.zeros(q.size), time)
            largest = float(np.abs(potential.mean_tension(own)).max())
            said.append(stretch_of(cable, (largest, largest), q[np.newaxis, :, 0], time))
    warn_of_worst(said)


def _warn_of_folds(cables: Sequence[CableInScene], found: Sequence[Equilibrium], time: float) -> None:
    """Of the first cable that rests in a shape of coarse elements alone."""
    pairs = list(zip(cables, found, strict=False))
    folds = (fold_of(cable, one.q, time) for cable, one in pairs)
    turns = (turn_at_rest(cable, one.q) for cable, one in pairs)
    if said := next(filter(None, chain(folds, turns)), ""):
        warnings.warn(f"{said}.", stacklevel=4)


def _require_still_fluid(scene_cable: CableInScene) -> None:
    drag = scene_cable.cable.drag
    if drag is not None and any(drag.flow):
        raise SceneError(
            f"cable '{scene_cable.name}' lies in a flow of {list(drag.flow)} m/s, whose drag has no "
            "potential: set flowVelocity to zero, or let SolveExplicit run until the cable rests."
        )


def _require_known_weight(scene_cable: CableInScene) -> None:
    """Weights are asked once, nodal forces in each state of the search."""
    for load in scene_cable.among_others.loads:
        if isinstance(load, ElementWeight) and load.follows_state:
            raise SceneError(
                f"the user function of the load on {load.place} may depend on the state, which "
                "is not that of the equilibrium yet: if it depends on the time alone, set "
                "StaticSettings(dependsOnTimeOnly=[function]); otherwise put LoadForceVector on the nodes."
            )


def _report(cables: list[CableInScene], found: list[Equilibrium], time: float) -> dict[str, Any]:
    rows = [
        {
            "name": cable.name,
            "residual": equilibrium.residual,
            "violation": equilibrium.violation,
            "iterations": equilibrium.iterations,
            "smallestEigenvalue": equilibrium.smallest_eigenvalue,
            "coordinates": equilibrium.q,
        }
        for cable, equilibrium in zip(cables, found, strict=True)
    ]
    return StaticReport(
        {
            "success": True,
            "residual": max(equilibrium.residual for equilibrium in found),
            "violation": max(equilibrium.violation for equilibrium in found),
            "iterations": max(equilibrium.iterations for equilibrium in found),
            "smallestEigenvalue": min(equilibrium.smallest_eigenvalue for equilibrium in found),
            "time": time,
            "cables": rows,
        }
    )


def _failure(
    what: str,
    equilibrium: Equilibrium,
    more: str,
    cables: Iterable[tuple[CableInScene, Equilibrium]],
    time: float,
    where: str = "",
    taut: Sequence[str] = (),
    redundant: str = "",
) -> str:
    """What went wrong and what helps.

    cables: with their last states.   where: forces are not balanced.   taut: names of cables that are
        straight between what holds their ends.   redundant: what is said of joints that depend on others.
    """
    pairs = list(cables)
    hints = [NO_POTENTIAL] if equilibrium.message == GROWS else []
    hints += filter(None, (hint(cable, own.q, time) for cable, own in pairs))
    hints += [f"{one} is straight between what holds its ends, {NO_TENSION}" for one in taut]
    hints += [redundant] if redundant else []
    is_met = np.isfinite(equilibrium.residual)
    nearer = "start nearer to the equilibrium"
    ways = ["add supports", nearer, f"use more {more}"] if is_met else [REACH, nearer]
    if any(not cable.cable.stretches for cable, _ in pairs):
        ways.append("give the cables their axialStiffness, as inextensible ones side by side are redundant")
    remedy = hints or [f"{', '.join(ways[:-1])}, or {ways[-1]}"]
    balance = (
        f" after {equilibrium.iterations} iterations (unbalanced force {equilibrium.residual:.3g} N{where}, "
        f"violation of constraints {equilibrium.violation:.3g}, smallest eigenvalue "
        f"{equilibrium.smallest_eigenvalue:.3g} 1/s^2)"
    )
    return (
        f"{what}: {equilibrium.message}{balance if is_met else f' (violation {equilibrium.violation:.3g})'}: "
        f"{remedy[0]}. mbs is unchanged; the error's report has the last state."
    )
