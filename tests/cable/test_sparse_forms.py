"""Energy and tangent of a whole cable against quadrature and differences."""

import numpy as np
import pytest

from exudyn_inext.cable.assembly import elastic_energy
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.constraint_rows import unconstrained_force
from exudyn_inext.cable.sparse_forms import damping_tangent, elastic_tangent, form_of_cable
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    bending_energy,
    bending_force,
    bending_tangent,
    dense_form,
    mass_matrix,
    random_state,
    relative_error,
    with_section,
)

pytestmark = pytest.mark.kernel

KINDS = [(2, 0.0), (2, -0.7), (3, 0.0)]  # dimension and natural curvature

every_kind = pytest.mark.parametrize(("dim", "natural"), KINDS)
both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)


def state_of(number, dim, measure, natural):
    return with_section(random_state(61, number, dim, measure), natural_curvature=natural)


@every_kind
@both_measures
def test_energy_is_the_quadrature_of_the_squared_curvature(dim, measure, natural):
    state = state_of(5, dim, measure, natural)
    found = elastic_energy(build_chain(state.cable), state.q)
    assert found == pytest.approx(bending_energy(state.cable, state.q), rel=1e-12)


@every_kind
@both_measures
@pytest.mark.parametrize("number", [1, 2, 3, 7])
def test_tangent_is_the_second_derivative_of_the_energy(dim, measure, natural, number):
    state = state_of(number, dim, measure, natural)
    found = elastic_tangent(build_chain(state.cable), state.q).toarray()
    assert relative_error(found, bending_tangent(state.cable, state.q)) < 1e-11


@both_measures
@pytest.mark.parametrize("dim", DIMENSIONS)
def test_damping_tangent_gives_the_damping_force(dim, measure):
    state = with_section(random_state(61, 5, dim, measure), bending_damping=0.3)
    chain, rest = build_chain(state.cable), np.zeros_like(state.q)
    moving, still = np.zeros_like(state.q), np.zeros_like(state.q)
    unconstrained_force(chain, rest, state.q, state.v, moving)
    unconstrained_force(chain, rest, state.q, rest, still)
    found = damping_tangent(chain, state.q) @ state.v.ravel()
    assert np.abs(found).max() > 0.0
    assert relative_error(found, (still - moving).ravel()) < 1e-11


@every_kind
@both_measures
def test_dense_tangent_of_the_tests_is_the_derivative_of_their_force(dim, measure, natural):
    state = state_of(3, dim, measure, natural)
    columns = []
    for unit in np.eye(state.q.size):
        forces = [
            bending_force(state.cable, state.q + s * unit.reshape(state.q.shape)) for s in (-2, -1, 1, 2)
        ]
        columns.append(np.tensordot([-1, 8, -8, 1], forces, 1).ravel() / 12)  # exact for cubic forces
    assert relative_error(np.array(columns).T, bending_tangent(state.cable, state.q)) < 1e-11


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_assembled_form_is_the_sum_over_the_elements(dim):
    cable = state_of(4, dim, MEASURES[0], 0.0).cable
    np.testing.assert_allclose(form_of_cable(cable, mass_matrix).toarray(), dense_form(cable, mass_matrix))
