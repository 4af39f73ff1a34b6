"""RATTLE: constraints at position level, without stabilisation, and symplectic.

H. C. Andersen, RATTLE: a "velocity" version of the SHAKE algorithm for molecular dynamics
calculations, Journal of Computational Physics 52 (1983) 24-34. Of the step

    v_(n+1/2) = v_n + h/2 a_n - M^-1 C_q(q_n)^T mu_n,    q_(n+1) = q_n + h v_(n+1/2),    c(q_(n+1)) = 0
    v_(n+1) = v_(n+1/2) + h/2 a_(n+1) - M^-1 C_q(q_(n+1))^T nu_(n+1),    C_q(q_(n+1)) v_(n+1) = 0

mu_n is found by fixed-point iteration with the factor at q_n, which also served a_n: one
factorisation a step. The constrained acceleration is the first guess, so that two or three cheap
solves reach round-off.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import implements, takes_any_system
from ..checks import require_integer, require_positive
from ..compiled import inlined, inlined_kernel
from ..system import accelerate_and_project, correct_position
from .integrator import Integrator, advance, external_force, store

MOST_ITERATIONS = 1_000_000
ROUND_OFF = 8.0 * np.finfo(float).eps  # of the violation of a constraint, relative to the coordinates


class Rattle(NamedTuple):
    """RATTLE, the default integrator, with its parameters.

    tolerance: of the position constraints, |c| [-], lengths relative to the element.
    iterations: largest number of position corrections in a step; a step that needs more has gone wrong.
    """

    tolerance: float = 1e-10
    iterations: int = 30


def checked(scheme: Rattle) -> Rattle:
    """The same, with plain numbers; InputError if a parameter is out of its limits."""
    return Rattle(
        require_positive("tolerance", scheme.tolerance),
        require_integer("iterations", scheme.iterations, 1, MOST_ITERATIONS),
    )


def for_size(scheme: Rattle, size: float) -> Rattle:
    """The same; where differences of such coordinates have a larger round-off than usual, with that."""
    round_off = ROUND_OFF * size
    if round_off < Rattle().tolerance:
        return scheme
    return scheme._replace(tolerance=max(scheme.tolerance, round_off))


class RattleState(NamedTuple):
    """Coordinates, velocities, accelerations, and memory.

    residual: (1,) violation at which the iteration of a step gave up; 0 if none did.
    """

    q: Array
    v: Array
    a: Array
    v_half: Array
    external: Array
    correction: Array
    residual: Array


@takes_any_system(accelerate_and_project)
def start(system, external, state):
    """Evaluate at the initial state and project its velocity."""
    state.residual[0] = 0.0
    for i in range(len(state.v)):
        state.v_half[i] = state.v[i]
    accelerate_and_project(system, external, state.q, state.v_half, 0.0, state.a, state.v)


@takes_any_system(accelerate_and_project)
def resume(system, external, state):
    """The factor at q, which the next step corrects positions with."""
    state.v_half.fill(0.0)
    accelerate_and_project(system, external, state.q, state.v, 0.0, state.v_half, state.correction)


@inlined_kernel
def _drift(h, q, v, a, v_half):
    """v_(n+1/2) and q_(n+1) before the position constraints act."""
    for i in range(len(q)):
        v_half[i] = v[i] + 0.5 * h * a[i]
        q[i] += h * v_half[i]


@inlined_kernel
def _add_correction(h, correction, q, v_half):
    for i in range(len(q)):
        q[i] += correction[i]
        v_half[i] += correction[i] / h


@inlined
def shake(system, external, state, h, scheme):
    """The first half of a step of h [s]: q_(n+1) on the position constraints, and v_(n+1/2).

    external: at the end of the step; what moves the constraints.
    """
    q, v_half, correction = state.q, state.v_half, state.correction
    _drift(h, q, state.v, state.a, v_half)
    learning = 2.0 / (h * h)
    violation = np.inf
    for _ in range(scheme.iterations):
        violation = correct_position(system, external, q, scheme.tolerance, learning, correction)
        if violation < scheme.tolerance:
            break
        _add_correction(h, correction, q, v_half)
        learning = 0.0
    if not violation < scheme.tolerance:
        if state.residual[0] == 0.0:
            state.residual[0] = violation
        q.fill(np.nan)


@implements(advance, Rattle, compiled=inlined_kernel)
def advance_rattle(scheme, system, loads, state, h, steps, history):
    q, v, a, external = state.q, state.v, state.a, state.external
    for step in range(len(history) * steps):
        external_force(loads, step, 0, external)
        shake(system, external, state, h, scheme)
        accelerate_and_project(system, external, q, state.v_half, 0.5 * h, a, v)
        store(history, loads, step, steps, q, v, a)


def trouble(scheme: Rattle, state: RattleState) -> str:
    """Where the iteration gave up."""
    if state.residual[0] == 0.0:
        return ""
    return (
        f"RATTLE's position constraints were violated by {state.residual[0]:.3g} after {scheme.iterations} "
        f"iterations (tolerance {scheme.tolerance:g}): reduce stepSize, or choose a larger tolerance or more "
        "iterations, Rattle(tolerance=..., iterations=...)."
    )


INTEGRATOR = Integrator(
    name="RATTLE",
    order=2,
    stages=(1.0,),
    evaluations=lambda scheme: 1,
    scheme=Rattle,
    state=RattleState,
    start=start,
    calls=(accelerate_and_project, correct_position),
    carries=("a",),
    stabilised=False,
    has_implicit_damping=True,
    resume=resume,
    checked=checked,
    for_size=for_size,
    trouble=trouble,
)
