"""The O(N) solve with contact beside the mass gives what a dense solve gives."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.contact_mass import add_contact_row, clear_contact_mass
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.system import accelerate_and_project, correct_position
from tests.cables import (
    MEASURES,
    SUPPORTS,
    dense_constraints,
    dense_mass,
    dense_rates,
    random_state,
    relative_error,
)

DURATION, TOUCHED = 0.05, (1, 2, 4)  # [s]; elements


def solved(system, state):
    """Accelerations, velocities at the end, and a correction of positions that are off, and these."""
    a, end, correction = np.zeros((3, state.q.size))
    external, moved = state.external.ravel(), (state.q + 0.01 * state.v).ravel()
    accelerate_and_project(system, external, state.q.ravel(), state.v.ravel(), DURATION, a, end)
    correct_position(system, external, moved, 1e-10, 0.0, correction)
    return a, end, correction, moved


def press(system, random):
    """Rows of some elements; their dense matrix."""
    chain = system.chain
    size = 4 * len(chain.nodes)
    pressed, free = np.zeros((size, size)), np.repeat(chain.nodes["free"].ravel(), 2)
    for k in TOUCHED:
        for _ in range(2):
            row, mass = random.standard_normal((1, 8)), random.uniform(0.1, 10.0)
            b = np.zeros(size)
            b[4 * k : 4 * k + 8] = row[0] * free[4 * k : 4 * k + 8]
            pressed += mass * np.outer(b, b)
            add_contact_row(chain.nodes, chain.elements[k], k, mass, row)
    return pressed


@pytest.mark.kernel
@pytest.mark.parametrize("supports", SUPPORTS)
@pytest.mark.parametrize("n_bar", [1, 3, 6])
def test_a_chain_that_is_pressed_agrees_with_the_dense_solve(supports, n_bar):
    state = random_state(41, 6, 2, MEASURES[0], n_bar, supports)
    system = CableSystem(build_chain(replace(state.cable, pressed=True)), 0.0)
    without = solved(system, state)
    pressed = press(system, np.random.default_rng(3))
    a, end, correction, moved = solved(system, state)

    free, _, lam, _, c = dense_rates(state, 0.0)
    mass, rows = dense_mass(state.cable), c.jacobian
    force = mass @ free + rows.T @ lam
    matrix = np.block([[mass + pressed, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    expected = np.linalg.solve(matrix, np.concatenate([force, rows @ free]))[: len(a)]
    assert relative_error(a, expected) < 1e-9
    assert relative_error(free, expected) > 1e-2
    response = np.linalg.solve(mass + pressed, rows.T)
    project = response @ np.linalg.inv(rows @ response)
    reached = state.v.ravel() + DURATION * expected
    assert relative_error(end, reached - project @ (rows @ reached)) < 1e-9
    value = dense_constraints(state.cable, moved.reshape(state.q.shape), state.v).value
    assert relative_error(correction, -project @ value) < 1e-9

    clear_contact_mass(system.chain.axes, system.chain.nodes, system.chain.elements)
    np.testing.assert_array_equal(solved(system, state), without)
    unpressed = solved(CableSystem(build_chain(state.cable), 0.0), state)
    for one, other in zip(without, unpressed, strict=True):
        assert relative_error(one, other) < 1e-12
