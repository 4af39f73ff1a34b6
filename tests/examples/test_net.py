"""The net: twin, knots and rods, energy, free fall before it pulls, symmetry."""

import numpy as np
import pytest

from examples import net
from tests.examples.measures import gaps, total_energy
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

TWIN = Twin(end_time=0.4, step=1e-3, axial=1e6)


@pytest.fixture(scope="module")
def run():
    return run_inextensible(net, TWIN.end_time)


def heights(run, cable):
    """(n, nodes) z [m]."""
    return run[1].cables[cable][0][:, :, 0, 2]


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(net, TWIN)) < 1e-2


def test_knots_and_rods_hold_to_a_micrometre(run):
    assert len(gaps(run)) == 13
    assert max(gaps(run)) < 1e-6


def energy_error(run):
    """Largest change of the energy over the largest kinetic energy."""
    kinetic, total = total_energy(run, [(net.SIDE, net.CABLE)] * 6, [], net.GRAVITY)
    return np.abs(total - total[0]).max() / kinetic.max()


def test_energy_stays_what_it_was(run):
    assert energy_error(run) < 1e-2


def test_the_centre_falls_freely_until_the_net_pulls(run):
    t = run[1].t
    falling = t < 0.1
    fall = -heights(run, 1)[falling, net.ELEMENTS // 2]
    np.testing.assert_allclose(fall, 0.5 * 9.81 * t[falling] ** 2, atol=0.01 * fall.max())


def test_its_motion_has_the_symmetry_of_the_square(run):
    edge, other_edge, across = heights(run, 0), heights(run, 2), heights(run, 3)
    np.testing.assert_allclose(edge, edge[:, ::-1], atol=1e-6)
    np.testing.assert_allclose(edge, other_edge, atol=1e-6)
    np.testing.assert_allclose(edge, across, atol=1e-6)
