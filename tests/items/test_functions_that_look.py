"""Which functions may look at accelerations and forces of constraints, as far as their code shows."""

import exudyn
import numpy as np
import pytest

from exudyn_inext.items.functions_that_look import may_look_at_forces

POSITION, ACCELERATION = exudyn.OutputVariableType.Position, exudyn.OutputVariableType.Acceleration
MBS = exudyn.SystemContainer().AddSystem()
bound = MBS.GetNodeOutput


class Controller:
    def step(self, mbs, t):
        return mbs.GetObjectOutput(0, exudyn.OutputVariableType.Force)


controller, numbers = Controller(), [1, 2.0, np.zeros(3)]


def position(mbs, t):
    return mbs.GetNodeOutput(0, POSITION)[0] + mbs.GetSensorValues(0)[1]


def acceleration(mbs, t):
    return mbs.GetNodeOutput(0, ACCELERATION)


def sets(mbs, t):
    mbs.SetLoadParameter(0, "loadVector", [np.sin(t) * numbers[0] - position(mbs, t), 0, 0])
    return True


BLIND = [lambda mbs, t: True, position, sets, lambda mbs, t: MBS.systemData.GetODE2Coordinates_t()]
LOOKING = [
    acceleration,
    controller.step,
    bound,
    lambda mbs, t: controller.step(mbs, t),
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
    assert not may_look_at_forces(function)


@pytest.mark.parametrize("function", LOOKING)
def test_whatever_is_not_known_may_look(function):
    assert may_look_at_forces(function)
