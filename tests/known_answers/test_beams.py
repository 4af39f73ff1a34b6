"""Straight beams: w_k = beta_k^2 sqrt(EI / rho_A) with the textbook's roots beta_k L.

S. P. Timoshenko, D. H. Young, W. Weaver, Vibration Problems in Engineering, Wiley 1974, chapter 5.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from exudyn_inext.cable.cable import Section
from exudyn_inext.cable.link import rest
from exudyn_inext.constraints.prescribed_motion import prescribed
from tests.cables import DIMENSIONS, MEASURES, State, straight_cable
from tests.known_answers.vibrations import natural_frequencies, observed_order, sampled_frequency
from tests.moving import move

LENGTH, SECTION = 1.7, Section(0.3, 0.9)
MODES = np.arange(1, 4)

# Characteristic equation, divided by cosh, and what its k-th root is close to.
ROOTS = {
    "free": (lambda x: np.cos(x) - 1 / np.cosh(x), MODES + 0.5),
    "pinned": (lambda x: np.sin(x) - np.cos(x) * np.tanh(x), MODES + 0.25),
    "clamped": (lambda x: np.cos(x) + 1 / np.cosh(x), MODES - 0.5),
    "both ends pinned": (np.sin, MODES),
    "clamped and pinned": (lambda x: np.sin(x) - np.cos(x) * np.tanh(x), MODES + 0.25),
    "both ends clamped": (lambda x: np.cos(x) - 1 / np.cosh(x), MODES + 0.5),
}


def wave_numbers(supports):
    """(3,) beta_k L."""
    equation, near = ROOTS[supports]
    return np.array([brentq(equation, (x - 0.2) * np.pi, (x + 0.2) * np.pi, xtol=1e-14) for x in near])


def exact(supports):
    """(3,) lowest frequencies of bending [rad/s]."""
    stiffness = SECTION.bending_stiffness / SECTION.mass_per_length
    return (wave_numbers(supports) / LENGTH) ** 2 * np.sqrt(stiffness)


def beam(number, supports, dim=2, **changes):
    return straight_cable(number, dim, supports, LENGTH, section=SECTION, **changes)


def bending_frequencies(cable):
    """(3,) lowest ones that are no rigid motion; in space each of them stands twice."""
    found, _ = natural_frequencies(cable)
    return found[found > 1e-2 * exact("clamped")[0]][: 3 * (cable.dimension - 1)]


def test_roots_are_those_of_the_textbook():
    found = [wave_numbers(supports)[0] for supports in ("free", "pinned", "clamped", "both ends pinned")]
    np.testing.assert_allclose(found, [4.730, 3.927, 1.875, 3.1416], atol=5e-4)


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)
@pytest.mark.parametrize("supports", ROOTS)
def test_frequencies_of_a_beam_converge_with_order_four(supports, measure, known_answer):
    errors = [
        bending_frequencies(beam(number, supports, measure=measure)) / exact(supports) - 1.0
        for number in (12, 24)
    ]
    orders = observed_order(np.array(errors))
    np.testing.assert_allclose(orders, 4.0, atol=0.2)
    what = f"beam, {supports}: three lowest frequencies, N = 24, {measure.value}"
    known_answer(what, np.abs(errors[-1]).max(), orders.mean())


@pytest.mark.parametrize("supports", ROOTS)
def test_beams_vibrate_alike_in_both_directions_across(supports):
    plane, space = (bending_frequencies(beam(6, supports, dim)) for dim in DIMENSIONS)
    np.testing.assert_allclose(space.reshape(3, 2), np.stack([plane, plane], axis=1), rtol=1e-8)


def test_error_of_a_pinned_beam_is_the_leading_term_of_cubic_elements():
    """A cubic element gives w (1 + (beta l)^4 / 1440) to a long harmonic wave."""
    number = 12
    errors = bending_frequencies(beam(number, "both ends pinned")) / exact("both ends pinned") - 1.0
    expected = (np.pi * MODES / number) ** 4 / 1440
    np.testing.assert_allclose(errors, expected, rtol=0.05)


def on_rollers(number):
    """Pinned at one end, its other end moves along x."""
    cable = beam(number, "pinned")
    last = cable.reference[-1, 0]
    return replace(cable, links=tuple(prescribed(number, rest(last), [1])))


RUNS = {
    "free": (beam(4, "free"), "free"),
    "clamped": (beam(4, "clamped"), "clamped"),
    "pinned and on rollers": (on_rollers(4), "both ends pinned"),
}


def lowest_mode(cable, supports):
    """w and the shape (n, 2, dim), at most 1, of the first vibration that is no rigid motion."""
    found, modes = natural_frequencies(cable)
    place = int(np.argmax(found > 0.5 * exact(supports)[0]))
    return found[place], modes[place] / np.abs(modes[place]).max()


def frequency_of_run(cable, w, mode, h, theta=0.0):
    """w [rad/s] of a run of RATTLE over 3 periods that starts straight with the velocities of a mode."""
    state = State(cable, cable.reference, 1e-4 * w * mode, 0.0 * mode)
    every = round(2.0 * np.pi / w / h / 16)
    history = move(state, h, 48 * every, every, mass_scaling=theta * h**2)
    return sampled_frequency(np.tensordot(history[:, 0] - cable.reference, mode, 3), h * every)


@pytest.mark.parametrize("case", RUNS)
def test_run_of_rattle_vibrates_with_the_frequency_of_the_beam(case, known_answer):
    cable, supports = RUNS[case]
    w, mode = lowest_mode(cable, supports)
    h = 2.0 * np.pi / w / 1600
    found = frequency_of_run(cable, w, mode, h)
    assert found == pytest.approx(w, rel=(h * w) ** 2 / 12)
    known_answer(f"beam, {case}: frequency of a run, N = 4", abs(found / exact(supports)[0] - 1.0))
    assert w == pytest.approx(exact(supports)[0], rel=2 * (wave_numbers(supports)[0] / 4) ** 4 / 1440)


@pytest.mark.parametrize("case", RUNS)
def test_frequency_with_scaled_mass_is_off_by_the_second_order_of_its_step(case):
    """M + theta h^2 K under the central difference: sin(h w_h / 2)^2 (1 + theta h^2 w^2) = (h w / 2)^2."""
    cable, supports = RUNS[case]
    (w, mode), theta, errors = lowest_mode(cable, supports), 0.3, []
    for steps in (16, 32, 64):  # a period
        h = 2.0 * np.pi / w / steps
        found = frequency_of_run(cable, w, mode, h, theta)
        sine = 0.5 * h * w / np.sqrt(1.0 + theta * (h * w) ** 2)
        assert found == pytest.approx(2.0 / h * np.arcsin(sine), rel=1e-6)
        errors.append(found / w - 1.0)
    np.testing.assert_allclose(observed_order(np.abs(errors)), 2.0, atol=0.2)


def damped_harmonic(samples, interval):
    """w and decay rate [1/s] of exp(-decay t) sin(w t): each sample follows from the two before it."""
    (first, second), *_ = np.linalg.lstsq(
        np.stack([samples[1:-1], samples[:-2]], axis=1), samples[2:], rcond=None
    )
    factor = np.sqrt(-second)
    return np.arccos(0.5 * first / factor) / interval, -np.log(factor) / interval


def test_a_damped_cantilever_decays_with_half_of_d_w_squared_over_ei(known_answer):
    """A moment EI kappa + D kappa_t damps each mode for itself; the frequency falls as an oscillator's."""
    cable, supports = RUNS["clamped"]
    w, mode = lowest_mode(cable, supports)
    decay = 0.01 * w
    damping = 2.0 * decay / w**2 * SECTION.bending_stiffness
    cable = replace(cable, section=replace(SECTION, bending_damping=damping))
    h, every = 2.0 * np.pi / w / 16000, 1000
    state = State(cable, cable.reference, 1e-4 * w * mode, 0.0 * mode)
    history = move(state, h, 48 * every, every)
    samples = np.tensordot(history[:, 0] - cable.reference, mode, 3)
    found = damped_harmonic(samples, h * every)
    np.testing.assert_allclose(found, [np.sqrt(w**2 - decay**2), decay], rtol=1e-5)
    known_answer("cantilever with bending damping: decay rate", abs(found[1] / decay - 1.0))
