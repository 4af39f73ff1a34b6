"""The largest stable step, found by running: a small disturbance must not grow."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from exudyn_inext.arrays import Array
from exudyn_inext.chain.frequency import FrequencyTracker
from exudyn_inext.chain.linked_cable import cable_system
from exudyn_inext.system import index_reduced_rates
from studies.harness.study import Row

from .cables import Equilibrium
from .motion import PORTION, Method, Motion
from .prediction import predict

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
    fastest = _fastest_vibration(start)
    scaled = np.abs(fastest)
    scaled[:, 0] /= start.element_length
    noise += 0.9 / scaled.max() * fastest
    noise *= DISTURBANCE
    noise[start.cable.fixed] = 0.0
    if start.cable.closed:
        noise[-1] = noise[0]
    return replace(start, q=start.q + noise)


def _fastest_vibration(start: Equilibrium) -> Array:
    """(n, 2, dim) of any size."""
    system, rate = cable_system(start.cable, 1.0), np.zeros(start.q.size)
    a = np.zeros_like(start.q)
    tracker = FrequencyTracker(system, start.q.shape)
    for _ in range(ITERATIONS):
        index_reduced_rates(system, start.inputs, start.q.ravel(), start.v.ravel(), a.ravel(), rate)
        tracker.frequency(start.q, a)
    return tracker.vibration


def distance(start: Equilibrium) -> Callable[[Array, Array], float]:
    """How far two configurations are apart: slopes [-], and positions over the element length.

    Of a cable that spins, after the second one has been turned to the direction of the first one.
    """
    spins = start.v.any()

    def apart(q: Array, other: Array) -> float:
        moved = np.abs(q - (_turned_to(q, other) if spins else other))
        moved[:, 0] /= start.element_length
        return float(moved.max())

    return apart


def _turned_to(q: Array, other: Array) -> Array:
    """`other` about the origin, so that it ends in the direction of q."""
    angle = np.arctan2(q[-1, 0, 1], q[-1, 0, 0]) - np.arctan2(other[-1, 0, 1], other[-1, 0, 0])
    turn = np.exp(1j * angle)
    turned = turn * (other[..., 0] + 1j * other[..., 1])
    return np.stack([turned.real, turned.imag], axis=-1)


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


def largest_stable_step(is_stable: Stable, estimate: float, resolution: float = RESOLUTION) -> float:
    """The limit near an estimate [s]; infinite, or zero, if it is beyond FARTHEST times the estimate."""
    low, high, factor = estimate, estimate, 1.02
    if is_stable(estimate):
        while is_stable(high := high * factor):
            low, factor = high, factor**1.7
            if high > FARTHEST * estimate:
                return math.inf
    else:
        while not is_stable(low := low / factor):
            high, factor = low, factor**1.7
            if low < estimate / FARTHEST:
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
    far = 10.0 * prediction.frequency**-1
    is_unlimited = math.isinf(prediction.step)
    found = largest_stable_step(
        is_stable_about(start, method, steps), far if is_unlimited else prediction.step
    )
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
