"""Bodies: M a = F with a mass matrix of small blocks, some of which change with the configuration.

A body that turns by Euler parameters p keeps |p| = 1 itself, as a cable keeps its length: its block is
the solve on that constraint, c = (p . p - 1) / 2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ..arrays import Array
from ..compiled import inlined, kernel
from ..sparse import Entries
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .joints import respond_to_rows

_DENSE = 40  # coordinates up to which a dense product is the faster one
_MANY_PRODUCTS = 1_000_000  # from which on the zeros of forces are worth being left out


@dataclass(frozen=True, eq=False)
class MassBlock:
    """Coordinates whose accelerations are coupled by mass.   dofs: (k,).   mass: (k, k), regular."""

    dofs: np.ndarray
    mass: Array


class VariableBlocks:
    """B blocks of one size whose masses change with the configuration; their solve Z F + w b has p . a = b.

    Args:
        dofs: (B, k).   quaternion: (B,) first of the four Euler parameters in the block, or -1.
        reference: (B, 4) what their coordinates are displacements from.

    mass: (B, k, k) M now.   mass_before: (B, k, k) when its change was counted last.
    normal: (B, k) dc/dq.   inverse: (B, k, k) Z.   lever: (B, k) w.   target: (B,) b.
    drift_correction: (B,) what b lacked in the last step of a position-level scheme.
    """

    def __init__(self, dofs: np.ndarray, quaternion: np.ndarray, reference: Array) -> None:
        self.dofs, self.quaternion, self.reference = dofs, quaternion, reference
        self.mass, self.mass_before, self.inverse = np.zeros((3, *dofs.shape, dofs.shape[1]))
        self.normal, self.lever = np.zeros((2, *dofs.shape))
        self.target, self.drift_correction = np.zeros((2, len(dofs)))


class BodiesSystem:
    """The `system` of all bodies: joints are the coupling's.

    Args:
        size: number of coordinates.
        constant: blocks whose masses do not depend on the configuration, inverted once.
        variable: blocks whose masses `set_masses` gives at each evaluation.
        zeta: stabilisation rate of unit quaternions [1/s].

    bodies: (n,) first coordinate of the body of each coordinate.
    """

    def __init__(
        self,
        size: int,
        constant: Sequence[MassBlock],
        variable: Sequence[VariableBlocks] = (),
        zeta: float = 0.0,
    ) -> None:
        self._variable = variable
        self._size = size
        self.set_constant(constant)
        self.bodies = np.arange(size)
        for dofs in (*(block.dofs[None] for block in constant), *(blocks.dofs for blocks in variable)):
            self.bodies[dofs] = dofs.min(axis=1, keepdims=True)
        self.zeta = zeta
        self.has_quaternions = any((blocks.quaternion >= 0).any() for blocks in variable)

    def set_constant(self, blocks: Sequence[MassBlock]) -> None:
        """Blocks whose masses do not depend on the configuration."""
        inverse = [MassBlock(block.dofs, np.asarray(np.linalg.inv(block.mass), float)) for block in blocks]
        self._constant = _matrix_of_blocks(self._size, inverse)
        self._constant_mass = _matrix_of_blocks(self._size, blocks)
        self._entries = sum(block.mass.size for block in blocks) if self._size > _DENSE else 0

    def set_masses(self, stack: int, masses: Array, q: Array) -> None:
        """Masses (B, k, k), overwritten, of the variable blocks of one size in the configuration q (n,)."""
        s = self._variable[stack]
        s.mass[:] = masses
        _set_normals(s.dofs, s.quaternion, s.reference, q, s.normal)
        _invert(masses, s.normal, s.inverse, s.lever)

    def mass_at(self, first: int) -> Array:
        """(k, k) memory of the variable mass of a block, by the first of its coordinates."""
        found = ((s, b) for s in self._variable for b in np.flatnonzero(s.dofs[:, 0] == first))
        stack, block = next(found)
        return stack.mass[block]

    def kinetic_energy(self, v: Array) -> float:
        """v . M v / 2 [J] with the masses at present.   v: (n,)."""
        twice = float(v @ (self._constant_mass @ v))
        for s in self._variable:
            rates = v[s.dofs]
            twice += float(np.einsum("bi,bij,bj->", rates, s.mass, rates))
        return 0.5 * twice

    @property
    def mass_entries(self) -> Entries:
        """Those of the mass at present."""
        mass = self.mass
        if isinstance(mass, np.ndarray):
            rows, columns = mass.nonzero()
            return rows, columns, mass[rows, columns]
        entries = mass.tocoo()
        return entries.row, entries.col, entries.data

    @property
    def masses(self) -> Array:
        """(n,) diagonal of the mass at present."""
        return self.mass.diagonal()

    @property
    def mass(self) -> Any:
        """(n, n) at present, sparse if it is large."""
        blocks = [MassBlock(*one) for s in self._variable for one in zip(s.dofs, s.mass, strict=True)]
        return self._constant_mass + _matrix_of_blocks(self._size, blocks)

    def begin_changes(self) -> None:
        """Count changes from the masses at present on."""
        for s in self._variable:
            s.mass_before[:] = s.mass

    def count_changes(self, way: Array, total: Array) -> None:
        """Add way . dM way to `total` (1,), dM the changes of the masses since the last call.

        way: (n,) of the bodies meanwhile.
        """
        for s in self._variable:
            _count_changes(s.dofs, s.mass, s.mass_before, way, total)

    def masses_before(self) -> dict[str, Array]:
        """(B, k, k) since when changes are counted, for each size of blocks."""
        return {str(number): s.mass_before for number, s in enumerate(self._variable)}

    def solve(self, force: Array) -> Array:
        """Z F + w b with the targets b that are set.   force: (n,) [N, Nm]."""
        result: Array = self._constant @ force
        for s in self._variable:
            _apply(s.dofs, s.inverse, s.lever, s.target, force[np.newaxis], result[np.newaxis])
        return result

    def responses(self, forces: Array) -> Array:
        """Z F for rows F of forces (rows, n), each on few coordinates; Z is symmetric."""
        if self._entries * len(forces) < _MANY_PRODUCTS:
            result = np.ascontiguousarray((self._constant @ forces.T).T)
        else:
            result = (scipy.sparse.csr_array(forces) @ self._constant).toarray()
        for s in self._variable:
            _apply(s.dofs, s.inverse, s.lever, np.zeros_like(s.target), forces, result)
        return result

    def levered(self, size: int) -> Array:
        """w b (n,): what the targets alone ask for."""
        result = np.zeros(size)
        for s in self._variable:
            _lever(s.dofs, s.lever, s.target, result)
        return result

    def memory(self) -> dict[str, Array]:
        """What earlier steps taught: (B,) for each size of blocks."""
        return {str(number): s.drift_correction for number, s in enumerate(self._variable)}

    def share_drift_correction(self, first: np.ndarray, memory: Array) -> bool:
        """Keep what steps teach in this memory (B,) of bodies whose coordinates begin there.

        Returns:
            False if the first of them are not the quaternions, one block each.
        """
        stacks = [s for s in self._variable if (s.quaternion >= 0).any()]
        wanted = [s.dofs[:, 0] for s in stacks]
        number = sum(map(len, wanted))
        if not np.array_equal(np.concatenate([np.zeros(0), *wanted]), first[:number]):
            return False
        done = 0
        for s in stacks:
            own = memory[done : done + len(s.drift_correction)]
            own[:] = s.drift_correction
            s.drift_correction, done = own, done + len(own)
        return True

    def forget(self) -> None:
        """What earlier steps taught does not hold any more."""
        for drift_correction in self.memory().values():
            drift_correction[:] = 0.0

    def aim_at_accelerations(self, v: Array, zeta: float) -> None:
        """b = -v . v - zeta p . v: Eq. (27) of unit quaternions, and what earlier steps taught."""
        for s in self._variable:
            _aim_at_accelerations(s.dofs, s.quaternion, s.normal, v, zeta, s.target)
            s.target += s.drift_correction

    def aim_at_velocities(self, v: Array, zeta: float) -> None:
        """b = -zeta c - p . v leads to the manifold; zeta = 0 to that of the velocities."""
        for s in self._variable:
            _aim_at_velocities(s.dofs, s.normal, v, zeta, s.target)

    def violation(self, q: Array, learning: float) -> float:
        """Largest |c|; b = -c, which also teaches the next steps."""
        worst = 0.0
        for s in self._variable:
            _aim_at_positions(s.dofs, s.quaternion, s.reference, q, s.target)
            worst = float(np.maximum(worst, np.abs(s.target).max()))  # unlike max, keeps a NaN
            s.drift_correction += learning * s.target
        return worst


def _matrix_of_blocks(size: int, blocks: Sequence[MassBlock]) -> Any:
    if size <= _DENSE:
        dense: Array = np.zeros((size, size))
        for block in blocks:
            dense[block.dofs[:, None], block.dofs] = block.mass
        return dense
    rows = [np.repeat(block.dofs, len(block.dofs)) for block in blocks]
    columns = [np.tile(block.dofs, len(block.dofs)) for block in blocks]
    if not blocks:
        return scipy.sparse.csr_array((size, size))
    places = (np.concatenate(rows), np.concatenate(columns))
    return scipy.sparse.csr_array(
        (np.concatenate([block.mass.ravel() for block in blocks]), places), shape=(size, size)
    )


@kernel
def _count_changes(dofs, mass, before, way, total):
    """total += way . (M - M_before) way; M_before becomes M."""
    number, size = dofs.shape
    for b in range(number):
        for i in range(size):
            for j in range(size):
                change = mass[b, i, j] - before[b, i, j]
                total[0] += way[dofs[b, i]] * change * way[dofs[b, j]]
                before[b, i, j] = mass[b, i, j]


@kernel
def _aim_at_positions(dofs, quaternion, reference, q, target):
    """b = -(p . p - 1) / 2."""
    for b in range(len(dofs)):
        first, square = quaternion[b], 1.0
        if first >= 0:
            square = 0.0
            for i in range(4):
                square += (q[dofs[b, first + i]] + reference[b, i]) ** 2
        target[b] = 0.5 * (1.0 - square)


@kernel
def _set_normals(dofs, quaternion, reference, q, normal):
    """normal = p in the places of the quaternion, zero elsewhere."""
    for b in range(len(dofs)):
        first = quaternion[b]
        if first >= 0:
            for i in range(4):
                normal[b, first + i] = q[dofs[b, first + i]] + reference[b, i]


@kernel
def _invert(masses, normal, inverse, lever):
    """Z and w of each block.

    With p . a given, a term s p p^T in M changes no acceleration, and makes M regular.
    """
    for b in range(len(normal)):
        _add_normal(masses[b], normal[b])
        _gauss_jordan(masses[b], inverse[b])
        _constrain(normal[b], inverse[b], lever[b])


@inlined
def _add_normal(mass, normal):
    """M += s p p^T, s the mean of M's diagonal."""
    size, trace = len(normal), 0.0
    for i in range(size):
        trace += mass[i, i]
    for i in range(size):
        for j in range(size):
            mass[i, j] += trace / size * normal[i] * normal[j]


