"""Single precision: the state is rounded to float32 after every step, the solves stay in double precision."""

import numpy as np

from studies.harness.study import Row

from .bisection import distance, largest_stable_step
from .cables import Equilibrium, sagging
from .motion import Method, Motion
from .prediction import predict

STEPS = 2000
SHARE = 0.9  # span over length
BLOWN_UP = 1e-2  # distance from the equilibrium: slopes [-], positions over the element length
HALF = 0.5  # part of the limit at which noise is measured


def precision_cases(quick: bool) -> list[Row]:
    """value: N."""
    numbers = (5, 20) if quick else (5, 10, 20, 50, 100, 200, 400)
    return [
        {
            "kind": "precision",
            "label": f"{scheme}, {bits} bit",
            "scheme": scheme,
            "bits": bits,
            "value": number,
        }
        for scheme in ("Zhai", "RATTLE", "RK4")
        for bits in (32, 64)
        for number in numbers
    ]


class RoundedMotion(Motion):
    """A motion whose coordinates and velocities are stored in single precision between steps."""

    def advance(self, steps: int) -> bool:
        """Take the steps one by one."""
        for _ in range(steps):
            if not super().advance(1):
                return False
            with np.errstate(over="ignore"):  # of a run that diverges
                for values in (self.state.q, self.state.v):
                    values[:] = values.astype(np.float32)
        return True


def run_precision(case: Row) -> Row:
    """Noise about the equilibrium of a sagging cable, and the largest step at which it stays small."""
    start: Equilibrium = sagging(case["value"], SHARE)
    method = Method(case["scheme"], zeta=10.0)
    predicted = predict(start, method).step
    kind, measure = (RoundedMotion if case["bits"] == 32 else Motion), distance(start)

    def noise(h: float) -> float:
        motion, largest = kind(start, method, h), 0.0
        while motion.steps < STEPS:
            if not motion.advance(100):
                return float("inf")
            largest = max(largest, measure(motion.q, start.q))
        return largest

    found = largest_stable_step(lambda h: noise(h) < BLOWN_UP, predicted, 1e-2)
    return {
        "predicted": predicted,
        "found": found,
        "ratio": found / predicted,
        "noise": noise(HALF * predicted),
    }
