"""The largest natural frequency of the constrained chain, which bounds every explicit step."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..compiled import inlined, inlined_kernel, kernel, optional
from ..element.axial_strain import mean_strain
from ..element.inextensibility import length_gradient
from ..lowered import local_array
from ..system import accelerate_and_project
from .assembly import VALUE, add_elastic_force, add_element_force, differences
from .axial_stiffness import FORCE, FREE_STRAIN, STRAIN
from .index_reduction import CableSystem
from .linear_response import add_link_stiffness, constrained_inverse, take_link_forces
from .linked_cable import LinkedCableSystem
from .saddle_point import apply_mass, nodal_multipliers

LANCZOS_STEPS = 40
BREAKDOWN = 1e-7  # what is left of a Lanczos vector, relative, that is nothing but round-off


@inlined
def _combine(a, x, b, y, result):
    """result = a x + b y for arrays of the shape (n, 2, dim)."""
    for k in range(len(x)):
        for i in range(x.shape[2]):
            result[k, 0, i] = a * x[k, 0, i] + b * y[k, 0, i]
            result[k, 1, i] = a * x[k, 1, i] + b * y[k, 1, i]


@inlined
def _inner(x, y):
    """Inner product of arrays of the shape (n, 2, dim)."""
    total = 0.0
    for k in range(len(x)):
        for i in range(x.shape[2]):
            total += x[k, 0, i] * y[k, 0, i] + x[k, 1, i] * y[k, 1, i]
    return total


@inlined
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


@inlined
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


@inlined
def _apply_stiffness(system, q, tension, x, memory, y):
    """y = H x: the elastic stiffness at q, and the geometric one of `tension`.

    tension: nodal (n,), length (N,), link (m,) multipliers.   memory: (2, n, 2, dim) or longer.
    """
    chain = system.chain
    _apply_elastic_tangent(chain, q, x, memory, y)
    _add_geometric_stiffness(chain, tension[0], tension[1], x, y)
    add_link_stiffness(system, tension[2], x, y)


@inlined
def _lanczos(system, q, tension, rows, memory, diagonal, off_diagonal):
    """Lanczos recursion of x -> constrained M^-1 H x in the mass inner product.

    H: see `_apply_stiffness`.   rows: of the tridiagonal matrix, at most.
    memory: (6, n, 2, dim): the third one holds the vector to start from, the fourth one is zero.
    Returns the number of rows that were found before breakdown.
    """
    chain = system.chain
    current, previous, image, momentum = memory[2], memory[3], memory[4], memory[5]
    apply_mass(chain, current, momentum)
    _combine(1.0 / np.sqrt(_inner(current, momentum)), current, 0.0, current, current)
    norm = 0.0
    for row in range(rows):
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
    return rows


@inlined
def largest_of_tridiagonal(number, diagonal, off_diagonal):
    """Largest eigenvalue of a symmetric tridiagonal matrix, by bisection of its Sturm sequence.

    Args:
        number: n, of rows.   diagonal: (n,) or longer.   off_diagonal: (n - 1,) or longer.
    """
    lower, upper = -np.inf, -np.inf
    for i in range(number):
        left = abs(off_diagonal[i - 1]) if i > 0 else 0.0
        right = abs(off_diagonal[i]) if i < number - 1 else 0.0
        lower = max(lower, diagonal[i])
        upper = max(upper, diagonal[i] + left + right)
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


def _no_tension(system: Any) -> tuple[Array, Array, Array]:
    """Memory for nodal (n,), length (N,) and link (m,) multipliers."""
    chain = system.chain
    links = len(system.border.links) if isinstance(system, LinkedCableSystem) else 0
    return np.zeros(len(chain.nodes)), np.zeros(len(chain.elements)), np.zeros(links)


@inlined
def _of_multipliers(axes, nodes, elements, chain, acceleration, momentum, tension):
    """Nodal and length multipliers behind an evaluation; arguments: see `_set_tension`."""
    nodal_multipliers(chain, acceleration, momentum, tension[0])
    for k in range(len(elements)):
        tension[1][k] = elements[k].multiplier[0]


@optional("axial", otherwise=_of_multipliers)
def set_length_tension(axes, nodes, elements, chain, acceleration, momentum, tension):
    """Multipliers of (18), (19) that give the stiffness of the axial forces, or a little more."""
    for k in range(len(nodes)):
        tension[0][k] = 0.5 * nodes[k].axial[FORCE] / (1.0 + nodes[k].constraint[VALUE])
    for k in range(len(elements)):
        force = elements[k].axial[FORCE]
        left, right = nodes[k].constraint[VALUE], nodes[k + 1].constraint[VALUE]
        middle = elements[k].axial[STRAIN] + elements[k].axial[FREE_STRAIN]
        mean = 1.0 + mean_strain(left, middle, right)
        tension[1][k] = 0.75 * force * elements[k].per_length / mean
        tension[0][k] -= 0.125 * force / (1.0 + left)
        tension[0][k + 1] -= 0.125 * force / (1.0 + right)


@kernel
def _set_tension(system, acceleration, momentum, tension):
    """`tension` behind the last evaluation of `system`, which gave this acceleration (n, 2, dim).

    momentum: (n, 2, dim) memory.   tension: output, see `_no_tension`.
    """
    elements = system.chain.elements
    take_link_forces(system, tension[2])
    set_length_tension(
        system.chain.axes, system.chain.nodes, elements, system.chain, acceleration, momentum, tension
    )


def nodal_multipliers_of(system: Any, acceleration: Array) -> Array:
    """(n,) multipliers of the nodal constraints (18) [N m].

    Args:
        system: just evaluated by `accelerate_and_project`.   acceleration: (n, 2, dim) that it gave.
    """
    tension = _no_tension(system)
    _set_tension(system, acceleration, np.zeros_like(acceleration), tension)
    return tension[0]


@inlined
def _of_constrained(axes, nodes, elements):
    """Coordinates that move, less nodal and length constraints."""
    dim, number = len(axes), 0
    for k in range(len(nodes)):
        number += int(dim * nodes[k].free[0] + (dim - 1) * nodes[k].free[1]) - int(nodes[k].ends_group)
    return number


@optional("axial", otherwise=_of_constrained)
def _degrees_of_freedom(axes, nodes, elements):
    """Coordinates that move."""
    number = 0
    for k in range(len(nodes)):
        number += int(len(axes) * (nodes[k].free[0] + nodes[k].free[1]))
    return number


@inlined_kernel
def _scatter(x):
    """x (n, 2, dim): numbers between -1 and 1 without a pattern, always the same: every mode has a share."""
    place = 0.0
    for k in range(len(x)):
        for kind in range(2):
            for i in range(x.shape[2]):
                x[k, kind, i] = np.cos(1.6180339887 * place * place)
                place += 1.0


@kernel
def _largest_at_state(system, q, tension, memory, diagonal, off_diagonal):
    """w_max^2 [rad^2/s^2] where `system` was evaluated last; 0 if nothing can move, NaN if it is not found.

    tension: see `_set_tension`.   memory: (6, n, 2, dim); the fourth one is zero.
    """
    start, scattered = memory[2], memory[4]
    chain = system.chain
    freedom = _degrees_of_freedom(chain.axes, chain.nodes, chain.elements) - len(tension[2])
    rows = min(len(diagonal), freedom)
    if rows < 1:
        return 0.0
    _scatter(scattered)
    constrained_inverse(system, scattered, start)
    found = _lanczos(system, q, tension, rows, memory, diagonal, off_diagonal)
    for row in range(found):
        if not (abs(diagonal[row]) < np.inf and abs(off_diagonal[row]) < np.inf):
            return np.nan
    return largest_of_tridiagonal(found, diagonal, off_diagonal)


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
        Largest natural frequency [rad/s]; 0 if nothing can vibrate, NaN if state or forces are not finite, or
        constraints depend on each other.
    """
    inputs = external.copy()
    if v is None:
        v = np.zeros(q.shape)
        inputs[q.size :].reshape(-1, 3, q.shape[2])[:, 1] = 0.0  # velocities of the anchors
    tension, (acceleration, rate) = _no_tension(system), np.zeros((2, *q.shape))
    accelerate_and_project(system, inputs, q.ravel(), v.ravel(), 0.0, acceleration.ravel(), rate.ravel())
    _set_tension(system, acceleration, rate, tension)
    return _root(_largest_at_state(system, q, tension, *_lanczos_memory(q.shape)))