@inlined
def _gauss_jordan(matrix, inverse):
    """Inverse of a positive definite matrix, which becomes the identity."""
    size = len(matrix)
    for i in range(size):
        for j in range(size):
            inverse[i, j] = 1.0 if i == j else 0.0
    for p in range(size):
        pivot = 1.0 / matrix[p, p]
        for j in range(size):
            matrix[p, j] *= pivot
            inverse[p, j] *= pivot
        for i in range(size):
            if i != p:
                multiple = matrix[i, p]
                for j in range(size):
                    matrix[i, j] -= multiple * matrix[p, j]
                    inverse[i, j] -= multiple * inverse[p, j]


@inlined
def _constrain(normal, inverse, lever):
    """Z = M^-1 - w (p^T M^-1), w = M^-1 p / (p^T M^-1 p), in place of M^-1; nothing without p."""
    size, share = len(normal), 0.0
    for i in range(size):
        lever[i] = 0.0
        for j in range(size):
            lever[i] += inverse[i, j] * normal[j]
        share += normal[i] * lever[i]
    if share > 0.0:
        for i in range(size):
            for j in range(size):
                inverse[i, j] -= lever[i] * lever[j] / share
        for i in range(size):
            lever[i] /= share


@kernel
def _apply(dofs, inverse, lever, target, forces, results):
    """Z F + w b in the places of the blocks, for rows F."""
    number, size = dofs.shape
    for row in range(len(forces)):
        for b in range(number):
            for i in range(size):
                total = lever[b, i] * target[b]
                for j in range(size):
                    total += inverse[b, i, j] * forces[row, dofs[b, j]]
                results[row, dofs[b, i]] = total


