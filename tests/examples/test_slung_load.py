"""The slung load: native twin under the same control, decay of the swing, way to the goal."""

import exudyn
import numpy as np
import pytest

from examples import slung_load as example
from examples.flight import settings_of_period
from exudyn_inext import ExplicitSolver
from reference_models.conventional.native_cables import NativeCables
from reference_models.model import silence


def fly(solver, settings=None, **options):
    with silence():
        return example.fly(solver, settings or settings_of_period(), **options)


@pytest.fixture(scope="module")
def flown():
    """{swing damping: (times, paths of the cable's nodes)}."""
    return {damping: fly(ExplicitSolver(example.SETTINGS), swingDamping=damping) for damping in (0.0, 9.0)}


def angle(points):
    """(T,) of the cable to the vertical, in the plane of the way [rad]."""
    x, _, z = (points[:, -1] - points[:, 0]).T
    return np.arctan2(x, -z)


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(flown):
    settings = settings_of_period(4)
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    solver, elements = exudyn.MainSolverImplicitSecondOrder(), 2 * example.ELEMENTS
    times, native = fly(solver, settings, addCable=NativeCables(1e5), elements=elements)
    ours_times, ours = flown[9.0]
    common, mine, theirs = np.intersect1d(ours_times.round(9), times.round(9), return_indices=True)
    assert len(common) == len(ours_times)
    assert np.abs(ours[mine] - native[theirs, ::2]).max() < 1e-3 * np.linalg.norm(example.GOAL)


def slowest_decay(swingDamping):
    """Smallest decay rate [1/s] of drone and load as a trolley with a pendulum, for small angles.

    States: position and velocity of the drone, and of the load relative to it.
    """
    drone, load, length = example.MASS, example.LOAD.Mass(), example.LENGTH + 0.05
    k, c = 4.0 / drone, 8.0 / drone
    pull, s, swing = load * 9.81 / length / drone, swingDamping / drone, 9.81 / length
    rates = [[0, 1, 0, 0], [-k, -c, pull, s], [0, 0, 0, 1], [k, c, -pull - swing, -s]]
    return -np.linalg.eigvals(np.array(rates)).real.max()


def test_the_swing_decays_as_that_of_the_linear_model(flown):
    times, points = flown[0.0]
    late = times > example.DURATION + 1.0
    t, phi = times[late], np.abs(angle(points[late]))
    peaks = 1 + np.flatnonzero((phi[1:-1] > phi[:-2]) & (phi[1:-1] > phi[2:]))
    assert len(peaks) >= 4
    rate = -np.polyfit(t[peaks], np.log(phi[peaks]), 1)[0]
    assert rate == pytest.approx(slowest_decay(0.0), rel=0.1)
    assert slowest_decay(9.0) > 3 * slowest_decay(0.0)


def test_the_controller_damps_the_swing_and_gets_to_the_goal(flown):
    largest = {damping: np.abs(angle(points[-50:])).max() for damping, (_, points) in flown.items()}
    assert largest[9.0] < 0.1 * largest[0.0]
    np.testing.assert_allclose(flown[9.0][1][-1, 0], example.GOAL, atol=0.02)
