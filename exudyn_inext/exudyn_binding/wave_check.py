"""Whether axial vibrations that the steps do not resolve carry much of the tension of cables that stretch."""

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import InextensibleError
from ..run.accurate_step import step_of_axial_waves
from ..run.coupled_run import Run
from .kept_states import KeptStates

FEW_LOOKS, LOOKS, MOST_SOLVES = 4, 12, 300  # at tensions, and solves of cables for that, about
LARGEST_SHARE = 1.0  # of the tension
SUSPICIOUS = 0.3  # share in few states, for which more are looked at
SMALL = 1e-5  # strain that loads no material


def share_of_waves(kept: KeptStates) -> tuple[float, str]:
    """Largest share of unresolved vibrations in the tension of a cable, and a sentence; the run is over.

    They are what the strain has beyond the mean forces of the steps, see `axial`; root mean squares.
    """
    if not (kept.run.watch.stretches and len(kept)):
        return 0.0, ""
    found = _share(kept, FEW_LOOKS)
    return found if found[0] < SUSPICIOUS else _share(kept, LOOKS)


def _share(kept: KeptStates, most: int) -> tuple[float, str]:
    run, (times, steps, states) = kept.run, kept.all()
    number = min(most, max(2, MOST_SOLVES // len(run.cables)), len(states))
    places = np.linspace(0, len(states) - 1, number).astype(int)
    looks = [(float(times[k]), float(steps[k]), states[k]) for k in places]
    try:
        found = [(_tensions(run, look, look[1]), _tensions(run, look, 0.0)) for look in looks]
    except InextensibleError:  # items that were changed do not allow an earlier state any more
        return 0.0, ""
    return max(_of_cable(run, k, found) for k, cable in enumerate(run.cables) if cable.stretches)


def _tensions(run: Run, look: tuple[float, float, Array], h: float) -> list[Array]:
    """Of all cables in a state, as means of steps of h [s]; 0: by their strains."""
    for cable in run.cable_runs:
        cable.take_means(h)
    time, _, state = look
    return run.tensions(time, *state)


def _of_cable(run: Run, place: int, found: Sequence[Any]) -> tuple[float, str]:
    means, strained = np.array([[mean[place], strained[place]] for mean, strained in found]).swapaxes(0, 1)
    mean, beyond = (math.sqrt(np.mean(tension**2)) for tension in (means, strained - means))
    scene_cable = run.cable_runs[place].scene_cable
    stiffness = scene_cable.cable.section.axial_stiffness or 0.0
    share = beyond / mean if beyond > SMALL * stiffness and mean > 0.0 else 0.0
    return share, (
        f"cable '{scene_cable.name}' vibrates along its axis faster than the steps resolve, with "
        f"{beyond:.3g} N beside a tension of {mean:.3g} N (root mean squares): peaks of forces may be wrong. "
        f"Take stepSize = {step_of_axial_waves(scene_cable.cable):.2g}."
    )


def warn_of_waves(shares: Sequence[tuple[float, str]]) -> None:
    """Of what `share_of_waves` says of the runs of a scene, if that is much."""
    share, said = max(shares, default=(0.0, ""))
    if share > LARGEST_SHARE:
        warnings.warn(said, stacklevel=5)
