"""What a run costs, from what others cost: a + steps (b + c N)."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
import scipy  # its `optimize` is imported where it is used first

from ..arrays import Array
from .pilot import Choice, Pilot

UNKNOWNS = 3


def predicted_seconds(pilots: Sequence[Pilot], choice: Choice, end_time: float) -> float:
    """CPU time of a run [s]: of the same integrator if it has run, else of any.

    Fewer runs of the integrator than unknowns only scale what the integrator with the most runs costs.

    Args:
        pilots: measured.   choice: not measured yet.   end_time: [s].
    """
    own = [pilot for pilot in pilots if pilot.choice.integrator == choice.integrator]
    factors = _factors(own if len(own) >= UNKNOWNS else _of_most_runs(pilots))
    ratios = [pilot.seconds / (_row_of(pilot) @ factors) for pilot in own]
    scale = np.mean(ratios) if ratios else 1.0
    return float(scale * (_row(end_time / choice.step_size, choice.elements) @ factors))


def _of_most_runs(pilots: Sequence[Pilot]) -> list[Pilot]:
    """Those of one integrator."""
    ((name, _),) = Counter(pilot.choice.integrator for pilot in pilots).most_common(1)
    return [pilot for pilot in pilots if pilot.choice.integrator == name]


def _factors(pilots: Sequence[Pilot]) -> Array:
    """a, b, c [s], none of them negative; relative errors count."""
    rows = np.array([_row_of(pilot) / pilot.seconds for pilot in pilots])
    return scipy.optimize.nnls(rows, np.ones(len(pilots)))[0]


def _row_of(pilot: Pilot) -> Array:
    return _row(pilot.steps, pilot.choice.elements)


def _row(steps: float, elements: int) -> Array:
    return np.array([1.0, steps, steps * elements])
