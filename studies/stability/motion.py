"""Cables in equilibrium, at rest or spinning, and how they move."""

import math
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import exudyn
import numpy as np

from exudyn_inext import (
    AddPointMass,
    CableShape,
    CreateInextensibleCable,
    DivergenceError,
    ExplicitSettings,
    InextensibleCable,
    Rattle,
    RungeKutta4,
    SolveEquilibrium,
    SolveExplicit,
    Zhai,
)
from reference_models.conventional.supports import add_constraint
from reference_models.model import quiet_settings, silence
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
    """A planar cable alone in an mbs, in equilibrium, spinning or thrown.   container: owns mbs."""

    container: Any
    mbs: Any

    @cached_property
    def _in_scene(self) -> Any:
        return inner.read_scene(self.mbs).cables[0]

    @property
    def cable(self) -> inner.Cable:
        return self._in_scene.cable  # type: ignore[no-any-return]

    @cached_property
    def inputs(self) -> Array:
        """See `CableLoads.at`; constant."""
        return inner.CableLoads(self._in_scene).at(0.0)

    @cached_property
    def state(self) -> tuple[Array, Array]:
        """q and v at the start (n, 2, 2)."""
        return inner.initial_states(self.mbs, [self._in_scene])[0]

    @property
    def element_length(self) -> float:
        return float(self.cable.element_lengths[0])

    def moved(self, q: Array, settings: ExplicitSettings, steps: int) -> Array | None:
        """Coordinates (n, 2, 2) after so many steps from q; None if the run diverged."""
        own, given = self._in_scene.indices, np.zeros(self.mbs.systemData.ODE2Size())
        given[own] = (q - self.cable.reference).ravel()
        found = moved(self.mbs, given, settings, steps)
        return None if found is None else self.cable.reference + found[own].reshape(q.shape)


def moved(mbs: Any, coordinates: Array, settings: ExplicitSettings, steps: int) -> Array | None:
    """Coordinates (n,) of an mbs after so many steps from these; None if the run diverged."""
    data, end = mbs.systemData, steps * (settings.stepSize or 0.0)
    data.SetODE2Coordinates(coordinates, exudyn.ConfigurationType.Initial)
    with warnings.catch_warnings(), silence():
        warnings.simplefilter("ignore", UserWarning)  # the step is above the limit on purpose
        try:
            SolveExplicit(mbs, quiet_settings(end, 1, period=end), settings)
        except DivergenceError:
            return None
    return np.array(data.GetODE2Coordinates())


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
    return Equilibrium(container, mbs)


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
    place = np.pi * np.linspace(0.0, 1.0, 2 * elements + 1)
    angle = -2.0 * np.sqrt(1.0 - share) * np.cos(place)  # of an arch as long as the cable, nearly
    slopes = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    places = np.zeros((elements + 1, 2))
    places[1:] = LENGTH / elements * slopes[1::2].cumsum(axis=0)
    places[:, 0] *= share * LENGTH / places[-1, 0]
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


def thrown(elements: int, speed: float) -> Equilibrium:
    """Pinned and straight, under gravity; one wave and a half run up and down at that speed [m/s]."""
    x, wave = np.linspace(0.0, LENGTH, elements + 1), 3.0 * np.pi / LENGTH
    v, slope_v = np.zeros((2, elements + 1, 2))
    v[:, 1], slope_v[:, 1] = speed * np.sin(wave * x), speed * wave * np.cos(wave * x)
    shape = CableShape(np.outer(x, [1, 0]), np.outer(x**0, [1, 0]), velocities=v, slopeVelocities=slope_v)
    return _placed(shape, Pin(at=0.0), gravity=GRAVITY)


# ----------------------------------------------------------------------------------------- methods


SCHEMES: dict[str, Any] = {
    "Zhai": Zhai(),
    "Zhai, v_n": Zhai(projected_rate=False),
    "Zhai, corrector, psi = phi = 0": Zhai(psi=0.0, phi=0.0, corrector=True),
    "Zhai, corrector": Zhai(corrector=True),
    "RATTLE": Rattle(),
    "RK4": RungeKutta4(),
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

    def settings(self, h: float | None = None, energy_tolerance: float = math.inf) -> ExplicitSettings:
        """For steps of size h [s], unstable ones, too."""
        return ExplicitSettings(
            SCHEMES[self.scheme],
            stepSize=h,
            massScaling=self.theta,
            stabilizationRate=self.zeta,
            energyTolerance=energy_tolerance,
            allowUnstableStep=True,
            rejectSteps=False,
        )

    def system(self, cable: inner.Cable, h: float) -> Any:
        """The index-reduced equations for steps of size h [s]."""
        return inner.cable_system(cable, self.zeta, inner.ImplicitBending(self.theta * h * h))


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
