"""SolveEquilibrium: the stable static equilibrium of the inextensible cables of an mbs."""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..checks import require_finite, require_integer, require_positive
from ..constraints.prescribed_motion import KIND
from ..errors import EquilibriumError, InputError, SceneError
from ..run.cable_loads import CableLoads
from ..scene.model import CableInScene
from ..statics import Equilibrium, Potential, StaticOptions, find_equilibrium
from .arguments import simulation_settings
from .scene import initial_state, read_cables, require_assembled

REACH_TOLERANCE = 1e-9
MOST_ITERATIONS = 1_000_000


@dataclass(frozen=True)
class StaticSettings:
    """How SolveEquilibrium searches.

    Args:
        tolerance: of the forces that are not balanced, relative to the largest one on a cable [-].
        maxIterations: largest number of Newton steps for each load step.
        loadSteps: the loads, gravity included, are applied in that many equal parts.
    """

    tolerance: float = 1e-9
    maxIterations: int = 500
    loadSteps: int = 1

    def __post_init__(self) -> None:
        """Check all numbers.

        Raises:
            InputError: a number out of range.
        """
        require_positive("tolerance", self.tolerance)
        for name in ("maxIterations", "loadSteps"):
            require_integer(name, getattr(self, name), 1, MOST_ITERATIONS)


def SolveEquilibrium(
    mbs: Any, simulationSettings: Any = None, staticSettings: StaticSettings | None = None
) -> dict[str, Any]:
    """Static equilibrium of a scene of inextensible cables; the counterpart of mbs.SolveStatic.

    The search runs downhill on the constraints from the initial configuration, which need not fulfil them,
    to a stable equilibrium, and writes it into mbs as the initial and the present state, at rest: a
    following SolveExplicit starts from it, after loads were changed, for example.

    Args:
        mbs: assembled system.
        simulationSettings: exudyn.SimulationSettings; used is timeIntegration.startTime, at which loads and
            moving supports are taken.
        staticSettings: tolerances and load steps.

    Returns:
        dict with 'success', 'residual' [N], 'violation' of constraints [-, m], 'iterations',
        'smallestEigenvalue' of the constrained Hessian over the mass [1/s^2] (its root is the lowest
        natural frequency), each the worst of all cables, and 'cables' (the same for each one).

    Raises:
        SceneError: mbs not assembled, contains what is not supported, or supports farther apart than
            the cable between them is long.
        EquilibriumError: no stable equilibrium within reach; mbs is unchanged, the error's `report` has
            the figures and the last coordinates.

    Example:
        SolveEquilibrium(mbs)
        mbs.SetLoadParameter(ice, "loadVector", [0, 0, 0])
        SolveExplicit(mbs, simulationSettings)
    """
    settings = simulation_settings(simulationSettings)
    static = _static_settings(staticSettings)
    require_assembled(mbs)
    time = require_finite("timeIntegration.startTime", settings.timeIntegration.startTime, "s")
    cables = read_cables(mbs, "SolveEquilibrium")
    if not cables:
        raise SceneError("mbs has no inextensible cable: use mbs.SolveStatic for native items.")
    found = [_solve_cable(mbs, cable, time, static) for cable in cables]
    report = _report(cables, found)
    failed = [(c, e) for c, e in zip(cables, found, strict=True) if not e.converged]
    if failed:
        raise EquilibriumError(_failure(*failed[0]), report | {"success": False})
    for cable, equilibrium in zip(cables, found, strict=True):
        _write(mbs, cable, equilibrium.q)
    return report


def _static_settings(given: Any) -> StaticSettings:
    if given is not None and not isinstance(given, StaticSettings):
        raise InputError(f"staticSettings = {given!r}: must be a StaticSettings, or None.")
    return given or StaticSettings()


def _solve_cable(mbs: Any, scene_cable: CableInScene, time: float, static: StaticSettings) -> Equilibrium:
    cable = scene_cable.cable
    _require_still_fluid(scene_cable)
    _require_reach(cable, time, scene_cable)
    external = CableLoads(scene_cable).at(time)[: cable.reference.size]
    options = StaticOptions(static.tolerance, static.maxIterations)
    q, _ = initial_state(mbs, scene_cable)
    for step in range(1, static.loadSteps + 1):
        equilibrium = find_equilibrium(Potential(cable, external * step / static.loadSteps, time), q, options)
        q = equilibrium.q
    return equilibrium


