"""Row operations against the same in NumPy, with the compiler and without it."""

import numpy as np
import pytest
from numba.core.errors import TypingError

from exudyn_inext.compiled import kernel
from exudyn_inext.rows import set_multiple, subtract_multiple

pytestmark = pytest.mark.kernel
LENGTHS = range(1, 13)


@kernel
def combine(places, rows, factor):
    """rows[0] -= factor rows[1]; rows[2] = factor rows[1]."""
    subtract_multiple(places, rows[0], factor, rows[1])
    set_multiple(places, rows[2], factor, rows[1])


@pytest.mark.parametrize("length", LENGTHS)
def test_rows_of_any_length_and_nothing_beside_them(length):
    rows = np.random.default_rng(length).standard_normal((3, length + 2))
    expected = rows.copy()
    expected[0, :length] -= 0.7 * rows[1, :length]
    expected[2, :length] = 0.7 * rows[1, :length]
    combine((0,) * length, rows, 0.7)
    np.testing.assert_allclose(rows, expected, rtol=1e-14, atol=1e-15)


def test_rows_with_gaps_are_no_rows():
    columns = np.zeros((3, 3)).T

    @kernel
    def subtract(places, rows):
        subtract_multiple(places, rows[0], 1.0, rows[1])

    if hasattr(subtract, "py_func"):
        with pytest.raises(TypingError):
            subtract((0, 0, 0), columns)