def _lanczos_memory(shape: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Memory (6, n, 2, dim), and the tridiagonal matrix.   shape: (n, 2, dim)."""
    return np.zeros((6, *shape)), np.zeros(LANCZOS_STEPS), np.zeros(LANCZOS_STEPS)


def _root(squared: float) -> float:
    """w of w^2: zero if that is negative, as nothing vibrates then; a NaN stays."""
    return 0.0 if squared <= 0.0 else float(np.sqrt(squared))


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

        Where the fastest vibration has been lost, it is looked for as `largest_frequency` does.

        Args:
            q, a: (n, 2, dim) of that state; its velocities count by the tension that they cause.

        Returns:
            See `largest_frequency`.
        """
        system, x = self._system, self.vibration
        tension, memory = _no_tension(system), np.zeros((4, *q.shape))
        _set_tension(system, a, memory[0], tension)
        iterations = self.LATER
        if not x.any():
            _scatter(memory[0])
            constrained_inverse(system, memory[0], x)
            iterations = self.FIRST
        squared = 0.0
        if x.any():
            squared = _power_iteration(system, q, tension, iterations, memory, x)
        if not (squared > 0.0 and np.isfinite(x).all()):
            x[:] = 0.0
            squared = _largest_at_state(system, q, tension, *_lanczos_memory(q.shape))
        return _root(squared)
