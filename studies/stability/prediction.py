"""The largest stable step that the linear theory gives, and which bound it is."""

import math
from dataclasses import dataclass

import numpy as np

from exudyn_inext.chain.frequency import largest_frequency
from exudyn_inext.integrators.linear_stability import GROWTH_TOLERANCE, decay_limit, frequency_limit
from exudyn_inext.integrators.step_size import rule_step

from .cables import Equilibrium
from .motion import Method

RULE_CONSTANT = 0.7  # C of Eq. (37)
_FARTHEST = 1e4  # times the limit without mass scaling


@dataclass(frozen=True)
class Prediction:
    """Bounds of the step [s].

    bending: h w_max at the scheme's limit, tension included.   stabilisation: h zeta at its limit.
    rule: Eq. (37) with C = 0.7.
    frequency: w_max without mass scaling [rad/s].   tension_free: the same without loads and spin.
    """

    bending: float
    stabilisation: float
    rule: float
    frequency: float
    tension_free: float

    @property
    def step(self) -> float:
        """The largest stable one [s]."""
        return min(self.bending, self.stabilisation)

    @property
    def ruled_by(self) -> str:
        """Zeta, or what gives the larger part of w_max^2."""
        if self.stabilisation < self.bending:
            return "zeta"
        return "bending" if self.tension_free**2 > 0.5 * self.frequency**2 else "tension"


def predict(start: Equilibrium, method: Method, growth: float = GROWTH_TOLERANCE) -> Prediction:
    """Bounds for small vibrations about an equilibrium.

    growth: of a step that counts as none [-]; see `frequency_limit`.
    """
    limit = frequency_limit(method.integrator, method.parameters, growth=growth)

    def frequency(h: float) -> float:
        system = method.system(start.cable, h)
        return largest_frequency(system, start.inputs, start.q, start.v)

    plain = frequency(0.0)
    relaxed = largest_frequency(method.system(start.cable, 0.0), 0.0 * start.inputs, start.q)
    section = start.cable.section
    bending = _scaled_limit(frequency, limit, limit / plain) if method.theta else limit / plain
    return Prediction(
        bending,
        decay_limit(method.integrator, method.parameters) / method.zeta,
        rule_step(start.element_length, section.mass_per_length, section.bending_stiffness, RULE_CONSTANT),
        plain,
        relaxed,
    )


def _scaled_limit(frequency, limit: float, plain: float) -> float:  # type: ignore[no-untyped-def]
    """h with h w_max(h) = limit, where the scaled mass depends on h; infinite if there is none."""
    low, high = plain, 2.0 * plain
    while high * frequency(high) < limit:
        low, high = high, 2.0 * high
        if high > _FARTHEST * plain:
            return math.inf
    while high - low > 1e-4 * low:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if middle * frequency(middle) < limit else (low, middle)
    return low
