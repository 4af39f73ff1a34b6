"""Cases and solutions that studies share."""

import math
from collections.abc import Sequence

from exudyn_inext import ExplicitSettings
from exudyn_inext.errors import InextensibleError
from reference_models.conventional.convergence import explicit_solution
from reference_models.inextensible import Inextensible, fine_solution, inextensible_case, label_of
from reference_models.scenes import Scene
from reference_models.trajectory import Case, Run, Trajectory


def explicit_case(
    scene: Scene,
    integrator: str,
    elements: int,
    step_size: float,
    mass_scaling: float = 0.0,
    measure: str = "secondDerivative",
    zeta: float = ExplicitSettings.stabilizationRate,
) -> Case:
    """An inextensible row at a given step [s].   zeta: stabilisation rate of Zhai [1/s].

    It is not ended for its energy, which coarse runs of Zhai gain: studies measure errors.
    """
    settings = ExplicitSettings(
        integrator,
        stepSize=step_size,
        massScaling=mass_scaling,
        stabilizationRate=zeta,
        energyTolerance=math.inf,
    )
    return kept_case(scene, Inextensible(elements, settings, measure=measure))


def kept_case(scene: Scene, model: Inextensible) -> Case:
    """A row that keeps its place, with its status, even if its step is refused or the run diverges."""
    try:
        return inextensible_case(scene, model)
    except InextensibleError as error:
        settings = model.settings
        step_size = settings.stepSize or math.nan
        label = label_of(model, step_size)
        return failing_case(label, settings.integrator, model.elements, error, step_size)


def failing_case(
    label: str, integrator: str, elements: int, error: Exception, step_size: float = math.nan
) -> Case:
    """An inextensible row that could not even be prepared: it keeps its place, with its status."""

    def prepare() -> Run:
        raise error

    return Case(label, "inextensible", integrator, elements, step_size, 0, prepare)


def mesh_series(
    scene: Scene, full: Sequence[int], lobatto: Sequence[int], inextensible: Sequence[int]
) -> dict[str, dict[int, Trajectory]]:
    """Solutions on finer and finer meshes, with negligible time steps (untimed).

    Args:
        scene: what to solve.
        full: numbers of native elements with Exudyn's default quadrature.
        lobatto: numbers of native elements with Lobatto quadrature.
        inextensible: numbers of inextensible elements.
    """
    return {
        "native, full quadrature": {n: explicit_solution(scene, n) for n in full},
        "native, Lobatto quadrature": {n: explicit_solution(scene, n, "lobatto") for n in lobatto},
        "inextensible": {n: fine_solution(scene, n) for n in inextensible},
    }
