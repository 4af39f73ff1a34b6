"""The largest natural frequency of the constrained chain, which bounds every explicit step."""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import called
from ..compiled import called_kernel, inlined, inlined_kernel, kernel
from ..element.axial_strain import mean_strain
from ..system import accelerate_and_project
from .assembly import ACCELERATION, VALUE
from .axial_stiffness import FORCE, FREE_STRAIN, STRAIN
from .chain import Chain
from .index_reduction import CableSystem
from .linear_response import respond
from .linked_cable import LinkedCableSystem
from .saddle_point import apply_mass, multiply_by_mass
from .stiffness import apply_stiffness, combine, inner

LANCZOS_STEPS = 40
BREAKDOWN = 1e-7  # what is left of a Lanczos vector, relative, that is nothing but round-off


class Vibrating(NamedTuple):
    """What the iterations need of a cable, whatever its type.

    system: called by address.   node_mass, element_mass: (n, 3), (N, 4), see `records`.
    nodal, length, links: (n,), (N,), (m,) multipliers of constraints, whose tension gives stiffness.
    q: (n_dof,).   memory: (2 n_dof,).
    """

    system: Any
    node_mass: Array
    element_mass: Array
    nodal: Array
    length: Array
    links: Array
    q: Array
    memory: Array


@called_kernel
def _apply_mass(vibrating, x, y):
    nodes = len(vibrating.node_mass)
    shape = nodes, 2, len(x) // (2 * nodes)
    multiply_by_mass(vibrating.node_mass, vibrating.element_mass, x.reshape(shape), y.reshape(shape))


@called_kernel
def _invert(vibrating, force, x):
    respond(vibrating.system, 0, force, x)


@called_kernel
def _apply_stiffness(vibrating, x, y):
    """y = H x: the elastic stiffness at q, and the geometric one of the tension."""
    one = vibrating
    apply_stiffness(one.system, one.nodal, one.length, one.links, one.q, x, one.memory, y)


@inlined
def _lanczos(vibrating, rows, memory, diagonal, off_diagonal):
    """Lanczos recursion of x -> constrained M^-1 H x in the mass inner product.

    H: see `_apply_stiffness`.   rows: of the tridiagonal matrix, at most.
    memory: (4, n_dof): the first one holds the vector to start from, the second one is zero.
    Returns the number of rows that were found before breakdown.
    """
    current, previous, image, momentum = memory[0], memory[1], memory[2], memory[3]
    _apply_mass(vibrating, current, momentum)
    combine(1.0 / np.sqrt(inner(current, momentum)), current, 0.0, current, current)
    norm = 0.0
    for row in range(rows):
        _apply_stiffness(vibrating, current, image)
        diagonal[row] = inner(current, image)
        combine(1.0, image, 0.0, image, momentum)
        _invert(vibrating, momentum, image)
        combine(1.0, image, -diagonal[row], current, image)
        combine(1.0, image, -norm, previous, image)
        _apply_mass(vibrating, image, momentum)
        _invert(vibrating, momentum, image)  # what is left may be mostly off the constraints
        _apply_mass(vibrating, image, momentum)
        norm = np.sqrt(max(inner(image, momentum), 0.0))
        off_diagonal[row] = norm
        if not norm > BREAKDOWN * abs(diagonal[row]):
            return row + 1
        combine(1.0, current, 0.0, current, previous)
        combine(1.0 / norm, image, 0.0, image, current)
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
def _power_iteration(vibrating, iterations, memory, x):
    """Rayleigh quotient of x under x -> constrained M^-1 H x, H as in `_lanczos`, which x is iterated with.

    memory: (2, n_dof).   x: (n_dof,), improved in place towards the fastest vibration.
    """
    image, momentum = memory[0], memory[1]
    quotient = 0.0
    for _ in range(iterations):
        _apply_mass(vibrating, x, momentum)
        norm = np.sqrt(inner(x, momentum))
        combine(1.0 / norm, x, 0.0, x, x)
        _apply_stiffness(vibrating, x, image)
        quotient = inner(x, image)
        _invert(vibrating, image, momentum)
        combine(1.0, momentum, 0.0, momentum, x)
    return quotient


@inlined_kernel
def _scatter(x):
    """x (n_dof,): numbers between -1 and 1 without a pattern, always the same: every mode has a share."""
    for i in range(len(x)):
        x[i] = np.cos(1.6180339887 * i * i)


@kernel
def _largest_at_state(vibrating, rows, memory, diagonal, off_diagonal):
    """w_max^2 [rad^2/s^2] where `system` was evaluated last; NaN if it is not found.

    rows: of the tridiagonal matrix, at most.   memory: (4, n_dof); the second one is zero.
    """
    start, scattered = memory[0], memory[2]
    _scatter(scattered)
    _invert(vibrating, scattered, start)
    found = _lanczos(vibrating, rows, memory, diagonal, off_diagonal)
    for row in range(found):
        if not (abs(diagonal[row]) < np.inf and abs(off_diagonal[row]) < np.inf):
            return np.nan
    return largest_of_tridiagonal(found, diagonal, off_diagonal)


