"""Elastic forces follow from the bending energy, in both measures and both dimensions."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.assembly import add_elastic_force
from exudyn_inext.cable.cable import CurvatureMeasure
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.element.bending import stiffness_matrix, stiffness_tensor
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    arc,
    bending_energy,
    bending_force,
    opening_arc,
    random_state,
    relative_error,
    straight_cable,
)

pytestmark = pytest.mark.kernel

STEP = 0.01  # the energy is of degree four, for which these differences are exact

both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)
both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def elastic_force(cable, q):
    force = np.zeros(q.shape)
    add_elastic_force(build_chain(cable), q, force)
    return force


def random_rotation(rng, dim):
    rotation, _ = np.linalg.qr(rng.standard_normal((dim, dim)))
    rotation[:, 0] *= np.sign(np.linalg.det(rotation))
    return rotation


@both_measures
@both_dimensions
@pytest.mark.parametrize("seed", range(3))
def test_elastic_force_is_minus_the_gradient_of_the_energy(measure, dim, seed):
    state = random_state(seed, 4, dim, measure)
    gradient = []
    for unit in np.eye(state.q.size):
        change = STEP * unit.reshape(state.q.shape)
        energy = [bending_energy(state.cable, state.q + s * change) for s in (-2, -1, 1, 2)]
        gradient.append(np.dot([1, -8, 8, -1], energy) / (12 * STEP))
    force = elastic_force(state.cable, state.q).ravel()
    assert relative_error(force, np.negative(gradient)) < 1e-7


@both_measures
@both_dimensions
def test_elastic_force_is_the_quadrature_of_the_virtual_work_to_round_off(measure, dim):
    state = random_state(7, 6, dim, measure)
    expected = bending_force(state.cable, state.q)
    assert relative_error(elastic_force(state.cable, state.q), expected) < 1e-12


@both_measures
@both_dimensions
def test_elastic_force_is_added_to_what_is_there(measure, dim):
    state = random_state(8, 2, dim, measure)
    force = np.ones(state.q.shape)
    add_elastic_force(build_chain(state.cable), state.q, force)
    np.testing.assert_allclose(force - 1.0, elastic_force(state.cable, state.q), atol=1e-12)


@both_measures
@both_dimensions
def test_rigid_motions_of_a_straight_cable_give_no_elastic_force(measure, dim):
    rng = np.random.default_rng(1)
    cable = straight_cable(3, dim, measure=measure)
    q = cable.reference @ random_rotation(rng, dim).T
    q[:, 0] += rng.standard_normal(dim)
    # one unit of force bends a unit element by a fraction of its length
    assert np.abs(elastic_force(cable, q)).max() < 1e-13


@both_measures
@both_dimensions
def test_elastic_force_turns_with_the_cable(measure, dim):
    state = random_state(2, 3, dim, measure)
    rotation = random_rotation(np.random.default_rng(2), dim)
    moved = state.q @ rotation.T
    moved[:, 0] += 5.0
    expected = elastic_force(state.cable, state.q) @ rotation.T
    assert relative_error(elastic_force(state.cable, moved), expected) < 1e-11


RADIUS, ANGLE = 0.8, 2.0
ARC_LENGTH = RADIUS * ANGLE


def energies(number):
    """Energy of the arc in both measures, from the element matrices, with EI = 1."""
    q, length = arc(ARC_LENGTH, number, RADIUS), ARC_LENGTH / number
    nodal = np.concatenate([q[:-1], q[1:]], axis=1)
    pairs = 0.5 * np.einsum("eai,ebi->eab", nodal, nodal)
    second = 0.5 * np.einsum("eai,ab,ebi->", nodal, stiffness_matrix(length), nodal)
    product = 0.5 * np.einsum("eab,abmn,emn->", pairs, stiffness_tensor(length), pairs)
    return np.array([second, product])


def observed_order(errors):
    """Smallest order of a sequence of errors on meshes that double."""
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:])).min()


def test_energy_of_an_arc_converges_to_the_exact_one_in_both_measures():
    exact = 0.5 * ARC_LENGTH / RADIUS**2
    errors = np.array([energies(number) for number in (4, 8, 16, 32)]) / exact - 1.0
    assert observed_order(errors) > 3.7
    assert np.abs(errors[-1]).max() < 1e-6


def test_the_two_measures_agree_as_the_mesh_is_refined():
    gap = np.array([np.subtract(*energies(number)) for number in (4, 8, 16, 32)])
    assert np.all(np.abs(gap[1:]) < np.abs(gap[:-1]))
    assert observed_order(gap) > 3.7


@both_dimensions
def test_work_on_an_opening_arc_converges_to_the_exact_one_in_both_measures(dim):
    exact = ARC_LENGTH / RADIUS**3  # -dU/dR of EI L / (2 R^2)
    errors = []
    for number in (4, 8, 16, 32):
        opening, q = (shape(ARC_LENGTH, number, RADIUS, dim) for shape in (opening_arc, arc))
        cable = straight_cable(number, dim, length=ARC_LENGTH)
        errors.append(
            [
                (elastic_force(replace(cable, measure=m), q) * opening).sum() / exact - 1.0
                for m in (CurvatureMeasure.SECOND_DERIVATIVE, CurvatureMeasure.PRODUCT)
            ]
        )
    assert observed_order(np.array(errors)) > 3.5
    assert np.abs(errors[-1]).max() < 1e-5
