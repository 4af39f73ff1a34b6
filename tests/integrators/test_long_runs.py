"""Long runs of the undamped planar pendulum decide which integrator can be trusted."""

import numpy as np
import pytest

from exudyn_inext.cable.cable import Cable, CurvatureMeasure, Section
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.constraints import constraints_of_cable
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import LoadHistory, record
from exudyn_inext.loads.gravity import gravity_force

ELEMENTS, LENGTH, SECTION = 5, 1.8, Section(0.034768131560984385, 0.08664512538600652)
SUBSTEPS = 10


def pendulum():
    reference = np.zeros((ELEMENTS + 1, 2, 2))
    reference[:, 0, 0] = np.linspace(0.0, LENGTH, ELEMENTS + 1)
    reference[:, 1, 0] = 1.0
    fixed = np.zeros((ELEMENTS + 1, 2), dtype=bool)
    fixed[0, 0] = True
    lengths = np.full(ELEMENTS, LENGTH / ELEMENTS)
    return Cable(reference, lengths, SECTION, CurvatureMeasure.SECOND_DERIVATIVE, ELEMENTS, fixed)


def run(name, h, steps, zeta=100.0):
    """q and v after every SUBSTEPS steps, each (steps / SUBSTEPS, n, 2, dim); and the cable."""
    cable = pendulum()
    system, integrator = CableSystem(build_chain(cable), zeta), INTEGRATORS[name]
    state = integrator.allocate(cable.reference.size, cable.reference.size)
    state.q[:] = cable.reference.ravel()
    gravity = gravity_force(cable, np.array([0.0, -9.81])).ravel()
    integrator.start(system, gravity, state)
    loads = LoadHistory(gravity, np.zeros((0, gravity.size)), np.zeros((steps, 1, 0)))
    history = np.zeros((steps // SUBSTEPS, 3, gravity.size))
    record(integrator, integrator.scheme(), system, loads, state, h, SUBSTEPS, history)
    shape = (len(history), *cable.reference.shape)
    return history[:, 0].reshape(shape), history[:, 1].reshape(shape), cable


def relative_energy(q, v):
    """Energy change over the swing (the largest kinetic energy); textbook beam matrices."""
    l = LENGTH / ELEMENTS  # noqa: E741
    mass = np.array(
        [[156, 22 * l, 54, -13 * l], [22 * l, 4 * l**2, 13 * l, -3 * l**2],
         [54, 13 * l, 156, -22 * l], [-13 * l, -3 * l**2, -22 * l, 4 * l**2]]
    ) * SECTION.mass_per_length * l / 420  # fmt: skip
    stiffness = np.array(
        [[12, 6 * l, -12, 6 * l], [6 * l, 4 * l**2, -6 * l, 2 * l**2],
         [-12, -6 * l, 12, -6 * l], [6 * l, 2 * l**2, -6 * l, 4 * l**2]]
    ) * SECTION.bending_stiffness / l**3  # fmt: skip
    height = np.array([l / 2, l**2 / 12, l / 2, -(l**2) / 12]) * SECTION.mass_per_length * 9.81
    e, e_t = (np.concatenate([x[:, :-1], x[:, 1:]], axis=2) for x in (q, v))
    kinetic = 0.5 * np.einsum("tkai,ab,tkbi->t", e_t, mass, e_t)
    potential = 0.5 * np.einsum("tkai,ab,tkbi->t", e, stiffness, e)
    potential += np.einsum("a,tka->t", height, e[..., 1])
    total = kinetic + potential
    return (total - total[0]) / kinetic.max()


def test_rattle_keeps_energy_and_constraints_over_a_million_steps():
    q, v, cable = run("RATTLE", 2.5e-3, 1_000_000)
    energy = relative_energy(q, v)
    assert np.abs(energy).max() < 1e-4
    first, last = energy[: len(energy) // 10], energy[-len(energy) // 10 :]
    assert abs(last.mean() - first.mean()) < 0.1 * np.ptp(energy)
    constraints = constraints_of_cable(cable)
    assert np.abs(constraints.value(q[-1])).max() < 1e-10
    assert np.abs(constraints.rate(q[-1], v[-1])).max() < 1e-9


def test_zhai_keeps_the_energy_within_a_thousandth_of_the_swing_over_5_s():
    q, v, _ = run("Zhai", 2.5e-3, 2000)
    assert np.abs(relative_energy(q, v)).max() < 1e-3


@pytest.mark.parametrize(("h", "survives"), [(2.5e-3, False), (6.25e-4, True)])
def test_zhai_survives_100_s_only_with_small_steps(h, survives):
    q, v, _ = run("Zhai", h, round(100 / h))
    assert np.isfinite(q).all() == survives
    if survives:
        assert np.abs(relative_energy(q, v)).max() < 1e-3
