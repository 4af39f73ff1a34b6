"""Stability limits of any scheme, measured on the two linear systems that decide.

The undamped oscillator q'' = -w^2 q stands for the bending vibrations, the decay c' = -zeta c for the
constraint stabilisation. The amplification matrix of one step is built column by column by the
scheme itself, in Python: so a limit is always that of the code that runs, and nothing is compiled for it.
Many systems are moved at once, in rows of numbers in place of each number.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import implements
from ..compiled import in_python, inlined
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .integrator import Integrator, advance, no_loads

GROWTH_TOLERANCE = 1e-9
_TRIALS = 400
_REFINEMENTS = 2
UNDAMPED = 1e-4  # damping ratio, below which a limit is that without damping


class LinearSystem(NamedTuple):
    """q'' = -w^2 q, with velocity and position constraint terms that decay with rate zeta.

    squared_frequency: w^2 [1/s^2].   zeta: [1/s]: v' and q' have the terms -zeta v and -zeta q.
    damping: of the oscillator [1/s]. All of them are numbers, or (n,) those of n systems.
    """

    squared_frequency: Any
    zeta: Any
    damping: Any = 0.0


@implements(index_reduced_rates, LinearSystem, compiled=inlined)
def linear_rates(system, external, q, v, acceleration, rate):
    """Right-hand side; with zeta > 0 it is what Eqs. (27), (28) leave of a constrained direction."""
    for i in range(len(q)):
        acceleration[i] = (
            external[i] - system.squared_frequency * q[i] - (system.zeta + system.damping) * v[i]
        )
        rate[i] = (system.zeta == 0.0) * v[i] - system.zeta * q[i]


@implements(accelerate_and_project, LinearSystem, compiled=inlined)
def accelerate_and_project_linear(system, external, q, v, duration, acceleration, end_velocity):
    """Without constraints there is nothing to project."""
    for i in range(len(q)):
        leading = v[i] + duration * acceleration[i]
        acceleration[i] = external[i] - system.squared_frequency * q[i] - system.damping * leading
        end_velocity[i] = v[i] + duration * acceleration[i]


@implements(correct_position, LinearSystem, compiled=inlined)
def correct_linear_position(system, external, q, tolerance, learning, correction):
    """Without constraints there is nothing to correct."""
    correction[:] = 0.0
    return 0.0


def amplification_matrix(integrator: Integrator, scheme: Any, system: LinearSystem) -> Array:
    """One step h = 1 as a matrix on (q, v, and the history of a multi-step scheme).

    Returns: (k, k), or (n, k, k) of n systems.
    """
    number = max(np.size(value) for value in system)
    loads = no_loads(1, len(integrator.stages))
    start, take_step = in_python(integrator.start), in_python(advance.dispatch(type(scheme)))
    fields = ["q", "v", *integrator.carries]
    columns = []
    for unit in fields:
        state = integrator.allocate(1, 1)
        state = type(state)(*(np.zeros((len(array), number)) for array in state))
        getattr(state, unit)[:] = 1.0
        given = [getattr(state, name).copy() for name in fields]
        start(system, np.zeros(1), state)
        for name, value in zip(fields, given, strict=True):
            getattr(state, name)[:] = value
        take_step(scheme, system, loads, state, 1.0, 1, np.zeros((1, 3, 1, number)))
        columns.append([getattr(state, name)[0] for name in fields])
    matrices = np.array(columns).transpose(2, 1, 0)
    return matrices if any(np.ndim(value) for value in system) else matrices[0]


def _first_unstable(integrator: Integrator, scheme: Any, family: Any, largest: float, growth: float) -> float:
    """The smallest argument of `family` at which a step grows by more than that, by ever finer scans."""
    below, width = 0.0, largest
    for scan in range(1 + _REFINEMENTS):
        trials = below + width * np.arange(1, _TRIALS + 1) / _TRIALS
        eigenvalues = np.linalg.eigvals(amplification_matrix(integrator, scheme, family(trials)))
        is_unstable = np.abs(eigenvalues).max(axis=1) > 1.0 + growth
        if scan == 0 and not is_unstable.any():
            return largest
        is_unstable[-1] = True
        width /= _TRIALS
        below += width * int(is_unstable.argmax())
    return float(below)


def frequency_limit(
    integrator: Integrator, scheme: Any, damping_ratio: float = 0.0, growth: float = GROWTH_TOLERANCE
) -> float:
    """Largest h w [-] up to which the oscillator q'' = -w^2 q - damping_ratio w q' does not grow.

    To three digits of the ratio, so that runs of a study, whose ratios are close, search for it once.

    growth: what counts as none, relative, in a step [-].
    """
    ratio = 0.0 if damping_ratio < UNDAMPED else float(f"{damping_ratio:.3g}")
    return _frequency_limit(integrator, scheme, ratio, growth)


@lru_cache
def _frequency_limit(integrator: Integrator, scheme: Any, damping_ratio: float, growth: float) -> float:
    return _first_unstable(
        integrator, scheme, lambda x: LinearSystem(x * x, 0.0, damping_ratio * x), 4.0, growth
    )


@lru_cache
def decay_limit(integrator: Integrator, scheme: Any) -> float:
    """Largest h zeta [-] up to which constraint errors do not grow; infinite without stabilisation."""
    if not integrator.stabilised:
        return math.inf
    return _first_unstable(integrator, scheme, lambda x: LinearSystem(0.0, x), 4.0, GROWTH_TOLERANCE)
