"""Largest eigenvalues of operators."""

import numpy as np
import pytest

from exudyn_inext.scene import small_vibrations

SIZE = 12


def operator(values):
    """A symmetric operator with these eigenvalues, and a vector to start from."""
    rng, size = np.random.default_rng(3), len(values)
    turned, _ = np.linalg.qr(rng.standard_normal((size, size)))
    return lambda x: turned @ (values * (turned.T @ x)), rng.standard_normal(size)


@pytest.mark.parametrize("size", [1, 3, SIZE, 450])
def test_the_largest_eigenvalue_is_found(size):
    for values, expected in ((np.linspace(-3.0, 7.0, size), 7.0), (np.linspace(-3.0, -1.0, size), 0.0)):
        values[-1] = expected if size == 1 else values[-1]
        found = small_vibrations._largest_eigenvalue(*operator(values))
        assert found == pytest.approx(expected, rel=2 * small_vibrations.OF_DAMPING.residual)


@pytest.mark.parametrize("size", [SIZE, 60])
def test_the_largest_eigenvalue_is_found_where_vectors_are_not_orthogonal(size):
    """As those of accelerations are: masses of cables and bodies differ by orders of magnitude."""
    values = np.linspace(1.0, 5.0, size) ** 4
    apply, start = operator(values)
    scales = np.logspace(0.0, 3.0, size)
    found = small_vibrations._largest_eigenvalue(lambda x: scales * apply(x / scales), start)
    assert found == pytest.approx(625.0, rel=2 * small_vibrations.OF_DAMPING.residual)


def test_of_a_few_directions_that_are_stiff_all_are_found():
    """The iteration ends early where all that is left is round-off."""
    values = np.zeros(500)
    values[:3] = 1.0, 20.0, 5.0
    assert small_vibrations._largest_eigenvalue(*operator(values)) == pytest.approx(20.0, rel=1e-9)


@pytest.mark.parametrize("size", [3, SIZE, 450])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_not_nothing(size, bad):
    apply, start = operator(np.linspace(-3.0, 7.0, size))
    assert np.isnan(small_vibrations._largest_eigenvalue(lambda x: apply(x) * bad, start))
    start[1] = bad
    assert np.isnan(small_vibrations._largest_eigenvalue(apply, start))


def test_nothing_is_where_nothing_moves_and_where_nothing_resists():
    apply, start = operator(np.linspace(1.0, 7.0, SIZE))
    assert small_vibrations._largest_eigenvalue(apply, 0.0 * start) == 0.0
    assert small_vibrations._largest_eigenvalue(lambda x: 0.0 * x, start) == 0.0


def counted(apply):
    """The operator, and a list that grows with each of its calls."""
    calls = []

    def call(x):
        calls.append(x)
        return apply(x)

    return call, calls


@pytest.mark.parametrize("fastest", [101.0, 150.0])
def test_a_search_that_starts_from_an_earlier_one_is_short_and_finds_what_has_become_the_fastest(fastest):
    """The second operator is stiffer in a direction that was among the slower ones."""
    values = np.linspace(0.0, 100.0, 450)
    apply, start = operator(values)
    kept = np.zeros(len(start))
    first, long = counted(apply)
    assert small_vibrations._largest_eigenvalue(first, start, kept=kept) == pytest.approx(100.0, rel=2e-3)
    values[7] = fastest
    second, short = counted(apply)
    assert small_vibrations._largest_eigenvalue(second, start, kept=kept) == pytest.approx(fastest, rel=0.02)
    assert len(short) < 0.7 * len(long)
