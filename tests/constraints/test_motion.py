"""Motions of anchors: derivatives that are given or found by differences, and jumps that are refused."""

import numpy as np
import pytest

from exudyn_inext.constraints.motion import (
    differences,
    find_jump,
    jump_of_velocity,
    many_differences,
    motion_of,
    require_smooth,
)
from exudyn_inext.errors import InputError

pytestmark = pytest.mark.kernel

T = 0.7


def p(t):
    return [np.sin(3.0 * t), t**3]


def p_t(t):
    return [3.0 * np.cos(3.0 * t), 3.0 * t**2]


def p_tt(t):
    return [-9.0 * np.sin(3.0 * t), 6.0 * t]


@pytest.mark.parametrize(
    ("given", "accuracy"),
    [((p, p_t, p_tt), 1e-15), ((p, p_t), 1e-7), ((p,), 1e-6), ((p, None, p_tt), 1e-6)],
    ids=["all", "velocity", "position", "acceleration"],
)
def test_motion_has_the_derivatives_of_its_position(given, accuracy):
    motion = motion_of(*given)
    np.testing.assert_allclose(motion.at(T), [p(T), p_t(T), p_tt(T)], rtol=accuracy, atol=accuracy)
    assert not motion.rests and motion.is_pure
    require_smooth(motion, T, "motion")


def test_a_single_coordinate_moves_as_a_vector_of_one():
    motion = motion_of(lambda t: 2.0 * t, is_pure=False)
    np.testing.assert_allclose(motion.at(T), [[1.4], [2.0], [0.0]], atol=1e-7)
    assert not motion.is_pure


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((lambda t: [abs(t - T)],), "velocity"),
        ((lambda t: [(t - T) * abs(t - T)],), "acceleration"),
        ((p, lambda t: [1.0, 1.0]), "the given velocity at t = 0.7 s is .* correct it, or leave it out"),
        ((p, p_t, lambda t: [1.0, 1.0]), "the given acceleration at t = 0.7 s is .* leave it out"),
        ((lambda t: [np.nan, 0.0],), "is not finite at t = 0.7 s"),
    ],
    ids=["kink", "jump of the acceleration", "wrong velocity", "wrong acceleration", "no number"],
)
def test_motions_without_the_stated_derivatives_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        require_smooth(motion_of(*given), T, "the hanger")


@pytest.mark.parametrize("outside", ["rests", "is not defined", "raises"])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_motion_that_begins_or_ends_has_the_derivatives_of_its_own_side(side, outside):
    def position(t):
        if side * (t - T) >= 0.0:
            return p(t)
        if outside == "raises":
            raise ValueError("beyond the table")
        return p(T) if outside == "rests" else [np.nan, 0.0]

    motion = motion_of(position)
    np.testing.assert_allclose(motion.at(T)[:2], [p(T), p_t(T)], atol=1e-6)
    np.testing.assert_allclose(motion.at(T)[2], p_tt(T), atol=1e-2)
    if side > 0.0:
        require_smooth(motion, T, "motion")


def test_an_error_at_the_time_itself_is_that_of_the_function():
    with pytest.raises(ZeroDivisionError):
        motion_of(lambda t: [1.0 / (t - T)]).at(T)


def test_a_table_that_begins_flat_may_end_where_the_run_begins():
    motion = motion_of(lambda t: [0.0 if t >= T else np.nan, 1.0])
    np.testing.assert_array_equal(motion.at(T), [[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]])


@pytest.mark.parametrize(("position", "jump"), [(lambda t: [0.3 * abs(t - T), t], 0.6), (p, 0.0)])
def test_a_jump_of_the_velocity_is_seen_nearby(position, jump):
    for t in (T - 1e-4, T, T + 1e-4):
        assert jump_of_velocity(motion_of(position), t) == pytest.approx(jump, rel=1e-6)


