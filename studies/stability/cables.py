"""Cables in equilibrium, at rest or spinning, whose small vibrations decide on the step. Without Exudyn."""

from dataclasses import dataclass, replace

import numpy as np

from exudyn_inext.arrays import Array
from exudyn_inext.chain.attached import PointMass
from exudyn_inext.chain.border import all_links, motions_of
from exudyn_inext.chain.cable import Cable, CurvatureMeasure, Section
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.statics import Potential, StaticOptions, find_equilibrium
from reference_models.scenes import load_scene

_OWN = load_scene("planar_pendulum").cable
LENGTH = _OWN.length  # [m]
DENSITY = _OWN.section.mass_per_length  # rho_A [kg/m]
STIFFNESS = _OWN.section.bending_stiffness  # EI [N m^2]
GRAVITY = 9.81  # [m/s^2]


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A cable, its coordinates and velocities (n, 2, 2), and the external force (n, 2, 2)."""

    cable: Cable
    q: Array
    v: Array
    external: Array

    @property
    def element_length(self) -> float:
        return float(self.cable.element_lengths[0])

    @property
    def inputs(self) -> Array:
        """(n_external,) what a system takes: the force, and the anchors of links at rest."""
        motions = [motion.at(0.0).ravel() for motion in motions_of(all_links(self.cable))]
        return np.concatenate([self.external.ravel(), *motions])


def _cable(
    nodes: Array,
    fixed: Array,
    stiffness: float,
    natural: float = 0.0,
    closed: bool = False,
    mass: float = 0.0,
) -> Cable:
    number = len(nodes) - 1
    return Cable(
        reference=nodes,
        element_lengths=np.full(number, LENGTH / number),
        section=Section(DENSITY, stiffness, natural),
        measure=CurvatureMeasure.SECOND_DERIVATIVE,
        length_constraints=number,
        fixed=fixed,
        closed=closed,
        point_masses=(PointMass(LENGTH, mass),) if mass else (),
    )


def _line(elements: int, direction: tuple[float, float]) -> Array:
    nodes = np.zeros((elements + 1, 2, 2))
    nodes[:, 0] = np.outer(np.linspace(0.0, LENGTH, elements + 1), direction)
    nodes[:, 1] = direction
    return nodes


def _held(elements: int, *held: tuple[int, int]) -> Array:
    """(n, 2) flags; held: pairs of node and 0 (position) or 1 (slope)."""
    fixed = np.zeros((elements + 1, 2), dtype=bool)
    for node, what in held:
        fixed[node, what] = True
    return fixed


def straight(elements: int, stiffness: float = STIFFNESS) -> Equilibrium:
    """Pinned at its start, without loads."""
    cable = _cable(_line(elements, (1.0, 0.0)), _held(elements, (0, 0)), stiffness)
    zero = np.zeros_like(cable.reference)
    return Equilibrium(cable, cable.reference, zero, zero)


def hanging(
    elements: int, gravity: float, stiffness: float = STIFFNESS, tip_mass: float = 1.0
) -> Equilibrium:
    """Pinned at its upper end, with a mass at the lower one, in masses of the cable.

    Without the mass, a limp free end does not hang straight (README, "When to use it").
    """
    mass = tip_mass * DENSITY * LENGTH
    cable = _cable(_line(elements, (0.0, -1.0)), _held(elements, (0, 0)), stiffness, mass=mass)
    force = gravity_force(cable, np.array([0.0, -gravity]))
    return Equilibrium(cable, cable.reference, np.zeros_like(cable.reference), force)


def sagging(elements: int, share: float, gravity: float = GRAVITY) -> Equilibrium:
    """Between two pins at the same height, that share of the cable's length apart [-]; its equilibrium."""
    nodes = _line(elements, (share, 0.0))
    straight_cable = _cable(nodes, _held(elements, (0, 0), (elements, 0)), STIFFNESS)
    cable = replace(straight_cable, straight_lengths=True)
    force = gravity_force(cable, np.array([0.0, -gravity]))
    place = np.pi * np.linspace(0.0, 1.0, elements + 1)
    angle = -2.0 * np.sqrt(1.0 - share) * np.cos(place)  # of an arch as long as the cable, nearly
    start = nodes.copy()
    start[:, 0, 1] = -2.0 / np.pi * LENGTH * np.sqrt(1.0 - share) * np.sin(place)
    start[:, 1] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    found = _settled(cable, force, start)
    return Equilibrium(cable, found, np.zeros_like(found), force)


def _settled(cable: Cable, force: Array, start: Array) -> Array:
    """(n, 2, 2) stable equilibrium.

    Raises:
        ArithmeticError: none was found.
    """
    found = find_equilibrium(Potential(cable, force, 0.0), start, StaticOptions())
    if not found.converged:
        raise ArithmeticError(f"no equilibrium with {cable.number_of_elements} elements: {found.message}")
    return found.q


def coil(elements: int, turns: float) -> Equilibrium:
    """Clamped at its start, free of stress in that many turns."""
    radius = LENGTH / (2.0 * np.pi * turns)
    angle = np.linspace(0.0, 2.0 * np.pi * turns, elements + 1)
    nodes = np.stack(
        [
            radius * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1),
            np.stack([np.cos(angle), np.sin(angle)], axis=1),
        ],
        axis=1,
    )
    cable = _cable(nodes, _held(elements, (0, 0), (0, 1)), STIFFNESS, natural=1.0 / radius)
    zero = np.zeros_like(nodes)
    return Equilibrium(cable, _settled(cable, zero, nodes), zero, zero)


def ring(elements: int) -> Equilibrium:
    """A free closed ring."""
    radius = LENGTH / (2.0 * np.pi)
    angle = 2.0 * np.pi * np.arange(elements + 1) / elements
    cosine, sine = np.cos(angle), np.sin(angle)
    nodes = np.stack([radius * np.stack([cosine, sine], axis=1), np.stack([-sine, cosine], axis=1)], axis=1)
    nodes[-1] = nodes[0]
    cable = _cable(nodes, _held(elements), STIFFNESS, closed=True)
    zero = np.zeros_like(nodes)
    return Equilibrium(cable, nodes, zero, zero)


def spinning(elements: int, rate: float) -> Equilibrium:
    """Straight, spinning about the pin at its start with that rate [rad/s]; as much mass at its end."""
    mass = DENSITY * LENGTH
    cable = _cable(_line(elements, (1.0, 0.0)), _held(elements, (0, 0)), STIFFNESS, mass=mass)
    v = rate * np.stack([-cable.reference[..., 1], cable.reference[..., 0]], axis=-1)
    return Equilibrium(cable, cable.reference, v, np.zeros_like(v))
