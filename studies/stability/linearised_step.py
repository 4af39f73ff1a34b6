"""The step itself, linearised about a cable that spins steadily: the limit that a theory at rest misses."""

import math
from typing import Any

import numpy as np

from exudyn_inext import Rattle
from exudyn_inext.arrays import Array
from exudyn_inext.integrators.integrator import no_loads, record

from .bisection import FARTHEST, GROWTH, RESOLUTION, largest_stable_step
from .cables import Equilibrium
from .motion import Method, Motion

SETTLING = 200  # steps until the stretch of a spinning cable is that of its scheme
DIFFERENCE = 1e-6
_TIGHT = Rattle(tolerance=1e-13)


def limit_in_motion(start: Equilibrium, method: Method, estimate: float, steps: int) -> float:
    """Largest step [s] at which the linearised step grows by less than GROWTH over so many steps."""
    allowed = math.exp(math.log(GROWTH) / steps)

    def is_stable(h: float) -> bool:
        try:
            return spectral_radius(start, method, h) <= allowed
        except ArithmeticError:
            return False

    return largest_stable_step(is_stable, estimate, RESOLUTION) or estimate / FARTHEST


def spectral_radius(start: Equilibrium, method: Method, h: float) -> float:
    """Of one step of a steadily spinning cable, seen from a frame that turns with it.

    By central differences in coordinates, velocities and what else the scheme carries from step to step.

    Raises:
        ArithmeticError: the undisturbed motion does not last.
    """
    motion = Motion(start, method, h)
    if not motion.advance(SETTLING):
        raise ArithmeticError("the undisturbed motion diverged")
    fields = ["q", "v", *method.integrator.carries]
    steady = np.concatenate([getattr(motion.state, name) for name in fields])
    step = _Step(motion, method, fields)
    angle = step.turned(steady)
    free = np.tile(np.repeat(~start.cable.fixed[:, :, None], 2, axis=2).ravel(), len(fields))
    scale = np.repeat([1.0, 1.0 / h, 1.0 / h**2][: len(fields)], start.q.size)
    columns = []
    for place in np.flatnonzero(free):
        unit = np.zeros(len(steady))
        unit[place] = DIFFERENCE * scale[place]
        change = step.take(steady + unit, angle) - step.take(steady - unit, angle)
        columns.append((change / (2.0 * DIFFERENCE * scale))[free])
    return float(np.abs(np.linalg.eigvals(np.array(columns))).max())


class _Step:
    """One step as a function of everything that it starts from."""

    def __init__(self, motion: Motion, method: Method, fields: list[str]) -> None:
        self._motion, self._fields = motion, fields
        self._integrator = method.integrator
        is_rattle = isinstance(method.parameters, Rattle)
        self._parameters: Any = _TIGHT if is_rattle else method.parameters
        stages = len(self._integrator.stages)
        self._loads = no_loads(len(motion.external), stages)._replace(constant=motion.external)

    def _after(self, given: Array) -> Array:
        state, system = self._motion.state, self._motion.system
        parts = np.split(given, len(self._fields))
        state.q[:], state.v[:] = parts[:2]
        self._integrator.start(system, self._motion.external, state)
        for name, part in zip(self._fields, parts, strict=True):
            getattr(state, name)[:] = part
        for records in (system.chain.nodes, system.chain.elements):
            records["foresight"] = 0.0
        history = np.zeros((1, 3, state.q.size))
        record(self._parameters, system, self._loads, state, self._motion.h, 1, history)
        return np.concatenate([getattr(state, name) for name in self._fields])

    def turned(self, given: Array) -> float:
        """Angle of a step [rad]."""
        pairs = [given, self._after(given)]
        shape = self._motion.q.shape
        ends = [pair[: self._motion.q.size].reshape(shape)[-1, 0] for pair in pairs]
        return math.atan2(ends[1][1], ends[1][0]) - math.atan2(ends[0][1], ends[0][0])

    def take(self, given: Array, angle: float) -> Array:
        """The state after a step, turned back by the angle."""
        cosine, sine = math.cos(angle), math.sin(angle)
        back = np.array([[cosine, sine], [-sine, cosine]])
        vectors: Array = self._after(given).reshape(-1, 2) @ back.T
        return vectors.ravel()
