"""Bodies that nothing holds: no vibration bounds the step."""

import numpy as np
from exudyn.utilities import InertiaCuboid

GRAVITY = [0, 0, -9.81]


def test_a_free_body_takes_the_steps_of_the_time_loop(mbs, add_sensor, solve):
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.1] * 3), initialVelocity=[1, 0, 0], gravity=GRAVITY
    )
    sensor = add_sensor(mbs, mbs.GetObject(body)["nodeNumber"])
    mbs.Assemble()
    report = solve(mbs, 0.2, steps=20)
    assert report["steps"] == 20
    expected = [0.2, 0, -0.5 * 9.81 * 0.2**2]
    np.testing.assert_allclose(mbs.GetSensorStoredData(sensor)[-1, 1:], expected, atol=1e-10)
