"""User functions that read what elements do not show any more after cables took their place."""

import warnings

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerNodePosition,
    ObjectANCFCable2D,
    SensorBody,
    SensorNode,
    SensorUserFunction,
)

from exudyn_inext import CreateCableForceSensor, ReplaceNativeCables, SolveEquilibrium
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import PINNED, solve_native, trajectory

Output = exudyn.OutputVariableType
SECTION = {"massPerLength": 0.2, "bendingStiffness": 0.05, "axialStiffness": 2e4, "bendingDamping": 1e-3}
PLACE = 0.53  # of the moment that is read [m]


class Pendulum:
    """A native cable of 1 m with a load at its tip.   element: of 16, in the middle."""

    def __init__(self, mbs, **function):
        line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": 16}
        made = GenerateBeamElementsAlongLine(
            mbs,
            **line,
            beamTemplate=ObjectANCFCable2D(**SECTION),
            gravity=[0, -9.81, 0],
            groundConstraintsStart=PINNED,
        )
        self.mbs, self.element, self.node = mbs, int(made["elements"][8]), int(made["nodes"][-1])
        tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=self.node))
        self.load = mbs.AddLoad(LoadForceVector(markerNumber=tip, loadVector=[0, 0, 0], **function))
        sensor = SensorNode(nodeNumber=self.node, storeInternal=True, outputVariableType=Output.Position)
        self.sensor = mbs.AddSensor(sensor)

    def steer(self, moment):
        """Let the load follow a moment, a function of mbs."""

        def follow(mbs, t):
            mbs.SetLoadParameter(self.load, "loadVector", [0.0, -5.0 * float(moment(mbs)), 0.0])
            return True

        self.mbs.SetPreStepUserFunction(follow)

    def native_moment(self, mbs):
        return mbs.GetObjectOutputBody(self.element, Output.TorqueLocal, [PLACE - 0.5, 0, 0])

    def speed(self, mbs):
        return mbs.GetObjectOutputBody(self.element, Output.Velocity, [PLACE - 0.5, 0, 0])[1]

    @property
    def path(self):
        return trajectory(self.mbs, self.sensor)[:, 1:]


def said_of(solve, mbs):
    """Warnings of a short run."""
    mbs.Assemble()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solve(mbs, 0.01, steps=10)
    return [str(one.message) for one in caught]


def test_step_functions_that_read_section_forces_are_told_what_works(new_mbs, solve):
    native = Pendulum(new_mbs())
    native.steer(native.native_moment)
    native.mbs.Assemble()
    solve_native(native.mbs, 0.3, step=2e-4)

    ours = Pendulum(new_mbs())
    ours.steer(ours.native_moment)
    (cable,) = ReplaceNativeCables(ours.mbs)
    (said,) = said_of(solve, ours.mbs)
    assert "(before or after steps) reads TorqueLocal by GetObjectOutputBody: it is zero" in said
    assert "Use CreateCableForceSensor" in said

    moment = CreateCableForceSensor(ours.mbs, cable, PLACE)
    ours.steer(lambda mbs: mbs.GetSensorValues(moment)[1])
    assert said_of(solve, ours.mbs) == []
    solve(ours.mbs, settings=quiet_settings(0.3, 1500))
    np.testing.assert_allclose(ours.path[-1], native.path[-1], rtol=0, atol=1e-3)
    unsteered = Pendulum(new_mbs())
    ReplaceNativeCables(unsteered.mbs)
    unsteered.mbs.Assemble()
    solve(unsteered.mbs, settings=quiet_settings(0.3, 300))
    assert np.abs(unsteered.path[-1] - native.path[-1]).max() > 0.05


@pytest.mark.parametrize("output", ["ForceLocal", "KineticEnergy"])
def test_functions_of_sensors_that_read_them_are_named(new_mbs, solve, output):
    pendulum = Pendulum(new_mbs())
    kind, place = getattr(Output, output), [0.03 if output == "ForceLocal" else 0.0, 0, 0]

    def read(mbs, t, numbers, factors, configuration):
        return np.atleast_1d(mbs.GetObjectOutputBody(pendulum.element, kind, place, configuration)).tolist()

    pendulum.mbs.AddSensor(SensorUserFunction(sensorUserFunction=read))
    ReplaceNativeCables(pendulum.mbs)
    (said,) = said_of(solve, pendulum.mbs)
    sensor = "CreateCableForceSensor" if output == "ForceLocal" else "CreateCableEnergySensor"
    assert f"of sensor 1 'sensor1' reads {output} " in said
    assert f"Use {sensor}" in said


def test_statics_warn_of_sensors_and_loads_that_see_no_section_forces(new_mbs):
    mbs = new_mbs()
    elements = {}

    def follow(mbs, t, load):
        return [0, float(mbs.GetObjectOutputBody(elements["middle"], Output.TorqueLocal, [0, 0, 0])), 0]

    pendulum = Pendulum(mbs, loadVectorUserFunction=follow)
    elements["middle"] = pendulum.element
    place = {"bodyNumber": pendulum.element, "localPosition": [0.03, 0, 0]}
    mbs.AddSensor(SensorBody(**place, outputVariableType=Output.ForceLocal))
    ReplaceNativeCables(mbs)
    mbs.Assemble()
    with silence(), pytest.warns(UserWarning) as caught:
        SolveEquilibrium(mbs)
    of_sensor, of_load = (str(one.message) for one in caught)
    assert "sensor 1 'sensor1' measures OutputVariableType.ForceLocal of object 8" in of_sensor
    assert "of load 16 'load16' (ForceVector) reads TorqueLocal" in of_load


@pytest.mark.parametrize("by_sensor", [True, False])
def test_loads_that_follow_accelerations_are_named(new_mbs, solve, by_sensor):
    mbs = new_mbs()
    asked = {}

    def follow(mbs, t, load):
        if by_sensor:
            return [0, -1e-5 * float(mbs.GetSensorValues(1)[1]), 0]
        return [0, -1e-5 * float(mbs.GetNodeOutput(asked["node"], Output.Acceleration)[1]), 0]

    pendulum = Pendulum(mbs, loadVectorUserFunction=follow)
    asked["node"] = pendulum.node
    mbs.AddSensor(SensorNode(nodeNumber=pendulum.node, outputVariableType=Output.Acceleration))
    ReplaceNativeCables(mbs)
    (said,) = said_of(solve, mbs)
    assert "of load 16 'load16' (ForceVector) reads Acceleration, which explicit steps know of the" in said
    assert "AddPointMass" in said


def test_functions_that_read_the_motion_are_not(new_mbs, solve):
    pendulum = Pendulum(new_mbs())
    pendulum.steer(pendulum.speed)
    ReplaceNativeCables(pendulum.mbs)
    assert said_of(solve, pendulum.mbs) == []


def test_loads_that_ask_for_section_forces_are_refused(new_mbs, solve):
    mbs = new_mbs()
    asked = {}

    def follow(mbs, t, load):
        return [0, -5.0 * float(mbs.GetSensorValues(asked["moment"])[1]), 0]

    Pendulum(mbs, loadVectorUserFunction=follow)
    (cable,) = ReplaceNativeCables(mbs)
    asked["moment"] = CreateCableForceSensor(mbs, cable, PLACE)
    mbs.Assemble()
    with pytest.raises(exudyn.ModelError, match="which follow from what it returns: let a step"):
        solve(mbs, 0.01, steps=10)
