"""What a pilot run is: what is chosen, what it gives, and who can run it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..arrays import Array

INEXTENSIBLE, EXTENSIBLE, CONVENTIONAL = "inextensible", "extensible", "conventional"


@dataclass(frozen=True)
class Choice:
    """All that a user has to choose for a run.

    formulation: INEXTENSIBLE, EXTENSIBLE with axial stiffness, or CONVENTIONAL.   integrator: its name.
    elements: N of each cable.   step_size: [s].   mass_scaling: theta [-].
    """

    formulation: str
    integrator: str
    elements: int
    step_size: float
    mass_scaling: float = 0.0

    @property
    def is_conventional(self) -> bool:
        return self.formulation == CONVENTIONAL

    @property
    def label(self) -> str:
        """In short, for tables and messages."""
        theta = f", theta = {self.mass_scaling:g}" if self.mass_scaling else ""
        return (
            f"{self.formulation}, {self.integrator}, N = {self.elements}, h = {self.step_size:.3g} s{theta}"
        )


@dataclass(eq=False)
class Pilot:
    """What a run gave.   values: (T, m) observed, at the same times in all runs.   seconds: CPU time.

    steps: taken.   failure: why it did not reach its end; empty if it did.
    error: inclusive of the uncertainty of what it was compared with; infinite until then.
    """

    choice: Choice
    values: Array
    seconds: float
    steps: int
    failure: str = ""
    error: float = float("inf")

    @property
    def works(self) -> bool:
        return not self.failure

    def distance(self, other: "Pilot") -> float:
        """Largest |difference| of what was observed."""
        return float(np.linalg.norm(self.values - other.values, axis=1).max())

    def expected_seconds(self, elements: int, step: float) -> float:
        """CPU time of a run of another mesh, by another step [s]."""
        return self.seconds * elements / self.choice.elements * self.choice.step_size / step


class Problem(Protocol):
    """A scene that can be run with any choice.   end_time, period: of the run, and of its samples [s].

    formulation: INEXTENSIBLE or EXTENSIBLE, what the cables are that `step_limit` was asked for.
    """

    end_time: float
    period: float
    formulation: str

    def step_limit(self, elements: int, integrator: str) -> float:
        """Largest step that is used without mass scaling [s].

        Raises:
            InputError: the scene cannot be built with so many elements.
        """
        ...

    def run(self, choice: Choice) -> Pilot:
        """Run to the end, alone and timed; a divergence is a failure, not an error.

        The pilot's choice has the step that was taken.
        """
        ...
