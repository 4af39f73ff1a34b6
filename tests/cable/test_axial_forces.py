"""Axial and bending forces of a cable that stretches."""

import numpy as np
import pytest

from exudyn_inext.cable.axial_energy import static_energy
from exudyn_inext.cable.cable import Cable, CurvatureMeasure, Section
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.system import ACCELERATION_ENERGY, REPORTED, RESOLVED, accelerate_and_project, report_energy

pytestmark = pytest.mark.kernel

AXIAL, BENDING = 40.0, 0.3


def cable_of(q, lengths, curvature=0.0):
    section = Section(1.0, BENDING, curvature, axial_stiffness=AXIAL, axial_strain=0.02)
    fixed = np.zeros(q.shape[:2], dtype=bool)
    measure = CurvatureMeasure.SECOND_DERIVATIVE
    return Cable(q, lengths, section, measure, len(lengths), fixed)


def chain_of(q, lengths, curvature=0.0):
    return build_chain(cable_of(q, lengths, curvature))


def energy(chain, q):
    return static_energy(chain, q, np.zeros(q.shape))


def polygon(number, radius=1.0):
    """Nodes and unit slopes of a closed circle, the first one twice, and lengths of its arcs."""
    angle = np.linspace(0.0, 2.0 * np.pi, number + 1)
    places, slopes = np.stack([np.cos(angle), np.sin(angle)]), np.stack([-np.sin(angle), np.cos(angle)])
    return np.stack([radius * places.T, slopes.T], axis=1), np.full(number, 2 * np.pi * radius / number)


@pytest.mark.parametrize("dim", [2, 3])
def test_forces_are_the_gradient_of_the_energy(dim):
    random = np.random.default_rng(dim)
    lengths = np.array([0.4, 0.5, 0.3])
    straight = np.zeros((4, 2, dim))
    straight[1:, 0, 0], straight[:, 1, 0] = np.cumsum(lengths), 1.0
    chain = chain_of(straight, lengths, curvature=0.7 if dim == 2 else 0.0)
    q = 1.3 * straight + 0.1 * random.standard_normal(straight.shape)
    force = np.zeros(q.shape)
    static_energy(chain, q, force)
    for _ in range(5):
        way = 1e-5 * random.standard_normal(q.shape)
        work = energy(chain, q - way) - energy(chain, q + way)
        assert 2.0 * float(np.sum(force * way)) == pytest.approx(work, rel=1e-6, abs=1e-13)


def test_a_straight_cable_has_the_energy_of_its_strain():
    lengths = np.array([0.4, 0.5, 0.3])
    straight = np.zeros((4, 2, 2))
    straight[1:, 0, 0], straight[:, 1, 0] = np.cumsum(lengths), 1.0
    expected = 0.5 * AXIAL * 0.38**2 * 1.2
    assert energy(chain_of(straight, lengths), 1.4 * straight) == pytest.approx(expected, rel=1e-12)


def test_bending_energy_depends_on_how_much_a_cable_turns_and_not_on_its_stretch():
    q, lengths = polygon(12)
    chain = chain_of(q, lengths)
    of_strain = [0.5 * AXIAL * (stretch - 1.02) ** 2 * 2.0 * np.pi for stretch in (1.0, 1.4)]
    bent = [energy(chain, stretch * q) - other for stretch, other in zip((1.0, 1.4), of_strain, strict=True)]
    assert bent[0] == pytest.approx(0.5 * BENDING * 2.0 * np.pi, rel=1e-3)
    assert bent[1] == pytest.approx(bent[0], rel=1e-12)


@pytest.mark.parametrize("h", [1e-4, 0.1])
def test_axial_vibrations_count_as_far_as_the_step_resolves_them(h):
    """Of the wave cos(pi x), w = pi sqrt(EA / rho_A), the share 1 / (1 + (h w / 2)^2) is left."""
    x, lengths = np.linspace(0.0, 1.0, 33), np.full(32, 1.0 / 32)
    q, along, across = np.zeros((3, 33, 2, 2))
    q[:, 0, 0], q[:, 1, 0] = x, 1.0
    along[:, 0, 0], along[:, 1, 0] = np.cos(np.pi * x), -np.pi * np.sin(np.pi * x)
    across[:, 0, 1], across[:, 1, 1] = along[:, 0, 0], along[:, 1, 0]
    system, rest = cable_system(cable_of(q, lengths), 0.0, ImplicitBending(step=h)), np.zeros(q.size)
    accelerate_and_project(system, rest, q.ravel(), rest, 0.0, rest.copy(), rest.copy())
    shares = []
    for a in (along, across):
        energy_report = np.zeros(REPORTED)
        report_energy(system, rest, q.ravel(), rest, a.ravel(), rest.copy(), energy_report)
        shares.append(np.sqrt(energy_report[RESOLVED] / energy_report[ACCELERATION_ENERGY]))
    share = 1.0 / (1.0 + (0.5 * h * np.pi) ** 2 * AXIAL)
    assert shares == pytest.approx([share, 1.0], rel=1e-3)
