"""ComputeEigenvalues: the lowest vibrations of a scene about its equilibrium."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import LARGEST_NUMBER_OF_ITEMS, require_finite, require_integer
from ..errors import SceneError
from ..items.arguments import simulation_settings
from ..native.coupled_scene import CoupledScene
from ..scene.model import Scene
from ..statics.small_motions import SmallMotions, small_motions
from ..statics.static_system import StaticSystem
from ..statics.vibrations import balance, missed_forces, shares_of, vibrations
from .reports import EigenvalueReport
from .scene import assemble, initial_states
from .scene_runs import needs_coupling
from .static_solver import cable_at_rest, scene_at_rest, scene_of

AT_REST = 1e-5  # force that is left unbalanced, over the largest load
MISSED = 0.05  # of the stiffness in a vibration, which forces without a potential may be [-]
ON_CONSTRAINTS = 1e-6  # violation of these [-, m]


def ComputeEigenvalues(
    mbs: Any, simulationSettings: Any = None, numberOfEigenvalues: int = 10, autoAssemble: bool = True
) -> dict[str, Any]:
    """Lowest vibrations about the equilibrium in which mbs rests; see mbs.ComputeODE2Eigenvalues.

    Call SolveEquilibrium before. What forces of constraints, the tension of cables among them, do to the
    stiffness is contained; mbs.ComputeODE2Eigenvalues leaves it out. Damping and initial velocities are not
    contained. The equilibrium need not be stable: it has a negative eigenvalue then.

    Args:
        mbs: system, which stays as it is.
        simulationSettings: exudyn.SimulationSettings; used is timeIntegration.startTime, at which loads and
            moving supports are taken.
        numberOfEigenvalues: how many, from the lowest one on; fewer are given if there are fewer.
        autoAssemble: whether mbs.Assemble() is called if mbs is not assembled.

    Returns:
        dict, which prints as a summary, with 'eigenvalues' (k,) w^2 rising [1/s^2], 'frequencies' (k,) [Hz],
        negative for negative eigenvalues, and 'eigenvectors' (n, k) of all ODE2 coordinates, of modal mass 1,
        as AnimateModes of exudyn.interactive takes them, with nodeNumber=None, for systemEigenVectors. Bodies
        that are free to turn have eigenvalues of zero, within round-off.

    Raises:
        InputError: arguments of another kind, or out of range.
        SceneError: mbs is not at rest, cannot be assembled, or shall not, contains what is not supported, has
            redundant constraints, or loads whose dependence on the state has no potential (bodyFixed forces,
            torques in space, functions that look at other nodes), where this matters.

    Example:
        SolveEquilibrium(mbs)
        found = ComputeEigenvalues(mbs, numberOfEigenvalues=5)
        print(found["frequencies"])
    """
    settings = simulation_settings(simulationSettings)
    number = require_integer("numberOfEigenvalues", numberOfEigenvalues, 1, LARGEST_NUMBER_OF_ITEMS)
    assemble(mbs, "ComputeEigenvalues", autoAssemble)
    time = require_finite("timeIntegration.startTime", settings.timeIntegration.startTime, "s")
    with scene_of(mbs, time, "mbs.ComputeODE2Eigenvalues") as scene:
        of_parts = _of_scene if needs_coupling(scene) else _of_cables
        found = list(of_parts(mbs, scene, time, number))
    values = np.concatenate([own for own, _ in found])
    vectors = np.hstack([own for _, own in found])
    lowest = np.argsort(values, kind="stable")[:number]
    rates = np.sign(values[lowest]) * np.sqrt(np.abs(values[lowest]))
    return EigenvalueReport(
        {
            "eigenvalues": values[lowest],
            "frequencies": rates / (2.0 * np.pi),
            "eigenvectors": vectors[:, lowest],
        }
    )


def _of_cables(mbs: Any, scene: Scene, time: float, number: int) -> Iterator[tuple[Array, Array]]:
    """Values (k,) and vectors (n, k) of all coordinates of mbs, of each cable."""
    cables = scene.cables
    for cable, (q, _) in zip(cables, initial_states(mbs, cables), strict=True):
        potential = cable_at_rest(cable, time)
        potential.turn_with(q)
        about = _about_rest(potential, q, f"cable '{cable.name}'")
        yield _spread(mbs, cable.indices, *vibrations(about, number))


def _of_scene(mbs: Any, scene: Scene, time: float, number: int) -> Iterator[tuple[Array, Array]]:
    """As `_of_cables`, of all that moves together."""
    with scene_at_rest(mbs, scene, time) as (joined, _, potential, start, _):
        potential.turn_with(start)
        about = _about_rest(potential, start, "the scene")
        values, vectors = vibrations(about, number)
        _require_potential(about, values, vectors, joined)
        yield _spread(mbs, joined.map.indices, values, vectors)


def _spread(mbs: Any, indices: Any, values: Array, own: Array) -> tuple[Array, Array]:
    """Values (k,), and vectors (n, k) of all coordinates of mbs.   indices: of those of `own` (k, m)."""
    vectors = np.zeros((mbs.systemData.ODE2Size(), len(values)))
    vectors[indices] = own.T
    return values, vectors


def _about_rest(system: StaticSystem, q: Array, name: str) -> SmallMotions:
    """name: of the system, for errors."""
    try:
        multipliers, left = balance(system, q)
    except RuntimeError as error:
        raise SceneError(
            f"{name} has redundant constraints, so that their forces, and what these do to vibrations, are "
            "not known: leave some of them out, or give cables their axialStiffness."
        ) from error
    _require_rest(system, q, left, name)
    return small_motions(system, q, multipliers)


def _require_potential(about: SmallMotions, values: Array, vectors: Array, joined: CoupledScene) -> None:
    """Raise SceneError, with the node, if forces change in a vibration as no potential has it.

    vectors: (k, n) vibrations.   joined: names their coordinates.
    """
    missed = missed_forces(about, vectors)
    shares = shares_of(missed, about, values)
    number = int(np.argmax(shares))
    if shares[number] > MISSED:
        place = joined.map.indices[int(np.argmax(np.abs(missed[number])))]
        raise SceneError(
            f"forces on {joined.coordinate_name(place)} depend on the state as no potential has it, "
            f"which is {shares[number]:.2g} of the stiffness in vibration {number} (limit {MISSED:g}): "
            "bodyFixed forces, torques in space and functions that look at other nodes make no symmetric "
            "stiffness. Put constant forces in their place, with bodyFixed=False, or let SolveExplicit show "
            "how the scene vibrates."
        )


def _require_rest(system: StaticSystem, q: Array, left: float, name: str) -> None:
    """Raise SceneError if that force [N] is left unbalanced, or constraints are violated."""
    limit, violation = AT_REST * system.largest_load, float(np.abs(system.values(q)).max(initial=0.0))
    if left > limit or violation > ON_CONSTRAINTS:
        raise SceneError(
            f"{name} does not rest in the initial configuration of mbs: a force of {left:.3g} N is not "
            f"balanced (limit {limit:.3g} N), and constraints are violated by {violation:.3g} (limit "
            f"{ON_CONSTRAINTS:g}). Call SolveEquilibrium(mbs) before."
        )