def nodal_multipliers_of(system: Any, acceleration: Array) -> Array:
    """(n,) multipliers of the nodal constraints (18) [N m]; zero where a support holds the slope.

    Args:
        system: just evaluated by `accelerate_and_project`.   acceleration: (n, 2, dim) that it gave.
    """
    chain = system.chain
    nodes, elements = chain.nodes, chain.elements
    rest = nodes["force"][:, ACCELERATION, 1] - apply_mass(chain, acceleration)[:, 1]
    forces = elements["gradient"] * elements["multiplier"][:, ACCELERATION, np.newaxis, np.newaxis]
    rest[1:] -= forces[:, 3]
    rest[:-1] -= forces[:, 1]
    if isinstance(system, LinkedCableSystem):
        links = system.link_system.links
        forces = links["gradient"][:, :, 1] * links["multiplier"][:, ACCELERATION, np.newaxis, np.newaxis]
        np.subtract.at(rest, links["node"], forces)
    slope = nodes["slope"]
    with np.errstate(over="ignore", invalid="ignore"):  # such a frequency is no number
        balance: Array = nodes["free"][:, 1] * (rest * slope).sum(axis=1) / (slope * slope).sum(axis=1)
    return 0.5 * balance


def _of_axial_forces(chain: Chain) -> tuple[Array, Array]:
    """Multipliers (n,), (N,) of (18), (19) that give the stiffness of the axial forces, or a little more."""
    nodes, elements = chain.nodes, chain.elements
    value, force = nodes["constraint"][:, VALUE], elements["axial"][:, FORCE]
    nodal: Array = 0.5 * nodes["axial"][:, FORCE] / (1.0 + value)
    middle = elements["axial"][:, STRAIN] + elements["axial"][:, FREE_STRAIN]
    length: Array = 0.75 * force * elements["per_length"] / (1.0 + mean_strain(value[:-1], middle, value[1:]))
    nodal[:-1] -= 0.125 * force / (1.0 + value[:-1])
    nodal[1:] -= 0.125 * force / (1.0 + value[1:])
    return nodal, length


def _vibrating(system: Any, q: Array, acceleration: Array) -> Vibrating:
    """About the state that `system` was evaluated at last.   q, acceleration: (n, 2, dim), of that state."""
    nodes, elements = system.chain.nodes, system.chain.elements
    if elements["axial"].size:
        nodal, length = _of_axial_forces(system.chain)
    else:
        nodal, length = (
            nodal_multipliers_of(system, acceleration),
            elements["multiplier"][:, 0].copy(),
        )
    links = np.zeros(0)
    if isinstance(system, LinkedCableSystem):
        links = system.link_system.links["multiplier"][:, ACCELERATION].copy()
    one = called(system, respond, apply_stiffness)
    masses, memory = (nodes["mass"].copy(), elements["mass"].copy()), np.zeros(2 * q.size)
    return Vibrating(one, *masses, nodal, length, links, q.reshape(-1), memory)


def _freedom(system: Any) -> int:
    """Coordinates that move, less constraints, unless these yield."""
    nodes, dim = system.chain.nodes, len(system.chain.axes)
    places, slopes = nodes["free"].sum(axis=0)
    links = len(system.link_system.links) if isinstance(system, LinkedCableSystem) else 0
    if nodes["axial"].size:
        return int(dim * (places + slopes)) - links
    return int(dim * places + (dim - 1) * slopes - nodes["ends_group"].sum()) - links


def _frequency_of(system: Any, vibrating: Vibrating) -> float:
    rows = min(LANCZOS_STEPS, _freedom(system))
    if rows < 1:
        return 0.0
    memory, (diagonal, off_diagonal) = np.zeros((4, len(vibrating.q))), np.zeros((2, LANCZOS_STEPS))
    return _root(_largest_at_state(vibrating, rows, memory, diagonal, off_diagonal))


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
    acceleration, rate = np.zeros((2, *q.shape))
    accelerate_and_project(system, inputs, q.ravel(), v.ravel(), 0.0, acceleration.ravel(), rate.ravel())
    if not np.isfinite(acceleration).all():
        return float("nan")
    return _frequency_of(system, _vibrating(system, q, acceleration))


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
        vibrating, x, memory = _vibrating(self._system, q, a), self.vibration.ravel(), np.zeros((2, q.size))
        iterations = self.LATER
        if not x.any():
            _scatter(memory[0])
            _invert(vibrating, memory[0], x)
            iterations = self.FIRST
        squared = 0.0
        if x.any():
            squared = _power_iteration(vibrating, iterations, memory, x)
        if not (squared > 0.0 and np.isfinite(x).all()):
            x[:] = 0.0
            return _frequency_of(self._system, vibrating)
        return _root(squared)
