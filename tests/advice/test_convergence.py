"""Order and remaining error are those of the sequence that was made."""

import math

import pytest

from exudyn_inext.advice.survey import observed_order, remaining_error

MESHES = [(4, 6, 8), (8, 12, 16), (10, 20, 40), (5, 6, 50)]


def differences(numbers, order, sign=1.0):
    """|x_0 - x_1|, |x_1 - x_2| of x = 3 + sign 0.7 N^-p."""
    x = [3.0 + sign * 0.7 * n**-order for n in numbers]
    return abs(x[0] - x[1]), abs(x[1] - x[2])


@pytest.mark.parametrize("numbers", MESHES, ids=str)
@pytest.mark.parametrize("order", [0.7, 1.0, 2.0, 3.5, 6.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_order_and_error_are_those_of_the_sequence(numbers, order, sign):
    found = differences(numbers, order, sign)
    assert observed_order(numbers, found) == pytest.approx(order, rel=1e-6)
    left = remaining_error(numbers[1], numbers[2], found[1], order)
    assert left == pytest.approx(0.7 * numbers[2] ** -order, rel=1e-6)


def test_an_order_above_8_counts_as_8_and_one_below_a_half_is_no_convergence():
    assert observed_order((4, 6, 8), differences((4, 6, 8), 9.0)) == 8.0
    assert observed_order((4, 6, 8), differences((4, 6, 8), 0.4)) is None


@pytest.mark.parametrize("found", [(1.0, 2.0), (1.0, 1.0), (0.0, 1.0), (math.nan, 1.0), (1.0, math.nan)])
def test_differences_that_grow_or_are_no_numbers_are_no_convergence(found):
    assert observed_order((4, 8, 16), found) is None


def test_equal_solutions_have_no_error_left():
    assert observed_order((4, 8, 16), (1e-3, 0.0)) == 8.0 and remaining_error(8, 16, 0.0, 8.0) == 0.0


def test_a_higher_order_leaves_less_error():
    left = [remaining_error(12, 16, 1e-3, order) for order in (1.0, 2.0, 4.0)]
    assert left == sorted(left, reverse=True) and left[0] == pytest.approx(3e-3)
