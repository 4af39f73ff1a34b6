"""The largest stable step: predicted by linear theory, and found by running."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reference_models.trajectory import Array
from studies.harness import Row, inner
from studies.harness.inner import FrequencyTracker, cable_system, index_reduced_rates

from .motion import Equilibrium, Method

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
    (q, v), scheme = start.state, method.settings().method
    limit = inner.frequency_limit(*scheme, growth=growth)

    def frequency(h: float) -> float:
        system = method.system(start.cable, h)
        return inner.largest_frequency(system, start.inputs, q, v)

    plain = frequency(0.0)
    relaxed = inner.largest_frequency(method.system(start.cable, 0.0), 0.0 * start.inputs, q)
    section = start.cable.section
    bending = limit / plain
    if method.theta:  # the scaled mass depends on h, and may leave no limit
        bending = largest_stable_step(lambda h: h * frequency(h) < limit, bending, 1e-4, 1e4)
    return Prediction(
        bending,
        inner.decay_limit(*scheme) / method.zeta,
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


def disturbed(start: Equilibrium) -> Array:
    """(n, 2, 2) coordinates nearby: the fastest vibration, which decides, and random ones.

    The latter, a tenth, give all modes a share.
    """
    q, v = start.state
    noise = 0.1 * np.random.default_rng(1).uniform(-1.0, 1.0, q.shape)
    noise[:, 0] *= start.element_length
    system, rate, a = cable_system(start.cable, 1.0), np.zeros(q.size), np.zeros_like(q)
    tracker = FrequencyTracker(system, q.shape)
    for _ in range(ITERATIONS):
        index_reduced_rates(system, start.inputs, q.ravel(), v.ravel(), a.ravel(), rate)
        tracker.frequency(q, a)
    scaled = np.abs(tracker.vibration)
    scaled[:, 0] /= start.element_length
    noise += 0.9 / scaled.max() * tracker.vibration
    noise *= DISTURBANCE
    noise[start.cable.fixed] = 0.0
    if start.cable.closed:
        noise[-1] = noise[0]
    return q + noise


def distance(start: Equilibrium) -> Callable[[Array, Array], float]:
    """How far two configurations are apart: slopes [-], and positions over the element length.

    Of a cable that spins, after the second one has been turned about the origin, as far as their ends differ.
    """
    spins = start.state[1].any()

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
    (q, v), near, apart = start.state, disturbed(start), distance(start)

    def is_stable(h: float) -> bool:
        settings = method.settings(h)
        moved = start.moved(near, settings, steps)
        twin = start.moved(q, settings, steps) if v.any() else q
        return moved is not None and twin is not None and apart(moved, twin) < GROWTH * DISTURBANCE

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
