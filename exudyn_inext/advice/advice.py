"""Why something is advised, in sentences."""

from collections.abc import Sequence

from .pilot import Pilot
from .survey import Search


def convergence_sentence(search: Search) -> str:
    """How good the finest solution is."""
    numbers = ", ".join(str(pilot.choice.elements) for pilot in search.meshes)
    return (
        f"Pilots with {numbers} elements converge with order {search.order:.1f}; the finest one is good to "
        f"{search.uncertainty:.1g}."
    )


def step_function_sentence(steps: int) -> str:
    """How often pilots called step functions.   steps: of Exudyn's loop."""
    return (
        f"The step functions of mbs were called in each of {steps} steps of the loop: set "
        f"timeIntegration.numberOfSteps = {steps} or more, as what they set follows lines within a step."
    )


def choice_sentence(pilot: Pilot, tolerance: float) -> str:
    """The best one."""
    return (
        f"{pilot.choice.label}: error {pilot.error:.2g} (tolerance {tolerance:g}), "
        f"{pilot.seconds:.2g} s of CPU time, both measured."
    )


def candidate_sentence(candidates: Sequence[Pilot], best: Pilot | None, tolerance: float) -> str:
    """How the conventional cable does."""
    good = [pilot for pilot in candidates if pilot.works and pilot.error <= tolerance]
    closest = min(candidates, key=lambda pilot: pilot.error)
    if not closest.works:
        return f"No conventional run reached its end: {closest.failure}"
    if not good:
        return (
            f"No conventional run was both accurate enough and worth its time; the most accurate one, "
            f"{closest.choice.label}, has an error of {closest.error:.2g} after {closest.seconds:.2g} s."
        )
    cheapest = min(good, key=lambda pilot: pilot.seconds)
    said = f"The cheapest conventional run, {cheapest.choice.label}, takes {cheapest.seconds:.2g} s"
    if best is None:
        return said + "."
    return f"{said}, {cheapest.seconds / best.seconds:.2g} times the best explicit one."


def stretch_sentence(axial_stiffness: float, moved: float, tolerance: float, matters: bool) -> str:
    """Whether inextensibility is the right model.   moved: what is observed, by stretch."""
    judged, verdict = "within", ""
    if matters:
        judged, verdict = "too much for", ": the inextensible model is the wrong one here"
    return (
        f"With axialStiffness = {axial_stiffness:g} N, what is observed differs by {moved:.2g}, {judged} the "
        f"tolerance of {tolerance:g}{verdict}."
    )


def cost_sentence(inextensible: Search, extensible: Search) -> str:
    """What a step of cables that stretch costs, of the finest mesh that both surveys have."""
    seconds = [
        {pilot.choice.elements: pilot.seconds / pilot.steps for pilot in search.meshes}
        for search in (inextensible, extensible)
    ]
    shared = max(seconds[0].keys() & seconds[1].keys())
    return f"With it a step costs {seconds[1][shared] / seconds[0][shared]:.2g} times that without."
