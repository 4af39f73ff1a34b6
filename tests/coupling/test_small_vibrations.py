"""Largest eigenvalues of operators, where the library's iteration ends well and where it does not."""

import numpy as np
import pytest
from scipy.sparse.linalg import ArpackError

from exudyn_inext.coupling import small_vibrations

SIZE = 12


def operator(values):
    """A symmetric operator with these eigenvalues, and a vector to start from."""
    rng = np.random.default_rng(3)
    turned, _ = np.linalg.qr(rng.standard_normal((SIZE, SIZE)))
    return lambda x: turned @ (values * (turned.T @ x)), rng.standard_normal(SIZE)


def refuse(*_, **__):
    raise ArpackError(3)


@pytest.mark.parametrize("fails", [False, True])
def test_the_largest_eigenvalue_is_found_if_the_iteration_fails_too(fails, monkeypatch):
    if fails:
        monkeypatch.setattr(small_vibrations, "eigs", refuse)
    for values, expected in ((np.linspace(-3.0, 7.0, SIZE), 7.0), (np.linspace(-3.0, -1.0, SIZE), 0.0)):
        found = small_vibrations._largest_eigenvalue(*operator(values))
        assert found == pytest.approx(expected, rel=small_vibrations.ACCURACY)
