"""Cases and solutions that studies share."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from exudyn_inext import ExplicitSettings, InextensibleError, Zhai
from reference_models.inextensible import Inextensible, build, inextensible_case, label_of
from reference_models.scenes import Scene
from reference_models.trajectory import Case, Run

from . import inner
from .ratios import DEFAULT, INEXTENSIBLE, ONE_SETTING

PAPER_METHOD = "paper's method at its settings: product, v_n in the predictor"
BRIEF = 0.01  # [s] of motion, to ask for a limit
THETA, ZETA, CONSTANT = 0.3, 100.0, 1.4  # of the one setting; C is twice the usual one
RULE = f"Zhai, theta = {THETA}, zeta = {ZETA:g} 1/s, h by Eq. (37) with C = {CONSTANT}, at most 1/(2 zeta)"


def unguarded(
    integrator: Any,
    step_size: float | None,
    mass_scaling: float = 0.0,
    zeta: float = ExplicitSettings.stabilizationRate,
) -> ExplicitSettings:
    """Not ended for its energy, which coarse runs of Zhai gain: studies measure errors.

    integrator: name, or scheme with its parameters.   step_size: [s].   zeta: stabilisation rate [1/s].
    """
    return ExplicitSettings(
        integrator,
        stepSize=step_size,
        massScaling=mass_scaling,
        stabilizationRate=zeta,
        energyTolerance=math.inf,
    )


def explicit_case(
    scene: Scene,
    integrator: str,
    elements: int,
    step_size: float,
    mass_scaling: float = 0.0,
    zeta: float = ExplicitSettings.stabilizationRate,
    measure: str = "secondDerivative",
) -> Case:
    """An inextensible row at a given step [s]."""
    settings = unguarded(integrator, step_size, mass_scaling, zeta)
    return kept_case(scene, Inextensible(elements, settings, measure=measure))


def paper_case(scene: Scene, proposed: Inextensible) -> Case:
    """The paper's method at the paper's settings: `product` as curvature, v_n in the predictor.

    proposed: ours, at these settings.
    """
    settings = replace(proposed.settings, integrator=Zhai(projected_rate=False), energyTolerance=math.inf)
    case = kept_case(scene, replace(proposed, settings=settings, measure="product"))
    return replace(case, label=PAPER_METHOD, details={**case.details, "choice": PAPER_METHOD})


def step_by_rule(mbs: Any) -> float:
    """The step of the one setting for the cables of an assembled mbs [s]."""
    cables = [one.cable for one in inner.read_scene(mbs).cables]
    return min(0.5 / ZETA, *(inner.rule_of_cable(cable, CONSTANT) for cable in cables))


def untuned_cases(scene: Scene, meshes: Sequence[int]) -> Iterator[Case]:
    """On each mesh: default settings, watch included; and the one setting for all scenes."""
    for elements in meshes:
        step = step_by_rule(build(scene, elements).mbs)
        one = unguarded("Zhai", step, THETA, ZETA)
        for choice, settings in ((DEFAULT, ExplicitSettings()), (ONE_SETTING, one)):
            case = kept_case(scene, Inextensible(elements, settings))
            yield replace(case, label=f"{choice}: {case.label}", details={**case.details, "choice": choice})


def kept_case(scene: Scene, model: Inextensible) -> Case:
    """A row that keeps its place, with its status, even if its step is refused or the run diverges."""
    try:
        return inextensible_case(scene, model)
    except InextensibleError as error:
        settings = model.settings
        step_size = settings.stepSize or math.nan
        label = label_of(model, step_size)
        return failing_case(label, settings.integratorName, model.elements, error, step_size)


def case_at_limit(scene: Scene, model: Inextensible, part: float) -> Case:
    """At that part of its stability limit; one that cannot even start keeps its place, with its status."""
    probe = kept_case(replace(scene, end_time=BRIEF), model)
    limit = probe.details.get("stepLimit")
    if limit is None:
        return probe
    return kept_case(scene, replace(model, settings=replace(model.settings, stepSize=part * limit)))


def failing_case(
    label: str, integrator: str, elements: int, error: Exception, step_size: float = math.nan
) -> Case:
    """An inextensible row that could not even be prepared: it keeps its place, with its status."""

    def prepare() -> Run:
        raise error

    return Case(label, INEXTENSIBLE, integrator, elements, step_size, 0, prepare)
