"""Discs that roll tow cables as natively, and go round as the closed form says."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    MarkerBodyPosition,
    MarkerNodePosition,
    SensorBody,
    SensorNode,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import InertiaCylinder, RotationMatrixY

from exudyn_inext import RungeKutta4, SceneError, SolveEquilibrium
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import either_cable, solve_native

RADIUS, G = 0.2, 9.81  # [m], [m/s^2]
INERTIA = InertiaCylinder(2000, 0.04, RADIUS, axis=0)
DOWN = [0, 0, -G]
END = 0.2


class Disc:
    """A disc that rolls on the ground, leaning by `tilt` [rad], with its contact at the origin.

    spin: angular velocity [rad/s].   foot: where its contact is [m].
    """

    def __init__(self, mbs, tilt, spin, foot=(0, 0, 0)):
        self.mbs, axes = mbs, RotationMatrixY(-tilt)
        up = RADIUS * axes[:, 2]
        self.velocity = np.cross(spin, up)
        self.centre = foot + up
        self.body = mbs.CreateRigidBody(
            inertia=INERTIA,
            referencePosition=list(self.centre),
            referenceRotationMatrix=axes,
            initialVelocity=list(self.velocity),
            initialAngularVelocity=list(spin),
            gravity=DOWN,
        )
        pair = [mbs.CreateGround(), self.body]
        self.joint = mbs.CreateRollingDisc(bodyNumbers=pair, axisPosition=[0, 0, 0], discRadius=RADIUS)
        self.sensors = [self.sense(SensorBody, "Position", bodyNumber=self.body)]
        self.sensors += [self.sense(SensorObject, "ForceLocal", objectNumber=self.joint)]

    def sense(self, kind, output, **what):
        output = getattr(exudyn.OutputVariableType, output)
        return self.mbs.AddSensor(kind(storeInternal=True, outputVariableType=output, **what))

    def add_cable(self, native=False, start=None, velocity=(0, 0, 0)):
        """Of 1.2 m along -y.   start: of it; None: the centre of the disc, which tows it."""
        a = self.centre if start is None else np.array(start)
        line = {"positionStart": list(a), "positionEnd": list(a + np.array([0, -1.2, 0])), "gravity": DOWN}
        section = {"massPerLength": 0.5, "bendingStiffness": 0.05}
        nodes, _ = either_cable(self.mbs, native, 3, section, 2e5, numberOfElements=8 + 8 * native, **line)
        for node in nodes:
            self.mbs.SetNodeParameter(node, "initialVelocities", [*velocity, 0, 0, 0])
        if start is None:
            ends = MarkerBodyPosition(bodyNumber=self.body), MarkerNodePosition(nodeNumber=nodes[0])
            self.mbs.AddObject(SphericalJoint(markerNumbers=[self.mbs.AddMarker(end) for end in ends]))
        self.sensors.append(self.sense(SensorNode, "Position", nodeNumber=nodes[-1]))
        self.mbs.Assemble()

    def rows(self):
        """(T, 1 + 3) of each sensor."""
        return [np.array(self.mbs.GetSensorStoredData(sensor)) for sensor in self.sensors]


def test_a_disc_that_rolls_tows_a_cable_as_natively(new_mbs, solve):
    found = []
    for native in (False, True):
        disc = Disc(new_mbs(), 0.2, [-6.0, 0.0, 0.5])
        disc.add_cable(native, velocity=disc.velocity)
        if native:
            solve_native(disc.mbs, END)
        else:
            solve(disc.mbs, END, quiet_settings(END, 200))
        found.append(disc.rows())
    for own, wanted, part in zip(*found, (1e-4, 0.06, 2e-3), strict=True):  # cables swing along themselves
        error, change = (own - wanted)[1:], np.ptp(wanted[1:, 1:], axis=0).max()
        assert np.sqrt((error**2).mean()) < part * change


def steady_turn(tilt, ring):
    """Angular velocity Omega about z [rad/s] of a disc that leans inwards, its contact on a ring [m].

    Its axis a and its radius w, from centre to contact, turn with it: of H = C (Omega . a + s) a
    + A (Omega . w) w with s = -Omega ring / r, Omega x H = r w x (force at the contact).
    """
    m, C, A = INERTIA.mass, *np.diag(INERTIA.inertiaTensor)[:2]
    s, c, centre = np.sin(tilt), np.cos(tilt), ring - RADIUS * np.sin(tilt)
    return np.sqrt(m * G * RADIUS * s / c / (C * (ring / RADIUS - s) + A * s + m * RADIUS * centre))


@pytest.mark.parametrize(
    ("scheme", "tolerance"), [({}, 2e-5), ({"integrator": RungeKutta4()}, 1e-8)], ids=str
)
def test_a_disc_that_leans_goes_round_steadily(mbs, solve, scheme, tolerance):
    """Without damping: place, height, and forces at the contact after a part of a turn."""
    tilt, ring = 0.3, 0.8
    turn = steady_turn(tilt, ring)
    axis = np.array([np.cos(tilt), 0, np.sin(tilt)])
    disc = Disc(mbs, tilt, turn * np.array([0, 0, 1]) - turn * ring / RADIUS * axis, [ring, 0, 0])
    disc.add_cable(start=[0, 0, 3])
    solve(mbs, 0.5, quiet_settings(0.5, 500), **scheme)
    (*_, place), (*_, force), _ = disc.rows()
    centre = ring - RADIUS * np.sin(tilt)
    wanted = centre * np.cos(0.5 * turn), centre * np.sin(0.5 * turn), RADIUS * np.cos(tilt)
    np.testing.assert_allclose(place[1:], wanted, rtol=0, atol=tolerance)
    weight, inwards = INERTIA.mass * G, INERTIA.mass * centre * turn**2
    np.testing.assert_allclose(force[1:], [-inwards, 0, weight], rtol=0, atol=tolerance * weight)


def test_where_a_disc_would_roll_to_rest_is_not_searched_for(mbs, solve, contents):
    """The remedy works: a joint holds it meanwhile, and then it stands by itself."""
    disc = Disc(mbs, 0.0, [0, 0, 0])
    disc.add_cable()
    before = contents(mbs)
    with pytest.raises(SceneError, match=r"\(JointRollingDisc\) rolls.*activeConnector.*CreateGenericJoint"):
        SolveEquilibrium(mbs)
    assert contents(mbs) == before
    hold = mbs.CreateGenericJoint(itemNumbers=[mbs.CreateGround(), disc.body], position=list(disc.centre))
    mbs.Assemble()
    for held in (True, False):
        mbs.SetObjectParameter(disc.joint, "activeConnector", not held)
        mbs.SetObjectParameter(hold, "activeConnector", held)
        if held:
            SolveEquilibrium(mbs)
    solve(mbs, 0.05)
    np.testing.assert_allclose(
        mbs.GetObjectOutputBody(disc.body, exudyn.OutputVariableType.Position), disc.centre, atol=1e-9
    )
