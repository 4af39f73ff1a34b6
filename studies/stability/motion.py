"""Cables in equilibrium, at rest or spinning, and compiled motion of one, in portions, without Exudyn."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from exudyn_inext import Rattle, RungeKutta4, Zhai
from reference_models.scenes import load_scene
from reference_models.trajectory import Array
from studies.harness import Row, inner

_OWN = load_scene("planar_pendulum").cable
LENGTH = _OWN.length  # [m]
DENSITY = _OWN.section.mass_per_length  # rho_A [kg/m]
STIFFNESS = _OWN.section.bending_stiffness  # EI [N m^2]
GRAVITY = 9.81  # [m/s^2]
_OWN_MASS = (inner.PointMass(LENGTH, DENSITY * LENGTH),)  # as much as the cable's, at its end


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A cable, its coordinates and velocities (n, 2, 2), and the external force (n, 2, 2)."""

    cable: inner.Cable
    q: Array
    v: Array
    external: Array

    @property
    def element_length(self) -> float:
        return float(self.cable.element_lengths[0])

    @property
    def inputs(self) -> Array:
        """(n_external,) what a system takes: the force, and the anchors of links at rest."""
        motions = [motion.at(0.0).ravel() for motion in inner.motions_of(inner.all_links(self.cable))]
        return np.concatenate([self.external.ravel(), *motions])


def _cable_at(
    nodes: Array,
    held: Sequence[tuple[int, int]] = (),
    gravity: float = 0.0,
    stiffness: float = STIFFNESS,
    natural: float = 0.0,
    **more: Any,
) -> Equilibrium:
    """A cable at rest.   nodes: (n, 2, 2).   held: pairs of node and 0 (position) or 1 (slope).

    more: of `Cable`.
    """
    number = len(nodes) - 1
    fixed = np.zeros((number + 1, 2), dtype=bool)
    for node, what in held:
        fixed[node, what] = True
    cable = inner.Cable(
        reference=nodes,
        element_lengths=np.full(number, LENGTH / number),
        section=inner.Section(DENSITY, stiffness, natural),
        measure=inner.CurvatureMeasure.SECOND_DERIVATIVE,
        length_constraints=number,
        fixed=fixed,
        **more,
    )
    force = inner.gravity_force(cable, np.array([0.0, -gravity]))
    return Equilibrium(cable, nodes, np.zeros_like(nodes), force)


def _settled(start: Equilibrium, guess: Array) -> Equilibrium:
    """In the stable equilibrium near a guess (n, 2, 2).

    Raises:
        ArithmeticError: none was found.
    """
    potential = inner.Potential([start.cable], start.external, 0.0)
    found = inner.find_equilibrium(potential, guess, inner.StaticOptions())
    if not found.converged:
        number = start.cable.number_of_elements
        raise ArithmeticError(f"no equilibrium with {number} elements: {found.message}")
    return replace(start, q=found.q)


def _line(elements: int, direction: tuple[float, float]) -> Array:
    places = np.outer(np.linspace(0.0, LENGTH, elements + 1), direction)
    return np.stack([places, np.tile(direction, (elements + 1, 1))], axis=1)


def _arc(elements: int, turns: float) -> Array:
    """From the origin along x, in circles that curve upwards."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, elements + 1)
    sine, cosine = np.sin(angle), np.cos(angle)
    places = LENGTH / (2.0 * np.pi * turns) * np.stack([sine, 1.0 - cosine], axis=1)
    return np.stack([places, np.stack([cosine, sine], axis=1)], axis=1)


def straight(elements: int, gravity: float = 0.0) -> Equilibrium:
    """Pinned at its start; under gravity it is released from the horizontal."""
    return _cable_at(_line(elements, (1.0, 0.0)), [(0, 0)], gravity)


def hanging(elements: int, gravity: float, stiffness: float = STIFFNESS) -> Equilibrium:
    """Pinned at its upper end, with as much mass at the lower one.

    Without the mass, a limp free end does not hang straight (docs/overview.md, "When to use it").
    """
    return _cable_at(_line(elements, (0.0, -1.0)), [(0, 0)], gravity, stiffness, point_masses=_OWN_MASS)


def sagging(elements: int, share: float, gravity: float = GRAVITY) -> Equilibrium:
    """Between two pins at the same height, that share of the cable's length apart [-]; its equilibrium."""
    nodes = _line(elements, (share, 0.0))
    start = _cable_at(nodes, [(0, 0), (elements, 0)], gravity, straight_lengths=True)
    place = np.pi * np.linspace(0.0, 1.0, elements + 1)
    angle = -2.0 * np.sqrt(1.0 - share) * np.cos(place)  # of an arch as long as the cable, nearly
    guess = nodes.copy()
    guess[:, 0, 1] = -2.0 / np.pi * LENGTH * np.sqrt(1.0 - share) * np.sin(place)
    guess[:, 1] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return _settled(start, guess)


