"""Copies of records, and places as slices."""

import numpy as np
import pytest

from exudyn_inext.arrays import as_slice, copies_of, copy_of, record_type

KIND = record_type([("x", float, (2, 3)), ("k", np.int64)])


def some(shape):
    records = np.zeros(shape, KIND)
    records["x"], records["k"] = 1.5, 7
    return records


@pytest.mark.parametrize("array", [some(3), some((2, 2)), some(0), some(6)[::2], np.eye(3)])
def test_a_copy_is_the_same_in_memory_of_its_own(array):
    copy = copy_of(array)
    assert copy.dtype == array.dtype and copy.shape == array.shape and copy.tobytes() == array.tobytes()
    assert copy.flags.c_contiguous and copy.flags.writeable and copy.flags.aligned
    assert not np.shares_memory(copy, array)


def test_records_are_made_one_by_one():
    make = copies_of(some(1)[0])
    one, other = make(), make()
    one["x"], one["k"] = 0.0, 0
    assert other["k"] == 7 and (other["x"] == 1.5).all()


@pytest.mark.parametrize("places, expected", [([3, 4], slice(3, 5)), ([7], slice(7, 8)), ([3, 5, 4], None)])
def test_places_that_follow_each_other_are_a_slice(places, expected):
    places = np.array(places)
    found = as_slice(places)
    assert found is places if expected is None else found == expected
