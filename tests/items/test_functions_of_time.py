"""Which user functions depend on the time alone."""

import math

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import MarkerNodePosition, NodePoint, SensorUserFunction
from exudyn.utilities import SmoothStep

from exudyn_inext.items.functions_of_time import functions_at_rest, is_of_time_alone, take_word

AMPLITUDE, TABLE, TARGET = 2.0, np.linspace(0.0, 1.0, 5), {"mbs": exudyn}
COUNT, MEMORY, WANTED = 2.0, np.zeros(3), {"force": 0.0}


def sine(mbs, t, load):
    return [AMPLITUDE * math.sin(t), 0, load[2]]


def from_a_table(mbs, t, load):
    values = [AMPLITUDE * value for value in TABLE]
    return [np.interp(t, TABLE, values) + in_an_array(None, t, load)[0], 0, 0]


def in_an_array(mbs, t, load):
    force = np.zeros(3)
    force[0] = sine(mbs=None, t=t, load=load)[0]
    return force.tolist()


def stepwise(mbs, t, load):
    return [SmoothStep(t, 0.0, 1.0, 0.0, 5.0), 0, 0]


def following(mbs, t, load):
    return [mbs.GetNodeOutput(0, exudyn.OutputVariableType.Position)[0], 0, 0]


def asking_within(mbs, t, load):
    return [value(mbs) for value in (str, str, str)]


def through_a_global(_, t, load):
    return [exudyn.sys["force"], 0, 0]


def of_a_dict(_, t, load):
    return [TARGET["mbs"].sys["force"], 0, 0]


def random(mbs, t, load):
    return [np.random.rand(), 0, 0]


def importing(mbs, t, load):
    import time

    return [time.time(), 0, 0]


def counting(mbs, t, load):
    global COUNT
    COUNT += 1.0
    return [COUNT, 0, 0]


def of_a_count(mbs, t, load):
    return [COUNT, 0, 0]


def remembering(mbs, t, load):
    MEMORY[0] = t
    return [MEMORY[1], 0, 0]


def when_a_key_is_pressed(key, action, mods):
    WANTED["force"] = 5.0


def as_wanted(mbs, t, load):
    return [WANTED["force"], 0, 0]


def caller_of_one(mbs, t, load):
    return following(None, t, load)


def closure(given):
    return lambda mbs, t, load: [given * t, 0, 0]


def memory():
    count = 0

    def function(mbs, t, load):
        nonlocal count
        count += 1
        return [count, 0, 0]

    return function


PURE = [sine, from_a_table, in_an_array, stepwise, closure(3.0)]
OTHERS = [
    following,
    asking_within,
    through_a_global,
    of_a_dict,
    random,
    importing,
    counting,
    of_a_count,
    remembering,
    as_wanted,
    memory(),
    closure(exudyn),
    math.sin,
    None,
]


@pytest.fixture
def mbs():
    return exudyn.SystemContainer().AddSystem()


def as_given(function):
    return {"function": function}


@pytest.mark.parametrize("function", PURE)
def test_functions_of_the_time(mbs, function):
    assert is_of_time_alone(mbs, as_given(function))


@pytest.mark.parametrize("function", OTHERS)
def test_functions_that_may_depend_on_more(mbs, function):
    assert not is_of_time_alone(mbs, as_given(function))


def test_no_function(mbs):
    assert not is_of_time_alone(mbs, 0)


@pytest.mark.parametrize("said", [True, False])
def test_what_settings_say_of_all_functions_counts(mbs, said):
    take_word(mbs, said)
    assert is_of_time_alone(mbs, as_given(sine)) is said
    assert is_of_time_alone(mbs, as_given(OTHERS[0])) is said
    take_word(mbs, None)
    assert is_of_time_alone(mbs, as_given(sine)) and not is_of_time_alone(mbs, as_given(OTHERS[0]))


def test_settings_say_it_of_single_functions_and_methods(mbs):
    table = Table()
    take_word(mbs, [table.force, OTHERS[0]])
    assert is_of_time_alone(mbs, as_given(table.force)) and is_of_time_alone(mbs, as_given(OTHERS[0]))
    assert not is_of_time_alone(mbs, as_given(Table().force))
    assert not is_of_time_alone(exudyn.SystemContainer().AddSystem(), as_given(table.force))


class Table:
    def force(self, mbs, t, load):
        return [t, 0, 0]


@pytest.mark.parametrize("declared", [True, False])
def test_the_attribute_of_earlier_releases_counts_and_is_deprecated(mbs, declared):
    function = closure(2.0)
    function.dependsOnTimeOnly = declared
    with pytest.warns(DeprecationWarning, match=r"ExplicitSettings\(dependsOnTimeOnly=") as said:
        assert is_of_time_alone(mbs, as_given(function)) is declared
    assert said[0].filename == __file__


def test_sensors_with_functions_may_change_what_others_read(mbs):
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=mbs.AddNode(NodePoint())))
    assert marker is not None
    mbs.AddSensor(
        SensorUserFunction(
            sensorNumbers=[], sensorUserFunction=lambda mbs, t, s, f, c: [t], storeInternal=True
        )
    )
    assert not is_of_time_alone(mbs, as_given(sine))


def steered(stores):
    """A function of a list around it, which a step function stores into, or reads."""
    values = [0.0]

    def function(mbs, t, load):
        return [values[0], 0, 0]

    def store(mbs, t):
        values[0] = t
        return True

    def read(mbs, t):
        return values[0] >= 0.0

    return function, store if stores else read


@pytest.mark.parametrize("stores", [True, False])
def test_a_function_that_step_functions_steer_is_none(stores):
    mbs = exudyn.SystemContainer().AddSystem()
    function, between = steered(stores)
    assert is_of_time_alone(mbs, {"function": function})
    mbs.SetPreStepUserFunction(between)
    assert is_of_time_alone(mbs, {"function": function}) is not stores


def test_what_a_function_reads_is_looked_at_again_once_it_may_have_changed(mbs):
    given = 3.0

    def function(mbs, t, load):
        return [given, 0, 0]

    with functions_at_rest(mbs):
        assert is_of_time_alone(mbs, as_given(function))
    given = exudyn
    assert not is_of_time_alone(mbs, as_given(function))
    with functions_at_rest(mbs):
        assert not is_of_time_alone(mbs, as_given(function))


def test_functions_of_one_code_are_judged_by_what_each_reads(mbs):
    with functions_at_rest(mbs):
        of_time = [
            is_of_time_alone(mbs, as_given(closure(given))) for given in (1.0, exudyn, sine, following)
        ]
    assert of_time == [True, False, True, False]