@kernel
def _lever(dofs, lever, target, result):
    """result = w b in the places of the blocks."""
    number, size = dofs.shape
    for b in range(number):
        for i in range(size):
            result[dofs[b, i]] = lever[b, i] * target[b]


@kernel
def _aim_at_accelerations(dofs, quaternion, normal, v, zeta, target):
    for b in range(len(dofs)):
        square, rate = 0.0, 0.0
        first = quaternion[b]
        if first >= 0:
            for i in range(first, first + 4):
                speed = v[dofs[b, i]]
                square += speed * speed
                rate += normal[b, i] * speed
        target[b] = -square - zeta * rate


@kernel
def _aim_at_velocities(dofs, normal, v, zeta, target):
    for b in range(len(dofs)):
        square, rate = 0.0, 0.0
        for i in range(dofs.shape[1]):
            square += normal[b, i] * normal[b, i]
            rate += normal[b, i] * v[dofs[b, i]]
        value = 0.5 * (square - 1.0) if square > 0.0 else 0.0
        target[b] = -zeta * value - rate


@index_reduced_rates.register(BodiesSystem)
def bodies_rates(system, external, q, v, acceleration, rate):
    system.aim_at_accelerations(v, system.zeta)
    acceleration[:] = system.solve(external)
    rate[:] = v
    if system.has_quaternions:
        system.aim_at_velocities(v, system.zeta)
        rate += system.levered(len(v))


@accelerate_and_project.register(BodiesSystem)
def accelerate_bodies(system, external, q, v, duration, acceleration, end_velocity):
    system.aim_at_accelerations(v, 0.0)
    acceleration[:] = system.solve(external)
    end_velocity[:] = v + duration * acceleration
    if system.has_quaternions:
        system.aim_at_velocities(end_velocity, 0.0)
        end_velocity += system.levered(len(v))


@correct_position.register(BodiesSystem)
def correct_bodies(system, external, q, tolerance, learning, correction):
    worst = system.violation(q, learning)
    if not worst < tolerance:
        correction[:] = system.levered(len(q))
    return worst


@respond_to_rows.register(BodiesSystem)
def respond_as_bodies(system, first, width, dof, jacobian, response):
    """Arguments: see `respond_to_rows`; each row is on all coordinates."""
    if len(first):
        places = slice(first[0], first[-1] + width[-1])
        response[places] = system.responses(jacobian[places].reshape(len(first), -1)).ravel()
