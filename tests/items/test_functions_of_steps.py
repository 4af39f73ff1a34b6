"""Which offset functions step functions may steer: within a step, these depend on the time alone."""

from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    Force,
    MarkerNodePosition,
    NodePoint,
    ObjectConnectorCoordinate,
    SensorNode,
    SensorUserFunction,
)

from exudyn_inext.items.functions_of_time import take_word
from exudyn_inext.items.functions_that_look import FunctionsOfSteps

POSITION = exudyn.OutputVariableType.Position
CONTROLLER = SimpleNamespace(place=0.5, log=[])


class Motor:
    """A controller of a user."""

    def __init__(self):
        self.place, self.calls = 0.0, 0

    def offset(self, mbs, t, i, offset):
        return self.place + np.sin(t)

    def counted(self, mbs, t, i, offset):
        self.calls += 1
        return self.place


def logged(mbs, t, i, offset):
    CONTROLLER.log.append(t)
    return CONTROLLER.place


STEERED = [
    lambda mbs, t, i, offset: mbs.variables["x"],
    lambda mbs, t, i, offset: [CONTROLLER.place * t, offset, 0, 0, 0, 0],
    lambda mbs, t, i, offset: mbs.GetObjectParameter(0, "offset"),
    Motor().offset,
]
NOT_STEERED = [
    lambda mbs, t, i, offset: mbs.variables["x"] + mbs.GetSensorValues(0)[0],
    lambda mbs, t, i, offset: mbs.GetNodeOutput(0, POSITION)[0],
    lambda mbs, t, i, offset: mbs.systemData.GetTime(),
    lambda mbs, t, i, offset: getattr(mbs, "GetSensor" + "Values")(0)[0],
    Motor().counted,
    logged,
]


def place_is_set(mbs, t, load):
    mbs.variables["x"] = t
    return load


def place_is_read(mbs, t, load):
    return [mbs.GetSensorValues(0)[0] + mbs.variables["x"], 0, 0]


def is_steered(mbs, offset, load=0):
    """Of a constraint on a node, on which a load acts."""
    node = mbs.AddNode(NodePoint())
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(Force(markerNumber=marker, loadVectorUserFunction=load))
    mbs.AddSensor(SensorNode(nodeNumber=node, outputVariableType=POSITION))
    mbs.variables["x"] = 0.0
    joint = ObjectConnectorCoordinate(markerNumbers=[marker, marker], offsetUserFunction=offset)
    return mbs.GetObject(mbs.AddObject(joint))["offsetUserFunction"] in FunctionsOfSteps(mbs)


@pytest.mark.parametrize("function", STEERED)
def test_what_step_functions_set_may_be_read(mbs, function):
    assert is_steered(mbs, function, place_is_read)


@pytest.mark.parametrize("function", NOT_STEERED)
def test_the_state_may_not_be_read_nor_anything_stored(mbs, function):
    assert not is_steered(mbs, function)


def test_no_other_function_may_store_within_steps(mbs):
    assert not is_steered(mbs, STEERED[0], place_is_set)


def test_no_sensor_may_call_a_function(mbs):
    mbs.AddSensor(SensorUserFunction(sensorUserFunction=lambda mbs, t, sensors, factors, settings: [t]))
    assert not is_steered(mbs, STEERED[0])


def test_users_may_say_that_none_is_of_time_alone(mbs):
    take_word(mbs, False)
    assert not is_steered(mbs, STEERED[0])