@pytest.mark.parametrize("duration", [0.3, 0.1, 0.05])
@pytest.mark.parametrize("rests_before", [False, True])
@pytest.mark.parametrize(
    ("ramp", "acceleration"),
    [(lambda x: x**3 * (10 - 15 * x + 6 * x**2), 0.0), (lambda x: x**2 * (3 - 2 * x), 6.0)],
)
def test_a_quick_ramp_has_its_derivatives_where_it_begins(duration, rests_before, ramp, acceleration):
    def position(t):
        x = min(t / duration, 1.0)
        return [0.3 * ramp(max(x, 0.0) if rests_before else x), 2.5]

    motion = motion_of(position)
    assert np.abs(motion.at(0.0)[1]).max() < 1e-7  # the limit of initial velocities is 1e-6
    np.testing.assert_allclose(motion.at(0.0)[2], [0.3 * acceleration / duration**2, 0.0], atol=5e-3)
    require_smooth(motion, 0.0, "the ramp")


def test_a_jump_is_found_among_values_that_move_fast():
    def values(t):
        return np.array([200.0 * t, 0.1 * (t > T) + t, np.sin(300.0 * t)])

    jump = find_jump(values, T - 3e-4, T + 4e-4)
    assert jump.number == 1 and jump.time == pytest.approx(T, abs=1e-8) and jump.size == pytest.approx(0.1)
    assert find_jump(values, T + 1e-6, T + 4e-4) is None


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_a_steep_ramp_is_no_jump_in_metres_nor_in_millimetres(unit):
    def values(t):
        return np.array([5e-3 * unit * min(max((t - T) / 1e-4, 0.0), 1.0)])

    assert find_jump(values, T - 3e-4, T + 7e-4) is None


def test_a_jump_is_found_where_times_are_as_far_apart_as_it_is_long():
    """The search did not end."""
    late = 1e9
    jump = find_jump(lambda t: np.array([0.1 * (t > late)]), late - 3e-4, late + 4e-4)
    assert jump.size == 0.1 and jump.time == pytest.approx(late, abs=1e-6)


def test_a_run_may_begin_where_a_motion_ends_unless_its_velocity_jumps_there():
    require_smooth(motion_of(lambda t: [min(t - T, 0.0) ** 2, 2.5]), T, "the ramp")
    with pytest.raises(InputError, match=r"the ramp is not smooth at t = .* its velocity jumps by 0.3"):
        require_smooth(motion_of(lambda t: [0.3 * min(t - T, 0.0)]), T, "the ramp")


@pytest.mark.parametrize("side", [1.0, 0.0, -1.0])
def test_differences_are_exact_up_to_the_fourth_power_and_of_one_side_up_to_the_fifth(side):
    coefficients = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0 if side else 0.0]

    def position(t):
        is_there = side * (t - T) >= 0.0
        return [sum(c * t**k for k, c in enumerate(coefficients))] if is_there else [np.nan]

    _, velocity, acceleration = motion_of(position).at(T)
    assert velocity == pytest.approx(sum(k * c * T ** (k - 1) for k, c in enumerate(coefficients)), abs=1e-10)
    expected = sum(k * (k - 1) * c * T ** (k - 2) for k, c in enumerate(coefficients))
    assert acceleration == pytest.approx(expected, abs=1e-4 if side else 1e-6)


def ramp(t):
    return [max(t - 1.0, 0.0) ** 2, max(t - 1.0, 0.0)]


def until_one(t):
    if t > 1.0:
        raise ValueError("the table ends")
    return p(t)


@pytest.mark.parametrize("function", [p, ramp, until_one], ids=lambda one: one.__name__)
def test_differences_at_many_times_are_those_at_each(function):
    times = [0.3, 1.0, 1.0 + 1e-5, 1.4] if function is not until_one else [0.3, 1.0 - 1e-5, 1.0]
    found = many_differences(function, times, np.square)
    expected = [differences(lambda t: np.square(function(t)), t) for t in times]
    np.testing.assert_allclose(found, expected, atol=1e-7)


@pytest.mark.parametrize("given", [(), (p_t,), (p_t, p_tt), (None, p_tt)])
def test_a_motion_at_many_times_is_that_at_each(given):
    motion, times = motion_of(p, *given), [0.3, 1.0, 1.4]
    expected = [[one(t) for one in (p, p_t, p_tt)] for t in times]
    np.testing.assert_allclose(motion.sample(times), expected, atol=1e-6)
    np.testing.assert_array_equal(motion.sample(times), [motion.at(t) for t in times])
