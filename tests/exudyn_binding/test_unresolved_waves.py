"""Forces of axial vibrations that the steps do not resolve: those that act, and what is said of many."""

import re

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import MarkerNodePosition, SensorBody, SensorObject, SphericalJoint

from exudyn_inext import (
    CableForces,
    CreateCableForceSensor,
    CreateInextensibleCable,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SolveExplicit,
)
from reference_models.model import quiet_settings

LENGTH, MASS, SPEED = 2.0, 1000.0, 1.0
OUTPUT = exudyn.OutputVariableType


def towed_rope(axialDamping=0.0):
    """A heavy mass pulls the end of a rope that rests; and sensors of mass, joint and rope at this end."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(0.2, 0.05, axialStiffness=1e5, axialDamping=axialDamping)
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [LENGTH, 0, 0], 8, section)
    mbs.SetNodeParameter(cable["nodes"][-1], "initialVelocities", [SPEED, 0, 0, 0])
    mass = mbs.CreateMassPoint(
        referencePosition=[LENGTH, 0, 0],
        initialVelocity=[SPEED, 0, 0],
        mass=MASS,
        create2D=True,
        returnDict=True,
    )
    ends = [
        mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        for node in (cable["nodes"][-1], mass["nodeNumber"])
    ]
    joint = mbs.AddObject(SphericalJoint(markerNumbers=ends, constrainedAxes=[1, 1, 0]))
    sensors = [
        mbs.AddSensor(
            SensorBody(
                bodyNumber=mass["bodyNumber"],
                outputVariableType=OUTPUT.Displacement,
                storeInternal=True,
            )
        ),
        mbs.AddSensor(SensorObject(objectNumber=joint, outputVariableType=OUTPUT.Force, storeInternal=True)),
        CreateCableForceSensor(mbs, cable, LENGTH),
    ]
    mbs.Assemble()
    return mbs, cable, sensors


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_forces_are_those_that_accelerate_the_mass(damping):
    """m (x_(n+1) - 2 x_n + x_(n-1)) / h^2; by strains of the states they are up to 15 times as large."""
    mbs, _, sensors = towed_rope(damping)
    h, steps = 2e-4, 200
    settings = quiet_settings(steps * h, steps, h)
    SolveExplicit(mbs, settings, ExplicitSettings(stepSize=h))
    way, joint, rope = (np.array(mbs.GetSensorStoredData(sensor))[:, 1] for sensor in sensors)
    force = MASS * np.diff(way, 2) / h**2
    size = np.abs(force).max()
    assert np.abs(np.abs(joint[1:-1]) - np.abs(force)).max() < 1e-3 * size
    assert np.abs(rope[1:-1] + force).max() < 1e-3 * size


def test_many_are_warned_of_until_the_remedy_is_followed():
    settings, says = quiet_settings(0.1, 50), "vibrates along its axis faster than the steps resolve"
    with pytest.warns(UserWarning) as caught:
        SolveExplicit(towed_rope()[0], settings, ExplicitSettings(stepSize=1e-3))
    said = next(str(warning.message) for warning in caught if says in str(warning.message))
    step = float(re.search(r"stepSize = ([\d.e-]+\d)", said)[1])
    SolveExplicit(towed_rope()[0], settings, ExplicitSettings(stepSize=step))


def test_a_stepper_shows_the_same_forces_as_a_run():
    mbs, cable, sensors = towed_rope()
    h = 2e-4
    SolveExplicit(mbs, quiet_settings(20 * h, 20, h), ExplicitSettings(stepSize=h))
    expected = np.array(mbs.GetSensorStoredData(sensors[2]))[-1, 1]
    assert CableForces(mbs, cable, [LENGTH])["tension"][0] == pytest.approx(expected, rel=1e-9)
    mbs, cable, _ = towed_rope()
    stepper = ExplicitStepper(mbs, stepSize=h)
    stepper.Start()
    stepper.Step(20)
    stepper.WriteToSystem()
    assert CableForces(mbs, cable, [LENGTH])["tension"][0] == pytest.approx(expected, rel=1e-9)


def test_forces_of_vibrations_that_are_resolved_are_of_order_two():
    def tension(h):
        mbs = exudyn.SystemContainer().AddSystem()
        section = InextensibleCable(0.3, 0.05, axialStiffness=500.0, axialDamping=2.0)
        pinned = {"gravity": [0, -9.81, 0], "groundConstraintsStart": [True, True, False, False]}
        cable = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, **pinned)
        sensor = CreateCableForceSensor(mbs, cable, 0.3)
        mbs.Assemble()
        SolveExplicit(mbs, quiet_settings(0.4, 40, 0.01), ExplicitSettings(stepSize=h))
        return np.array(mbs.GetSensorStoredData(sensor))[1:, 1]

    finest = tension(2e-3 / 32)
    coarse, fine = (np.linalg.norm(tension(h) - finest) for h in (2e-3, 1e-3))
    assert fine < 0.3 * coarse < 3e-4 * np.linalg.norm(finest)
