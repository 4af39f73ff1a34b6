"""Bodies with Euler parameters: blocks that keep their quaternions at unit length, against a dense solve."""

import numpy as np
import pytest
from scipy.sparse import issparse

from exudyn_inext.scene.bodies import BodiesSystem, MassBlock, VariableBlocks
from exudyn_inext.scene.joints import respond_to_rows
from exudyn_inext.system import accelerate_and_project, correct_position, index_reduced_rates
from tests.cables import relative_error

pytestmark = pytest.mark.kernel

ZETA = 3.0
PLACES = np.array([[0, 2, 4, 6, 8, 10, 12], [1, 3, 5, 7, 9, 11, 13]])  # of two bodies, interleaved
FIRST = 3  # of the Euler parameters in a block
SIZE = 16


class Bodies:
    """Two rigid bodies and a mass block in random motion; quaternions are not quite of unit length."""

    def __init__(self, zeta=ZETA):
        rng = np.random.default_rng(5)
        roots = [rng.standard_normal((k, k)) for k in (7, 7, 2)]
        self.masses = [root @ root.T + np.eye(len(root)) for root in roots]
        self.reference = rng.standard_normal((2, 4))
        self.q, self.v, self.force = rng.standard_normal((3, SIZE))
        for places, reference in zip(PLACES, self.reference, strict=True):
            p = rng.standard_normal(4)
            self.q[places[FIRST:]] = 1.1 * p / np.linalg.norm(p) - reference
        self.system = BodiesSystem(
            SIZE,
            [MassBlock(np.array([14, 15]), self.masses[2])],
            [VariableBlocks(PLACES, np.array([FIRST, FIRST]), self.reference)],
            zeta,
        )
        self.evaluate()

    def evaluate(self):
        self.system.set_masses(0, np.stack(self.masses[:2]), self.q)

    def p(self):
        return [self.q[places[FIRST:]] + r for places, r in zip(PLACES, self.reference, strict=True)]

    def speeds(self):
        return [self.v[places[FIRST:]] for places in PLACES]

    def values(self):
        return np.array([0.5 * (p @ p - 1.0) for p in self.p()])

    def jacobian(self):
        rows = np.zeros((2, SIZE))
        for row, places, p in zip(rows, PLACES, self.p(), strict=True):
            row[places[FIRST:]] = p
        return rows

    def solve(self, force, target):
        """x of M x + C^T lam = force, C x = target."""
        mass = np.zeros((SIZE, SIZE))
        for places, block in zip([*PLACES, np.array([14, 15])], self.masses, strict=True):
            mass[np.ix_(places, places)] = block
        c = self.jacobian()
        matrix = np.block([[mass, c.T], [c, np.zeros((2, 2))]])
        return np.linalg.solve(matrix, np.concatenate([force, target]))[:SIZE]


def test_rates_are_those_of_the_dense_system():
    bodies = Bodies()
    a, rate = np.zeros(SIZE), np.zeros(SIZE)
    index_reduced_rates(bodies.system, bodies.force, bodies.q, bodies.v, a, rate)
    of_rate = bodies.jacobian() @ bodies.v
    gamma = -np.array([s @ s for s in bodies.speeds()])
    assert relative_error(a, bodies.solve(bodies.force, gamma - ZETA * of_rate)) < 1e-11
    correction = bodies.solve(np.zeros(SIZE), -ZETA * bodies.values() - of_rate)
    assert relative_error(rate, bodies.v + correction) < 1e-11


def test_changes_of_masses_are_counted_along_the_way():
    bodies, total = Bodies(), np.zeros(1)
    bodies.system.begin_changes()
    rng, expected = np.random.default_rng(7), 0.0
    for way in rng.standard_normal((3, SIZE)):
        before = [mass.copy() for mass in bodies.masses[:2]]
        for mass in bodies.masses[:2]:
            mass += 0.1 * np.diag(rng.random(7))
        bodies.evaluate()
        bodies.system.count_changes(way, total)
        for places, mass, old in zip(PLACES, bodies.masses, before, strict=False):
            expected += way[places] @ (mass - old) @ way[places]
    assert total[0] == pytest.approx(expected, rel=1e-12) and expected > 0.1
    bodies.system.count_changes(way, total)
    assert total[0] == pytest.approx(expected, rel=1e-12)


