"""Factors of [B J^T; J 0] solve what NumPy solves, and an order of elimination keeps those of nets small."""

import numpy as np
import pytest
from scipy.sparse import block_array, csr_array, diags_array, kron, random_array, vstack

from exudyn_inext.statics.saddle_point import FEW, factorise, order_of_elimination, solve


def grid(side):
    """Laplacian of side x side points, and rows that make pairs of them move alike."""
    line = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(side, side))
    unit = diags_array(np.ones(side))
    model = csr_array(kron(line, unit) + kron(unit, line))
    first = np.arange(0, side * side - 1, 2)
    rows = np.repeat(np.arange(len(first)), 2)
    places = rows, np.stack([first, first + 1], axis=1).ravel()
    return model, csr_array((np.tile([1.0, -1.0], len(first)), places), (len(first), side * side))


@pytest.mark.parametrize("side", [3, 20])
@pytest.mark.parametrize("is_ordered", [False, True])
def test_solutions_are_those_of_the_dense_matrix(side, is_ordered):
    model, jacobian = grid(side)
    assert (sum(jacobian.shape) > FEW) == (side == 20)
    force, target = np.random.default_rng(1).normal(size=(2, side * side))
    target = target[: jacobian.shape[0]]
    order = order_of_elimination(model, jacobian) if is_ordered else None
    found = solve(factorise(model, jacobian, order), force, target)
    matrix = block_array([[model, jacobian.T], [jacobian, None]]).toarray()
    expected = np.linalg.solve(matrix, np.append(force, target))
    np.testing.assert_allclose(np.concatenate(found), expected, atol=1e-11)


def test_indefinite_matrices_are_solved_to_round_off():
    model, jacobian = grid(20)
    random = np.random.default_rng(2)
    model = csr_array(model + diags_array(random.normal(size=400) * 10.0 ** random.uniform(-8, 1, 400)))
    jacobian = csr_array(vstack([jacobian, random_array((5, 400), density=0.02, rng=random)]))
    force, zero = random.normal(size=400), np.zeros(jacobian.shape[0])
    x, multipliers = solve(factorise(model, jacobian, order_of_elimination(model, jacobian)), force, zero)
    np.testing.assert_allclose(model @ x + jacobian.T @ multipliers, force, atol=1e-10)
    np.testing.assert_allclose(jacobian @ x, zero, atol=1e-10)


@pytest.mark.parametrize("side", [3, 20])
def test_constraints_that_depend_on_each_other_are_refused(side):
    model, jacobian = grid(side)
    with pytest.raises(RuntimeError, match="singular"):
        factorise(model, csr_array(vstack([jacobian, 0.0 * jacobian[[0]]])))


def test_the_order_of_a_net_leaves_few_entries():
    model, jacobian = grid(40)
    factors = [factorise(model, jacobian, order) for order in (None, order_of_elimination(model, jacobian))]
    as_they_are, ordered = (factor.lu.nnz for factor in factors)
    assert ordered < 0.6 * as_they_are
