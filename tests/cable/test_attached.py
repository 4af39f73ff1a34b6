"""Chains with point masses and drag against the dense system."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.assembly import add_drag
from exudyn_inext.cable.attached import Drag, PointMass
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.frequency import largest_frequency
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.compiled import plain
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.system import accelerate_and_project
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    bending_force,
    dense_constraints,
    dense_largest_frequency,
    dense_mass,
    dense_rates,
    drag_force,
    point_masses,
    random_state,
    relative_error,
    structured_rates,
)

pytestmark = pytest.mark.kernel

ZETA = 5.0
both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def carrying(state, drag=True):
    """The same state with masses within an element, on a node, and at the tip; in a flow."""
    cable = state.cable
    ends = np.cumsum(cable.element_lengths)
    masses = [PointMass(0.3 * ends[0], 0.9), PointMass(ends[1], 1.7), PointMass(ends[-1], 0.4)]
    law = Drag(0.7, 0.2, (0.5, -1.0, 0.3)[: cable.dimension]) if drag else None
    return replace(state, cable=replace(cable, point_masses=tuple(masses), drag=law))


def states(dim, drag=True):
    return [carrying(random_state(71, 5, dim, MEASURES[0], 3, name), drag) for name in ("clamped", "free")]


@both_dimensions
def test_rates_with_point_masses_agree_with_the_dense_solve(dim):
    for state in states(dim, drag=False):
        acceleration, rate, _ = structured_rates(state, ZETA)
        expected, expected_rate, *_ = dense_rates(state, ZETA)
        assert relative_error(acceleration, expected) < 1e-11
        assert relative_error(rate, expected_rate) < 1e-11


@both_dimensions
def test_drag_of_the_chain_acts_at_the_leading_velocity(dim):
    """It is that of v + lead a. Plain Python: the plane stands for space in compiled code, below."""
    lead, rng = 0.05, np.random.default_rng(2)
    for state in states(dim):
        a, chain = rng.standard_normal(state.q.shape), build_chain(state.cable)
        of_chain = plain(add_drag)
        of_chain(chain.axes, chain.nodes, chain.elements, state.q, state.v, lead, a, 0)
        expected = drag_force(state.cable, state.q, state.v + lead * a)
        assert relative_error(chain.nodes["force"][:, 0], expected) < 1e-12


def test_drag_enters_the_projected_velocity():
    duration, rng = 0.05, np.random.default_rng(2)
    for state in states(2):
        cable, v = state.cable, state.v.ravel()
        given = np.where(cable.fixed[:, :, None], 0.0, rng.standard_normal(state.q.shape))
        a, end = given.ravel().copy(), np.zeros(v.size)
        accelerate_and_project(cable_system(cable, 0.0), state.inputs, state.q.ravel(), v, duration, a, end)
        force = state.external + bending_force(cable, state.q)
        force += drag_force(cable, state.q, state.v + duration * given)
        c = dense_constraints(cable, state.q, state.v)
        mass, zero = dense_mass(cable), np.zeros((len(c.value), len(c.value)))
        matrix = np.block([[mass, c.jacobian.T], [c.jacobian, zero]])
        expected = np.linalg.solve(matrix, np.concatenate([force.ravel(), c.gamma]))[: v.size]
        assert relative_error(a, expected) < 1e-10


def test_largest_frequency_is_that_of_the_loaded_cable():
    for state in states(2, drag=False):
        state = replace(state, v=np.zeros_like(state.v))
        found = largest_frequency(cable_system(state.cable, 100.0), state.inputs, state.q)
        expected = dense_largest_frequency(state)
        assert abs(found - expected) < 1e-6 * expected


@both_dimensions
def test_gravity_of_the_point_masses_is_their_mass_matrix_times_g(dim):
    state = states(dim)[1]
    g, fall = np.array([0.3, -9.81, 1.0])[:dim], np.zeros(state.q.shape)
    fall[:, 0] = g
    bare = replace(state.cable, point_masses=())
    found = gravity_force(state.cable, g) - gravity_force(bare, g)
    np.testing.assert_allclose(found.ravel(), point_masses(state.cable) @ fall.ravel(), atol=1e-12)
    np.testing.assert_allclose(found[:, 0].sum(axis=0), 3.0 * g, atol=1e-12)
