"""Small vibrations of a cable: from its matrices and constraints, and read off a run in time."""

import numpy as np
from scipy.linalg import eigh, null_space

from exudyn_inext.statics import potential_of


def squared_frequencies(cable, external=None):
    """(m,) w^2 [1/s^2] of small vibrations about the reference, an equilibrium, and (m, n, 2, dim) modes."""
    q = cable.reference
    potential = potential_of([cable], np.zeros(q.shape) if external is None else external, 0.0)
    jacobian, force = potential.jacobian(q).toarray(), potential.force(q)
    multipliers = np.linalg.lstsq(jacobian.T, force, rcond=1e-12)[0]
    np.testing.assert_allclose(jacobian.T @ multipliers, force, atol=1e-9 * (1.0 + np.abs(force).max()))
    free = null_space(jacobian, rcond=1e-9)
    hessian, mass = potential.hessian(q, multipliers).toarray(), potential.mass.toarray()
    squares, modes = eigh(free.T @ hessian @ free, free.T @ mass @ free)
    return squares, (free @ modes).T.reshape(-1, *q.shape)


def natural_frequencies(cable, external=None):
    """(m,) w [rad/s] about the reference, a stable equilibrium, and (m, n, 2, dim) modes."""
    squares, modes = squared_frequencies(cable, external)
    assert squares[0] > -1e-9 * squares[-1]
    return np.sqrt(np.abs(squares)), modes


def sampled_frequency(samples, interval):
    """w [rad/s] of a sampled harmonic: u(t - dt) + u(t + dt) = 2 cos(w dt) u(t)."""
    inner, outer = samples[1:-1], samples[2:] + samples[:-2]
    return np.arccos(0.5 * (inner @ outer) / (inner @ inner)) / interval


def observed_order(errors):
    """(k - 1,) orders of convergence from errors of which each has half the step of the one before."""
    return np.log2(np.divide(errors[:-1], errors[1:]))
