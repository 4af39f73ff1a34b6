"""Constant and user-function loads on the nodes of a cable."""

import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadCoordinate,
    LoadForceVector,
    MarkerNodeCoordinate,
    MarkerNodePosition,
)

from exudyn_inext import SceneError
from reference_models.model import quiet_settings

MASS = 0.0348 * 1.8  # of the cable of `add_cable` [kg]


def add_force(mbs, node, force, user_function=0):
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=force, loadVectorUserFunction=user_function))


def add_coordinate_load(mbs, node, load, user_function=0):
    marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
    mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=load, loadUserFunction=user_function))


@pytest.fixture
def motion(new_mbs, add_pendulum, add_sensor, solve):
    """Tip of a pendulum with what `add(mbs, node)` puts on it."""

    def run(add, **changes):
        mbs = new_mbs()
        cable = add_pendulum(mbs, **changes)
        tip = add_sensor(mbs, cable["nodes"][-1])
        add(mbs, cable["nodes"][3])
        mbs.Assemble()
        solve(mbs, 0.2, stepSize=1e-3)
        return np.asarray(mbs.GetSensorStoredData(tip))[:, 1:]

    return run


def test_a_user_function_that_returns_a_constant_is_the_constant_load(motion):
    constant = motion(lambda mbs, node: add_force(mbs, node, [0.1, 0.3, 0]))
    by_function = motion(
        lambda mbs, node: add_force(mbs, node, [0, 0, 0], lambda mbs, t, load: [0.1, 0.3, 0])
    )
    scaled = motion(lambda mbs, node: add_force(mbs, node, [0.05, 0.15, 0], lambda mbs, t, load: 2 * load))
    np.testing.assert_allclose(by_function, constant, atol=1e-12)
    np.testing.assert_allclose(scaled, constant, atol=1e-12)


def test_a_coordinate_load_is_the_component_of_a_force(motion):
    vector = motion(lambda mbs, node: add_force(mbs, node, [0, 0.3, 0]))
    coordinate = motion(lambda mbs, node: add_coordinate_load(mbs, node, 0.3))
    by_function = motion(lambda mbs, node: add_coordinate_load(mbs, node, 0.1, lambda mbs, t, load: 3 * load))
    without = motion(lambda mbs, node: None)
    assert np.linalg.norm(vector[-1] - without[-1]) > 1e-2
    np.testing.assert_allclose(coordinate, vector, atol=1e-12)
    np.testing.assert_allclose(by_function, vector, atol=1e-12)


def test_loads_of_one_node_add_up(motion):
    def both(mbs, node):
        add_force(mbs, node, [0, 0.2, 0])
        add_coordinate_load(mbs, node, 0, lambda mbs, t, load: 0.1)

    vector = motion(lambda mbs, node: add_force(mbs, node, [0, 0.3, 0]))
    np.testing.assert_allclose(motion(both), vector, atol=1e-12)


def test_a_nodal_slope_takes_a_coordinate_load(mbs, add_pendulum, solve, coordinates):
    """A generalised force on r_x, y turns the straight cable; clamps and gravity are absent."""
    cable = add_pendulum(mbs, gravity=[0, 0, 0])
    marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=cable["nodes"][0], coordinate=3))
    mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=0.02))
    mbs.Assemble()
    solve(mbs, 0.05)
    assert coordinates(mbs, cable["nodes"])[0, 1, 1] > 1e-3


@pytest.mark.parametrize("start", [0.0, 0.3])
@pytest.mark.parametrize("direction", [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0)], ids=["across", "along"])
def test_the_centre_of_mass_follows_a_force_in_time_with_second_order(
    new_mbs, add_cable, solve, coordinates, centre_of_mass, direction, start
):
    """m x'' = F sin(w t): x = F / (m w^2) (w s cos(w t0) - sin(w t) + sin(w t0)), s = t - t0."""
    force, w, duration = 0.05, 30.0, 0.2
    end = start + duration
    exact = (w * duration * np.cos(w * start) - np.sin(w * end) + np.sin(w * start)) / w**2
    exact *= force / MASS

    def error(h):
        mbs = new_mbs()
        cable = add_cable(mbs, gravity=[0, 0, 0])
        history = lambda mbs, t, load: np.array(load) * np.sin(w * t)  # noqa: E731
        add_force(mbs, cable["nodes"][-1], force * np.array(direction), history)
        mbs.Assemble()
        settings = quiet_settings(end, 1)
        settings.timeIntegration.startTime = start
        solve(mbs, settings=settings, stepSize=h)
        centre = centre_of_mass(coordinates(mbs, cable["nodes"]), 0.36)
        return np.linalg.norm(centre - [0.9, 0] - exact * np.array(direction[:2]))

    errors = [error(2e-3), error(1e-3), error(5e-4)]
    assert errors[0] < 1e-2 * abs(exact)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("user_function", [0, lambda mbs, t, load: [0, 0, 1.0]])
def test_a_force_out_of_the_plane_of_a_planar_cable_is_refused(
    mbs, add_pendulum, solve, contents, user_function
):
    cable = add_pendulum(mbs)
    add_force(mbs, cable["nodes"][2], [0, 0, 0 if user_function else 1.0], user_function)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(SceneError, match=r"node 2 .* 1 N.*dimension *= *3"):
        solve(mbs)
    assert contents(mbs) == before


def test_a_spatial_cable_takes_a_force_in_any_direction(mbs, add_cable, solve, coordinates):
    cable = add_cable(mbs, dimension=3, gravity=[0, 0, 0])
    add_force(mbs, cable["nodes"][2], [0, 0, 0.1])
    mbs.Assemble()
    solve(mbs, 0.1)
    assert coordinates(mbs, cable["nodes"])[2, 0, 2] > 1e-3


def test_an_error_in_a_load_function_arrives_with_its_text(mbs, add_pendulum, solve):
    cable = add_pendulum(mbs)

    def fails_later(mbs, t, load):
        if t > 0.05:
            raise RuntimeError("my own mistake")
        return load

    add_force(mbs, cable["nodes"][2], [0, 0, 0], fails_later)
    mbs.Assemble()
    settings = quiet_settings(0.1, 1)
    before = repr(settings.GetDictionary())
    with pytest.raises(Exception, match="my own mistake"):
        solve(mbs, settings=settings)
    assert repr(settings.GetDictionary()) == before
