"""What is said of a run that was stopped: cause and remedy."""

import math
from collections.abc import Sequence

from ..errors import DivergenceError
from ..integrators.integrator import Integrator

GIVEN_UP = (
    "its fastest vibration asks for steps of a thousandth of the first one, as only a diverged cable does"
)


FEW = 6  # cables that are all named


def listed(names: Sequence[str]) -> str:
    """Names of cables, of many the first and the last one."""
    if len(names) <= FEW:
        return ", ".join(names)
    return f"{len(names)} cables ({names[0]} to {names[-1]})"


def divergence(verdicts: Sequence[str], time: float, what_is_left: str) -> DivergenceError:
    """The error of a run that went wrong before `time` [s].

    Args:
        verdicts: what happened to whom, and why.   time: end of the step, or of the output interval [s].
        what_is_left: of the run, for its user.
    """
    said = " ".join(verdicts)
    return DivergenceError(f"the run diverged before t = {time:.6g} s. {said} {what_is_left}")


def explanation(integrator: Integrator, trouble: str, h: float, limit: float, scaled: bool) -> str:
    """Likely cause, and remedy.

    Args:
        integrator: of the run.   trouble: what it could not do, or nothing.   h: step [s].
        limit: stability limit of the last good state [s].   scaled: whether the mass is scaled.
    """
    if h > limit:
        instead = "" if scaled else "take adaptiveStep=True, or "
        return (
            f"Likely cause: the step of {h:.4g} s is above the stability limit of the present configuration, "
            f"{limit:.4g} s, which falls where a cable straightens or is pulled tight: {instead}reduce "
            f"stepSize below {0.95 * limit:.3g} s."
        )
    if trouble:
        return trouble
    known = 0.0 < limit < math.inf
    share = f"at {_percent(h / limit)} of the stability limit of the present configuration" if known else ""
    if integrator.stabilised:
        at = f", {share}," if share else ""
        return (
            f"Likely cause: {integrator.name}{at} gains energy where the motion is violent, and slowly "
            "in long runs: take integrator='RATTLE', or reduce stepSize to a quarter."
        )
    which = f", which is {share}" if share else f" of {h:.4g} s"
    return (
        f"Likely cause: a motion too violent for the step{which}: reduce stepSize, or start from "
        "smoother initial values."
    )


def _percent(share: float) -> str:
    return f"{share:.0%}" if share >= 0.01 else "less than 1%"
