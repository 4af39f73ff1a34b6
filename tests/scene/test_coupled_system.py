"""Parts that keep their own solves, coupled by joints, are one dense saddle-point system."""

import numpy as np
import pytest

from exudyn_inext import RedundantConstraintError
from exudyn_inext.system import accelerate_and_project, correct_position, index_reduced_rates
from tests.cables import relative_error
from tests.scene.scenes import TIME, solve_dense, whole

pytestmark = pytest.mark.kernel

ZETA = 5.0
NOW = np.array([TIME])
scenes = pytest.mark.parametrize(
    "scene",
    [{"dim": 2}, {"dim": 3}, {"dim": 2, "damped": True}, {"dim": 2, "linked": True}, {"dim": 2, "joints": 0}],
    ids=str,
)


@scenes
@pytest.mark.parametrize("seed", [1, 2])
def test_rates_are_those_of_the_dense_system(seed, scene):
    all_of_it = whole(seed, zeta=ZETA, **scene)
    a, rate = np.zeros(len(all_of_it.q)), np.zeros(len(all_of_it.q))
    index_reduced_rates(all_of_it.system, NOW, all_of_it.q, all_of_it.v, a, rate)
    mass, force, terms = all_of_it.dense()
    expected, nu = solve_dense(mass, terms["jacobian"], force, terms["gamma"] - ZETA * terms["rate"])
    assert relative_error(a, expected) < 1e-9
    joints = len(all_of_it.system.multipliers)
    np.testing.assert_allclose(all_of_it.system.multipliers, nu[len(nu) - joints :], rtol=1e-8, atol=1e-9)
    target = -ZETA * terms["value"] - terms["rate"]
    correction, _ = solve_dense(mass, terms["jacobian"], np.zeros(len(force)), target)
    assert relative_error(rate, all_of_it.v + correction) < 1e-9


@scenes
def test_projection_is_that_of_the_dense_system(scene):
    all_of_it, duration = whole(3, **scene), 0.07
    a = 0.1 * np.random.default_rng(0).standard_normal(len(all_of_it.q))
    mass, force, terms = all_of_it.dense(duration, a.copy())
    end = np.zeros(len(a))
    accelerate_and_project(all_of_it.system, NOW, all_of_it.q, all_of_it.v, duration, a, end)
    expected, _ = solve_dense(mass, terms["jacobian"], force, terms["gamma"])
    assert relative_error(a, expected) < 1e-9
    reached = all_of_it.v + duration * expected
    target = -terms["drift"] - terms["jacobian"] @ reached
    correction, _ = solve_dense(mass, terms["jacobian"], np.zeros(len(force)), target)
    assert relative_error(end, reached + correction) < 1e-9


@scenes
def test_position_correction_leads_back_along_the_last_jacobian(scene):
    all_of_it = whole(4, **scene)
    memory, correction = (np.zeros(len(all_of_it.q)) for _ in range(2))
    accelerate_and_project(all_of_it.system, NOW, all_of_it.q, all_of_it.v, 0.0, memory, correction)
    worst = correct_position(all_of_it.system, NOW, all_of_it.q, 1e-12, 0.0, correction)
    mass, _, terms = all_of_it.dense()
    expected, _ = solve_dense(mass, terms["jacobian"], np.zeros(len(mass)), -terms["value"])
    assert relative_error(correction, expected) < 1e-9
    joints = len(all_of_it.system.multipliers)
    assert worst >= np.abs(terms["value"][len(terms["value"]) - joints :]).max(initial=0.0)


def test_repeated_corrections_reach_the_manifold_of_all_constraints():
    all_of_it = whole(5, dim=2)
    q, memory, correction = all_of_it.q.copy(), *(np.zeros(len(all_of_it.q)) for _ in range(2))
    accelerate_and_project(all_of_it.system, NOW, q, all_of_it.v, 0.0, memory, correction)
    for _ in range(60):
        if correct_position(all_of_it.system, NOW, q, 1e-12, 0.0, correction) < 1e-12:
            break
        q += correction
    all_of_it.q = q
    assert np.abs(all_of_it.dense()[2]["value"]).max() < 1e-11


def test_what_a_step_lacked_is_learned():
    all_of_it = whole(6, dim=2)
    memory, correction = (np.zeros(len(all_of_it.q)) for _ in range(2))
    accelerate_and_project(all_of_it.system, NOW, all_of_it.q, all_of_it.v, 0.0, memory, correction)
    correct_position(all_of_it.system, NOW, all_of_it.q, 1e-12, 200.0, correction)
    expected = -200.0 * all_of_it.rule.value(TIME, all_of_it.q)
    np.testing.assert_allclose(all_of_it.system.drift_correction, expected)
    a = np.zeros(len(all_of_it.q))
    accelerate_and_project(all_of_it.system, NOW, all_of_it.q, all_of_it.v, 0.0, a, correction)
    jacobian = all_of_it.rule.jacobian(all_of_it.q)
    np.testing.assert_allclose(jacobian @ a, all_of_it.rule.gamma(TIME, all_of_it.v) + expected, rtol=1e-9)


def test_a_joint_that_stands_twice_is_named():
    all_of_it = whole(7, dim=2)
    rule = all_of_it.rule
    rule.linear[2], rule.quadratic[2] = rule.linear[0], rule.quadratic[0]
    a, rate = np.zeros(len(all_of_it.q)), np.zeros(len(all_of_it.q))
    with pytest.raises(RedundantConstraintError, match=r"joint 2, .* is not independent"):
        index_reduced_rates(all_of_it.system, NOW, all_of_it.q, all_of_it.v, a, rate)
    rule.linear[2, 0] = np.nan
    with pytest.raises(RedundantConstraintError, match="not finite"):
        index_reduced_rates(all_of_it.system, NOW, all_of_it.q, all_of_it.v, a, rate)
