"""Which step an explicit scheme may take: bending, stabilisation, and the paper's rule (37)."""

import math
from dataclasses import dataclass

from ..errors import StepSizeError

FREE_FREE_ALPHA = 1.5 * math.pi  # alpha of Eq. (37)


@dataclass(frozen=True)
class StepSizeBounds:
    """Upper bounds of the step [s] and what they follow from.

    bending: h w_max at the scheme's limit, w_max the largest frequency of the discretised cable.
    stabilisation: h zeta at the scheme's limit.
    rule: Eq. (37) with the constant C.
    largest_frequency: w_max [rad/s].
    cable: name of the cable that decides the first bound.
    contact: as `bending`, if all contacts close at once: an estimate, for the automatic step alone.
    accuracy: step that resolves the motion as well as the mesh does, for the automatic step alone.
    safety: share of the stability limit that leaves a margin for what the motion changes [-].
    """

    bending: float
    stabilisation: float
    rule: float
    largest_frequency: float
    cable: str
    contact: float = math.inf
    accuracy: float = math.inf
    safety: float = 0.95

    @property
    def stability_limit(self) -> float:
        """Largest step at which the linearised run does not grow [s]."""
        return min(self.bending, self.stabilisation)


def rule_step(element_length: float, density: float, stiffness: float, constant: float) -> float:
    """h = C l^2 / alpha^2 sqrt(rho_A / EI), Eqs. (35)-(37) with the root as it must be.

    Args:
        element_length: l [m].   density: rho_A [kg/m].   stiffness: EI [N m^2].
        constant: C [-]; the paper uses 0.7 to 0.9.

    Returns:
        h [s].
    """
    return constant * element_length**2 / FREE_FREE_ALPHA**2 * math.sqrt(density / stiffness)


def choose_step(bounds: StepSizeBounds, safety: float | None = None) -> tuple[float, str]:
    """The largest step within the rule and, with a safety, all stability bounds; and what decided.

    Args:
        bounds: of the step.   safety: share of the stability bounds [-]; None: that of the bounds.
    """
    safety = safety or bounds.safety
    candidates = {
        "accuracy": bounds.accuracy,
        "contact": safety * bounds.contact,
        "rule (37)": bounds.rule,
        "bending": safety * bounds.bending,
        "stabilisation": safety * bounds.stabilisation,
    }
    decided_by = min(candidates, key=lambda name: candidates[name])
    return candidates[decided_by], decided_by


def step_above_limit(h: float, bounds: StepSizeBounds, integrator: str) -> StepSizeError | None:
    """The error that a step of size h deserves, or None."""
    if h <= bounds.stability_limit * (1.0 + 1e-9):
        return None
    if bounds.bending <= bounds.stabilisation:
        cause = f"w_max = {bounds.largest_frequency:.6g} rad/s of {bounds.cable}"
        remedy = "reduce the step, use fewer elements, or set massScaling"
    else:
        cause = "the constraint stabilisation"
        remedy = "reduce the step or the stabilizationRate"
    return StepSizeError(
        f"stepSize = {h:.6g} s is above {bounds.stability_limit:.6g} s, the stability limit of "
        f"'{integrator}' for {cause}: {remedy}."
    )
