"""Energy of a cable, and what changes it: dense formulas, and the theorem of work and energy."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.attached import Drag
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.system import (
    ACCELERATION_ENERGY,
    ELASTIC,
    KINETIC,
    POWER,
    REPORTED,
    RESOLVED,
    VIOLATION,
    accelerate_and_project,
    index_reduced_rates,
    report_energy,
)
from tests.cables import (
    DIMENSIONS,
    LINKS,
    MEASURES,
    bending_energy,
    bending_force,
    dense_constraints,
    dense_mass,
    linked_state,
    random_state,
    with_section,
)

pytestmark = pytest.mark.kernel


def reported(system, state, v):
    """energy_report and forces at (q, v), the system evaluated there."""
    q, inputs = state.q.ravel(), state.inputs
    a, rate, force, energy_report = np.zeros(q.size), np.zeros(q.size), np.zeros(q.size), np.zeros(REPORTED)
    index_reduced_rates(system, inputs, q, v, a, rate)
    report_energy(system, inputs, q, v, a, force, energy_report)
    return energy_report, force, a


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("dim", DIMENSIONS)
def test_energies_are_those_of_the_dense_matrices(dim, measure):
    state = random_state(1, 5, dim, measure, supports="clamped and pinned")
    energy_report, force, a = reported(cable_system(state.cable, 0.0), state, state.v.ravel())
    v = state.v.ravel()
    assert energy_report[KINETIC] == pytest.approx(0.5 * v @ dense_mass(state.cable) @ v)
    assert energy_report[ACCELERATION_ENERGY] == pytest.approx(0.5 * a @ dense_mass(state.cable) @ a)
    assert energy_report[RESOLVED] == energy_report[ACCELERATION_ENERGY]
    assert energy_report[ELASTIC] == pytest.approx(bending_energy(state.cable, state.q))
    np.testing.assert_array_equal(force, state.external.ravel())
    assert energy_report[POWER] == 0.0


def test_elastic_energy_knows_the_natural_curvature():
    state = with_section(random_state(2, 5, 2, MEASURES[0]), natural_curvature=0.7)
    energy_report, _, _ = reported(cable_system(state.cable, 0.0), state, state.v.ravel())
    assert energy_report[ELASTIC] == pytest.approx(bending_energy(state.cable, state.q))


@pytest.mark.parametrize("links", LINKS)
def test_the_largest_violation_is_that_of_all_constraints_lengths_relative(links):
    state = linked_state(3, 5, 2, MEASURES[0], links)
    system = cable_system(state.cable, 0.0)
    energy_report, _, _ = reported(system, state, state.v.ravel())
    found = dense_constraints(state.cable, state.q, state.v, state.time)
    scales = {"length": state.cable.constrained_lengths(), "nodal inextensibility": 1.0}
    values = [np.abs(found.value[found.rows[name]] / scale).max() for name, scale in scales.items()]
    others = [np.abs(found.value[rows]).max() for name, rows in found.rows.items() if name not in scales]
    assert max(values) <= energy_report[VIOLATION] * (1 + 1e-12)
    assert energy_report[VIOLATION] <= max(*values, 1.5 * max(others, default=0.0)) * (1 + 1e-12)


@pytest.mark.parametrize("dim", DIMENSIONS)
@pytest.mark.parametrize("changes", ["damping", "drag"])
@pytest.mark.parametrize("links", LINKS)
def test_what_the_energy_gains_is_the_work_of_forces_and_power(links, changes, dim):
    """v . M a - Q_el . v = F . v + P, where v fulfils the moving constraints."""
    state = linked_state(4, 5, dim, MEASURES[0], links)
    if changes == "damping":
        state = with_section(state, bending_damping=0.3)
    else:
        state = replace(state, cable=replace(state.cable, drag=Drag(0.4, 0.1, np.ones(dim))))
    system = cable_system(state.cable, 0.0)
    v = np.zeros(state.q.size)
    accelerate_and_project(
        system, state.inputs, state.q.ravel(), state.v.ravel(), 0.0, np.zeros(state.q.size), v
    )
    energy_report, force, a = reported(system, state, v)
    gain = v @ dense_mass(state.cable) @ a - v @ bending_force(state.cable, state.q).ravel()
    assert abs(energy_report[POWER]) > 0.1
    assert force @ v + energy_report[POWER] == pytest.approx(gain, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_gauges_leave_no_trace_in_the_evaluations_to_come(dim):
    state = with_section(linked_state(5, 5, dim, MEASURES[0], next(iter(LINKS))), bending_damping=0.3)
    state = replace(state, cable=replace(state.cable, drag=Drag(0.4, 0.1, np.ones(dim))))
    system, q, v = cable_system(state.cable, 0.0), state.q.ravel(), state.v.ravel()
    before, after = np.zeros((2, q.size)), np.zeros((2, q.size))
    index_reduced_rates(system, state.inputs, q, v, *before)
    report_energy(system, state.inputs, q, v, before[0], np.zeros(q.size), np.zeros(REPORTED))
    index_reduced_rates(system, state.inputs, q, v, *after)
    np.testing.assert_array_equal(before, after)
