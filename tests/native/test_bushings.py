"""Bushings, as `CreateRigidBodySpringDamper` makes them, move bodies among cables as natively."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    MarkerBodyPosition,
    MarkerNodePosition,
    SensorNode,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid, RotXYZ2RotationMatrix

from reference_models.model import quiet_settings
from tests.exudyn_binding.items import either_cable, solve_native

END, STEP = 0.2, 5e-4  # [s]
SECTION = {"massPerLength": 0.3, "bendingStiffness": 0.02}
BOX = InertiaCuboid(1000, [0.2, 0.05, 0.1])
CUBE, RATE = InertiaCuboid(1000, [0.1, 0.1, 0.1]), 10.0  # of its swing [rad/s]
SHOWN = exudyn.OutputVariableType.Rotation, exudyn.OutputVariableType.TorqueLocal


def sense(mbs, kind, output, **what):
    return mbs.AddSensor(kind(storeInternal=True, outputVariableType=output, **what))


def box_on_a_bushing(mbs, native, dimension):
    """A torque turns it, a cable hangs at it, and a step function moves the offset of the angle.

    Returns sensors: angles, torques, the cable's tip.
    """
    body = mbs.CreateRigidBody(inertia=BOX, referencePosition=[0.1, 0, 0], create2D=dimension == 2)
    stiffness = np.diag([2e3, 3e3, 1e3, 0.4, 0.3, 0.5])
    stiffness[1, 5] = stiffness[5, 1] = 3.0
    spring = mbs.CreateRigidBodySpringDamper(
        itemNumbers=[mbs.CreateGround(), body],
        localPosition1=[-0.1, 0, 0],
        stiffness=stiffness,
        damping=np.diag([5, 5, 5, 0.01, 0.01, 0.005]),
    )
    mbs.CreateTorque(itemNumber=body, loadVector=[0.4 * (dimension - 2), 0, 3.0])
    line = {"positionStart": [0.2, 0, 0], "positionEnd": [0.2, -0.8, 0], "gravity": [0, -9.81, 0]}
    nodes, _ = either_cable(mbs, native, dimension, SECTION, 2e5, numberOfElements=8 + 4 * native, **line)
    ends = (
        MarkerBodyPosition(bodyNumber=body, localPosition=[0.1, 0, 0]),
        MarkerNodePosition(nodeNumber=nodes[0]),
    )
    markers = [mbs.AddMarker(end) for end in ends]
    mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, dimension - 2]))
    sensors = [sense(mbs, SensorObject, kind, objectNumber=spring) for kind in SHOWN]
    sensors.append(sense(mbs, SensorNode, exudyn.OutputVariableType.Position, nodeNumber=nodes[-1]))

    def steer(mbs, t):
        mbs.SetObjectParameter(spring, "offset", [0, 0, 0, 0, 0, -5.0 * t])
        return True

    mbs.SetPreStepUserFunction(steer)
    mbs.Assemble()
    return sensors


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_bushing_that_is_steered_moves_as_its_native_twin(new_mbs, solve, dimension):
    found = []
    for native in (True, False):
        mbs = new_mbs()
        sensors = box_on_a_bushing(mbs, native, dimension)
        if native:
            solve_native(mbs, END, STEP)
        else:
            path = solve(mbs, settings=quiet_settings(END, round(END / STEP)), stepSize=STEP)["path"]
        found.append([np.array(mbs.GetSensorStoredData(k))[:, 1:] for k in sensors])
    assert "Exudyn evaluates" not in path and np.abs(found[0][0]).max() > 1.5
    for wanted, own in zip(*found, strict=True):
        np.testing.assert_allclose(own, wanted, rtol=0, atol=1e-3 * np.ptp(wanted, axis=0).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cube_swings_by_almost_half_a_turn(mbs, solve, add_pendulum, dimension):
    """About any axis its angle is that of an oscillator, from zero to 3 rad."""
    axis = np.array([0.0, 0.0, 1.0]) if dimension == 2 else np.array([2.0, -1.0, 2.0]) / 3.0
    turn = RotXYZ2RotationMatrix([0.3, -0.4, 0.5])
    form = {"create2D": True} if dimension == 2 else {"referenceRotationMatrix": turn}
    body = mbs.CreateRigidBody(inertia=CUBE, initialAngularVelocity=3.0 * RATE * axis, **form)
    stiffness = RATE**2 * CUBE.inertiaTensor[0, 0] * np.diag([0, 0, 0, 1, 1, 1])
    pair = [mbs.CreateGround(), body]
    spring = mbs.CreateRigidBodySpringDamper(itemNumbers=pair, stiffness=stiffness)
    sensor = sense(mbs, SensorObject, SHOWN[0], objectNumber=spring)
    add_pendulum(mbs, numberOfElements=2)
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(0.5, 10, 0.05), stepSize=2.5e-4)
    t, *angles = np.array(mbs.GetSensorStoredData(sensor)).T
    assert "in one compiled call" in report["path"]
    np.testing.assert_allclose(
        np.transpose(angles), 3.0 * np.outer(np.sin(RATE * t), axis), rtol=0, atol=2e-5
    )
