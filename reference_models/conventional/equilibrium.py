"""Static equilibrium of a native model: Exudyn's static solver, from the initial shape.

A line that is stretched by 1e-5 of its length is hard on Newton's method. From the power line's parabola,
which is 7e-5 too short, it goes to a state that is stretched by 1e-2 and that a residual relative to
the enormous first one declares converged; or to the second stable equilibrium, with the hanger upright.
So the search begins with a softer cable, the result is solved for again, and hangers must stay on the
side of their anchors where they began. Where one softening fails, the next one is tried.
"""

from typing import Any

import exudyn
import numpy as np

from exudyn_inext.errors import InputError

from ..model import Model, node_index, silence
from ..scenes import Hanger
from ..trajectory import Array

SOFTENINGS = (1e-2, 3e-3, 3e-2, 1e-1)
"""Axial stiffness of the first search over that of the cable [-], in the order in which they are tried."""

MOVE_TOLERANCE = 1e-6
"""Largest change of a coordinate in a repeated search, over the length of the cable [-]."""

_INITIAL = exudyn.ConfigurationType.Initial


def settle(model: Model) -> None:
    """Make the equilibrium under all present loads the initial state.

    Raises:
        InputError: none found.
    """
    if not any(_find(model, softening) for softening in SOFTENINGS):
        raise InputError(
            f"scene '{model.scene.name}': no equilibrium found from the initial shape with "
            f"{len(model.nodes) - 1} elements, though the axial stiffness was reduced to "
            f"{', '.join(f'{softening:g}' for softening in SOFTENINGS)} of its value at first; start from a "
            "shape closer to it, or use other elements."
        )


def _find(model: Model, softening: float) -> bool:
    _return_to_the_shape(model)
    if not (_solve(model, softening) and _solve(model)):
        return False
    found = _coordinates(model)
    if not _solve(model):
        return False
    move = np.max(np.abs(_coordinates(model) - found))
    return bool(move <= MOVE_TOLERANCE * model.scene.cable.length) and _hangers_hang(model)


def _return_to_the_shape(model: Model) -> None:
    data = model.mbs.systemData
    data.SetODE2Coordinates(np.zeros(len(data.GetODE2Coordinates(_INITIAL))), _INITIAL)
    data.SetAECoordinates(np.zeros(len(data.GetAECoordinates(_INITIAL))), _INITIAL)


def _solve(model: Model, softening: float = 1.0) -> bool:
    """All load at once: nearly weightless, as after a small load step, the line would rather be straight."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    solver = settings.staticSolver
    solver.verboseMode = 0
    solver.numberOfLoadSteps = 1
    solver.newton.maxIterations = 100
    solver.newton.relativeTolerance = 1e-6
    solver.newton.absoluteTolerance = 1e-7
    stiffness = softening * model.scene.cable.section.axial_stiffness
    set_axial_stiffness(model.mbs, stiffness)
    try:
        with silence():
            model.mbs.SolveStatic(settings, updateInitialValues=True)
    except exudyn.ExudynError:
        return False
    finally:
        set_axial_stiffness(model.mbs, model.scene.cable.section.axial_stiffness)
    return True


def set_axial_stiffness(mbs: Any, stiffness: float) -> None:
    """Of all native cables [N]."""
    for number in range(mbs.systemData.NumberOfObjects()):
        if mbs.GetObject(number)["objectType"].startswith("ANCFCable"):
            mbs.SetObjectParameter(number, "axialStiffness", stiffness)


def _coordinates(model: Model) -> Array:
    return np.array(model.mbs.systemData.GetODE2Coordinates(_INITIAL))


def _hangers_hang(model: Model) -> bool:
    """Whether no hanger has turned by more than a right angle."""
    elements = len(model.nodes) - 1
    hangers = [support for support in model.scene.supports if isinstance(support, Hanger)]
    return all(_turn(model, node_index(hanger.at, elements), hanger) > 0.0 for hanger in hangers)


def _turn(model: Model, node: int, hanger: Hanger) -> float:
    """Cosine of the angle [-] by which the hanger has turned, times length squared."""
    reference, present = (
        np.subtract(
            model.mbs.GetNodeOutput(model.nodes[node], exudyn.OutputVariableType.Position, configuration),
            hanger.anchor,
        )
        for configuration in (exudyn.ConfigurationType.Reference, _INITIAL)
    )
    return float(reference @ present)
