"""The same integrator on native items, for comparisons."""

import dataclasses

import numpy as np

from reference_models.conventional.cases import native_case
from reference_models.conventional.settings import Explicit
from reference_models.conventional.zhai import zhai_case
from reference_models.scenes import load_scene

SHORT = dataclasses.replace(load_scene("planar_pendulum"), end_time=0.3)


def test_zhai_on_native_cables_agrees_with_native_velocity_verlet():
    zhai = zhai_case(SHORT, 4, 5e-5).prepare()()
    verlet = native_case(SHORT, 4, Explicit(5e-5)).prepare()()
    assert np.linalg.norm(verlet.positions[-1] - verlet.positions[0]) > 0.3
    np.testing.assert_allclose(zhai.times, verlet.times, atol=1e-9)
    np.testing.assert_allclose(zhai.positions, verlet.positions, atol=1e-4)


def test_a_native_mass_point_falls(mbs, add_sensor, solve):
    point = mbs.CreateMassPoint(mass=2.0, referencePosition=[0, 0, 0], gravity=[0, -9.81, 0])
    sensor = add_sensor(mbs, mbs.GetObject(point)["nodeNumber"])
    mbs.Assemble()
    report = solve(mbs, 0.2, stepSize=1e-3)
    assert report["decidedBy"] == "stepSize"
    np.testing.assert_allclose(
        mbs.GetSensorStoredData(sensor)[-1, 1:], [0, -0.5 * 9.81 * 0.2**2, 0], atol=1e-10
    )
