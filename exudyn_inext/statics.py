"""Static equilibrium of a cable: a minimum of the potential energy on the constraint manifold.

Newton's method on the manifold: a step along it, found from the Hessian of the Lagrangian, is followed by
a projection onto the constraints; the energy must fall. Where the Hessian is not positive along the step,
some mass is added; where this does not help, a convex model takes its place: bending stiffness, the tension
where it is positive, and some mass. So the
search runs downhill to a stable equilibrium, whether it starts taut, slack or upside down. A point where the
constrained Hessian is not positive definite is left along its worst direction.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import block_array, csc_array, csr_array, vstack
from scipy.sparse.linalg import SuperLU, splu

from .arrays import Array
from .chain.assembly import add_elastic_force, elastic_energy
from .chain.border import CLOSURE
from .chain.cable import Cable
from .chain.chain import build_chain
from .chain.sparse_forms import assembled, elastic_tangent, form_of_cable
from .constraints import constraints_of_cable
from .element.bending import stiffness_matrix
from .element.forms import forms_of_mesh
from .element.inertia import mass_matrix
from .element.inextensibility import slope_gram_matrix

LARGEST_TURN = 0.4  # of a slope in one step [-]
LARGEST_EXCURSION = 100.0  # of a node, in lengths of the cable: no equilibrium there
LANCZOS_STEPS = 60
NEGLIGIBLE = 1e-10  # of the inverse eigenvalues: round-off of those that are infinite
RESOLUTION = 1e-10  # gain of energy that round-off hides, relative
_ARMIJO = 1e-4
PROJECTIONS = 100
SHIFTS = (1.0, 10.0)  # of an indefinite Hessian, in units of the loads' own [-]
BOW = 0.3  # slope at the ends of the sag that a taut start is given [-]
SMALLEST_STEP = 1e-6


@dataclass(frozen=True)
class StaticOptions:
    """tolerance: of the residual, relative to the largest force on the cable [-].

    iterations: largest number of steps.   feasibility: of the constraints [-, m].
    """

    tolerance: float = 1e-9
    iterations: int = 500
    feasibility: float = 1e-12


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """What the search found.

    q: (n, 2, dim) last state.   converged: whether it is a stable equilibrium.   message: why not.
    residual: largest force that is not balanced [N], moments over the element length.
    violation: largest violation of a constraint [-, m].   iterations: steps taken.
    smallest_eigenvalue: of the constrained Hessian over the mass: the lowest frequency squared [1/s^2].
    """

    q: Array
    converged: bool
    message: str
    residual: float
    violation: float
    iterations: int
    smallest_eigenvalue: float


class Potential:
    """Energy, forces and Hessians of one cable under given loads, and its constraints at a time."""

    def __init__(self, cable: Cable, external: Array, time: float) -> None:
        self.cable = cable
        self.time = time
        self._chain = build_chain(cable)
        self._external = external.reshape(cable.reference.shape)
        self._constraints = constraints_of_cable(cable)
        section = cable.section
        self.mass = section.mass_per_length * form_of_cable(cable, mass_matrix)
        self._stiffness = section.bending_stiffness * form_of_cable(cable, stiffness_matrix)
        smoothing = cable.element_lengths.mean() * cable.length**3 * section.mass_per_length
        self.metric = self.mass + smoothing / section.bending_stiffness * self._stiffness
        lengths = np.ones(cable.reference.shape)
        lengths[:, 1] = 1.0 / float(cable.element_lengths.mean())
        self._scale = lengths.ravel()

    def turn_with(self, q: Array) -> None:
        """The slopes at both ends of a ring are joined transverse to the first one, which may turn."""
        if self.cable.closed:
            turned = constraints_of_cable(replace(self.cable, reference=q))
            pairs = zip(self._constraints, turned, strict=True)
            self._constraints = [new if new.name == CLOSURE else old for old, new in pairs]

    def energy(self, q: Array) -> float:
        """Bending energy less the work of the loads [J]."""
        return float(elastic_energy(self._chain, q)) - float(np.sum(self._external * q))

    def force(self, q: Array) -> Array:
        """(n_dof,) elastic and external force."""
        force = self._external.copy()
        add_elastic_force(self._chain, q, force)
        return force.ravel()

    def values(self, q: Array) -> Array:
        """(m,) all constraints."""
        return np.concatenate([c.value(q, self.time) for c in self._constraints])

    def jacobian(self, q: Array) -> csr_array:
        """(m, n_dof) of all constraints."""
        return csr_array(vstack([c.jacobian(q, self.time) for c in self._constraints]))

    def hessian(self, q: Array, multipliers: Array) -> csr_array:
        """Of the Lagrangian."""
        total = elastic_tangent(self._chain, q)
        first = 0
        for constraint in self._constraints:
            mine = multipliers[first : first + constraint.number]
            total = total + constraint.hessian(mine, q.shape)
            first += constraint.number
        return csr_array(total)

    def convex_model(self, multipliers: Array, shift: float) -> csr_array:
        """Bending stiffness, mean tension of the elements where it pulls, and shift times the mass."""
        gram = forms_of_mesh(slope_gram_matrix, self.cable.element_lengths)
        tension = np.maximum(self._mean_tension(multipliers), 0.0)
        geometric = assembled(tension[:, None, None] * gram, self.cable.reference.shape)
        return csr_array(self._stiffness + geometric + shift * self.mass)

    def _mean_tension(self, multipliers: Array) -> Array:
        """(N,) [N]: 2 lam of the length constraint, and the nodal multipliers' share."""
        cable, first = self.cable, 0
        tension = np.zeros(cable.number_of_elements)
        for constraint in self._constraints:
            mine = multipliers[first : first + constraint.number]
            first += constraint.number
            if constraint.name == "length":
                tension += 2.0 * mine[cable.group_of_element()]
            elif constraint.name == "nodal inextensibility":
                nodal = np.zeros(len(cable.reference))
                nodal[~cable.fixed[:, 1]] = mine
                tension += (nodal[1:] + nodal[:-1]) / cable.element_lengths
        return tension

    def size(self, force: Array) -> float:
        """Largest component [N], moments over the element length."""
        return float(np.abs(force * self._scale).max(initial=0.0))

    @property
    def total_force(self) -> Array:
        """(dim,) sum of the external forces [N]."""
        total: Array = self._external[:, 0].sum(axis=0)
        return total

    @property
    def largest_load(self) -> float:
        """Of the external forces [N], and of bending to a radius of the cable's length."""
        section = self.cable.section
        return self.size(self._external.ravel()) + section.bending_stiffness / self.cable.length**2


