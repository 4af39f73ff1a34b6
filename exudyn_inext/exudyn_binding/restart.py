"""Restart files of a run: when they are written, what they hold, and how a run continues from one.

They follow simulationSettings.solution.restart: `write`, `name`, `writePeriod`, `continueIfAvailable`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ..checks import require_positive
from ..errors import InputError
from ..run.loop_clock import LoopClock
from ..run.restart_file import Restart, packed, read_restart, unpack, write_restart
from ..run.settings import ExplicitSettings
from ..run.time_grid import TimeGrid
from .mbs_state import State, state_of
from .scene_identity import changes, difference, has_functions, scene_identity


class Restarts:
    """Restart files of one run.

    Args:
        mbs: assembled.   settings: exudyn.SimulationSettings.   explicit: of the run.

    Attributes:
        found: what the run continues from, or None.
        mass_scaling: theta of the run, to be written; that of the run which is continued.
        damps_implicitly: whether dashpots of springs are implicit in the run which is continued, or None.
        changes: what user functions had changed when the file was written; empty if nothing, or without one.
        changes_so_far: () -> what they have changed, to be written.

    Raises:
        InputError: the file that the run shall continue from is damaged, or of another run.
    """

    changes_so_far: Callable[[], dict[str, Any]] = dict
    mass_scaling: float | None = None
    damps_implicitly: bool | None = None

    def __init__(self, mbs: Any, settings: Any, explicit: ExplicitSettings) -> None:
        options = settings.solution.restart
        self._mbs = mbs
        self._name = str(options.name)
        self._period = 0.0
        if options.write:
            self._period = require_positive("solution.restart.writePeriod", options.writePeriod)
        continues = bool(options.continueIfAvailable) and Path(self._name).exists()
        self._start = float(settings.timeIntegration.startTime)
        self._end = float(settings.timeIntegration.endTime)
        self._explicit = explicit
        scene = mbs, explicit, self._start
        self._identity = scene_identity(*scene) if options.write or continues else {}
        self.found: Restart | None = read_restart(self._name) if continues else None
        self.changes: Mapping[str, Any] = {}
        if self.found is not None:
            header = self.found.header
            self._require_same(header["identity"], header["meanwhile"])
            self.mass_scaling, self.changes = header["massScaling"], header["changes"]
            self.damps_implicitly = header["dampsImplicitly"]
            self._old = TimeGrid(**header["grid"])

    def _require_same(self, theirs: dict[str, dict[str, str]], meanwhile: Mapping[str, Any]) -> None:
        """Our scene must be as theirs at its start; or, in the same process, as they have left it."""
        found = difference(self._identity, theirs, meanwhile)
        if found:
            raise InputError(
                f"restart file '{self._name}' is of another run: {found}. Build the same scene with the same "
                "settings, or remove the file to start anew."
            )
        self._identity = theirs

    def clock(self, grid: TimeGrid) -> LoopClock | None:
        """Of Exudyn's loop in the run that is continued; None: there is none."""
        return LoopClock(grid, self.found.header["loopStep"], self._end) if self.found else None

    @property
    def was_coupled(self) -> bool:
        """Whether the run that is continued moves cables together with other items; False without one."""
        return self.found is not None and any(self.found.header["evaluatedBy"])

    @property
    def time(self) -> float:
        """From which a run continues [s]."""
        return self._old.time(self._old.first)

    @property
    def step(self) -> float | None:
        """That of the run which is continued [s]."""
        return None if self.found is None else self._old.h

    def grid(self, grid: TimeGrid) -> TimeGrid:
        """The grid of the run which is continued, up to the present end time; or the given one.

        Raises:
            InputError: nothing is left to do, or the end is at no step of it.
        """
        if self.found is None:
            return grid
        old = self._old
        steps = (self._end - old.start) / (old.substeps * old.h)
        if abs(steps - round(steps)) > 1e-6 * max(1.0, steps):
            raise InputError(
                f"endTime = {self._end:g} s is at no step of the run that restart file '{self._name}' "
                f"continues: its steps of Exudyn's loop take {old.substeps * old.h:g} s."
            )
        if round(steps) <= old.first:
            raise InputError(
                f"restart file '{self._name}' is at t = {self.time:g} s: nothing is left until "
                f"endTime = {self._end:g} s; set a later one, or remove the file to start anew."
            )
        return replace(old, loop_steps=round(steps))

    def steps_until_due(self, grid: TimeGrid, step: int) -> int:
        """Steps of the loop after which the next file is to be written."""
        every = self._steps_between(grid)
        return every - step % every if every else grid.loop_steps - step

    def _steps_between(self, grid: TimeGrid) -> int:
        """Two files; 0: none are written."""
        return max(1, round(self._period / (grid.substeps * grid.h))) if self._period else 0

    def may_begin(self, grid: TimeGrid, step: int) -> bool:
        """Whether a run begins with that step of the loop, or with a file that is written there."""
        every = self._steps_between(grid)
        return step == 0 or bool(every and step % every == 0)

    def is_due(self, grid: TimeGrid, step: int) -> bool:
        """Whether a file is to be written after that step of the loop."""
        if not self._period or step == grid.first:
            return False
        return step == grid.loop_steps or self.steps_until_due(grid, step - 1) == 1

    def write(self, runs: Sequence[Any], grid: TimeGrid, step: int) -> None:
        """Write the state after that step of the loop, which mbs has at present."""
        meanwhile: dict[str, dict[str, str]] = {}
        if step == grid.loop_steps and has_functions(
            self._identity
        ):  # a later run of the same mbs finds them
            meanwhile = changes(self._identity, scene_identity(self._mbs, self._explicit, self._start))
        loop_step = (self._end - grid.start) / grid.loop_steps
        header = {
            "grid": asdict(replace(grid, first=step)),
            "loopStep": self.found.header["loopStep"] if self.found else loop_step,
            "massScaling": self.mass_scaling,
            "dampsImplicitly": any(run.damps_implicitly for run in runs),
            "evaluatedBy": [run.evaluated_by for run in runs],
            "changes": self.changes_so_far(),
            "ramps": [run.ramp for run in runs],
            "identity": self._identity,
            "meanwhile": meanwhile,
        }
        arrays = packed("mbs", state_of(self._mbs))
        for number, run in enumerate(runs):
            arrays |= packed(str(number), run.memory())
        write_restart(self._name, Restart(header, arrays))

    def resume(self, runs: Sequence[Any], grid: TimeGrid) -> None:
        """Give the runs the states and memories of the file."""
        assert self.found
        for number, run in enumerate(runs):
            run.evaluate_by(self.found.header["evaluatedBy"][number])
            unpack(str(number), run.memory(), self.found.arrays)
            run.take_ramp(self.found.header["ramps"][number])
            run.resume(grid.time(grid.first))

    @property
    def state(self) -> State:
        """Of the mbs, that a run continues with: see `state_of`."""
        arrays = self.found.arrays if self.found else {}
        return {name[4:]: array for name, array in arrays.items() if name.startswith("mbs/")}

    @property
    def first_state(self) -> list[list[float]]:
        """Coordinates, velocities and first order states that the run continues with."""
        return [self.state[name].tolist() for name in ("ODE2", "ODE2_t", "ODE1")]
