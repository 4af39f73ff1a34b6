"""What a run costs, from what others cost: a + steps (b + c N)."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from .pilot import Choice, Pilot


def predicted_seconds(pilots: Sequence[Pilot], choice: Choice, end_time: float) -> float:
    """CPU time of a run [s]; of the same integrator if it has run, else of any.

    Args:
        pilots: measured.   choice: not measured yet.   end_time: [s].
    """
    own = [pilot for pilot in pilots if pilot.choice.integrator == choice.integrator] or list(pilots)
    rows = np.array([_row(pilot.steps, pilot.choice.elements) for pilot in own])
    seconds = np.array([pilot.seconds for pilot in own])
    factors, _ = nnls(rows / seconds[:, None], np.ones(len(own)))  # relative errors count
    return float(_row(end_time / choice.step_size, choice.elements) @ factors)


def _row(steps: float, elements: int) -> np.ndarray:
    return np.array([1.0, steps, steps * elements])
