"""User functions of many loads that are asked together."""

import numpy as np
import pytest

from exudyn_inext.errors import SceneError
from exudyn_inext.loads.nodal import LoadFunction
from exudyn_inext.run.load_functions import Asked, LoadFunctions

TIMES = [0.0, 0.5, 1.0]


def asked(function, value=0.0, scale=1.0, number=1, is_pure=True):
    return Asked(LoadFunction(function, None, value, scale), number, "load 7", is_pure)


def counting():
    calls = []
    return calls, lambda mbs, t, value: calls.append(t) or value + t


@pytest.mark.parametrize("is_pure", [True, False])
def test_a_function_that_loads_share_is_called_once_a_time_if_time_alone_decides(is_pure):
    calls, function = counting()
    loads = LoadFunctions([asked(function, 2.0, scale, is_pure=is_pure) for scale in (1.0, 3.0)])
    assert np.array_equal(loads.values(TIMES), [[2.0, 6.0], [2.5, 7.5], [3.0, 9.0]])
    assert len(calls) == len(TIMES) * (1 if is_pure else 2)


def test_loads_of_other_values_share_no_call():
    _, function = counting()
    loads = LoadFunctions([asked(function, value) for value in (1.0, 2.0)])
    assert np.array_equal(loads.values([0.5]), [[1.5, 2.5]])


def test_vectors_numbers_and_jumps_stand_beside_each_other():
    loads = LoadFunctions(
        [
            asked(lambda mbs, t, value: [t, 0, value[2]], (0.0, 0.0, 5.0), number=3),
            asked(lambda mbs, t, value: t > 0.5),
            asked(lambda mbs, t, value: [2 * t]),
        ]
    )
    assert np.array_equal(loads.values([0.5, 1.0]), [[0.5, 0, 5, 0, 1], [1, 0, 5, 1, 2]])


@pytest.mark.parametrize("wrong", [np.nan, "much", None, [1.0, 2.0], 1j])
def test_the_first_time_without_numbers_is_named(wrong):
    one, other = (lambda mbs, t, value: t), (lambda mbs, t, value: wrong if t > 0.2 else t)
    with pytest.raises(SceneError, match=r"load 7 returned .* at t = 0.5 s: must return 1 finite number"):
        LoadFunctions([asked(one), asked(other)]).values(TIMES)