def _factor(model: csr_array, jacobian: csr_array) -> SuperLU:
    """LU of [B J^T; J 0]."""
    return splu(csc_array(block_array([[model, jacobian.T], [jacobian, None]])))


def _solve(factor: SuperLU, force: Array, target: Array) -> tuple[Array, Array]:
    solution = factor.solve(np.concatenate([force, target]))
    return solution[: len(force)], solution[len(force) :]


def feasible(potential: Potential, q: Array, tolerance: float) -> tuple[Array, float]:
    """q moved onto the constraints, and what is left of their largest violation.

    Newton's method with steps that are smallest in the metric of mass and bending, shortened until the
    sum of squares falls.
    """
    values = potential.values(q)
    for _ in range(PROJECTIONS):
        if float(np.abs(values).max(initial=0.0)) <= tolerance:
            break
        try:
            factor = _factor(potential.metric, potential.jacobian(q))
        except RuntimeError:  # constraints depend on each other here
            break
        step = _solve(factor, np.zeros(q.size), -values)[0].reshape(q.shape)
        size = _cautious(step)
        while size > SMALLEST_STEP:
            trial = potential.values(q + size * step)
            if trial @ trial < values @ values:
                break
            size *= 0.5
        else:
            break
        q, values = q + size * step, trial
    return q, float(np.abs(values).max(initial=0.0))


