"""Drag is Morison's law integrated along the element, and takes energy out of a cable in still fluid."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.attached import Drag
from exudyn_inext.element.drag import add_drag_force, drag_table
from tests.cables import DIMENSIONS, MEASURES, drag_force, random_state, relative_error

pytestmark = pytest.mark.kernel

FLOW = (0.5, -1.0, 0.3)

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def state_in_fluid(seed, dim, flow=FLOW):
    state = random_state(seed, 4, dim, MEASURES[0])
    return replace(state, cable=replace(state.cable, drag=Drag(0.7, 0.2, flow[:dim])))


def found_force(cable, q, v):
    """(n, 2, dim) of the package, element by element."""
    force, memory = np.zeros(q.shape), np.zeros((2, 3))
    for k, length in enumerate(cable.element_lengths):
        e = np.array([q[k + 1, 0] - q[k, 0], q[k, 1], q[k + 1, 1]])
        element, rates = np.zeros((4, cable.dimension)), v[k : k + 2].reshape(4, -1)
        axes = tuple(range(cable.dimension))
        add_drag_force(axes, drag_table(length), cable.drag.law(), e, rates, memory, element)
        force[k : k + 2] += element.reshape(2, 2, -1)
    return force


@both_dimensions
@pytest.mark.parametrize("seed", range(3))
def test_force_is_the_integral_of_the_law(dim, seed):
    state = state_in_fluid(seed, dim)
    expected = drag_force(state.cable, state.q, state.v)
    assert relative_error(found_force(state.cable, state.q, state.v), expected) < 1e-12


@both_dimensions
@pytest.mark.parametrize("seed", range(5))
def test_power_in_still_fluid_is_negative(dim, seed):
    state = state_in_fluid(seed, dim, flow=(0.0, 0.0, 0.0))
    assert np.sum(found_force(state.cable, state.q, state.v) * state.v) < 0.0


@both_dimensions
def test_a_cable_that_drifts_with_the_flow_feels_nothing(dim):
    state = state_in_fluid(1, dim)
    v = np.zeros_like(state.v)
    v[:, 0] = FLOW[:dim]
    assert np.abs(found_force(state.cable, state.q, v)).max() < 1e-15