def coil(elements: int, turns: float) -> Equilibrium:
    """Clamped at its start, free of stress in that many turns."""
    nodes = _arc(elements, turns)
    return _settled(_cable_at(nodes, [(0, 0), (0, 1)], natural=2.0 * np.pi * turns / LENGTH), nodes)


def ring(elements: int) -> Equilibrium:
    """A free closed ring."""
    nodes = _arc(elements, 1.0)
    nodes[-1] = nodes[0]
    return _cable_at(nodes, closed=True)


def spinning(elements: int, rate: float) -> Equilibrium:
    """Straight, spinning about the pin at its start with that rate [rad/s]; as much mass at its end."""
    start = _cable_at(_line(elements, (1.0, 0.0)), [(0, 0)], point_masses=_OWN_MASS)
    return replace(start, v=rate * np.stack([-start.q[..., 1], start.q[..., 0]], axis=-1))


CABLES = {make.__name__: make for make in (straight, hanging, sagging, coil, ring, spinning)}


# ------------------------------------------------------------------------------------------ motion


STRETCH_LIMIT = 0.05  # |r_x|^2 - 1 [-] beyond which a run has diverged
PORTION = 100  # steps

SCHEMES: dict[str, tuple[str, Any]] = {
    "Zhai": ("Zhai", Zhai()),
    "Zhai, v_n": ("Zhai", Zhai(projected_rate=False)),
    "Zhai, corrector, psi = phi = 0": ("Zhai", Zhai(psi=0.0, phi=0.0, corrector=True)),
    "Zhai, corrector": ("Zhai", Zhai(corrector=True)),
    "RATTLE": ("RATTLE", Rattle()),
    "RK4": ("RK4", RungeKutta4()),
}


@dataclass(frozen=True)
class Method:
    """scheme: one of SCHEMES.   zeta: [1/s].   theta: mass scaling [-]."""

    scheme: str
    zeta: float = 100.0
    theta: float = 0.0

    @classmethod
    def of(cls, case: Row) -> "Method":
        """What a case asks for."""
        return cls(case["scheme"], case.get("zeta", cls.zeta), case.get("theta", cls.theta))

    @property
    def integrator(self) -> inner.Integrator:
        return inner.find_integrator(SCHEMES[self.scheme][0])

    @property
    def parameters(self) -> Any:
        return SCHEMES[self.scheme][1]

    def system(self, cable: inner.Cable, h: float) -> Any:
        """The index-reduced equations for steps of size h [s]."""
        return inner.cable_system(cable, self.zeta, inner.ImplicitBending(self.theta * h * h))


class Motion:
    """A cable that moves from a state with steps of size h [s].

    q, v: (n, 2, dim) present state, views.   steps: taken so far.
    """

    def __init__(self, start: Equilibrium, method: Method, h: float) -> None:
        self.h, self.steps, self._method = h, 0, method
        self.system = method.system(start.cable, h)
        self.external = start.inputs
        integrator = method.integrator
        self.state = integrator.allocate(start.q.size, self.external.size)
        self.state.q[:], self.state.v[:] = start.q.ravel(), start.v.ravel()
        if not integrator.stabilised:
            inner.settle(self.system, self.external, self.state.q, self.state.v)
        integrator.start(self.system, self.external, self.state)
        self.q, self.v = (array.reshape(start.q.shape) for array in (self.state.q, self.state.v))
        self.a = self.state.a.reshape(start.q.shape)

    def advance(self, steps: int) -> bool:
        """Take so many steps; returns whether the state is that of an inextensible cable."""
        pattern = np.zeros((0, self.external.size))
        factor = np.zeros((steps, len(self._method.integrator.stages), 0))
        loads = inner.LoadHistory(self.external, pattern, factor)
        history = np.zeros((1, 3, self.state.q.size))
        method = self._method
        system, state = self.system, self.state
        inner.record(method.integrator, method.parameters, system, loads, state, self.h, steps, history)
        self.steps += steps
        return self.is_credible

    @property
    def is_credible(self) -> bool:
        squares = np.einsum("ki,ki->k", self.q[:, 1], self.q[:, 1])
        return bool(np.abs(squares - 1.0).max() < STRETCH_LIMIT)  # a NaN is not


class Invariants:
    """Energy [J] and worst constraint [-, m] of a cable under constant forces (n, 2, 2)."""

    def __init__(self, cable: inner.Cable, external: Array) -> None:
        self._potential = inner.potential_of([cable], external, 0.0)
        self._mass = self._potential.mass

    def kinetic(self, v: Array) -> float:
        return float(0.5 * v.ravel() @ (self._mass @ v.ravel()))

    def energy(self, q: Array, v: Array) -> float:
        """Kinetic, elastic, and less the work of the forces."""
        return self.kinetic(v) + self._potential.energy(q.copy())

    def violation(self, q: Array) -> float:
        """Worst |c|."""
        return float(np.abs(self._potential.values(q)).max(initial=0.0))

    def rate(self, q: Array, v: Array) -> float:
        """Worst |dc/dt|."""
        return float(np.abs(self._potential.jacobian(q) @ v.ravel()).max(initial=0.0))