def _require_still_fluid(scene_cable: CableInScene) -> None:
    drag = scene_cable.cable.drag
    if drag is not None and any(drag.flow):
        raise SceneError(
            f"cable '{scene_cable.name}' lies in a flow of {list(drag.flow)} m/s, whose drag has no "
            "potential: set flowVelocity to zero, or let SolveExplicit run until the cable rests."
        )


def _report(cables: list[CableInScene], found: list[Equilibrium]) -> dict[str, Any]:
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
    return {
        "success": True,
        "residual": max(equilibrium.residual for equilibrium in found),
        "violation": max(equilibrium.violation for equilibrium in found),
        "iterations": max(equilibrium.iterations for equilibrium in found),
        "smallestEigenvalue": min(equilibrium.smallest_eigenvalue for equilibrium in found),
        "cables": rows,
    }


def _failure(cable: CableInScene, equilibrium: Equilibrium) -> str:
    return (
        f"cable '{cable.name}': {equilibrium.message} after {equilibrium.iterations} iterations (unbalanced "
        f"force {equilibrium.residual:.3g} N, violation of constraints {equilibrium.violation:.3g}, smallest "
        f"eigenvalue {equilibrium.smallest_eigenvalue:.3g} 1/s^2): add supports, start nearer to the "
        "equilibrium, or use more loadSteps or maxIterations. mbs is unchanged; the error's report has the "
        "last state."
    )


def _write(mbs: Any, scene_cable: CableInScene, q: Array) -> None:
    """q (n, 2, dim) as initial and present state, at rest."""
    displacements = (q - scene_cable.cable.reference).ravel()
    rest = np.zeros(len(displacements))
    data = mbs.systemData
    for configuration in (exudyn.ConfigurationType.Initial, exudyn.ConfigurationType.Current):
        for values, get, put in (
            (displacements, data.GetODE2Coordinates, data.SetODE2Coordinates),
            (rest, data.GetODE2Coordinates_t, data.SetODE2Coordinates_t),
        ):
            system = np.array(get(configuration))
            system[scene_cable.indices] = values
            put(system.tolist(), configuration)
    width = 2 * scene_cable.cable.dimension
    for k, node in enumerate(scene_cable.item.nodes):
        mine = displacements[k * width : (k + 1) * width].tolist()
        mbs.SetNodeParameter(node, "initialCoordinates", mine)
        mbs.SetNodeParameter(node, "initialVelocities", [0.0] * width)


def _require_reach(cable: Cable, time: float, scene_cable: CableInScene) -> None:
    """Raise SceneError if supports are farther apart than cable and rods between them reach."""
    arc = np.append(0.0, np.cumsum(cable.element_lengths))
    names = scene_cable.item.node_names
    for (a, here, slack_a), (b, there, slack_b) in combinations(_held_points(cable, time), 2):
        distance, reach = float(np.linalg.norm(there - here)), abs(arc[b] - arc[a]) + slack_a + slack_b
        if distance > reach * (1.0 + REACH_TOLERANCE):
            raise SceneError(
                f"the supports of nodes {names[a]} and {names[b]} of cable '{scene_cable.name}' are "
                f"{distance:.9g} m apart, but the cable between them reaches {reach:.9g} m only: lengthen "
                "the cable or move the supports together."
            )


def _held_points(cable: Cable, time: float) -> list[tuple[int, Array, float]]:
    """(node, point, how far the node may be from it) of pins, clamps, moving supports and hangers."""
    nodes = np.flatnonzero(cable.fixed[:, 0])
    points = [(int(k), cable.reference[k, 0], 0.0) for k in nodes if not (cable.closed and k == nodes[-1])]
    for node in {link.nodes[0] for link in cable.links if link.kind == KIND}:
        held = [link for link in cable.links if link.kind == KIND and link.nodes == (node,)]
        if len(held) == cable.dimension:
            points.append((node, sum(link.normal * link.anchor.at(time)[0] for link in held), 0.0))
    hangers = [link for link in cable.links if len(link.nodes) == 1 and np.isfinite(link.length)]
    return points + [(link.nodes[0], link.anchor.at(time)[0], link.length) for link in hangers]