def test_projection_leads_to_velocities_that_keep_the_length():
    bodies, duration = Bodies(), 0.07
    a, end = np.zeros(SIZE), np.zeros(SIZE)
    accelerate_and_project(bodies.system, bodies.force, bodies.q, bodies.v, duration, a, end)
    expected = bodies.solve(bodies.force, -np.array([s @ s for s in bodies.speeds()]))
    assert relative_error(a, expected) < 1e-11
    free = bodies.v + duration * expected
    expected = free + bodies.solve(np.zeros(SIZE), -bodies.jacobian() @ free)
    assert relative_error(end, expected) < 1e-11


def test_position_correction_and_what_it_teaches():
    bodies, learning = Bodies(), 200.0
    correction = np.full(SIZE, 7.0)
    worst = correct_position(bodies.system, bodies.force, bodies.q, 1.0, 0.0, correction)
    assert worst == pytest.approx(np.abs(bodies.values()).max(), rel=1e-12)
    assert (correction == 7.0).all()
    worst = correct_position(bodies.system, bodies.force, bodies.q, 1e-12, learning, correction)
    assert relative_error(correction, bodies.solve(np.zeros(SIZE), -bodies.values())) < 1e-11
    gamma = -np.array([s @ s for s in bodies.speeds()])
    for lacked in (-learning * bodies.values(), np.zeros(2)):
        a, end = np.zeros(SIZE), np.zeros(SIZE)
        accelerate_and_project(bodies.system, bodies.force, bodies.q, bodies.v, 0.0, a, end)
        assert relative_error(a, bodies.solve(bodies.force, gamma + lacked)) < 1e-11
        bodies.system.forget()


def test_a_quaternion_that_is_no_number_is_seen():
    bodies = Bodies()
    bodies.q[PLACES[1, FIRST]] = np.nan
    worst = correct_position(bodies.system, bodies.force, bodies.q, 1e-12, 0.0, np.zeros(SIZE))
    assert np.isnan(worst)


def test_response_to_joint_forces_is_that_of_the_dense_system():
    bodies = Bodies()
    rows = np.random.default_rng(6).standard_normal((3, SIZE))
    response = np.zeros((3, SIZE))
    first, width = SIZE * np.arange(3), np.full(3, SIZE)
    respond_to_rows(bodies.system, first, width, 0 * first, rows.ravel(), response.reshape(-1))
    for row, found in zip(rows, response, strict=True):
        assert relative_error(found, bodies.solve(row, np.zeros(2))) < 1e-11


@pytest.mark.parametrize("size", [3, 60])
def test_constant_blocks_are_inverted_in_few_and_in_many_coordinates(size):
    mass, force = np.array([[3.0, 1.0], [1.0, 2.0]]), np.arange(1.0, size + 1.0)
    system = BodiesSystem(size, [MassBlock(np.array([0, size - 1]), mass)])
    expected = np.zeros(size)
    expected[[0, -1]] = np.linalg.solve(mass, force[[0, -1]])
    np.testing.assert_allclose(system.solve(force), expected, rtol=1e-14)
    np.testing.assert_allclose(system.responses(np.stack([force, 2 * force]))[1], 2 * expected, rtol=1e-14)
    assert issparse(system._constant) == (size == 60)
    assert not BodiesSystem(size, []).solve(force).any()


@pytest.mark.parametrize("rows", [3, 300])
def test_responses_of_a_mesh_are_those_of_its_dense_inverse(rows):
    random = np.random.default_rng(5)
    factor = random.normal(size=(60, 60))
    mass = factor @ factor.T + np.eye(60)
    system = BodiesSystem(60, [MassBlock(np.arange(60), mass)])
    forces = np.zeros((rows, 60))
    forces[np.arange(rows), np.arange(rows) % 60] = random.normal(size=rows)
    forces[:, 7] += 1.0
    response = system.responses(forces)
    np.testing.assert_allclose(response, np.linalg.solve(mass, forces.T).T, atol=1e-12)
    assert response.flags.c_contiguous
