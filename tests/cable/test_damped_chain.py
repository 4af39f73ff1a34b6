"""Chains with natural curvature and bending damping against the dense system."""

import numpy as np
import pytest

from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.system import accelerate_and_project
from tests.cables import (
    MEASURES,
    bending_force,
    damping_force,
    dense_constraints,
    dense_mass,
    dense_rates,
    random_state,
    relative_error,
    structured_rates,
    with_section,
)

pytestmark = pytest.mark.kernel

ZETA = 5.0
KINDS = [(2, {"natural_curvature": 0.7, "bending_damping": 0.3}), (3, {"bending_damping": 0.3})]


def states():
    for dim, section in KINDS:
        for supports in ("clamped", "free"):
            yield with_section(random_state(71, 5, dim, MEASURES[0], 3, supports), **section)


def test_rates_agree_with_the_dense_solve():
    for state in states():
        acceleration, rate, _ = structured_rates(state, ZETA)
        expected, expected_rate, *_ = dense_rates(state, ZETA)
        assert relative_error(acceleration, expected) < 1e-11
        assert relative_error(rate, expected_rate) < 1e-11


def test_projected_velocity_is_damped_at_the_end_of_the_step():
    """The damping force is that of v + duration a, with the acceleration a handed in."""
    duration, rng = 0.05, np.random.default_rng(2)
    for state in states():
        cable, v = state.cable, state.v.ravel()
        given = np.where(state.cable.fixed[:, :, None], 0.0, rng.standard_normal(state.q.shape))
        a, end = given.ravel().copy(), np.zeros(v.size)
        accelerate_and_project(cable_system(cable, 0.0), state.inputs, state.q.ravel(), v, duration, a, end)
        force = state.external + bending_force(cable, state.q)
        force += damping_force(cable, state.q, state.v + duration * given)
        c = dense_constraints(cable, state.q, state.v)
        mass, zero = dense_mass(cable), np.zeros((len(c.value), len(c.value)))
        matrix = np.block([[mass, c.jacobian.T], [c.jacobian, zero]])
        expected = np.linalg.solve(matrix, np.concatenate([force.ravel(), c.gamma]))[: v.size]
        assert relative_error(a, expected) < 1e-10
        free = v + duration * expected
        speed = np.linalg.solve(matrix, np.concatenate([mass @ free, np.zeros(len(c.value))]))[: v.size]
        assert relative_error(end, speed) < 1e-10
