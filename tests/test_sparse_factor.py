"""L D L^T of sparse matrices against dense ones."""

import numpy as np
import pytest

from exudyn_inext.compiled import kernel
from exudyn_inext.sparse_factor import (
    build_factor,
    eliminate_column,
    find_order,
    places_of,
    substitute,
)

pytestmark = pytest.mark.kernel


@kernel
def solve(factor, x):
    """x = S^-1 x."""
    for j in range(len(x)):
        eliminate_column(factor, j)
    substitute(factor, x)


def random_pairs(random, number, density):
    one, other = np.tril_indices(number)
    kept = (one == other) | (random.random(len(one)) < density)
    return np.stack([other[kept], one[kept]], axis=1)


@pytest.mark.parametrize("number", [1, 2, 7, 12, 40])
@pytest.mark.parametrize("density", [0.0, 0.05, 0.3, 1.0])
def test_solutions_are_those_of_the_dense_matrix(number, density):
    """Positive definite on some unknowns, negative definite on the others, in any order."""
    random = np.random.default_rng(number)
    pairs = random_pairs(random, number, density)
    place = find_order(pairs, number)
    assert sorted(place) == list(range(number))
    factor = build_factor(place[pairs], number)
    signs = random.choice([-1.0, 1.0], number)
    dense = np.zeros((number, number))
    values = random.uniform(-1.0, 1.0, len(pairs))
    for (one, other), value in zip(place[pairs], values, strict=True):
        dense[one, other] = dense[other, one] = value
    same = np.outer(signs, signs) > 0.0
    dense += np.diag(signs * (1.0 + (np.abs(dense) * same).sum(axis=1)))
    columns, rows = np.sort(place[pairs], axis=1).T
    factor.values[places_of(factor, columns, rows)] = dense[rows, columns]
    x = random.uniform(-1.0, 1.0, number)
    expected = np.linalg.solve(dense, x)
    solve(factor, x)
    np.testing.assert_allclose(x, expected, rtol=1e-10, atol=1e-12)


def test_factors_of_one_pattern_have_memory_of_their_own():
    pairs = random_pairs(np.random.default_rng(3), 12, 0.3)
    one, other = build_factor(pairs, 12), build_factor(pairs, 12)
    one.values[:], one.sums[:] = 1.0, 1.0
    assert not other.values.any() and not other.sums.any() and len(other.values) == len(other.rows)


def test_a_tree_fills_nothing_and_a_star_is_eliminated_from_its_ends():
    number = 60
    star = np.array([[0, k] for k in range(1, number)] + [[k, k] for k in range(number)])
    factor = build_factor(find_order(star, number)[star], number)
    assert len(factor.values) == 2 * number - 1


def test_a_square_mesh_fills_less_than_its_band():
    side = 20
    cell = np.arange(side * side).reshape(side, side)
    along = np.stack([cell[:, :-1].ravel(), cell[:, 1:].ravel()], axis=1)
    across = np.stack([cell[:-1].ravel(), cell[1:].ravel()], axis=1)
    pairs = np.concatenate([along, across, np.stack([cell.ravel()] * 2, axis=1)])
    factor = build_factor(find_order(pairs, side * side)[pairs], side * side)
    assert len(factor.values) < 0.6 * side**3
