"""Classical Runge-Kutta method of order 4 for the index-reduced equations (30).

E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, Springer 1993, table
II.1.2. Four evaluations a step; the last one, at the end of the step, is the first one of the next.
"""

from typing import NamedTuple

from ..arrays import Array
from ..called_system import implements, takes_any_system
from ..checks import require_choice
from ..compiled import inlined_kernel
from ..system import index_reduced_rates
from .integrator import Integrator, advance, external_force, store

WEIGHTS = (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)
ABSCISSAE = (0.5, 0.5, 1.0, 1.0)  # where the evaluation after each stage takes place
LOAD_STAGE = (0, 0, 1, 1)  # of INTEGRATOR.stages


class RungeKutta4(NamedTuple):
    """The classical Runge-Kutta method of order 4; its name is its only parameter."""

    name: str = "RK4"


def checked(scheme: RungeKutta4) -> RungeKutta4:
    """The scheme; InputError if it has another name."""
    return RungeKutta4(require_choice("name", scheme.name, (RungeKutta4().name,)))


class RungeKuttaState(NamedTuple):
    """Coordinates, velocities, their rates, and memory."""

    q: Array
    v: Array
    a: Array
    rate: Array
    external: Array
    q_stage: Array
    v_stage: Array
    q_sum: Array
    v_sum: Array


@takes_any_system(index_reduced_rates)
def start(system, external, state):
    """Evaluate at the initial state."""
    index_reduced_rates(system, external, state.q, state.v, state.a, state.rate)


@inlined_kernel
def _next_stage(h, stage, x, rate, x_sum, x_stage):
    """Where to evaluate next: along the last rate, or, at the end, along the weighted sum."""
    for i in range(len(x)):
        if stage == 0:
            x_sum[i] = x[i]
        x_sum[i] += h * WEIGHTS[stage] * rate[i]
        x_stage[i] = x_sum[i] if stage == 3 else x[i] + h * ABSCISSAE[stage] * rate[i]


@implements(advance, RungeKutta4, compiled=inlined_kernel)
def advance_runge_kutta(scheme, system, loads, state, h, steps, history):
    q, v, a, rate = state.q, state.v, state.a, state.rate
    external, q_stage, v_stage = state.external, state.q_stage, state.v_stage
    q_sum, v_sum = state.q_sum, state.v_sum
    for step in range(len(history) * steps):
        for stage in range(4):
            _next_stage(h, stage, q, rate, q_sum, q_stage)
            _next_stage(h, stage, v, a, v_sum, v_stage)
            external_force(loads, step, LOAD_STAGE[stage], external)
            index_reduced_rates(system, external, q_stage, v_stage, a, rate)
        for i in range(len(q)):
            q[i] = q_stage[i]
            v[i] = v_stage[i]
        store(history, loads, step, steps, q, v, a)


INTEGRATOR = Integrator(
    name="RK4",
    order=4,
    stages=(0.5, 1.0),
    evaluations=lambda scheme: 4,
    scheme=RungeKutta4,
    state=RungeKuttaState,
    start=start,
    calls=(index_reduced_rates,),
    checked=checked,
)
