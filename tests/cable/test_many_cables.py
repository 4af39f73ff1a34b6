"""Cables in one set of records move as each of them alone."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.attached import Drag, PointMass
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.cable.many_cables import cable_systems, in_few_chains
from exudyn_inext.system import accelerate_and_project, correct_position, index_reduced_rates
from tests.cables import DIMENSIONS, MEASURES, random_state

pytestmark = pytest.mark.kernel
ZETA = 7.0


KINDS = ((3, None, "free"), (5, 2, "clamped"), (4, 3, "pinned"), (1, None, "pinned and guided"))


def states(dim, measure, number=4):
    return [
        random_state(seed, elements, dim, measure, n_bar, supports)
        for seed, (elements, n_bar, supports) in enumerate(KINDS[:number])
    ]


def evaluate(system, external, q, v):
    """Accelerations and rates of the stabilised equations, those of RATTLE, and a step to the manifold."""
    a, rate, b, end, d = np.zeros((5, q.size))
    index_reduced_rates(system, external, q, v, a, rate)
    accelerate_and_project(system, external, q, v, 1e-3, b, end)
    worst = correct_position(system, external, q, 0.0, 0.0, d)
    return np.stack([a, rate, b, end, d]), worst


@pytest.mark.parametrize("dim", DIMENSIONS)
@pytest.mark.parametrize("measure", MEASURES)
def test_each_moves_as_alone_bit_for_bit(dim, measure):
    alone = states(dim, measure)
    systems = [cable_system(state.cable, ZETA) for state in alone]
    inputs = [(state.inputs, state.q.ravel(), state.v.ravel()) for state in alone]
    expected = [evaluate(system, *given) for system, given in zip(systems, inputs, strict=True)]
    ((whole, parts),) = in_few_chains(systems)
    found, worst = evaluate(whole, *(np.concatenate(arrays) for arrays in zip(*inputs, strict=True)))
    np.testing.assert_array_equal(found, np.concatenate([values for values, _ in expected], axis=1))
    assert worst == max(violation for _, violation in expected)
    multipliers = [system.chain.elements["multiplier"] for system in systems]
    for part, multiplier in zip(parts, multipliers, strict=True):
        np.testing.assert_array_equal(part.chain.elements["multiplier"], multiplier)


def various_cables():
    """Each followed by one that differs from it in one respect alone."""
    plain, other = (random_state(seed, 4, 2, MEASURES[0], 2, "clamped").cable for seed in (1, 2))
    section, last = plain.section, np.linspace(0.2, 0.4, 4)
    changes = [
        {"reference": other.reference},
        {"fixed": ~plain.fixed},
        {"element_lengths": last},
        {"section": replace(section, mass_per_length=3.0)},
        {"section": replace(section, bending_damping=0.1)},
        {"section": replace(section, natural_curvature=0.3, strain_is_relative=1.0)},
        {"section": replace(section, axial_stiffness=1e3)},
        {"measure": MEASURES[1]},
        {"length_constraints": 4},
        {"straight_lengths": not plain.straight_lengths},
        {"point_masses": (PointMass(0.3, 2.0),)},
        {"drag": Drag(1.0, 0.5, (0.0, 1.0))},
    ]
    first = [replace(plain, **change) for change in changes]
    return [plain, *first, *(replace(cable, reference=1.5 * cable.reference) for cable in first)]


def test_systems_of_many_cables_are_those_of_each_bit_for_bit():
    cables, implicit = various_cables(), ImplicitBending(1e-3)
    together = cable_systems(cables, ZETA, implicit)
    for cable, found in zip(cables, together, strict=True):
        expected = cable_system(cable, ZETA, implicit)
        assert found.zeta == expected.zeta and found.chain.axes == expected.chain.axes
        for records in ("nodes", "elements"):
            one, other = getattr(found.chain, records), getattr(expected.chain, records)
            assert one.dtype == other.dtype
            for field in one.dtype.names:
                np.testing.assert_array_equal(one[field], other[field])


def test_systems_of_many_cables_share_no_memory():
    cable = various_cables()[0]
    one, other = cable_systems([cable, cable], ZETA)
    assert not np.shares_memory(one.chain.nodes, other.chain.nodes)
    assert not np.shares_memory(one.chain.elements, other.chain.elements)


def test_systems_of_later_calls_are_as_new():
    """What they have in common is kept, and what earlier ones do with their memory is not."""
    cable = various_cables()[0]
    kept = [records.tobytes() for records in cable_system(cable, ZETA).chain[1:]]
    for _ in range(3):
        (system,) = cable_systems([cable], ZETA)
        for records, expected in zip(system.chain[1:], kept, strict=True):
            assert records.tobytes() == expected
            records[:] = np.zeros_like(records)


def test_parts_share_the_memory_of_the_whole():
    systems = [cable_system(state.cable, ZETA) for state in states(2, MEASURES[0])]
    ((whole, parts),) = in_few_chains(systems)
    for part in parts:
        assert np.shares_memory(part.chain.nodes, whole.chain.nodes)
        assert np.shares_memory(part.chain.elements, whole.chain.elements)


def test_only_cables_of_one_kind_that_follow_each_other_are_put_together():
    planar, product = (states(2, measure, number=2) for measure in MEASURES)
    order = [*planar, *product, *states(3, MEASURES[0], number=1), planar[0]]
    groups = in_few_chains([cable_system(state.cable, ZETA) for state in order])
    assert [len(parts) for _, parts in groups] == [2, 2, 1, 1]
    assert all(whole is parts[0] for whole, parts in groups if len(parts) == 1)


def test_a_cable_without_length_constraints_remains_alone():
    free = random_state(1, 3, 2, MEASURES[0], n_bar=0)
    systems = [cable_system(state.cable, ZETA) for state in (free, free, *states(2, MEASURES[0], number=2))]
    assert [len(parts) for _, parts in in_few_chains(systems)] == [1, 1, 2]


def test_what_a_cable_does_not_have_needs_no_code_of_its_own():
    """Damping, drag and natural curvature are flags in records of one type."""
    plain = random_state(3, 3, 2, MEASURES[0]).cable
    section = replace(plain.section, bending_damping=0.1, natural_curvature=0.3)
    rich = replace(plain, section=section, drag=Drag(1.0, 0.5, (0.0, 1.0)))
    one, other = build_chain(plain).elements, build_chain(rich).elements
    assert one.dtype == other.dtype
    for flag in ("curved", "damped", "dragged"):
        assert not one[flag].any() and other[flag].all()
    systems = [cable_system(cable, ZETA) for cable in (plain, replace(rich, drag=None))]
    assert len(in_few_chains(systems)) == 2  # all cables of a chain are damped, or none
