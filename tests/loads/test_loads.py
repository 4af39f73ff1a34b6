"""Generalised forces have the resultant, the moment and the virtual work of their loads."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.attached import PointMass
from exudyn_inext.cable.cable import Section
from exudyn_inext.loads.gravity import gravity_force
from tests.cables import DIMENSIONS, MEASURES, hermite, planar_pendulum, random_state, straight_cable

pytestmark = pytest.mark.kernel

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def moment(cable, force):
    """z component of the moment about the origin, in the reference configuration."""
    q = cable.reference
    return (q[..., 0] * force[..., 1] - q[..., 1] * force[..., 0]).sum()


def point_weight(cable, force, arc_length):
    """Weight of a unit mass at an arc length, in the gravity `force`."""
    massless = replace(cable.section, mass_per_length=0.0)
    return gravity_force(replace(cable, section=massless, point_masses=(PointMass(arc_length, 1.0),)), force)


def position(cable, arc_length):
    """Point of the reference curve at an arc length, for elements found by hand."""
    starts = np.append(0.0, np.cumsum(cable.element_lengths))
    k = max(int(np.argmax(starts >= arc_length)) - 1, 0)
    shape = np.array([p(arc_length - starts[k]) for p in hermite(cable.element_lengths[k])])
    return shape @ np.concatenate([cable.reference[k], cable.reference[k + 1]])


@both_dimensions
def test_gravity_has_the_weight_as_resultant(dim):
    cable = random_state(51, 5, dim, MEASURES[0]).cable
    gravity = np.array([1.0, -9.81, 0.3])[:dim]
    mass = cable.section.mass_per_length * cable.length
    resultant = gravity_force(cable, gravity)[:, 0].sum(axis=0)
    np.testing.assert_allclose(resultant, mass * gravity, rtol=1e-12)


def test_gravity_acts_in_the_middle_of_a_straight_cable():
    cable, gravity = planar_pendulum(4)
    weight = cable.section.mass_per_length * 1.8 * 9.81
    assert moment(cable, gravity_force(cable, gravity)) == pytest.approx(-weight * 0.9, rel=1e-12)


def test_gravity_of_one_element_is_the_textbook_load_vector():
    cable = straight_cable(1, 2, length=2.0, section=Section(3.0, 1.0))
    force = gravity_force(cable, (0.0, -10.0))[..., 1]
    np.testing.assert_allclose(force, -30.0 * np.array([[1.0, 1 / 3], [1.0, -1 / 3]]), rtol=1e-12)


@both_dimensions
@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.81, 1.0])
def test_weight_of_a_point_mass_has_its_force_and_moment(dim, share):
    cable = random_state(52, 5, dim, MEASURES[0]).cable
    force = np.array([2.0, -3.0, 0.7])[:dim]
    generalised = point_weight(cable, force, share * cable.length)
    np.testing.assert_allclose(generalised[:, 0].sum(axis=0), force, rtol=1e-12)
    at = position(cable, share * cable.length)
    expected = at[0] * force[1] - at[1] * force[0]
    assert moment(cable, generalised) == pytest.approx(expected, rel=1e-10)


@both_dimensions
def test_weight_of_a_point_mass_does_the_work_of_its_force(dim):
    state = random_state(53, 4, dim, MEASURES[0])
    cable, force = state.cable, np.arange(1.0, dim + 1)
    ends = np.cumsum(cable.element_lengths)
    for k, length in enumerate(cable.element_lengths):
        shape = np.array([p(0.3 * length) for p in hermite(length)])
        velocity = shape @ np.concatenate([state.v[k], state.v[k + 1]])
        generalised = point_weight(cable, force, ends[k] - 0.7 * length)
        assert (generalised * state.v).sum() == pytest.approx(force @ velocity, rel=1e-10)


def test_weight_of_a_point_mass_at_a_node_acts_on_its_position_only():
    cable = straight_cable(4, 2)
    for node in range(5):
        generalised = point_weight(cable, (2.0, -1.0), float(node))
        expected = np.zeros((5, 2, 2))
        expected[node, 0] = (2.0, -1.0)
        np.testing.assert_allclose(generalised, expected, atol=1e-14)


def test_the_end_of_the_cable_is_on_it_whatever_its_elements_add_up_to():
    cable = straight_cable(6, 2, length=1.0)
    assert cable.length < 1.0  # by round-off
    generalised = point_weight(cable, (2.0, -1.0), 1.0)
    np.testing.assert_array_equal(generalised[-1, 0], (2.0, -1.0))
    np.testing.assert_allclose(generalised[-1, 1], 0.0, atol=1e-14)
