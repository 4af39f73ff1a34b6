"""What the axial forces of cables that stretch say of a run: vibrations, and compression.

Axial vibrations that the steps do not resolve may carry much of the tension. A cable that is compressed by P
buckles in half waves of pi sqrt(EI / P): if these have less than two elements, it folds as the mesh lets it.
"""

import math
import warnings
from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..checks import SMALLEST
from ..errors import InextensibleError
from ..run.accurate_step import step_of_axial_waves
from ..run.coupled_run import Run
from ..scene.model import CableInScene
from .bend_check import cosines_of_turns
from .kept_states import KeptStates

FEW_LOOKS, LOOKS, MOST_SOLVES = 4, 12, 300  # at tensions, and solves of cables for that, about
LARGEST_SHARE = 1.0  # of the tension
LARGEST_LOAD = 0.5  # root mean square, over the load under which two elements buckle
SUSPICIOUS = 0.2  # share in few states, for which more are looked at
SMALL = 1e-5  # strain that loads no material
STRAIGHT, BENDS = 1e-3, 0.2  # turn along elements that nothing bends, and of those that buckle [rad]

Finding = tuple[float, str]  # share, and a sentence
NOTHING: Finding = 0.0, ""


def axial_findings(kept: KeptStates) -> tuple[Finding, Finding]:
    """The largest shares of the cables of a run that is over, root mean squares in time.

    Of vibrations that the steps do not resolve in the tension, and of the compression in `LARGEST_LOAD`. The
    state of the run is another one then.
    """
    if not (kept.run.watch.stretches and len(kept)):
        return NOTHING, NOTHING
    found = _findings(kept, FEW_LOOKS, STRAIGHT)
    return found if max(found)[0] < SUSPICIOUS else _findings(kept, LOOKS, BENDS)


def _findings(kept: KeptStates, most: int, turn: float) -> tuple[Finding, Finding]:
    """most: looks.   turn: along compressed elements that count, a small one [rad]."""
    run, (times, steps, states) = kept.run, kept.under_present_forces
    number = min(most, max(2, MOST_SOLVES // len(run.cables)), len(states))
    places = np.linspace(0, len(states) - 1, number).astype(int)
    looks = [(float(times[k]), float(steps[k]), states[k]) for k in places]
    try:
        means = [_tensions(run, look, look[1]) for look in looks]
        strained = [_tensions(run, look, 0.0) for look in looks]
    except InextensibleError:  # items that were changed do not allow an earlier state any more
        return NOTHING, NOTHING
    found = []
    for k, cable in enumerate(run.cable_runs):
        if cable.scene_cable.cable.stretches:
            mean, by_strains = (np.array([tensions[k] for tensions in of]) for of in (means, strained))
            cosines = cosines_of_turns(kept.nodes(k, states[places, 0])[:, :, 1])
            compression = _compression(cable.scene_cable, mean, 2.0 - 2.0 * cosines > turn**2)
            found.append((_waves(cable.scene_cable, mean, by_strains), compression))
    return max(waves for waves, _ in found), max(compression for _, compression in found)


def _tensions(run: Run, look: tuple[float, float, Array], h: float) -> list[Array]:
    """Of all cables in a state, as means of steps of h [s]; 0: by their strains."""
    for cable in run.cable_runs:
        cable.take_means(h)
    time, _, state = look
    return run.tensions(time, *state)


def _waves(cable: CableInScene, means: Array, strained: Array) -> Finding:
    """They are what the strain has beyond the mean forces of the steps, see `axial`.

    means, strained: (T, N) tensions as means of the steps, and by strains [N].
    """
    mean, beyond = map(_root_mean_square, (means, strained - means))
    stiffness = cable.cable.section.axial_stiffness or 0.0
    share = beyond / mean if beyond > SMALL * stiffness and mean > 0.0 else 0.0
    return share, (
        f"cable '{cable.name}' vibrates along its axis faster than the steps resolve, with "
        f"{beyond:.3g} N beside a tension of {mean:.3g} N (root mean squares): peaks of forces may be wrong. "
        f"Take stepSize = {step_of_axial_waves(cable.cable):.2g}."
    )


def _compression(cable: CableInScene, means: Array, is_bent: np.ndarray) -> Finding:
    """Of elements that are bent: what is straight stays so, however much it is compressed.

    means: (T, N) tensions [N].   is_bent: (T, N).
    """
    compression = np.maximum(-means, 0.0)
    stiffness, lengths = cable.cable.section.bending_stiffness, cable.cable.element_lengths
    shares = np.where(is_bent, compression, 0.0) * (2.0 * lengths / math.pi) ** 2 / stiffness
    largest = float(compression.max())
    wanted = 0.5 * math.pi * math.sqrt(stiffness / max(largest, SMALLEST))
    return _root_mean_square(shares.max(axis=1)) / LARGEST_LOAD, (
        f"cable '{cable.name}' is compressed by up to {largest:.3g} N, under which it buckles in half waves "
        f"of {2.0 * wanted:.2g} m: how it folds depends on its elements. Take elements of at most "
        f"{wanted:.2g} m, or avoid the blow: start from SolveEquilibrium(mbs), or let loads change gradually."
    )


def _root_mean_square(x: Array) -> float:
    return math.sqrt(np.mean(x**2))


def warn_of_axial_findings(found: Sequence[tuple[Finding, Finding]]) -> None:
    """Of the worst in the runs of a scene, if that is much.

    Vibrations come first: what is compressed is known only where steps resolve them.
    """
    for of_kind in zip(*found, strict=True):
        share, said = max(of_kind)
        if share > LARGEST_SHARE:
            warnings.warn(said, stacklevel=5)
            return
