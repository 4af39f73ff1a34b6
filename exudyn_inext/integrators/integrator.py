"""What an integrator is, the load history that it reads, and the loop over its steps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import called
from ..compiled import inlined_kernel, protocol


@dataclass(frozen=True)
class Integrator:
    """An explicit one-step or multi-step scheme; its module implements `advance` for `scheme`.

    name: what the user calls it.
    order: order of convergence in the step.
    stages: abscissae within a step, in steps, at which loads are needed; 1.0 is its end.
    evaluations: scheme -> number of evaluations of the accelerations in a step; the last one is at its end.
    scheme: NamedTuple type of its parameters, with defaults.
    state: NamedTuple type of its arrays, with fields q, v, a, external at least.
    start: (system, external, state): sets all but q and v of the state; external (n_dof,).
    calls: protocols of `system` that `advance` calls.
    carries: fields of the state that a step needs besides q and v, and does not compute from them.
    stabilised: whether it integrates the stabilised equations (30), whose zeta bounds the step.
    has_implicit_damping: whether its accelerations are central differences of the positions, so that damping
        may be in the matrix on the left.
    change_step: (state, ratio): prepares the memory of a multi-step scheme for steps longer by that ratio.
    resume: (system, external, state): what a step needs of the system besides the state, evaluated again.
    checked: scheme -> the same of plain numbers; raises InputError for a parameter out of its limits.
    for_size: (scheme, size) -> the same, where coordinates are as large as that, in units of its tolerance.
    trouble: (scheme, state) -> what the scheme could not do, for messages; empty if there is nothing.
    """

    name: str
    order: int
    stages: tuple[float, ...]
    evaluations: Callable[[Any], int]
    scheme: type[Any]
    state: type[Any]
    start: Callable[..., None]
    calls: tuple[Any, ...]
    carries: tuple[str, ...] = ()
    stabilised: bool = True
    has_implicit_damping: bool = False
    change_step: Callable[[Any, float], None] = lambda state, ratio: None
    resume: Callable[..., None] = lambda system, external, state: None
    checked: Callable[[Any], Any] = lambda scheme: scheme
    for_size: Callable[[Any, float], Any] = lambda scheme, size: scheme
    trouble: Callable[[Any, Any], str] = lambda scheme, state: ""

    def allocate(self, n_dof: int, n_external: int) -> Any:
        """A state of zeros: `external` (n_external,), the `residual` of iterations (1,), others (n_dof,)."""
        sizes = {"external": n_external, "residual": 1}
        return self.state(*[np.zeros(sizes.get(field, n_dof)) for field in self.state._fields])


NO_WORK = np.zeros((0, 5))
SUM, PROJECTION, FACTOR, FIRST, LAST = range(5)


class LoadHistory(NamedTuple):
    """External force F(t) = constant + sum_p factor_p(t) pattern_p, sampled where a scheme needs it.

    Prescribed motions, where a system has them, follow the force: n_external >= n_dof.

    constant: (n_external,) [N, Nm].
    pattern: (P, n_external) [N, Nm] per unit factor.
    factor: (steps, stages, P) [-].
    work: (P, 5) of each pattern: its work so far [J] (SUM), what it needs of the last step (PROJECTION of q,
        FACTOR), and its FIRST and LAST coordinate; or NO_WORK.
    """

    constant: Array
    pattern: Array
    factor: Array
    work: Array = NO_WORK


@protocol
def advance(scheme, system, loads, state, h, steps, history):
    """Take `steps` steps of size h [s] for each row of `history`, in place; `store` keeps the results.

    history: (intervals, 3, n_dof) output q, v, a at the end of each interval.
    """


def record(
    integrator: Integrator,
    scheme: Any,
    system: Any,
    loads: Any,
    state: Any,
    h: float,
    steps: int,
    history: Array,
) -> None:
    """Advance through len(history) intervals of `steps` steps each, in one call; nobody watches.

    Args:
        integrator: of the scheme.   scheme, system, loads, state, h: see `advance`.
        steps: in each interval.
        history: (intervals, 3, n_dof) output q, v, a at the end of each interval.
    """
    advance(scheme, called(system, *integrator.calls), loads, state, h, steps, history)


@inlined_kernel
def count_work(loads, step, q):
    """Add the work of each pattern in a step to q, by the trapezoidal rule."""
    pattern, factor, work = loads.pattern, loads.factor, loads.work
    for p in range(len(work)):
        projection, now = 0.0, factor[step, -1, p]
        for i in range(int(work[p, FIRST]), int(work[p, LAST]) + 1):
            projection += pattern[p, i] * q[i]
        before = work[p, FACTOR] if work[p, FACTOR] < np.inf else now
        work[p, SUM] += 0.5 * (before + now) * (projection - work[p, PROJECTION])
        work[p, PROJECTION], work[p, FACTOR] = projection, now


@inlined_kernel
def store(history, loads, step, steps, q, v, a):
    """Keep q, v, a after step number `step` if it ends an interval of `steps` steps; count work."""
    count_work(loads, step, q)
    if (step + 1) % steps == 0:
        interval = step // steps
        for i in range(len(q)):
            history[interval, 0, i] = q[i]
            history[interval, 1, i] = v[i]
            history[interval, 2, i] = a[i]


@inlined_kernel
def external_force(loads, step, stage, external):
    """external = F at the given stage of the given step.   external: (n_external,) output."""
    constant, pattern, factor = loads.constant, loads.pattern, loads.factor
    for i in range(len(external)):
        external[i] = constant[i]
    for p in range(len(pattern)):
        if factor[step, stage, p] != 0.0:  # as those of most loads that pass by
            for i in range(len(external)):
                external[i] += factor[step, stage, p] * pattern[p, i]


def remembered(state: Any) -> dict[str, Array]:
    """Arrays of a state that the next steps depend on, by names."""
    return {name: array for name, array in state._asdict().items() if name != "external"}


def no_loads(n_dof: int, stages: int) -> LoadHistory:
    """The load history of one free step."""
    return LoadHistory(np.zeros(n_dof), np.zeros((0, n_dof)), np.zeros((1, stages, 0)))
