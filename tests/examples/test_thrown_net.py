"""The thrown net: momentum without the tether, the catch, and what the tether does."""

import exudyn
import numpy as np
import pytest

from examples import thrown_net
from exudyn_inext import SolveExplicit
from reference_models.model import quiet_settings, silence

OF_NET = 84 * thrown_net.SIZE["mesh"] * thrown_net.CABLE.massPerLength + 4 * thrown_net.CORNER  # [kg]
MOMENTUM = OF_NET * thrown_net.SIZE["speed"]  # [kg m/s]


@pytest.fixture(scope="module")
def caught():
    """Coordinates of a run without the tether, 0.6 s after the throw: its mbs, and the scene."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    scene = thrown_net.build(mbs, tethered=False)
    mbs.Assemble()
    with silence():
        report = SolveExplicit(mbs, quiet_settings(0.6, 10), thrown_net.SETTINGS)
    mbs.variables["container"] = container
    return mbs, scene, report


def of_body(mbs, number, kind):
    return np.array(mbs.GetObjectOutputBody(number, kind, [0, 0, 0]))


def momentum_of_cables(mbs, cables):
    """(3,) by the mean velocity of cubic elements: (v_0 + v_1) / 2 + L (s_0 - s_1) / 12."""
    total, length = np.zeros(3), thrown_net.SIZE["mesh"] / thrown_net.ELEMENTS
    for cable in cables:
        rates = [mbs.GetNodeOutput(n, exudyn.OutputVariableType.Coordinates_t) for n in cable["nodes"]]
        v, s = np.array(rates)[:, :3], np.array(rates)[:, 3:]
        means = (v[1:] + v[:-1]) / 2.0 + length * (s[:-1] - s[1:]) / 12.0
        total += thrown_net.CABLE.massPerLength * length * means.sum(axis=0)
    return total


def test_momentum_of_net_and_ball_stays(caught):
    mbs, scene, _ = caught
    masses = [thrown_net.MASS] + 4 * [thrown_net.CORNER]
    velocities = [of_body(mbs, number, exudyn.OutputVariableType.Velocity) for number in scene["bodies"]]
    total = momentum_of_cables(mbs, scene["cables"]) + masses @ np.array(velocities)
    np.testing.assert_allclose(total, [0.0, 0.0, MOMENTUM], atol=1e-6 * MOMENTUM)


def test_the_net_closes_around_the_ball_and_takes_it_along(caught):
    mbs, scene, _ = caught
    ball, *corners = (of_body(mbs, n, exudyn.OutputVariableType.Position) for n in scene["bodies"])
    start = thrown_net.SIZE["mesh"] * thrown_net.SIZE["meshes"] / np.sqrt(2.0)  # of a corner from the middle
    assert all(np.linalg.norm(corner[:2] - ball[:2]) < 0.4 * start for corner in corners)
    assert all(corner[2] > ball[2] for corner in corners)  # in front of it: they flew past
    together = MOMENTUM / (OF_NET + thrown_net.MASS)
    assert of_body(mbs, scene["bodies"][0], exudyn.OutputVariableType.Velocity)[2] > 0.7 * together


def test_bodies_and_joints_move_in_compiled_code(caught):
    assert "bodies and joints are compiled" in caught[2]["path"]
    assert caught[2]["drift"]["constraints"] < 1e-9


def test_knots_do_not_enter_the_ball(caught):
    """By more than the speed of the net may press them into the contact's springs."""
    mbs, scene, _ = caught
    centre = of_body(mbs, scene["bodies"][0], exudyn.OutputVariableType.Position)
    nodes = [cable["nodes"][k] for cable in scene["cables"] for k in (0, -1)]
    places = np.array([mbs.GetNodeOutput(n, exudyn.OutputVariableType.Position) for n in nodes])
    gap = np.linalg.norm(places - centre, axis=1).min() - thrown_net.RADIUS - thrown_net.THICKNESS
    assert -0.03 < gap < 0.0
