"""Sparse Jacobians by differences: few rounds find all entries."""

import numpy as np
import pytest

from exudyn_inext.statics.joined_potential import rounds_of

SIZE = 40


def chain(length):
    return [np.array([k, k + 1, k + 2]) for k in range(length - 2)]


def scattered():
    random = np.random.default_rng(5)
    return [random.choice(SIZE, 4, replace=False) for _ in range(12)]


@pytest.mark.parametrize("first_shared", [SIZE, SIZE // 2])
@pytest.mark.parametrize("groups", [chain(SIZE), scattered(), [np.arange(SIZE)], []], ids=len)
def test_all_entries_of_what_the_items_do_are_found(groups, first_shared):
    """Each item adds the cube of the sum of its coordinates, times a number, to each of them."""
    factors = np.random.default_rng(1).uniform(1.0, 2.0, (len(groups), SIZE))

    def force(q):
        result = np.zeros(SIZE)
        for group, factor in zip(groups, factors, strict=True):
            result[group] += factor[group] * q[group].sum() ** 3
        return result

    q, expected, found = np.linspace(0.1, 1.0, SIZE), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for group, factor in zip(groups, factors, strict=True):
        expected[np.ix_(group, group)] += 3.0 * factor[group, np.newaxis] * q[group].sum() ** 2
    expected[first_shared:, :first_shared] = 0.0  # found by symmetry
    for one in rounds_of(groups, first_shared):
        step = np.zeros(SIZE)
        step[one.places] = 1e-5
        change = (force(q + step) - force(q - step)) / 2e-5
        found[one.rows, one.columns] += change[one.rows]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_the_number_of_rounds_does_not_grow_with_the_scene():
    assert len(rounds_of(chain(20), 20)) == len(rounds_of(chain(200), 200)) == 5


def test_a_wheel_that_all_elements_touch_adds_its_own_rounds_alone():
    wheel = [1000, 1001, 1002]
    for length in (20, 200):
        touching = [np.append(element, wheel) for element in chain(length)]
        assert len(rounds_of(touching, wheel[0])) == 5 + len(wheel)
