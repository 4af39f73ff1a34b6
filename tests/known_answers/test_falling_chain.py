"""The falling folded chain: both ends side by side at first, one held, the other let go.

While the free end falls by x, the part that still moves, (L - x) / 2 long, keeps all of the energy:
v^2 = 2 g x (1 - x / 2L) / (1 - x / L). The end falls faster than a stone and is down after 0.847 of its time.

M. G. Calkin, R. H. March, The dynamics of a falling chain: I, American Journal of Physics 57 (1989) 154-157.
M. Schagerl, A. Steindl, W. Steiner, H. Troger, On the paradox of the free falling folded chain, Acta
Mechanica 125 (1997) 155-168.

A cable with a fold of radius R and EI = R^2 / 40 (rho_A = g L = 1) approaches that chain as R falls.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from exudyn_inext.cable.cable import Section
from exudyn_inext.loads.gravity import gravity_force
from tests.cables import State, bending_energy, dense_mass, straight_cable
from tests.moving import move

LENGTH, RHO, G = 1.0, 1.0, 9.81
END = 0.36  # the ideal chain's end is down at 0.3825 s
LEVELS = np.array([0.2, 0.4, 0.6, 0.8])
RADII = (0.02, 0.01, 0.005)


def ideal_speed(x):
    return np.sqrt(2.0 * G * x * (1.0 - 0.5 * x / LENGTH) / (1.0 - x / LENGTH))


def ideal_time(x):
    """int dx / v, with x = LENGTH u^2 to take out its singularity at the start."""
    return quad(lambda u: 2.0 * LENGTH * u / ideal_speed(LENGTH * u * u), 0.0, np.sqrt(x / LENGTH))[0]


def folded(radius):
    """(n, 2, 2) down from the origin, half round, and up to the same height; the fold has 3.8 elements."""
    number = round(1.2 * LENGTH / radius)
    straight = 0.5 * (LENGTH - np.pi * radius)
    s = np.linspace(0.0, LENGTH, number + 1)
    angle = np.clip((s - straight) / radius, 0.0, np.pi)
    down, up = np.minimum(s, straight), np.maximum(s - straight - np.pi * radius, 0.0)
    positions = np.stack([radius - radius * np.cos(angle), up - down - radius * np.sin(angle)], axis=1)
    return np.stack([positions, np.stack([np.sin(angle), -np.cos(angle)], axis=1)], axis=1)


@dataclass(frozen=True)
class Fall:
    """t [s], the free end's x [m] and v [m/s] downwards, energy [J] that changes hands."""

    t: Any
    x: Any
    v: Any
    kinetic: Any
    potential: Any


@cache
def fall(radius, refinement=1):
    q = folded(radius)
    number = len(q) - 1
    section = Section(RHO, radius**2 / 40.0)
    cable = straight_cable(number, 2, "pinned", LENGTH, section=section)
    cable, weight = replace(cable, reference=q), gravity_force(cable, np.array([0.0, -G]))
    h = 0.005 * radius / refinement
    steps = round(END / h / 36) * 36
    history = move(State(cable, q, 0.0 * q, weight), h, steps, steps // 36)
    mass = dense_mass(cable)
    kinetic = np.array([0.5 * v.ravel() @ mass @ v.ravel() for v in history[:, 1]])
    potential = np.array([bending_energy(cable, q) - np.sum(weight * q) for q in history[:, 0]])
    start = bending_energy(cable, q) - np.sum(weight * q)
    return Fall(
        h * (steps // 36) * np.arange(1, 37),
        q[-1, 0, 1] - history[:, 0, -1, 0, 1],
        -history[:, 1, -1, 0, 1],
        kinetic,
        potential - start,
    )


def test_ideal_chain_is_down_after_0_847_of_the_time_of_a_free_fall():
    ratio = ideal_time(LENGTH * (1 - 1e-12)) / np.sqrt(2.0 * LENGTH / G)
    assert ratio == pytest.approx(0.84721, abs=1e-5)


def arrival_errors(radius):
    """Relative, at `LEVELS`."""
    found = fall(radius)
    times = np.array([ideal_time(x) for x in found.x])
    return np.interp(LEVELS, found.x, found.t / times - 1.0)


def test_free_end_falls_faster_than_a_stone_all_the_time():
    found = fall(RADII[-1])
    ahead = found.x - 0.5 * G * found.t**2
    assert (np.diff(ahead, prepend=0.0) > 0.0).all()
    assert (found.v > G * found.t).all()
    assert ahead[-1] > 0.14 * LENGTH


def test_times_of_arrival_converge_to_those_of_the_ideal_chain_as_the_fold_gets_smaller(known_answer):
    """With first order at least: the fold hides a length of the order of its radius."""
    errors = np.array([np.abs(arrival_errors(radius)).max() for radius in RADII])
    assert (errors < 0.1 * np.array(RADII)).all()
    orders = np.log2(errors[:-1] / errors[1:])
    assert (orders > 0.9).all()
    known_answer(
        "folded chain that falls: times of arrival, as the fold gets smaller", errors[-1], orders.mean()
    )


@pytest.mark.parametrize("radius", RADII)
def test_speed_of_the_free_end_is_that_which_its_energy_asks_for(radius):
    """Waves that the fold sends up the falling part pass through the end; they get weaker with it."""
    found = fall(radius)
    late = found.x > 0.1 * LENGTH
    np.testing.assert_allclose(found.v[late], ideal_speed(found.x[late]), rtol=radius)


def test_energy_is_kept_with_second_order_while_all_of_it_changes_hands(known_answer):
    coarse, fine = (fall(RADII[0], n) for n in (1, 2))
    errors = [np.abs(run.kinetic + run.potential).max() / run.kinetic.max() for run in (coarse, fine)]
    assert errors[0] < 3e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)
    known_answer("folded chain that falls: energy", errors[1], np.log2(errors[0] / errors[1]))
    falling = 0.25 * (LENGTH - coarse.x[-1]) * RHO * coarse.v[-1] ** 2
    assert coarse.kinetic[-1] == pytest.approx(falling, rel=0.1)
