"""Explicit Zhai method (paper, section 3.2) for the index-reduced equations.

Read with the misprints of Eqs. (31), (33) corrected: v_n carries a factor h, and
beta = 1/4 (1/2 + gamma)^2. In place of v_n the predictor uses the projected rate q'_n of Eq. (30),
unless `projected_rate` is switched off.

What the parameters do (undamped oscillator; see `linear_stability`):
psi = phi = 1/2 without corrector: neutral, no dissipation, stable up to h w = 2.
psi = phi = 1/2 with the corrector: weakly unstable at every step.
psi = phi = 0 with the corrector: stable up to h w = 2, dissipates.
"""

from typing import NamedTuple

from ..arrays import Array
from ..called_system import implements, takes_any_system
from ..checks import require_finite, require_flag
from ..compiled import inlined_kernel
from ..system import index_reduced_rates
from .integrator import Integrator, advance, external_force, store


class Zhai(NamedTuple):
    """The paper's explicit Zhai method, with its parameters.

    psi, phi: predictor weights of Eqs. (31), (32) [-].
    corrector: whether phases III and IV, Eqs. (33), (34), follow: two evaluations a step.
    gamma_newmark: gamma of Eq. (34) [-].
    projected_rate: whether the predictor uses q'_n of Eq. (30) in place of v_n.
    """

    psi: float = 0.5
    phi: float = 0.5
    corrector: bool = False
    gamma_newmark: float = 0.5
    projected_rate: bool = True


def checked(scheme: Zhai) -> Zhai:
    """The same, with plain numbers; InputError if a parameter is out of its limits."""
    return Zhai(
        require_finite("psi", scheme.psi),
        require_finite("phi", scheme.phi),
        require_flag("corrector", scheme.corrector),
        require_finite("gamma_newmark", scheme.gamma_newmark),
        require_flag("projected_rate", scheme.projected_rate),
    )


class ZhaiState(NamedTuple):
    """Coordinates, velocities, accelerations now and one step ago, projected rate, and memory."""

    q: Array
    v: Array
    a: Array
    a_previous: Array
    rate: Array
    external: Array
    q_start: Array
    v_start: Array


@takes_any_system(index_reduced_rates)
def start(system, external, state):
    """Evaluate at the initial state; a_(-1) = a_0 makes the first step a Taylor step."""
    index_reduced_rates(system, external, state.q, state.v, state.a, state.rate)
    for i in range(len(state.a)):
        state.a_previous[i] = state.a[i]


def change_step(state: ZhaiState, ratio: float) -> None:
    """The acceleration one new step ago, on the line through the last two."""
    state.a_previous[:] = state.a - ratio * (state.a - state.a_previous)


@inlined_kernel
def _predict(scheme, h, q, v, a, a_previous, rate, q_start, v_start):
    """Phase I, Eqs. (31), (32); what the corrector needs of q_n and v_n is kept."""
    for i in range(len(q)):
        q_start[i] = q[i] + h * (rate[i] if scheme.projected_rate else v[i])
        v_start[i] = v[i]
        q[i] = q_start[i] + h * h * ((0.5 + scheme.psi) * a[i] - scheme.psi * a_previous[i])
        v[i] += h * ((1.0 + scheme.phi) * a[i] - scheme.phi * a_previous[i])
        a_previous[i] = a[i]


@inlined_kernel
def _correct(scheme, h, q, v, a_predicted, a_start, q_start, v_start):
    """Phase III, Eqs. (33), (34), from the predicted acceleration."""
    gamma = scheme.gamma_newmark
    beta = 0.25 * (0.5 + gamma) ** 2
    for i in range(len(q)):
        q[i] = q_start[i] + h * h * ((0.5 - beta) * a_start[i] + beta * a_predicted[i])
        v[i] = v_start[i] + h * ((1.0 - gamma) * a_start[i] + gamma * a_predicted[i])


@implements(advance, Zhai, compiled=inlined_kernel)
def advance_zhai(scheme, system, loads, state, h, steps, history):
    q, v, a, a_previous, rate = state.q, state.v, state.a, state.a_previous, state.rate
    external, q_start, v_start = state.external, state.q_start, state.v_start
    for step in range(len(history) * steps):
        _predict(scheme, h, q, v, a, a_previous, rate, q_start, v_start)
        external_force(loads, step, 0, external)
        for phase in range(1 + scheme.corrector):
            if phase == 1:
                _correct(scheme, h, q, v, a, a_previous, q_start, v_start)
            index_reduced_rates(system, external, q, v, a, rate)
        store(history, loads, step, steps, q, v, a)


INTEGRATOR = Integrator(
    name="Zhai",
    order=2,
    stages=(1.0,),
    evaluations=lambda scheme: 1 + scheme.corrector,
    scheme=Zhai,
    state=ZhaiState,
    start=start,
    calls=(index_reduced_rates,),
    carries=("a_previous",),
    has_implicit_damping=True,
    change_step=change_step,
    checked=checked,
)