def _bowed(potential: Potential, q: Array) -> Array:
    """q with a sag towards the loads, or anywhere: on a straight line no step makes a cable longer."""
    arc = np.append(0.0, np.cumsum(potential.cable.element_lengths)) * np.pi / potential.cable.length
    chord = q[-1, 0] - q[0, 0]
    chord = chord / max(float(np.linalg.norm(chord)), 1e-300)
    candidates = np.stack([potential.total_force, *np.eye(q.shape[2])])
    across = candidates - np.outer(candidates @ chord, chord)
    sizes = np.linalg.norm(across, axis=1)
    chosen = 0 if sizes[0] > 1e-6 * potential.largest_load else 1 + int(np.argmax(sizes[1:]))
    sag = BOW * potential.cable.length / np.pi * across[chosen] / sizes[chosen]
    bowed = q.copy()
    bowed[:, 0] += np.outer(np.sin(arc), sag)
    bowed[:, 1] += np.outer(np.cos(arc), sag * np.pi / potential.cable.length)
    return bowed


def _cautious(step: Array) -> float:
    """How much of a step turns no slope by more than `LARGEST_TURN`."""
    return min(1.0, LARGEST_TURN / max(float(np.abs(step[:, 1]).max()), 1e-300))


def _step(potential: Potential, q: Array, multipliers: Array, shift: float) -> tuple[Array, Array, float]:
    """A descent direction along the constraints, new multipliers, and the energy's slope along it."""
    jacobian, force = potential.jacobian(q), potential.force(q)
    exact = potential.hessian(q, multipliers)
    zero = np.zeros(jacobian.shape[0])
    shifted = [csr_array(exact + factor * shift * potential.mass) for factor in SHIFTS]
    for model in (exact, *shifted, potential.convex_model(multipliers, shift)):
        try:
            direction, new = _solve(_factor(model, jacobian), force, zero)
        except RuntimeError:  # singular
            continue
        slope = -float(force @ direction)
        if np.isfinite(slope) and slope < 0.0:
            return direction, new, slope
        if np.isfinite(new).all():  # where forces are balanced there is no direction, but tension
            multipliers = new
    return np.zeros(q.size), multipliers, 0.0


def _line_search(
    potential: Potential, q: Array, direction: Array, slope: float, feasibility: float
) -> Array | None:
    """The next state on the constraints with less energy; None if there is none along the step.

    Close to the equilibrium, where round-off hides the gain of energy, Newton's step is trusted.
    """
    step = direction.reshape(q.shape)
    size = _cautious(step)
    energy = potential.energy(q)
    is_resolved = -slope > RESOLUTION * (abs(energy) + potential.largest_load * potential.cable.length)
    for _ in range(30):
        trial, left = feasible(potential, q + size * step, feasibility)
        falls = not is_resolved or potential.energy(trial) <= energy + _ARMIJO * size * slope
        if left <= 1e3 * feasibility and falls:
            return trial
        size *= 0.5
    return None


