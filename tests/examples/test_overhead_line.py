"""The overhead line: twin, supports and droppers, equilibrium, and a string under a moving force."""

from functools import partial

import numpy as np
import pytest

from examples import overhead_line as line
from studies.harness.coupled_runs import Inextensible, Native, distance, prepare
from studies.harness.coupled_scenes import overhead_line

ELEMENTS, END_TIME = line.ELEMENTS, 1.2
MASS = line.MESSENGER.massPerLength + line.CONTACT.massPerLength

run = partial(prepare, overhead_line(1, meshes=(1, ELEMENTS)), end_time=END_TIME)


@pytest.fixture(scope="module")
def paths():
    return run(Inextensible(ELEMENTS))()[1]


@pytest.fixture
def wires(paths):
    """Times (n,) [s], and positions (n, k, 3) [m] of both wires, at supports and droppers."""
    return paths[:, 0, 0], *np.split(paths[..., 1:], 2, axis=1)


def string_under_a_moving_force(x, t):
    """(n, k) [m] deflection of a string with tension and mass of both wires, by its modes.

    x: (k,) [m].   t: (n,) [s].   Fryba, Vibration of Solids and Structures under Moving Loads.
    """
    n = np.arange(1, 400)[:, None, None]
    w, driven = (n * np.pi / line.SPAN * c for c in (np.sqrt(2 * line.TENSION / MASS), line.SPEED))
    motion = np.sin(driven * t[:, None]) - driven / w * np.sin(w * t[:, None])
    modes = np.sin(n * np.pi * x / line.SPAN) * motion / (w**2 - driven**2)
    return 2 * line.FORCE / (MASS * line.SPAN) * modes.sum(axis=0)


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(paths):
    assert distance(run(Native(2 * ELEMENTS, 2e-3, axial=1e8))()[1], paths) < 3e-3


def test_supports_and_droppers_hold_to_a_micrometre(wires):
    _, messenger, contact = wires
    for wire, height in ((messenger, line.DEPTH), (contact, 0.0)):
        assert np.abs(wire[:, 0] - [0, height, 0]).max() < 1e-6
        assert np.abs(wire[:, -1, 1] - height).max() < 1e-6
    lengths = np.linalg.norm(messenger - contact, axis=2)[:, 1:-1]
    assert np.abs(lengths - lengths[0]).max() < 1e-6


def test_at_rest_the_contact_wire_is_level_and_the_messenger_a_parabola(wires):
    _, messenger, contact = (some[0] for some in wires)
    x = np.linspace(0, line.SPAN, line.DROPPERS + 2)
    assert np.abs(contact[:, 1]).max() < 1e-3
    sag = MASS * 9.81 * x * (line.SPAN - x) / (2 * line.TENSION)
    np.testing.assert_allclose(messenger[:, 1], line.DEPTH - sag, atol=1e-2 * sag.max())


def test_a_pantograph_lifts_it_as_a_moving_force_lifts_a_string(wires):
    t, _, contact = wires
    x = np.linspace(0, line.SPAN, line.DROPPERS + 2)
    uplift = contact[:, :, 1] - contact[0, :, 1]
    expected = string_under_a_moving_force(x, t)
    assert np.abs(uplift - expected).max() < 0.02 * expected.max()
