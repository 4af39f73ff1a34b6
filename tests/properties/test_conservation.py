"""What a cable keeps: momentum, angular momentum, energy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exudyn_inext.integrators import INTEGRATORS
from tests.cables import bending_energy, dense_mass, kinetic_energy
from tests.properties.moving_cables import (
    SAME,
    STEPS,
    H,
    moving_cable,
    moving_ring,
    numbers,
    run,
    seeds,
    supports_of_cables,
)


def with_start(state, **options):
    """(6, 2, n, 2, dim) q and v at the start and during a short motion."""
    history = run(state, **options)[:, :2]
    return np.concatenate([[np.stack([state.q, state.v])], history])


def momenta(cable, history, mass_scaling=0.0):
    """(t, n, 2, dim) generalised momenta M v; those of the positions add up to the momentum."""
    mass = dense_mass(cable, mass_scaling)
    return np.stack([(mass @ v.ravel()).reshape(v.shape) for v in history[:, 1]])


def angular_momentum(history, momentum):
    """(t, dim, dim) of the whole cable about the origin; slopes turn with it."""
    product = np.einsum("tkai,tkaj->tij", history[:, 0], momentum)
    return product - product.transpose(0, 2, 1)


def is_constant(found):
    np.testing.assert_allclose(found, np.broadcast_to(found[0], found.shape), atol=SAME)


def without_forces(state):
    return replace(state, external=0 * state.external)


@pytest.mark.parametrize("name", INTEGRATORS)
@given(seed=seeds, number=numbers)
def test_momentum_of_a_free_cable_grows_with_the_sum_of_its_forces(name, seed, number):
    state = moving_cable(seed, number, 2)
    found = momenta(state.cable, with_start(state, name=name))[:, :, 0].sum(axis=1)
    growth = np.multiply.outer(H * STEPS / 5 * np.arange(6), state.external[:, 0].sum(axis=0))
    np.testing.assert_allclose(found, found[0] + growth, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@given(seed=seeds, number=numbers, theta=st.sampled_from([0.0, 0.3]))
def test_rattle_keeps_the_angular_momentum_of_a_free_cable(dim, seed, number, theta):
    """With mass scaling it is that of the scaled mass."""
    state, scaling = without_forces(moving_cable(seed, number, dim)), theta * H**2
    history = with_start(state, mass_scaling=scaling)
    is_constant(angular_momentum(history, momenta(state.cable, history, scaling)))


@given(seed=seeds, number=st.integers(5, 8))
def test_rattle_keeps_momentum_and_angular_momentum_of_a_free_ring(seed, number):
    state = without_forces(moving_ring(seed, number, 2))
    history = with_start(state)
    momentum = momenta(state.cable, history)
    is_constant(momentum[:, :, 0].sum(axis=1))
    is_constant(angular_momentum(history, momentum))


def energy(state, history):
    """(t,) kinetic and bending energy less the work of the constant forces."""
    motion = [kinetic_energy(state.cable, v) for v in history[:, 1]]
    bending = [bending_energy(state.cable, q) for q in history[:, 0]]
    return np.array(motion) + bending - np.sum(state.external * history[:, 0], axis=(1, 2, 3))


@pytest.mark.parametrize("dim", [2, 3])
@given(seed=seeds, number=numbers, supports=supports_of_cables)
def test_energy_of_rattle_is_kept_with_second_order(dim, seed, number, supports):
    """Four times smaller steps, sixteen times smaller errors; half of that is asked for."""
    state = moving_cable(seed, number, dim, supports)
    coarse, fine = (np.ptp(energy(state, with_start(state, h=H / n, steps=STEPS * n))) for n in (1, 4))
    assert fine < coarse / 8 + SAME
