"""Cables in equilibrium, at rest or spinning, and compiled motion of one, in portions, without Exudyn."""

from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
from scipy.optimize import brentq

from exudyn_inext import (
    AddPointMass,
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    Rattle,
    RungeKutta4,
    SolveEquilibrium,
    Zhai,
)
from reference_models.conventional.supports import add_constraint
from reference_models.scenes import Clamp, Pin, load_scene
from reference_models.trajectory import Array
from studies.harness import Row, inner

_OWN = load_scene("planar_pendulum").cable
LENGTH = _OWN.length  # [m]
DENSITY = _OWN.section.mass_per_length  # rho_A [kg/m]
STIFFNESS = _OWN.section.bending_stiffness  # EI [N m^2]
GRAVITY = 9.81  # [m/s^2]
_OWN_MASS = DENSITY * LENGTH  # as much as the cable's, at its end


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A cable, its coordinates and velocities (n, 2, 2).   inputs: see `CableLoads.at`, constant."""

    cable: inner.Cable
    q: Array
    v: Array
    inputs: Array

    @property
    def element_length(self) -> float:
        return float(self.cable.element_lengths[0])

    @property
    def external(self) -> Array:
        """Forces on the coordinates (n, 2, 2)."""
        return self.inputs[: self.q.size].reshape(self.q.shape)


def _placed(
    shape: CableShape,
    start: Pin | Clamp | None = None,
    end: Pin | None = None,
    gravity: float = 0.0,
    mass: float = 0.0,
    settles: bool = False,
    **template: float,
) -> Equilibrium:
    """A cable with supports and a mass [kg] at its end.   settles: in the equilibrium near its shape."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    template = {"massPerLength": DENSITY, "bendingStiffness": STIFFNESS, **template}
    own = InextensibleCable(**template)
    cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=own, gravity=[0.0, -gravity, 0.0])
    for node, support in ((cable["nodes"][0], start), (cable["nodes"][-1], end)):
        if support:
            add_constraint(mbs, node, support, 2)
    if mass:
        AddPointMass(mbs, cable, LENGTH, mass)
    mbs.Assemble()
    if settles:
        SolveEquilibrium(mbs)
    cables = inner.read_scene(mbs).cables
    ((q, v),) = inner.initial_states(mbs, cables)
    return Equilibrium(cables[0].cable, q, v, inner.CableLoads(cables[0]).at(0.0))


def straight(elements: int, gravity: float = 0.0) -> Equilibrium:
    """Pinned at its start; under gravity it is released from the horizontal."""
    return _placed(CableShape.Line([0, 0], [LENGTH, 0], elements), Pin(at=0.0), gravity=gravity)


def hanging(elements: int, gravity: float, stiffness: float = STIFFNESS) -> Equilibrium:
    """Pinned at its upper end, with as much mass at the lower one.

    Without the mass, a limp free end does not hang straight (docs/overview.md, "When to use it").
    """
    line = CableShape.Line([0, 0], [0, -LENGTH], elements)
    return _placed(line, Pin(at=0.0), gravity=gravity, mass=_OWN_MASS, bendingStiffness=stiffness)


def sagging(elements: int, share: float, gravity: float = GRAVITY) -> Equilibrium:
    """Between two pins at the same height, that share of the cable's length apart [-]; its equilibrium."""
    waves = np.cos(np.pi * np.linspace(0.0, 1.0, 2 * elements + 1))
    largest = brentq(lambda x: np.cos(x * waves[1::2]).mean() - share, 0.0, 2.4)  # angle, of an arch as long
    slopes = np.stack([np.cos(largest * waves), -np.sin(largest * waves)], axis=1)
    places = np.zeros((elements + 1, 2))
    places[1:] = LENGTH / elements * slopes[1::2].cumsum(axis=0)
    shape = CableShape(places, slopes[::2], LENGTH / elements, lengthReference="straight")
    return _placed(shape, Pin(at=0.0), Pin(at=1.0), gravity, settles=True)


def coil(elements: int, turns: float) -> Equilibrium:
    """Clamped at its start, free of stress in that many turns, in circles that curve upwards."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, elements + 1)
    sine, cosine = np.sin(angle), np.cos(angle)
    curvature = 2.0 * np.pi * turns / LENGTH
    places = np.stack([sine, 1.0 - cosine], axis=1) / curvature
    shape = CableShape(places, np.stack([cosine, sine], axis=1), LENGTH / elements)
    return _placed(shape, Clamp(at=0.0), settles=True, referenceCurvature=curvature)


def ring(elements: int) -> Equilibrium:
    """A free closed ring."""
    return _placed(CableShape.Circle([0, 0], LENGTH / (2.0 * np.pi), elements))


def spinning(elements: int, rate: float) -> Equilibrium:
    """Straight, spinning about the pin at its start with that rate [rad/s]; as much mass at its end."""
    line = CableShape.Line([0, 0], [LENGTH, 0], elements, [0, 0], [0, rate * LENGTH])
    return _placed(line, Pin(at=0.0), mass=_OWN_MASS)


CABLES = {make.__name__: make for make in (straight, hanging, sagging, coil, ring, spinning)}


STRETCH_LIMIT = 0.05  # |r_x|^2 - 1 [-] beyond which a run has diverged
PORTION = 100  # steps

SCHEMES: dict[str, Any] = {
    "Zhai": Zhai(),
    "Zhai, v_n": Zhai(projected_rate=False),
    "Zhai, corrector, psi = phi = 0": Zhai(psi=0.0, phi=0.0, corrector=True),
    "Zhai, corrector": Zhai(corrector=True),
    "RATTLE": Rattle(),
    "RK4": RungeKutta4(),
}


def settings_of(case: Row) -> ExplicitSettings:
    """What a case asks for: one of SCHEMES, zeta [1/s], mass scaling theta [-]."""
    usual = ExplicitSettings.stabilizationRate
    own = {"stabilizationRate": case.get("zeta", usual), "massScaling": case.get("theta", 0.0)}
    return ExplicitSettings(SCHEMES[case["scheme"]], **own)


def system_of(cable: inner.Cable, settings: ExplicitSettings, h: float) -> Any:
    """The index-reduced equations for steps of size h [s]."""
    scaling = inner.ImplicitBending((settings.massScaling or 0.0) * h * h)
    return inner.cable_system(cable, settings.stabilizationRate, scaling)


class Motion:
    """A cable that moves from a state with steps of size h [s].

    q, v: (n, 2, dim) present state, views.   steps: taken so far.
    """

    def __init__(self, start: Equilibrium, settings: ExplicitSettings, h: float) -> None:
        self.h, self.steps, self._method = h, 0, settings.method
        self.system = system_of(start.cable, settings, h)
        self.external = start.inputs
        integrator, _ = self._method
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
        factor = np.zeros((steps, len(self._method[0].stages), 0))
        loads = inner.LoadHistory(self.external, pattern, factor)
        history = np.zeros((1, 3, self.state.q.size))
        inner.record(*self._method, self.system, loads, self.state, self.h, steps, history)
        self.steps += steps
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
