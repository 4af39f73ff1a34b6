"""What a run offers to whoever asks it for states: a cable alone, or cables among other items."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..integrators.integrator import Integrator
from .consistent_start import StartCorrection
from .step_control import StepControl, StepRule
from .time_grid import TimeGrid


class Run(Protocol):
    """What the loop moves: a cable, or a coupled scene; see CableRun for the attributes."""

    state: Any
    gave_up: bool
    integrator: Integrator
    lenience: float
    control: StepControl
    watch: Any
    indices: np.ndarray
    reference: Array

    @property
    def looks_ahead(self) -> bool: ...

    @property
    def is_steady(self) -> bool: ...

    @property
    def finding(self) -> str: ...

    @property
    def remembered(self) -> Array | None: ...

    @property
    def reason(self) -> str: ...

    @property
    def cables(self) -> Sequence[Cable]: ...

    @property
    def cable_runs(self) -> Sequence[Any]: ...

    @property
    def start_corrections(self) -> Sequence[StartCorrection]: ...

    @property
    def name(self) -> str: ...

    def scale_mass(self, theta: float, h: float) -> None: ...

    def set_step(self, h: float) -> None: ...

    def start(self, time: float) -> None: ...

    def start_scheme(self, time: float) -> None: ...

    def make_consistent(self, start: Any) -> None: ...

    def largest_frequency(self, time: float) -> float: ...

    def damping_ratio(self, frequency: float) -> float: ...

    def follow_frequency(self, rule: StepRule) -> None: ...

    def record(self, grid: TimeGrid, first: int, history: Array) -> int: ...

    def complete(self, times: Array, history: Array, multipliers: Array) -> bool:
        """Set accelerations, unless they are those of the scheme, and multipliers of recorded states.

        Args:
            times: (k,) of the states [s].
            history: (k, 3, n) displacements and velocities, and output: accelerations.
            multipliers: (k, m) output, of Exudyn's algebraic equations.

        Returns:
            Whether multipliers have been set.
        """

    def accelerations(self, time: float, multipliers: Array) -> Array: ...

    def verdict(self, time: float, h: float) -> str: ...

    def figures(self) -> dict[str, float]: ...

    def memory(self) -> dict[str, Any]: ...

    def resume(self, time: float) -> None: ...
