"""Rows of joints that are too many are named all at once."""

import re

import numpy as np

from exudyn_inext.scene.redundant_rows import NOT_FINITE, dependent_rows


def test_what_is_left_of_many_rows_without_those_named_is_independent():
    """Seven of twelve equations are sums of others before them; five joints are named, and two counted."""
    rng = np.random.default_rng(3)
    jacobian = np.zeros((12, 9))
    jacobian[[0, 1, 3, 4, 8]] = rng.normal(size=(5, 9))
    jacobian[[2, 5, 6, 7, 9, 10, 11]] = rng.normal(size=(7, 5)) @ jacobian[[0, 1, 3, 4, 8]]
    jacobian[[6, 7]] = jacobian[[0, 1]] + jacobian[[1, 3]]  # of rows before them alone
    jacobian[[2, 5]] = jacobian[[0, 3]] - jacobian[[1, 4]]
    names = [f"'j{row // 2 if row < 4 else row}' (Joint), equation {row}," for row in range(12)]
    said = str(dependent_rows(np.tril(jacobian @ jacobian.T), names))
    assert re.findall(r"equations? ([\d, ]+),", said) == ["2", "5", "6", "7", "9"]
    assert "and 2 other joints are not independent" in said


def test_a_matrix_that_is_not_finite_names_nobody():
    assert str(dependent_rows(np.full((2, 2), np.nan), ["a", "b"])) == NOT_FINITE
