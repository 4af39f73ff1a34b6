"""A cable that is thrown: how much of the limit at rest remains."""

import math
from itertools import product

from exudyn_inext import ExplicitStepper
from studies.harness import Row, inner

from .limits import predict
from .motion import Equilibrium, Method, straight, thrown

SPEEDS = (1.0, 3.0, 10.0, 30.0, 100.0)  # [m/s]
METHODS = (
    ("Zhai", 10.0),
    ("Zhai", 100.0),
    ("Zhai", 300.0),
    ("Zhai, corrector, psi = phi = 0", 100.0),
    ("RK4", 100.0),
    ("RATTLE", 100.0),
)
ELEMENTS, DURATION = 10, 1.0  # [-], [s]
STEPS_A_FACTOR = 4  # tried steps within a factor of two
HALVINGS = 6
ENERGY = 0.05  # gain that is no divergence yet, see `ExplicitSettings.energyTolerance`
FINE, SAMPLES = 8, 100  # part of the limit at which the motion's frequency is looked at, and how often


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
    start, method = thrown(ELEMENTS, case["value"]), Method.of(case)
    at_rest = predict(straight(ELEMENTS), method).step
    limit = inner.frequency_limit(*method.settings().method)
    frequency = _largest_in_motion(start, at_rest / FINE, case["duration"])
    in_motion = min(limit / frequency, predict(straight(ELEMENTS), method).stabilisation)
    lasting = 0.0
    for k in range(-HALVINGS * STEPS_A_FACTOR, 1):
        h = at_rest * 2.0 ** (k / STEPS_A_FACTOR)
        if start.moved(start.state[0], method.settings(h, ENERGY), round(case["duration"] / h)) is None:
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
    method = Method("RATTLE")
    stepper, system = ExplicitStepper(start.mbs, method.settings(h)), method.system(start.cable, 0.0)
    stepper.Start()
    q, v, _ = stepper.State()
    found = [inner.largest_frequency(system, start.inputs, q, v)]
    while stepper.time < duration:
        stepper.Step(max(1, round(duration / h / SAMPLES)))
        found.append(inner.largest_frequency(system, start.inputs, q, v))
    return max(w for w in found if math.isfinite(w))
