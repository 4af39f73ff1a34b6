"""Work along a way of steps, against integrals by hand."""

import numpy as np
import pytest

from exudyn_inext.scene.path_work import (
    LACK,
    SUMS,
    begin_path,
    build_path,
    expect_energy,
    follow,
    gather,
    take_sums,
)

pytestmark = pytest.mark.kernel


def follow_way(positions, forces):
    """(work, scatter) of (steps + 1, n) positions and forces."""
    path = build_path(positions.shape[1])
    begin_path(path, positions[0], forces[0])
    for q, force in zip(positions[1:], forces[1:], strict=True):
        follow(path, q, force)
    return take_sums(path)


@pytest.mark.parametrize("stiffness", [3.0, -1.0])
def test_work_of_linear_springs_is_exact_and_known_to_be(stiffness):
    positions = np.random.default_rng(2).standard_normal((20, 3))
    work, scatter = follow_way(positions, -stiffness * positions)
    assert work == pytest.approx(
        0.5 * stiffness * (positions[0] @ positions[0] - positions[-1] @ positions[-1])
    )
    assert scatter < 1e-28


@pytest.mark.parametrize(
    ("position", "force", "integral", "lack"),
    [
        (lambda t: t, lambda t: t**2, 1.0 / 3.0, -1.0 / 6.0),  # -f'' q' / 12
        (lambda t: t**2, lambda t: t, 2.0 / 3.0, 1.0 / 6.0),  # f' q'' / 12
        (lambda t: t**2, lambda t: t**2, 0.5, 0.0),
    ],
)
def test_what_the_rule_lacks_is_what_its_scatter_tells(position, force, integral, lack):
    t = np.linspace(0.0, 1.0, 101)[:, np.newaxis]
    work, scatter = follow_way(position(t), force(t))
    assert integral - work == pytest.approx(lack / 100**2, rel=1e-9, abs=1e-14)
    assert np.sqrt(100 * scatter) == pytest.approx(abs(lack) / 100**2, rel=0.01, abs=1e-14)


def test_coordinates_add_up_before_the_lack_is_squared():
    """Two forces whose lacks cancel, as those of a spring between two coordinates."""
    t = np.linspace(0.0, 1.0, 11)
    positions, forces = np.column_stack([t, t**2]), np.column_stack([t**2, t])
    _, scatter = follow_way(positions, forces)
    (_, one), (_, other) = (follow_way(positions[:, [k]], forces[:, [k]]) for k in range(2))
    assert scatter < 1e-30 < min(one, other)


def test_sums_begin_anew_and_the_way_goes_on():
    t = np.linspace(0.0, 1.0, 21)[:, np.newaxis]
    positions, forces = np.sin(t), np.cos(3.0 * t)
    whole = follow_way(positions, forces)
    path, parts = build_path(1), []
    begin_path(path, positions[0], forces[0])
    for k in range(1, 21):
        follow(path, positions[k], forces[k])
        if k in (7, 20):
            parts.append(take_sums(path))
    np.testing.assert_allclose(np.sum(parts, axis=0), whole, rtol=1e-12)


def test_forces_are_taken_from_a_system_vector_and_followed():
    vector, places = np.array([5.0, 7.0, 11.0, 13.0]), np.array([2, 0, -1])
    force, q = np.zeros(3), np.array([1.0, 2.0, 3.0, 4.0])
    gather(vector, places, force)
    np.testing.assert_array_equal(force, [11.0, 5.0, 0.0])
    path = build_path(3)
    begin_path(path, np.zeros(4), force)
    gather(2.0 * vector, places, force)
    follow(path, q, force)
    np.testing.assert_array_equal(force, [22.0, 10.0, 0.0])
    assert take_sums(path)[0] == pytest.approx(1.5 * (11.0 * 1.0 + 5.0 * 2.0))


def largest_lack(positions, forces, energy=0.0, tolerance=0.003):
    path = build_path(1)
    begin_path(path, positions[:1], forces[:1])
    expect_energy(path, energy, 0.0, tolerance)
    for q, force in zip(positions[1:], forces[1:], strict=True):
        follow(path, np.array([q]), np.array([force]))
    return path[SUMS, LACK]


def test_linear_springs_lack_no_work_and_a_stop_does():
    positions = 0.3 - 0.2 * np.arange(4.0)
    assert largest_lack(positions, -5.0 * positions, energy=1.0) < 1e-15
    stop = 60.0 * np.maximum(-positions, 0.0)  # from 0.1 to -0.1 m, and on
    assert largest_lack(positions, stop, energy=2.0) == pytest.approx(6.0 * 0.2 / 12.0 / 2.0)


@pytest.mark.parametrize("tolerance", [0.003, 1e-5])
def test_a_force_that_sets_in_at_rest_is_no_lack(tolerance):
    """Under unit force, in steps of any length; the same force in motion is one."""
    steps = np.arange(20.0)
    forces = np.where(steps > 0.0, 1.0, 0.0)
    assert 0.0 < largest_lack(0.5 * steps**2, forces, tolerance=tolerance) < tolerance
    assert largest_lack(steps, np.where(steps > 5.0, 1.0, 0.0), energy=1.0, tolerance=tolerance) > tolerance
