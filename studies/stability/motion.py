"""Compiled motion of one cable, in portions, without Exudyn; and its energy, constraints and momenta."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from exudyn_inext import Rattle, RungeKutta4, Zhai
from exudyn_inext.arrays import Array
from exudyn_inext.chain.assembly import elastic_energy
from exudyn_inext.chain.cable import Cable
from exudyn_inext.chain.chain import build_chain
from exudyn_inext.chain.implicit_bending import ImplicitBending
from exudyn_inext.chain.linked_cable import cable_system
from exudyn_inext.chain.sparse_forms import form_of_cable
from exudyn_inext.constraints import constraints_of_cable
from exudyn_inext.element.inertia import mass_matrix
from exudyn_inext.exudyn_binding.consistent_start import settle
from exudyn_inext.integrators import find_integrator
from exudyn_inext.integrators.integrator import Integrator, LoadHistory, record
from studies.harness.study import Row

from .cables import Equilibrium

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
    def integrator(self) -> Integrator:
        return find_integrator(SCHEMES[self.scheme][0])

    @property
    def parameters(self) -> Any:
        return SCHEMES[self.scheme][1]

    def system(self, cable: Cable, h: float) -> Any:
        """The index-reduced equations for steps of size h [s]."""
        return cable_system(cable, self.zeta, ImplicitBending(self.theta * h * h))


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
            settle(self.system, self.external, self.state.q, self.state.v)
        integrator.start(self.system, self.external, self.state)
        self.q, self.v = (array.reshape(start.q.shape) for array in (self.state.q, self.state.v))
        self.a = self.state.a.reshape(start.q.shape)

    def advance(self, steps: int) -> bool:
        """Take so many steps; returns whether the state is that of an inextensible cable."""
        pattern = np.zeros((0, self.external.size))
        factor = np.zeros((steps, len(self._method.integrator.stages), 0))
        loads = LoadHistory(self.external, pattern, factor)
        history = np.zeros((1, 3, self.state.q.size))
        record(self._method.parameters, self.system, loads, self.state, self.h, steps, history)
        self.steps += steps
        return self.is_credible

    @property
    def is_credible(self) -> bool:
        squares = np.einsum("ki,ki->k", self.q[:, 1], self.q[:, 1])
        return bool(np.abs(squares - 1.0).max() < STRETCH_LIMIT)  # a NaN is not


class Invariants:
    """Energy [J], worst constraint [-, m] and momenta of a cable under constant forces."""

    def __init__(self, start: Equilibrium) -> None:
        self._start = start
        self._chain = build_chain(start.cable)
        self._constraints = constraints_of_cable(start.cable)
        self._mass = start.cable.section.mass_per_length * form_of_cable(start.cable, mass_matrix)

    def kinetic(self, v: Array) -> float:
        return float(0.5 * v.ravel() @ (self._mass @ v.ravel()))

    def energy(self, q: Array, v: Array) -> float:
        """Kinetic, elastic, and less the work of the forces."""
        elastic = float(elastic_energy(self._chain, q.copy()))
        return self.kinetic(v) + elastic - float(np.sum(self._start.external * q))

    def violation(self, q: Array) -> float:
        """Worst |c|."""
        return max(float(np.abs(c.value(q)).max(initial=0.0)) for c in self._constraints)

    def momenta(self, q: Array, v: Array) -> tuple[Array, float]:
        """Linear (2,) [N s] and angular momentum about the origin [N m s]."""
        momentum = (self._mass @ v.ravel()).reshape(v.shape)
        angular = q[..., 0] * momentum[..., 1] - q[..., 1] * momentum[..., 0]
        return momentum[:, 0].sum(axis=0), float(angular.sum())
