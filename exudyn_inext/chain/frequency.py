"""The largest natural frequency of the constrained chain, which bounds every explicit step."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..compiled import counting_kernel, kernel, local_array
from ..element.inextensibility import length_gradient
from ..system import index_reduced_rates
from .assembly import add_elastic_force, add_element_force, differences
from .index_reduction import CableSystem
from .linear_response import add_link_stiffness, constrained_inverse
from .linked_cable import LinkedCableSystem
from .saddle_point import apply_mass, nodal_multipliers

LANCZOS_STEPS = 40
BREAKDOWN = 1e-7  # what is left of a Lanczos vector, relative, that is nothing but round-off


@kernel
def _combine(a, x, b, y, result):
    """result = a x + b y for arrays of the shape (n, 2, dim)."""
    for k in range(len(x)):
        for i in range(x.shape[2]):
            result[k, 0, i] = a * x[k, 0, i] + b * y[k, 0, i]
            result[k, 1, i] = a * x[k, 1, i] + b * y[k, 1, i]


@kernel
def _inner(x, y):
    """Inner product of arrays of the shape (n, 2, dim)."""
    total = 0.0
    for k in range(len(x)):
        for i in range(x.shape[2]):
            total += x[k, 0, i] * y[k, 0, i] + x[k, 1, i] * y[k, 1, i]
    return total


@kernel
def _apply_elastic_tangent(chain, q, x, memory, y):
    """y = -(dQ_el/dq) x, exact: Q_el is cubic in q, so that two central differences suffice."""
    trial, force = memory[0], memory[1]
    _combine(0.0, x, 0.0, x, y)
    for difference in range(4):
        step = 1.0 + difference // 2
        sign = 1.0 - 2.0 * (difference % 2)
        weight = -8.0 / 12.0 if difference < 2 else 1.0 / 12.0
        _combine(1.0, q, sign * step, x, trial)
        _combine(0.0, x, 0.0, x, force)
        add_elastic_force(chain, trial, force)
        _combine(1.0, y, sign * weight, force, y)


@kernel
def _add_geometric_stiffness(chain, nodal, length, x, y):
    """y += sum lam d2c/dq2 x: the stiffness that the tension gives.   nodal: (n,); length: (N,)."""
    for k in range(len(nodal)):
        for i in range(len(chain.axes)):
            y[k, 1, i] += 2.0 * nodal[k] * x[k, 1, i]
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(length)):
        differences(chain.axes, x, k, e)
        length_gradient(chain.axes, chain.elements[k].slope_gram, e, gradient)
        for a in range(3):
            for i in range(len(chain.axes)):
                gradient[a, i] *= length[k]
        add_element_force(chain.axes, gradient, y[k], y[k + 1])


@kernel
def _apply_stiffness(system, q, tension, x, memory, y):
    """y = H x: the elastic stiffness at q, and the geometric one of `tension`.

    tension: nodal (n,), length (N,), link (m,) multipliers.   memory: (2, n, 2, dim) or longer.
    """
    chain = system.chain
    _apply_elastic_tangent(chain, q, x, memory, y)
    _add_geometric_stiffness(chain, tension[0], tension[1], x, y)
    add_link_stiffness(system, tension[2], x, y)


@kernel
def _lanczos(system, q, tension, start, memory, diagonal, off_diagonal):
    """Lanczos recursion of x -> constrained M^-1 H x in the mass inner product.

    H: see `_apply_stiffness`.   memory: (6, n, 2, dim), zero.
    Returns the number of rows of the tridiagonal matrix that were found before breakdown.
    """
    chain = system.chain
    current, previous, image, momentum = memory[2], memory[3], memory[4], memory[5]
    apply_mass(chain, start, momentum)
    _combine(1.0 / np.sqrt(_inner(start, momentum)), start, 0.0, start, current)
    norm = 0.0
    for row in range(len(diagonal)):
        _apply_stiffness(system, q, tension, current, memory, image)
        diagonal[row] = _inner(current, image)
        _combine(1.0, image, 0.0, image, momentum)
        constrained_inverse(system, momentum, image)
        _combine(1.0, image, -diagonal[row], current, image)
        _combine(1.0, image, -norm, previous, image)
        apply_mass(chain, image, momentum)
        constrained_inverse(system, momentum, image)  # what is left may be mostly off the constraints
        apply_mass(chain, image, momentum)
        norm = np.sqrt(max(_inner(image, momentum), 0.0))
        off_diagonal[row] = norm
        if not norm > BREAKDOWN * abs(diagonal[row]):
            return row + 1
        _combine(1.0, current, 0.0, current, previous)
        _combine(1.0 / norm, image, 0.0, image, current)
    return len(diagonal)


@counting_kernel
def largest_of_tridiagonal(diagonal, off_diagonal):
    """Largest eigenvalue of a symmetric tridiagonal matrix, by bisection of its Sturm sequence.

    Args:
        diagonal: (n,).   off_diagonal: (n - 1,) or longer.
    """
    number = len(diagonal)
    upper = -np.inf
    for i in range(number):
        left = abs(off_diagonal[i - 1]) if i > 0 else 0.0
        right = abs(off_diagonal[i]) if i < number - 1 else 0.0
        upper = max(upper, diagonal[i] + left + right)
    lower = diagonal.max()
    for _ in range(60):
        middle = 0.5 * (lower + upper)
        pivot = 1.0
        is_bound = True  # no eigenvalue above `middle`: all pivots of middle - T are positive
        for i in range(number):
            coupling = off_diagonal[i - 1] if i > 0 else 0.0
            pivot = middle - diagonal[i] - coupling * coupling / pivot
            if not pivot > 0.0:
                is_bound = False
                break
        lower, upper = (lower, middle) if is_bound else (middle, upper)
    return upper


@kernel
def _power_iteration(system, q, tension, iterations, memory, x):
    """Rayleigh quotient of x under x -> constrained M^-1 H x, H as in `_lanczos`, which x is iterated with.

    memory: (4, n, 2, dim).   x: (n, 2, dim), improved in place towards the fastest vibration.
    """
    chain = system.chain
    image, momentum = memory[2], memory[3]
    quotient = 0.0
    for _ in range(iterations):
        apply_mass(chain, x, momentum)
        norm = np.sqrt(_inner(x, momentum))
        _combine(1.0 / norm, x, 0.0, x, x)
        _apply_stiffness(system, q, tension, x, memory, image)
        quotient = _inner(x, image)
        constrained_inverse(system, image, momentum)
        _combine(1.0, momentum, 0.0, momentum, x)
    return quotient


def _tension_in_motion(system: Any, external: Array, q: Array, v: Array | None) -> tuple[Array, Array, Array]:
    """Nodal (n,), length (N,) and link (m,) multipliers at q, v (None: at rest); factorised at q."""
    acceleration, rate = np.zeros(q.size), np.zeros(q.size)
    inputs = external.copy()
    if v is None:
        v = np.zeros(q.size)
        inputs[q.size :].reshape(-1, 3, q.shape[2])[:, 1] = 0.0  # velocities of the anchors
    index_reduced_rates(system, inputs, q.ravel(), v.ravel(), acceleration, rate)
    return _tension(system, acceleration.reshape(q.shape))


def _tension(system: Any, acceleration: Array) -> tuple[Array, Array, Array]:
    """Nodal (n,), length (N,) and link (m,) multipliers; arguments: see `nodal_multipliers_of`."""
    of_links = np.array([link.multiplier[0] for link in _links(system)], dtype=float)
    nodal = nodal_multipliers_of(system, acceleration)
    return nodal, system.chain.elements["multiplier"][:, 0].copy(), of_links


def _links(system: Any) -> Any:
    return system.border.links if isinstance(system, LinkedCableSystem) else []


def nodal_multipliers_of(system: Any, acceleration: Array) -> Array:
    """(n,) multipliers of the nodal constraints (18) [N m].

    Args:
        system: just evaluated by `index_reduced_rates`.   acceleration: (n, 2, dim) that it gave.
    """
    for link in _links(system):
        for k, gradient in zip(link.node, link.gradient, strict=True):
            system.chain.nodes[k].force[0] -= link.multiplier[0] * gradient
    nodal = np.zeros(len(acceleration))
    nodal_multipliers(system.chain, acceleration, np.zeros_like(acceleration), nodal)
    return nodal


def _degrees_of_freedom(system: Any) -> int:
    """Coordinates that move, less nodal, length and link constraints."""
    free = system.chain.nodes["free"].sum(axis=0)
    dim = len(system.chain.axes)
    rows = system.chain.nodes["ends_group"].sum()
    if isinstance(system, LinkedCableSystem):
        rows += len(system.border.links)
    return int(dim * free[0] + (dim - 1) * free[1] - rows)


def largest_frequency(
    system: CableSystem | LinkedCableSystem, external: Array, q: Array, v: Array | None = None
) -> float:
    """w_max of small vibrations about q, constraints and tension included.

    Lanczos iteration with the structured solve: O(N), no matrix is formed.

    Args:
        system: the cable's system; its memory is used.
        external: (n_external,) external force, which sets the tension [N, Nm], and motions.
        q: (n, 2, dim) configuration.
        v: (n, 2, dim) velocities, which count by the tension that they cause; None: at rest.

    Returns:
        Largest natural frequency [rad/s]; 0 if nothing can move.
    """
    tension = _tension_in_motion(system, external, q, v)
    start = np.zeros_like(q)
    constrained_inverse(system, _scattered(q.shape), start)
    rows = min(LANCZOS_STEPS, _degrees_of_freedom(system))
    if rows < 1:
        return 0.0
    diagonal, off_diagonal = np.zeros(rows), np.zeros(rows)
    found = _lanczos(system, q, tension, start, np.zeros((6, *q.shape)), diagonal, off_diagonal)
    if not np.isfinite(diagonal[:found]).all():
        return 0.0
    top = largest_of_tridiagonal(diagonal[:found], off_diagonal)
    return float(np.sqrt(max(top, 0.0)))


class FrequencyTracker:
    """w_max of a cable in motion, cheaply: the fastest vibration is kept and improved from time to time.

    Args:
        system: of the cable.   shape: (n, 2, dim) of its coordinates.

    Attributes:
        vibration: (n, 2, dim) the fastest one so far.
    """

    FIRST, LATER = 40, 4  # iterations

    def __init__(self, system: CableSystem | LinkedCableSystem, shape: tuple[int, ...]) -> None:
        self._system = system
        self.vibration = np.zeros(shape)

    def frequency(self, q: Array, a: Array) -> float:
        """w_max [rad/s] of small vibrations about the state that `system` was evaluated at last.

        Args:
            q, a: (n, 2, dim) of that state; its velocities count by the tension that they cause.
        """
        system, x = self._system, self.vibration
        tension = _tension(system, a)
        iterations = self.LATER
        if not x.any():
            constrained_inverse(system, _scattered(q.shape), x)
            iterations = self.FIRST
        squared = 0.0
        if x.any():
            squared = _power_iteration(system, q, tension, iterations, np.zeros((4, *q.shape)), x)
        if not np.isfinite(x).all():
            x[:] = 0.0
        return float(np.sqrt(max(squared, 0.0)))


def _scattered(shape: tuple[int, ...]) -> Array:
    """Numbers between -1 and 1 without a pattern, always the same: every mode has a share in them."""
    return np.cos(np.arange(np.prod(shape), dtype=float) ** 2 * 1.6180339887).reshape(shape)
