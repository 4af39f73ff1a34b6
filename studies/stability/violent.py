"""A cable that is thrown: how much of the limit at rest remains."""

import math
from dataclasses import replace
from itertools import product

import numpy as np

from exudyn_inext import ExplicitSettings
from studies.harness import Row, inner

from .limits import predict
from .motion import GRAVITY, LENGTH, Equilibrium, Invariants, Motion, settings_of, straight, system_of

SPEEDS = (1.0, 3.0, 10.0, 30.0, 100.0)  # [m/s]
METHODS = (
    ("Zhai", 10.0),
    ("Zhai", 100.0),
    ("Zhai", 300.0),
    ("Zhai, corrector, psi = phi = 0", 100.0),
    ("RK4", 100.0),
    ("RATTLE", 100.0),
)
RATTLE = ExplicitSettings("RATTLE", massScaling=0.0)
ELEMENTS, DURATION = 10, 1.0  # [-], [s]
STEPS_A_FACTOR = 4  # tried steps within a factor of two
HALVINGS = 6
ENERGY = 0.05  # change over the kinetic energy at the start that is no divergence yet
FINE = 8  # part of the limit at which the motion's frequency is looked at


def thrown(speed: float) -> Equilibrium:
    """A pinned straight cable under gravity in which one wave and a half run up and down."""
    start = straight(ELEMENTS, GRAVITY)
    x = start.q[:, 0, 0]
    v = np.zeros_like(start.q)
    v[:, 0, 1] = speed * np.sin(3.0 * np.pi * x / LENGTH)
    v[:, 1, 1] = speed * 3.0 * np.pi / LENGTH * np.cos(3.0 * np.pi * x / LENGTH)
    q, velocity = start.q.ravel().copy(), v.ravel()
    inner.settle(system_of(start.cable, RATTLE, 0.0), start.external.ravel(), q, velocity)
    return replace(start, q=q.reshape(v.shape), v=velocity.reshape(v.shape))


def violent_cases(quick: bool) -> list[Row]:
    """value: largest velocity at the start [m/s]."""
    methods, speeds = (METHODS[1::4], (1.0, 30.0)) if quick else (METHODS, SPEEDS)
    return [
        {
            "label": f"{scheme}, zeta = {zeta:g} 1/s" if scheme != "RATTLE" else scheme,
            "scheme": scheme,
            "zeta": zeta,
            "value": speed,
            "duration": 0.1 if quick else DURATION,
        }
        for (scheme, zeta), speed in product(methods, speeds)
    ]


def run_violent(case: Row) -> Row:
    """The largest step that lasts, beside the limit at rest and that of the motion's own w_max."""
    start, settings = thrown(case["value"]), settings_of(case)
    prediction = predict(straight(ELEMENTS), settings)
    at_rest = prediction["predicted"]
    limit = inner.frequency_limit(*settings.method)
    frequency = _largest_in_motion(start, at_rest / FINE, case["duration"])
    in_motion = min(limit / frequency, prediction["predictedZeta"])
    lasting = 0.0
    for k in range(-HALVINGS * STEPS_A_FACTOR, 1):
        h = at_rest * 2.0 ** (k / STEPS_A_FACTOR)
        if not _lasts(start, settings, h, case["duration"]):
            break
        lasting = h
    return {
        "predicted": at_rest,
        "predictedInMotion": in_motion,
        "found": lasting,
        "part": lasting / at_rest,
        "partOfMotion": lasting / in_motion,
        "largestFrequency": frequency,
    }


def _largest_in_motion(start: Equilibrium, h: float, duration: float) -> float:
    """Largest w_max [rad/s] on the way of RATTLE with small steps."""
    motion, system = Motion(start, RATTLE, h), system_of(start.cable, RATTLE, 0.0)
    samples = 100
    found = [inner.largest_frequency(system, start.inputs, start.q, start.v)]
    while motion.steps * h < duration and motion.advance(max(1, round(duration / h / samples))):
        found.append(inner.largest_frequency(system, start.inputs, motion.q, motion.v))
    return max(w for w in found if math.isfinite(w))


def _lasts(start: Equilibrium, settings: ExplicitSettings, h: float, duration: float) -> bool:
    """Whether the run stays on the constraints and keeps its energy."""
    motion, invariants = Motion(start, settings, h), Invariants(start.cable, start.external)
    energy, weight = invariants.energy(start.q, start.v), float(np.abs(start.external[:, 0]).sum())
    scale = invariants.kinetic(start.v) + weight * LENGTH
    while motion.steps * h < duration:
        if not motion.advance(50):
            return False
        if not abs(invariants.energy(motion.q, motion.v) - energy) < ENERGY * scale:
            return False
    return True
