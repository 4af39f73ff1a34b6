"""The largest stable step: predicted by linear theory, and found by running."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from reference_models.trajectory import Array
from studies.harness import Row, inner
from studies.harness.inner import FrequencyTracker, cable_system, index_reduced_rates

from .motion import PORTION, Equilibrium, Method, Motion

# -------------------------------------------------------------------- what the linear theory gives


RULE_CONSTANT = 0.7  # C of Eq. (37)


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


def predict(start: Equilibrium, method: Method, growth: float = inner.GROWTH_TOLERANCE) -> Prediction:
    """Bounds for small vibrations about an equilibrium.

    growth: of a step that counts as none [-]; see `frequency_limit`.
    """
    limit = inner.frequency_limit(method.integrator, method.parameters, growth=growth)

    def frequency(h: float) -> float:
        system = method.system(start.cable, h)
        return inner.largest_frequency(system, start.inputs, start.q, start.v)

    plain = frequency(0.0)
    relaxed = inner.largest_frequency(method.system(start.cable, 0.0), 0.0 * start.inputs, start.q)
    section = start.cable.section
    bending = limit / plain
    if method.theta:  # the scaled mass depends on h, and may leave no limit
        bending = largest_stable_step(lambda h: h * frequency(h) < limit, bending, 1e-4, 1e4)
    return Prediction(
        bending,
        inner.decay_limit(method.integrator, method.parameters) / method.zeta,
        inner.rule_step(
            start.element_length, section.mass_per_length, section.bending_stiffness, RULE_CONSTANT
        ),
        plain,
        relaxed,
    )


# --------------------------------------------- found by running: a small disturbance must not grow


DISTURBANCE = 1e-7  # of slopes [-], of positions over the element length
GROWTH = 1e3  # of the disturbance that counts as unstable
STEPS = 3000
RESOLUTION = 4e-3  # of the bisected limit
AGREEMENT = 0.05  # of predicted and bisected limits in the linear regime
ITERATIONS = 20  # of the fastest vibration, times those of its tracker
FARTHEST = 30.0  # times the estimate, or that part of it

Stable = Callable[[float], bool]


def disturbed(start: Equilibrium) -> Equilibrium:
    """The same with coordinates nearby: the fastest vibration, which decides, and random ones.

    The latter, a tenth, are a little off the constraints and give all modes a share.
    """
    noise = 0.1 * np.random.default_rng(1).uniform(-1.0, 1.0, start.q.shape)
    noise[:, 0] *= start.element_length
    system, rate, a = cable_system(start.cable, 1.0), np.zeros(start.q.size), np.zeros_like(start.q)
    tracker = FrequencyTracker(system, start.q.shape)
    for _ in range(ITERATIONS):
        index_reduced_rates(system, start.inputs, start.q.ravel(), start.v.ravel(), a.ravel(), rate)
        tracker.frequency(start.q, a)
    scaled = np.abs(tracker.vibration)
    scaled[:, 0] /= start.element_length
    noise += 0.9 / scaled.max() * tracker.vibration
    noise *= DISTURBANCE
    noise[start.cable.fixed] = 0.0
    if start.cable.closed:
        noise[-1] = noise[0]
    return replace(start, q=start.q + noise)


def distance(start: Equilibrium) -> Callable[[Array, Array], float]:
    """How far two configurations are apart: slopes [-], and positions over the element length.

    Of a cable that spins, after the second one has been turned about the origin, as far as their ends differ.
    """
    spins = start.v.any()

    def apart(q: Array, other: Array) -> float:
        if spins:
            planes = [x[..., 0] + 1j * x[..., 1] for x in (q, other)]
            turned = np.exp(1j * np.angle(planes[0][-1, 0] / planes[1][-1, 0])) * planes[1]
            other = np.stack([turned.real, turned.imag], axis=-1)
        moved = np.abs(q - other)
        moved[:, 0] /= start.element_length
        return float(moved.max())

    return apart


def is_stable_about(start: Equilibrium, method: Method, steps: int) -> Stable:
    """Whether a disturbance of the equilibrium stays within GROWTH over so many steps, as a function of h.

    A cable that spins is compared with the same steps of an undisturbed one.
    """
    near, apart, is_at_rest = disturbed(start), distance(start), not start.v.any()

    def is_stable(h: float) -> bool:
        motion, twin = Motion(near, method, h), Motion(start, method, h)
        while motion.steps < steps:
            if not motion.advance(PORTION) or not (is_at_rest or twin.advance(PORTION)):
                return False
            if not apart(motion.q, twin.q) < GROWTH * DISTURBANCE:
                return False
        return True

    return is_stable


def largest_stable_step(
    is_stable: Stable, estimate: float, resolution: float = RESOLUTION, farthest: float = FARTHEST
) -> float:
    """The limit near an estimate [s]; infinite, or zero, if it is beyond `farthest` times the estimate."""
    low, high, factor = estimate, estimate, 1.02
    if is_stable(estimate):
        while is_stable(high := high * factor):
            low, factor = high, factor**1.7
            if high > farthest * estimate:
                return math.inf
    else:
        while not is_stable(low := low / factor):
            high, factor = low, factor**1.7
            if low < estimate / farthest:
                return 0.0
    while high > low * (1.0 + resolution):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return math.sqrt(low * high)


def compare_limits(start: Equilibrium, method: Method, steps: int = STEPS) -> Row:
    """Predicted and bisected limit of the step about an equilibrium, and the rule (37) beside them.

    The prediction allows the growth that so many steps do not show: 1000 over all of them.
    """
    prediction = predict(start, method, growth=math.log(GROWTH) / steps)
    is_unlimited = math.isinf(prediction.step)
    estimate = 10.0 / prediction.frequency if is_unlimited else prediction.step
    found = largest_stable_step(is_stable_about(start, method, steps), estimate)
    return {
        "largestFrequency": prediction.frequency,
        "predictedBending": prediction.bending,
        "predictedZeta": prediction.stabilisation,
        "predicted": prediction.step,
        "found": found,
        "isUnlimited": is_unlimited and math.isinf(found),
        "ratio": None if is_unlimited else found / prediction.step,
        "ruledBy": prediction.ruled_by,
        "rule": prediction.rule,
        "ruleOverLimit": prediction.rule / found if found else math.inf,
    }
