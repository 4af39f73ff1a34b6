"""Sparse matrices in known places are those that SciPy puts together."""

import numpy as np
import pytest
from scipy.sparse import block_diag, coo_array, csr_array, random_array, vstack

from exudyn_inext.sparse import Pattern, block_diagonal, one_below_another

SHAPES = [(3, 5), (0, 4), (4, 2)]


def some(shape, seed):
    return csr_array(random_array(shape, density=0.5, rng=np.random.default_rng(seed)))


@pytest.mark.parametrize("shape", [(4, 7), (0, 3)])
def test_entries_in_one_place_are_added(shape):
    random = np.random.default_rng(1)
    number = 50 if shape[0] else 0
    places = [random.integers(0, max(size, 1), number) for size in shape]
    pattern = Pattern(*places, shape)
    for _ in range(2):
        values = random.normal(size=number)
        np.testing.assert_allclose(
            pattern.matrix(values).toarray(), coo_array((values, places), shape).toarray(), atol=1e-14
        )


def test_blocks_are_put_beside_and_below_each_other():
    blocks = [some(shape, k) for k, shape in enumerate(SHAPES)]
    expected = block_diag(blocks).toarray()
    np.testing.assert_array_equal(block_diagonal(blocks).toarray(), expected)
    blocks = [some((number, 6), number) for number in (2, 0, 5)]
    np.testing.assert_array_equal(one_below_another(blocks).toarray(), vstack(blocks).toarray())
