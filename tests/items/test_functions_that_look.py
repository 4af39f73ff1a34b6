"""Which functions may look at accelerations and forces of constraints, as far as their code shows."""

from collections import deque
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import SensorBody, SensorUserFunction

from exudyn_inext.items.functions_that_look import Look, look_of

POSITION, ACCELERATION = exudyn.OutputVariableType.Position, exudyn.OutputVariableType.Acceleration
MBS = exudyn.SystemContainer().AddSystem()
bound = MBS.GetNodeOutput


class Controller:
    """Of a load, by a sensor; looks at no force."""

    gain = 2.0

    def __init__(self):
        self.mbs, self.sum, self.log = MBS, 0.0, []
        self.start = MBS.GetObjectOutput  # never used

    @property
    def target(self):
        return np.array([self.gain, 0, 0])

    @staticmethod
    def limited(force):
        return max(-1.0, min(1.0, force))

    def error(self, mbs):
        return mbs.GetSensorValues(0) - self.target

    def step(self, mbs, t):
        error = self.error(mbs)
        self.sum += error[0]
        self.log.append(error)
        self.mbs.SetLoadParameter(0, "loadVector", [self.limited(-self.sum), 0, 0])
        return True


class Called(Controller):
    def __call__(self, mbs, t):
        return self.step(mbs, t)


@dataclass
class Proportional:
    gain: float

    def __call__(self, mbs, t):
        return mbs.SetLoadParameter(0, "load", self.gain * mbs.GetSensorValues(0))


class OfForce(Controller):
    def error(self, mbs):
        return mbs.GetObjectOutput(0, exudyn.OutputVariableType.Force)


class OfAcceleration(Controller):
    @property
    def target(self):
        return self.mbs.systemData.GetODE2Coordinates_tt()


class OfStoredMethod(Controller):
    def error(self, mbs):
        return self.start(0, POSITION)


class OfSameName(Controller):
    def GetObjectOutput(self):
        return 0.0

    def error(self, mbs):
        return mbs.GetObjectOutput(0, ACCELERATION)


class OfAnyName(Controller):
    def __getattr__(self, name):
        return getattr(MBS, name)


class OfAnIndex(Controller):
    def __getitem__(self, k):
        return MBS.GetObjectOutput(k, ACCELERATION)

    def error(self, mbs):
        return self[0]


class OfAType(Controller):
    kind = exudyn.OutputVariableType.Acceleration

    def error(self, mbs):
        return mbs.GetNodeOutput(0, self.kind)


class OfItsDictionary(Controller):
    def error(self, mbs):
        return self.__dict__["start"](0, POSITION)


class Listed(list):
    def __getitem__(self, k):
        return MBS.GetObjectOutput(k, ACCELERATION)


def by(controller, gain, mbs, t):
    return controller.step(mbs, gain * t)


numbers, queue, listed = [1, 2.0, np.zeros(3)], deque([bound]), Listed([0])
pair, looking, around = (
    (Controller(), Called()),
    OfForce(),
    SimpleNamespace(controller=Controller(), gain=1.0),
)
MBS.variables["controller"] = around.controller


def position(mbs, t):
    return mbs.GetNodeOutput(0, POSITION)[0] + mbs.GetSensorValues(0)[1]


def acceleration(mbs, t):
    return mbs.GetNodeOutput(0, ACCELERATION)


def sets(mbs, t):
    mbs.SetLoadParameter(0, "loadVector", [np.sin(t) * numbers[0] - position(mbs, t), 0, 0])
    return True


CONTROLLERS = [
    Controller().step,
    Called(),
    Proportional(2.0),
    partial(by, Controller(), 2.0),
    lambda mbs, t: around.controller.step(mbs, around.gain * t),
    lambda mbs, t, controllers=pair: [one.step(mbs, t) for one in controllers],
    lambda mbs, t: mbs.variables["controller"].step(mbs, t),
]
BLIND = [
    lambda mbs, t: True,
    position,
    sets,
    lambda mbs, t: MBS.systemData.GetODE2Coordinates_t(),
    lambda mbs, t, load: np.linalg.norm(mbs.GetNodeOutput(0, POSITION)) * np.array(load),
]
LOOKING = [
    acceleration,
    *(kind().step for kind in (OfForce, OfAcceleration, OfStoredMethod, OfSameName, OfAnyName, OfAnIndex)),
    *(kind().step for kind in (OfAType, OfItsDictionary)),
    partial(by, looking, 2.0),
    partial(MBS.GetObjectOutput, 0),
    bound,
    lambda mbs, t: looking.step(mbs, t),
    lambda mbs, t: queue[0](0, POSITION),
    lambda mbs, t: listed[0],
    lambda mbs, t: bound(0, POSITION),
    lambda mbs, t: mbs.GetObjectOutput(0, POSITION),
    lambda mbs, t: mbs.systemData.GetAECoordinates(),
    lambda mbs, t: getattr(mbs, "GetObject" + "Output"),
    lambda mbs, t: [one(mbs) for one in (lambda mbs: mbs.systemData.GetSystemState(),)],
    lambda mbs, t: acceleration(mbs, t),
    lambda mbs, t, get=bound: get(0, POSITION),
]


@pytest.mark.parametrize("function", BLIND)
def test_a_function_that_reads_places_and_velocities_does_not_look(function):
    assert look_of(function, MBS) < Look.ANYTHING


@pytest.mark.parametrize("function", CONTROLLERS)
def test_methods_and_objects_that_are_called_are_looked_into(function):
    assert look_of(function, MBS) == Look.SENSORS


@pytest.fixture
def sensed():
    """mbs with a mass point, and sensors of its place, of its acceleration, and of twice the latter."""
    mbs = exudyn.SystemContainer().AddSystem()
    point = mbs.CreateMassPoint(mass=1)
    kinds = POSITION, ACCELERATION
    place, rate = (mbs.AddSensor(SensorBody(bodyNumber=point, outputVariableType=kind)) for kind in kinds)
    twice = SensorUserFunction(sensorUserFunction=lambda mbs, t, *_: (2 * mbs.GetSensorValues(rate)).tolist())
    return mbs, place, rate, mbs.AddSensor(twice)


def reading(*sensors):
    one, other = sensors[0], sensors[-1]
    return lambda mbs, t: (
        mbs.GetSensorValues(one)[0] + mbs.GetSensorValues(other)[0] + mbs.GetSensorValues(0)[0]
    )


def test_a_function_that_names_sensors_of_places_looks_at_these_alone(sensed):
    mbs, place, rate, twice = sensed
    assert look_of(reading(place), mbs) == Look.MOTION
    assert look_of(reading(rate), mbs) == look_of(reading(place, rate), mbs) == Look.SENSORS
    assert look_of(reading(twice), mbs) == Look.SENSORS


def test_a_sensor_that_is_not_named_in_the_call_may_be_any(sensed):
    mbs, place, rate, _ = sensed
    numbers = [int(place)]

    def within(mbs, t):
        place = rate
        return (lambda: mbs.GetSensorValues(place))()

    functions = [
        within,
        lambda mbs, t: mbs.GetSensorValues(numbers[0]),
        lambda mbs, t: mbs.GetSensorValues(sensorNumber=place),
        lambda mbs, t: mbs.GetSensorValues(place + t),
        lambda mbs, t: mbs.GetSensorValues(7),
        lambda mbs, t: mbs.GetSensorValues,
    ]
    for function in functions:
        assert look_of(function, mbs) == Look.SENSORS


@pytest.mark.parametrize("function", LOOKING)
def test_whatever_is_not_known_may_look(function):
    assert look_of(function, MBS) == Look.ANYTHING
