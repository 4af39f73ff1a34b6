"""What is said of a run that was stopped: cause and remedy."""

from collections.abc import Sequence

from ..errors import DivergenceError
from ..integrators.integrator import Integrator

GIVEN_UP = (
    "its fastest vibration asks for steps of a thousandth of the first one, as only a diverged cable does"
)


def divergence(verdicts: Sequence[str], time: float, what_is_left: str, step: float) -> DivergenceError:
    """The error of a run that went wrong before `time` [s].

    Args:
        verdicts: what happened to whom, and why.   time: end of the step, or of the output interval [s].
        what_is_left: of the run, for its user.   step: that it took [s].
    """
    said = " ".join(verdicts)
    return DivergenceError(f"the run diverged before t = {time:.6g} s. {said} {what_is_left}", step)


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
    known = f"at {h / limit:.0%} of the stability limit of the present configuration"
    share = known if limit > 0.0 else "in a configuration whose stability limit cannot be found"
    if integrator.stabilised:
        return (
            f"Likely cause: {integrator.name}, {share}, gains energy where the motion is violent, and slowly "
            "in long runs: take integrator='RATTLE', or reduce stepSize to a quarter."
        )
    return (
        f"Likely cause: a motion too violent for the step, which is {share}: reduce stepSize, or start from "
        "smoother initial values."
    )
