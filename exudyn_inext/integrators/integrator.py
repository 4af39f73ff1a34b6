"""What an integrator is, and the load history that it reads."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..compiled import kernel
from ..element.shape_functions import Array


@dataclass(frozen=True)
class Integrator:
    """An explicit one-step or multi-step scheme.

    name: what the user calls it.
    order: order of convergence in the step.
    stages: abscissae within a step, in steps, at which loads are needed; 1.0 is its end.
    scheme: NamedTuple type of its parameters, with defaults.
    allocate: n_dof -> state (NamedTuple of arrays with fields q, v, a at least).
    start: (system, external, state): sets all but q and v of the state; external (n_dof,).
    advance: (system, loads, scheme, state, h, steps): steps in place, in one compiled call.
    frequency_limit: scheme -> largest stable h w of an undamped oscillator [-].
    decay_limit: scheme -> largest stable h zeta of the constraint stabilisation [-].
    """

    name: str
    order: int
    stages: tuple[float, ...]
    scheme: type[Any]
    allocate: Callable[[int], Any]
    start: Callable[..., None]
    advance: Callable[..., None]
    frequency_limit: Callable[[Any], float]
    decay_limit: Callable[[Any], float]


class LoadHistory(NamedTuple):
    """External force F(t) = constant + sum_p factor_p(t) pattern_p, sampled where a scheme needs it.

    constant: (n_dof,) [N, Nm].
    pattern: (P, n_dof) [N, Nm] per unit factor.
    factor: (steps, stages, P) [-].
    """

    constant: Array
    pattern: Array
    factor: Array


@kernel
def external_force(loads, step, stage, external):
    """external = F at the given stage of the given step.   external: (n_dof,) output."""
    for i in range(len(external)):
        external[i] = loads.constant[i]
    for p in range(len(loads.pattern)):
        for i in range(len(external)):
            external[i] += loads.factor[step, stage, p] * loads.pattern[p, i]
