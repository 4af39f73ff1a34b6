"""What is taken from inside Numba: row operations against NumPy, and nothing of it elsewhere."""

import re
from importlib import metadata
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.errors import TypingError

import exudyn_inext
from exudyn_inext.compiled import kernel
from exudyn_inext.lowered import set_multiple, subtract_multiple

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


def test_only_one_module_takes_something_from_inside_numba():
    package = Path(exudyn_inext.__file__).parent
    inside = ("numba.core", "numba.np", "llvmlite", "_nrt", "._cache", "no_cpython_wrapper")
    found = {file.name for file in package.rglob("*.py") if any(name in file.read_text() for name in inside)}
    assert found == {"lowered.py"}


def test_numba_is_one_of_the_versions_that_are_allowed():
    """What is inside may change with every release: the next one is to be tried before it is allowed."""
    allowed = next(given for given in metadata.requires("exudyn_inext") if given.startswith("numba"))
    least, below = (int(re.search(sign + r"0\.(\d+)", allowed)[1]) for sign in (">=", "<"))
    assert least <= int(numba.__version__.split(".")[1]) < below