def smallest_eigenvalue(potential: Potential, q: Array, multipliers: Array) -> tuple[float, Array]:
    """Of the Hessian on the constraints' null space, over the mass [1/s^2], and its vector (n_dof,).

    Lanczos iteration with the inverse, orthogonalised: if some eigenvalues are negative, the one nearest
    to zero of these.
    """
    hessian, jacobian = potential.hessian(q, multipliers), potential.jacobian(q)
    rows = min(LANCZOS_STEPS, q.size - jacobian.shape[0])
    if rows < 1:
        return np.inf, np.zeros(q.size)
    zero = np.zeros(jacobian.shape[0])
    try:
        inverse, project = _factor(hessian, jacobian), _factor(potential.mass, jacobian)
    except RuntimeError:  # singular: something moves without any force
        return 0.0, np.zeros(q.size)
    vector, _ = _solve(project, np.random.default_rng(1).standard_normal(q.size), zero)
    basis = np.zeros((rows, q.size))
    reduced = np.zeros((rows, rows))
    for row in range(rows):
        for _ in range(2):
            vector = vector - basis[:row].T @ (basis[:row] @ (potential.mass @ vector))
        norm = np.sqrt(vector @ (potential.mass @ vector))
        basis[row] = vector / norm
        vector, _ = _solve(inverse, potential.mass @ basis[row], zero)
        reduced[row, : row + 1] = basis[: row + 1] @ (potential.mass @ vector)
    values, vectors = eigh(reduced, lower=True)
    worst = 0 if values[0] < -NEGLIGIBLE * abs(values).max() else rows - 1
    return float(1.0 / values[worst]), basis.T @ vectors[:, worst]


def find_equilibrium(potential: Potential, start: Array, options: StaticOptions) -> Equilibrium:
    """The stable equilibrium that lies downhill of `start`.

    Args:
        potential: cable, loads, constraints.
        start: (n, 2, dim) coordinates, not necessarily on the constraints.
        options: tolerances.
    """
    potential.turn_with(start)
    q, violation = feasible(potential, start, options.feasibility)
    if violation > 1e3 * options.feasibility:
        q, violation = feasible(potential, _bowed(potential, start), options.feasibility)
    if violation > 1e3 * options.feasibility:
        return Equilibrium(q, False, "the constraints cannot be met", np.inf, violation, 0, np.nan)
    multipliers = np.zeros(potential.jacobian(q).shape[0])
    shift = potential.largest_load / (potential.cable.section.mass_per_length * potential.cable.length**2)
    limit = options.tolerance * potential.largest_load
    message, eigenvalue, residual = "", np.nan, np.inf
    iterations = 0
    while iterations < options.iterations:
        iterations += 1
        potential.turn_with(q)
        direction, multipliers, slope = _step(potential, q, multipliers, shift)
        previous, residual = (
            residual,
            potential.size(potential.force(q) - potential.jacobian(q).T @ multipliers),
        )
        following = None
        is_stalled = -slope < RESOLUTION**2 * potential.largest_load * potential.cable.length
        if residual > limit and slope < 0.0 and not (is_stalled and residual > 0.5 * previous):
            following = _line_search(potential, q, direction, slope, options.feasibility)
        if following is None:
            eigenvalue, worst = smallest_eigenvalue(potential, q, multipliers)
            following = _escape(potential, q, worst, eigenvalue, options)
        if following is None:
            break
        q = following
        if np.abs(q).max() > LARGEST_EXCURSION * potential.cable.length:
            message = "the cable runs away: its loads are not balanced by anything that holds it"
            break
    converged = residual <= 1e3 * limit and eigenvalue > 0.0 and not message
    if not converged and not message:
        message = "no stable equilibrium within reach"
    violation = float(np.abs(potential.values(q)).max(initial=0.0))
    return Equilibrium(q, converged, message, residual, violation, iterations, eigenvalue)


def _escape(
    potential: Potential, q: Array, worst: Array, eigenvalue: float, options: StaticOptions
) -> Array | None:
    """A state with less energy beside an unstable equilibrium; None if it is stable."""
    if not eigenvalue < 0.0:
        return None
    direction = worst / max(float(np.abs(worst.reshape(q.shape)[:, 1]).max()), 1e-300)
    trials = []
    for size in (0.1, -0.1, 0.01, -0.01):
        trial, left = feasible(potential, q + size * direction.reshape(q.shape), options.feasibility)
        if left <= 1e3 * options.feasibility:
            trials.append((potential.energy(trial), trial))
    energy, best = min(trials, key=lambda pair: pair[0], default=(np.inf, q))
    return best if energy < potential.energy(q) else None
