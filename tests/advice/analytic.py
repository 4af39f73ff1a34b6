"""A problem whose errors and costs are known in closed form."""

import numpy as np

from exudyn_inext.advice.pilot import CONVENTIONAL, INEXTENSIBLE, Choice, Pilot
from exudyn_inext.errors import InputError

SAMPLES = 50
DIRECTIONS = np.array([[1.0, 0.3], [-0.4, 1.0], [0.2, -0.9]])  # of errors of mesh, step, native cables
OVERHEAD, OF_A_STEP, OF_AN_ELEMENT = 2e-3, 1e-6, 2e-7  # [s]
NATIVE = 40.0  # times the cost of a step


class Analytic:
    """values = limit + C N^-4 + D h^2, seconds = a + steps (b + c N), largest step L / N^2.

    mesh, step: C and D.   failing: choice -> whether it fails.   buildable: N -> whether it can be built.
    costs: of a step of each integrator, relative.
    """

    end_time, period, formulation = 1.0, 0.02, INEXTENSIBLE

    def __init__(
        self,
        mesh=1.0,
        step=40.0,
        *,
        limit=0.2,
        failing=lambda choice: False,
        buildable=lambda n: True,
        costs=None,
    ):
        self.mesh, self.step, self.limit = mesh, step, limit
        self.failing, self.buildable, self.costs = failing, buildable, costs or {}
        self.runs = []

    def step_limit(self, elements, integrator):
        if not self.buildable(elements):
            raise InputError(f"{elements} elements cannot be built.")
        return self.limit / elements**2

    def run(self, choice):
        self.runs.append(choice)
        failure = "diverged" if self.failing(choice) else ""
        values = np.zeros((0, 2)) if failure else self.values(choice)
        return Pilot(choice, values, self.seconds(choice), round(self.steps(choice)), failure)

    def steps(self, choice):
        return self.end_time / choice.step_size

    def seconds(self, choice):
        native = NATIVE if choice.formulation == CONVENTIONAL else 1.0
        of_a_step = OF_A_STEP + OF_AN_ELEMENT * choice.elements
        return OVERHEAD + native * self.costs.get(choice.integrator, 1.0) * self.steps(choice) * of_a_step

    def values(self, choice):
        """(T, 2)"""
        t = np.linspace(0.0, self.end_time, SAMPLES)[:, None]
        of_mesh, of_step = DIRECTIONS[:2] * [[self.mesh * choice.elements**-4.0], [self._of_step(choice)]]
        return np.hstack([np.cos(5 * t), np.sin(3 * t)]) + t * (of_mesh + of_step)

    def error(self, choice):
        """True one: of the last sample."""
        limit = Choice(choice.formulation, choice.integrator, 10**6, 1e-12)
        return float(np.linalg.norm(self.values(choice) - self.values(limit), axis=1).max())

    def _of_step(self, choice):
        return (1.0 + 4.0 * choice.mass_scaling) * self.step * choice.step_size**2
