"""The largest stable step: predicted by linear theory, and found by running."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from exudyn_inext import ExplicitSettings
from reference_models.trajectory import Array
from studies.harness import Row, inner
from studies.harness.inner import FrequencyTracker, cable_system, index_reduced_rates

from .motion import PORTION, Equilibrium, Motion, system_of

RULE_CONSTANT = 0.7  # C of Eq. (37)


def predict(start: Equilibrium, settings: ExplicitSettings, growth: float = inner.GROWTH_TOLERANCE) -> Row:
    """Bounds of the step [s] for small vibrations about an equilibrium.

    growth: of a step that counts as none [-]; see `frequency_limit`.

    Returns:
        "largestFrequency": w_max without mass scaling [rad/s]; "predictedBending": h w_max at the scheme's
        limit, tension included; "predictedZeta": h zeta at its limit; "predicted": the largest stable step;
        "ruledBy": zeta, or what gives the larger part of w_max^2; "rule": Eq. (37) with C = 0.7.
    """
    limit, system = (
        inner.frequency_limit(*settings.method, growth=growth),
        system_of(start.cable, settings, 0.0),
    )
    frequency = inner.largest_frequency(system, start.inputs, start.q, start.v)
    tension_free = inner.largest_frequency(system, 0.0 * start.inputs, start.q)  # and without spin
    bending = limit / frequency
    if settings.massScaling:  # the scaled mass depends on h, and may leave no limit

        def is_below(h: float) -> bool:
            scaled = system_of(start.cable, settings, h)
            return h * inner.largest_frequency(scaled, start.inputs, start.q, start.v) < limit

        bending = largest_stable_step(is_below, bending, 1e-4, 1e4)
    zeta = inner.decay_limit(*settings.method) / settings.stabilizationRate
    of_bending = "bending" if tension_free**2 > 0.5 * frequency**2 else "tension"
    section = start.cable.section.mass_per_length, start.cable.section.bending_stiffness
    return {
        "largestFrequency": frequency,
        "predictedBending": bending,
        "predictedZeta": zeta,
        "predicted": min(bending, zeta),
        "ruledBy": "zeta" if zeta < bending else of_bending,
        "rule": inner.rule_step(start.element_length, *section, RULE_CONSTANT),
    }


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


def is_stable_about(start: Equilibrium, settings: ExplicitSettings, steps: int) -> Stable:
    """Whether a disturbance of the equilibrium stays within GROWTH over so many steps, as a function of h.

    A cable that spins is compared with the same steps of an undisturbed one.
    """
    near, apart, is_at_rest = disturbed(start), distance(start), not start.v.any()

    def is_stable(h: float) -> bool:
        motion, twin = Motion(near, settings, h), Motion(start, settings, h)
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


def compare_limits(start: Equilibrium, settings: ExplicitSettings, steps: int = STEPS) -> Row:
    """Predicted and bisected limit of the step about an equilibrium, and the rule (37) beside them.

    The prediction allows the growth that so many steps do not show: 1000 over all of them.
    """
    prediction = predict(start, settings, growth=math.log(GROWTH) / steps)
    step = prediction["predicted"]
    is_unlimited = math.isinf(step)
    estimate = 10.0 / prediction["largestFrequency"] if is_unlimited else step
    found = largest_stable_step(is_stable_about(start, settings, steps), estimate)
    return prediction | {
        "found": found,
        "isUnlimited": is_unlimited and math.isinf(found),
        "ratio": None if is_unlimited else found / step,
        "ruleOverLimit": prediction["rule"] / found if found else math.inf,
    }
