"""What is advised, and why, in sentences."""

from collections.abc import Sequence
from dataclasses import dataclass

from .pilot import CONVENTIONAL, Choice
from .search import Search, Tried
from .stretch import Tension, axial_period


@dataclass(frozen=True)
class Advice:
    """A choice, what it is expected to give, and the reasons.

    error: in units of what is observed.   seconds: CPU time.   extrapolated: whether both are not measured.
    """

    choice: Choice
    error: float
    seconds: float
    extrapolated: bool
    reasons: tuple[str, ...]


def convergence_sentence(search: Search) -> str:
    """How good the judge is."""
    survey = search.survey
    numbers = ", ".join(str(pilot.choice.elements) for pilot in survey.pilots)
    return (
        f"Pilots with {numbers} elements converge with order {survey.order:.1f}; the finest one is good to "
        f"{survey.uncertainty:.1g}."
    )


def choice_sentence(tried: Tried, tolerance: float) -> str:
    """The best one."""
    return (
        f"{tried.pilot.choice.label}: error {tried.error:.2g} (tolerance {tolerance:g}), "
        f"{tried.pilot.seconds:.2g} s of CPU time, both measured."
    )


def rival_sentence(rivals: Sequence[Tried], best: Tried | None, tolerance: float) -> str:
    """How the conventional cable does."""
    good = [one for one in rivals if one.works and one.error <= tolerance]
    closest = min(rivals, key=lambda one: one.error)
    if not closest.works:
        return f"No conventional run reached its end: {closest.pilot.failure}"
    if not good:
        return (
            f"No conventional run was both accurate enough and worth its time; the most accurate one, "
            f"{closest.pilot.choice.label}, has an error of {closest.error:.2g} after "
            f"{closest.pilot.seconds:.2g} s."
        )
    cheapest = min(good, key=lambda one: one.pilot.seconds)
    said = (
        f"The cheapest conventional run, {cheapest.pilot.choice.label}, takes {cheapest.pilot.seconds:.2g} s"
    )
    if best is None:
        return said + "."
    return f"{said}, {cheapest.pilot.seconds / best.pilot.seconds:.2g} times the best inextensible one."


def stretch_sentence(tension: Tension, axial_stiffness: float, error: float, tolerance: float) -> str:
    """Whether inextensibility is the right model."""
    strain, period = tension.largest / axial_stiffness, axial_period(tension, axial_stiffness)
    said = (
        f"The tension reaches {tension.largest:.2g} N, a strain of {strain:.1e}; stretch moves the observed "
        f"point by some {error:.1g}, "
    )
    if error > tolerance:
        return said + "more than the tolerance: the inextensible model is the wrong one here."
    return (
        said + "within the tolerance. Loads that change within the axial period of "
        f"{period:.1g} s would still need a conventional cable."
    )


def is_conventional(tried: Tried) -> bool:
    """Whether it ran with native cables."""
    return tried.pilot.choice.formulation == CONVENTIONAL
