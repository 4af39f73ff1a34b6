"""Cables of one kind in one potential are the same as each by itself."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import block_diag

from exudyn_inext.cable.cable import CurvatureMeasure, Section
from exudyn_inext.cable.link import rest
from exudyn_inext.constraints.distance import hanger
from exudyn_inext.statics import potential_of, potentials_of
from tests.cables import straight_cable

KINDS = {
    "plain": {},
    "product": {"measure": CurvatureMeasure.PRODUCT},
    "stretching": {"axial_stiffness": 300.0, "axial_strain": 0.01},
    "curved": {"natural_curvature": 0.7},
}


def cables(dim, measure=CurvatureMeasure.SECOND_DERIVATIVE, **of_section):
    """Three of other meshes, sections and supports."""
    made = []
    for k, supports in enumerate(("clamped", "both ends pinned", "pinned")):
        section = Section(1.0 + k, 0.3 + k, **of_section)
        if section.axial_stiffness:
            section = replace(section, axial_stiffness=section.axial_stiffness * (1.0 + k))
        made.append(straight_cable(3 + k, dim, supports, 1.0 + 0.2 * k, section=section, measure=measure))
    rod = hanger(2, rest(np.full(dim, 0.3)), 0.3)
    return [*made[:2], replace(made[2], links=(rod,))]


@pytest.fixture(params=[(kind, dim) for kind in KINDS for dim in (2, 3)], ids=str)
def both(request):
    """All in one potential, each in its own, a state of each, and multipliers of all."""
    kind, dim = request.param
    random, own = np.random.default_rng(1), cables(dim, **KINDS[kind])
    forces = [random.normal(size=cable.reference.shape) for cable in own]
    (joined,) = potentials_of(own, forces, 0.0)
    alone = [potential_of([cable], force, 0.0) for cable, force in zip(own, forces, strict=True)]
    states = [cable.reference + 0.1 * random.normal(size=cable.reference.shape) for cable in own]
    return joined, alone, states, random.normal(size=joined.constraints.number)


def of_each(name, alone, states):
    return [getattr(one, name)(q) for one, q in zip(alone, states, strict=True)]


@pytest.mark.parametrize("name", ["force", "values", "strains"])
def test_vectors_follow_each_other(both, name):
    joined, alone, states, _ = both
    found = getattr(joined, name)(np.concatenate(states))
    np.testing.assert_allclose(found, np.concatenate(of_each(name, alone, states)), atol=1e-11)


@pytest.mark.parametrize("name", ["jacobian", "strain_rows", "elastic_tangent"])
def test_matrices_are_blocks(both, name):
    joined, alone, states, _ = both
    expected = block_diag(of_each(name, alone, states)).toarray()
    found = getattr(joined, name)(np.concatenate(states)).toarray()
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max(initial=0.0))


def test_models_and_masses_are_blocks_that_nothing_couples(both):
    joined, alone, states, multipliers = both
    for potential, q in zip([joined, *alone], [np.concatenate(states), *states], strict=True):
        potential.turn_with(q)
    parts = np.split(multipliers, np.cumsum(joined.numbers_of_constraints)[:-1])
    pairs = list(zip(alone, parts, strict=True))
    models = [one.convex_model(own, 2.0) for one, own in pairs]
    constraints = [one.constraints.hessian(own) for one, own in pairs]
    found = [joined.convex_model(multipliers, 2.0), joined.constraints.hessian(multipliers)]
    found += [joined.mass, joined.metric]
    expected = [models, constraints, [one.mass for one in alone], [one.metric for one in alone]]
    for one, blocks in zip(found, expected, strict=True):
        whole = block_diag(blocks).tocsr()
        np.testing.assert_allclose(one.toarray(), whole.toarray(), atol=1e-12 * np.abs(whole).max())
        assert one.nnz <= sum(block.nnz for block in blocks)


def test_energies_are_added_and_the_largest_counts(both):
    joined, alone, states, _ = both
    q = np.concatenate(states)
    assert joined.energy(q) == pytest.approx(sum(of_each("energy", alone, states)), rel=1e-12)
    assert joined.turn(q) == max(of_each("turn", alone, states))
    assert joined.largest_load == pytest.approx(max(one.largest_load for one in alone), rel=1e-14)
    np.testing.assert_allclose(joined.bowed(q), np.concatenate(of_each("bowed", alone, states)))


def test_the_slopes_of_each_ring_follow_its_own():
    """c of the row that joins the ends of a ring across its slope vanishes along the slope alone."""
    (cable, *_), turned = cables(2), [[0.0, 1.0], [-1.0, 0.0]]
    rings = [replace(cable, closed=True, fixed=np.zeros_like(cable.fixed)) for _ in range(2)]
    (joined,) = potentials_of(rings, [np.zeros(cable.reference.shape)] * 2, 0.0)
    states = [cable.reference, cable.reference @ np.array(turned)]
    alone = [potential_of([cable], np.zeros(cable.reference.shape), 0.0) for cable in rings]
    for potential, q in zip([joined, *alone], [np.concatenate(states), *states], strict=True):
        potential.turn_with(q)
    expected = block_diag(of_each("jacobian", alone, states)).toarray()
    np.testing.assert_allclose(joined.jacobian(np.concatenate(states)).toarray(), expected, atol=1e-14)


def test_cables_of_other_kinds_remain_apart():
    plain, stretching = cables(2), cables(2, **KINDS["stretching"])
    own = [*plain[:2], stretching[0], plain[2], replace(plain[0], length_constraints=0)]
    found = potentials_of(own, [np.zeros(cable.reference.shape) for cable in own], 0.0)
    assert [len(one.cables) for one in found] == [2, 1, 1, 1]
