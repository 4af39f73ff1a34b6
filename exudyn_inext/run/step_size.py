"""Which step an explicit scheme may take: bending, stabilisation, and the paper's rule (37)."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ..errors import StepSizeError

USUAL_SCALING = 0.3  # massScaling that is advised
_CLOSE = 0.95  # share of a bound below which another one decides clearly
FREE_FREE_ALPHA = 1.5 * math.pi  # alpha of Eq. (37)


@dataclass(frozen=True)
class StepSizeBounds:
    """Upper bounds of the step [s] and what they follow from.

    bending: h w_max at the scheme's limit, w_max the largest frequency of the discretised cable.
    stabilisation: h zeta at the scheme's limit.
    rule: Eq. (37) with the constant C.
    largest_frequency: w_max [rad/s].
    cable: name of the cable that decides the first bound.
    contact: as `bending`, if all contacts that are open at the start close at once.
    accuracy: step that resolves the motion as well as the mesh does, for the automatic step alone.
    safety: share of the stability limit that leaves a margin for what the motion changes [-].
    undamped: `bending` without damping, which lowers it.   damping: largest d [1/s] of v' = -d v.
    touching: which contacts decide the bound `contact`, and why.   softer: which of their parameters do.
    is_cable: whether bending of a cable decides, so that fewer elements raise the bound.
    is_scaled: whether bending is implicit, so that the rule does not count.
    """

    bending: float
    stabilisation: float
    rule: float
    largest_frequency: float
    cable: str
    contact: float = math.inf
    accuracy: float = math.inf
    safety: float = 0.95
    undamped: float = math.inf
    damping: float = 0.0
    touching: str = ""
    softer: str = ""
    is_cable: bool = True
    is_scaled: bool = False

    @property
    def stability_limit(self) -> float:
        """Largest step at which the linearised run does not grow, contacts open or closed [s]."""
        return min(self.bending, self.stabilisation, self.contact)


def rule_step(element_length: float, density: float, stiffness: float, constant: float) -> float:
    """h = C l^2 / alpha^2 sqrt(rho_A / EI), Eqs. (35)-(37) with the root as it must be.

    Args:
        element_length: l [m].   density: rho_A [kg/m].   stiffness: EI [N m^2].
        constant: C [-]; the paper uses 0.7 to 0.9.

    Returns:
        h [s].
    """
    return constant * element_length**2 / FREE_FREE_ALPHA**2 * math.sqrt(density / stiffness)


def largest_step(bounds: StepSizeBounds, safety: float | None = None) -> tuple[float, str]:
    """The largest step within the rule and, with a safety, all stability bounds; and what decided.

    Args:
        bounds: of the step.   safety: share of the stability bounds [-]; None: that of the bounds.
    """
    safety = safety or bounds.safety
    candidates = {
        "accuracy": bounds.accuracy,
        "contact": safety * bounds.contact,
        "rule (37)": math.inf if bounds.is_scaled else bounds.rule,
        "bending": safety * bounds.bending,
        "stabilisation": safety * bounds.stabilisation,
    }
    decided_by = min(candidates, key=lambda name: candidates[name])
    return candidates[decided_by], decided_by


def step_above_limit(
    h: float, bounds: StepSizeBounds, integrator: str, scaled: Callable[[], StepSizeBounds] | None = None
) -> StepSizeError | None:
    """The error that a step of size h deserves, or None.

    Args:
        h: step [s].   bounds: of it.   integrator: name of the scheme.
        scaled: bounds of the same step with massScaling = 0.3, which is advised if it helps; None: it is
            set, or there is nothing to scale.
    """
    limit = bounds.stability_limit
    if h <= limit * (1.0 + 1e-9):
        return None
    remedies = [f"reduce the step below {_below(limit):.4g} s"]
    if limit == bounds.stabilisation:
        cause = "the constraint stabilisation"
        remedies = ["reduce the step or the stabilizationRate"]
    elif limit < _CLOSE * bounds.bending:
        cause = f"what happens when contacts close: {bounds.touching}"
        remedies += [f"lower their {bounds.softer}"]
    else:
        cause, others = _vibration(bounds)
        remedies += others
    if scaled is not None and h <= scaled().stability_limit:
        remedies += [f"set massScaling = {USUAL_SCALING}"]
    return StepSizeError(
        f"stepSize = {h:.6g} s is above {limit:.6g} s, the stability limit of '{integrator}' for {cause}: "
        f"{', or '.join(remedies)}."
    )


def _below(limit: float) -> float:
    """A little less than the limit, however it is rounded [s]."""
    return 0.999 * limit


def _vibration(bounds: StepSizeBounds) -> tuple[str, list[str]]:
    """Cause and remedies where vibrations decide, or their damping."""
    fewer = ["use fewer elements"] if bounds.is_cable else []
    cause = f"w_max = {bounds.largest_frequency:.6g} rad/s of {bounds.cable}"
    if not _CLOSE * bounds.undamped > bounds.bending:
        return cause, fewer
    lowered = f"{cause} and a damping of {bounds.damping:.4g} 1/s, which lowers it"
    if math.isfinite(bounds.undamped):
        lowered += f" from {bounds.undamped:.4g} s"
    return lowered, ["reduce the damping (of bending, springs, contact or drag)", *fewer]
