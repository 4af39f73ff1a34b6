"""Torsional springs go on beyond half a turn, as under Exudyn's implicit solver."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import MarkerBodyPosition, MarkerNodePosition, SensorObject, SphericalJoint
from exudyn.utilities import InertiaCuboid

from exudyn_inext import ExplicitSettings, ExplicitStepper, SolveEnsemble, SolveExplicit
from exudyn_inext.run.coupled_run import CoupledRun
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_pendulum

END, OUTPUTS, STEP = 0.5, 25, 5e-4
KINDS = exudyn.OutputVariableType.Rotation, exudyn.OutputVariableType.TorqueLocal


def rotor(mbs, dimension, cable=True, spin=0.0, torque=0.35):
    """Assemble a rotor on the ground, on whose axis a cable hangs: spring, sensors of angle and torque.

    dimension: of the rotor; the cable lies in the plane.
    """
    planar = {"create2D": True} if dimension == 2 else {}
    inertia = InertiaCuboid(1000, [0.1, 0.1, 0.1])
    body = mbs.CreateRigidBody(inertia=inertia, initialAngularVelocity=[0, 0, spin], **planar)
    hinge = {"itemNumbers": [mbs.CreateGround(), body], "position": [0, 0, 0]}
    free = 3 - dimension  # of a body in the plane
    mbs.CreateGenericJoint(**hinge, constrainedAxes=[1, 1, 1 - free, 1 - free, 1 - free, 0])
    law = {"stiffness": 0.005, "damping": 0.001, "offset": 0.3}
    spring = mbs.CreateTorsionalSpringDamper(**hinge, axis=[0, 0, 1], **law)
    mbs.CreateTorque(itemNumber=body, loadVector=[0, 0, torque])
    if cable:
        made = add_pendulum(mbs, numberOfElements=4, groundConstraintsStart=None)
        pair = MarkerBodyPosition(bodyNumber=body), MarkerNodePosition(nodeNumber=made["nodes"][0])
        ends = [mbs.AddMarker(marker) for marker in pair]
        mbs.AddObject(SphericalJoint(markerNumbers=ends, constrainedAxes=[1, 1, 0]))
    read = {"objectNumber": spring, "storeInternal": True}
    sensors = [mbs.AddSensor(SensorObject(**read, outputVariableType=kind)) for kind in KINDS]
    mbs.Assemble()
    return spring, sensors


def seen(mbs, sensors):
    """(T, 2) angle [rad] and torque [Nm] about the axis."""
    return np.stack([mbs.GetSensorStoredData(sensor)[:, -1] for sensor in sensors], axis=1)


def by_exudyn(new_mbs, dimension, change=None, **arguments):
    """What Exudyn's implicit solver says of the rotor alone."""
    mbs = new_mbs()
    spring, sensors = rotor(mbs, dimension, cable=False, **arguments)
    if change:
        mbs.SetPreStepUserFunction(change(spring))
    with silence():
        mbs.SolveDynamic(settings(1000 if change else 5000))
    return seen(mbs, sensors)


def settings(steps=OUTPUTS):
    return quiet_settings(END, steps, END / OUTPUTS)


def steered(spring):
    def change(mbs, t):
        mbs.SetObjectParameter(spring, "offset", 0.3 + 20.0 * t)
        mbs.SetObjectParameter(spring, "torque", 0.01)
        mbs.SetObjectParameter(spring, "activeConnector", not 0.25 < t < 0.27)
        return True

    return change


@pytest.mark.parametrize(("dimension", "tolerance"), [(2, 1e-6), (3, 1e-4)])
def test_three_turns_are_those_of_exudyn(new_mbs, solve, dimension, tolerance):
    wanted, mbs = by_exudyn(new_mbs, dimension), new_mbs()
    spring, sensors = rotor(mbs, dimension)
    report = solve(mbs, settings=settings(), stepSize=STEP)
    found = seen(mbs, sensors)
    assert "in one compiled call" in report["path"] and found[-1, 0] > 6.0 * np.pi
    np.testing.assert_allclose(found, wanted, rtol=tolerance, atol=1e-6)
    assert mbs.systemData.GetDataCoordinates()[0] == pytest.approx(found[-1, 0], rel=1e-12)
    if dimension == 2:
        mbs.SetPreStepUserFunction(steered(spring))
        report = solve(mbs, settings=settings(1000), stepSize=STEP)
        steered_by_exudyn = by_exudyn(new_mbs, dimension, steered)
        assert "Exudyn evaluates" not in report["path"] and np.abs(steered_by_exudyn - wanted).max() > 0.5
        np.testing.assert_allclose(seen(mbs, sensors), steered_by_exudyn, rtol=0, atol=0.01)  # a step later


def test_members_and_steppers_count_turns_of_their_own(new_mbs, solve):
    def build(torque):
        mbs = new_mbs()
        springs.append(rotor(mbs, 2, torque=torque)[0])
        return mbs

    springs, explicit, torques = [], ExplicitSettings(stepSize=STEP), (0.35, -0.3, 0.35)
    members = SolveEnsemble(build, settings(), explicit, torques, threads=2)["coordinates"]
    for torque, coordinates in zip(torques, members, strict=True):
        mbs = build(torque)
        solve(mbs, settings=settings(), stepSize=STEP)
        angle = mbs.GetObjectOutput(springs[-1], KINDS[0])
        np.testing.assert_array_equal(coordinates[-1], mbs.systemData.GetODE2Coordinates())
        stepper = ExplicitStepper(mbs, explicit, interval=END / OUTPUTS)
        stepper.Start()
        stepper.Step(OUTPUTS)
        stepper.WriteToSystem()
        assert abs(angle) > 4.0 * np.pi and mbs.GetObjectOutput(springs[-1], KINDS[0]) == angle


def test_no_turn_is_lost_by_steps_of_more_than_half_a_turn(new_mbs, solve):
    wanted, mbs = by_exudyn(new_mbs, 2, spin=2000.0), new_mbs()
    _, sensors = rotor(mbs, 2, spin=2000.0)
    solve(mbs, settings=settings())
    np.testing.assert_allclose(seen(mbs, sensors), wanted, rtol=1e-4, atol=1e-3)


def test_turns_are_no_contact_that_has_changed(mbs, monkeypatch):
    """Where Exudyn evaluates the spring: the limit of the step is not found again because it turns."""
    spring, sensors = rotor(mbs, 2, torque=-0.35)
    law = lambda mbs, t, number, angle, rate, stiffness, damping, offset: stiffness * angle  # noqa: E731
    mbs.SetObjectParameter(spring, "springTorqueUserFunction", law)
    looks = []
    monkeypatch.setattr(CoupledRun, "_limit_of_motion", lambda run, time: looks.append(time) or np.inf)
    with silence():
        SolveExplicit(mbs, settings(500))
    assert seen(mbs, sensors)[-1, 0] < -1.0 and not looks
