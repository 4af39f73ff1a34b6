"""Restart files of a run: when they are written, what they hold, and how a run continues from one.

They follow simulationSettings.solution.restart: `write`, `name`, `writePeriod`, `continueIfAvailable`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..checks import require_positive
from ..errors import InputError
from ..run.loop_clock import LoopClock
from ..run.restart_file import Restart, packed, read_restart, unpack, write_restart
from ..run.settings import ExplicitSettings
from ..run.time_grid import TimeGrid
from .scene_identity import (
    changes,
    difference,
    has_functions,
    packed_identity,
    scene_identity,
    unpacked_identity,
)

_IDENTITY, _CHANGES = "identity", "changes"


class Restarts:
    """Restart files of one run.

    Args:
        mbs: assembled.   settings: exudyn.SimulationSettings.   explicit: of the run.

    Attributes:
        found: what the run continues from, or None.
        mass_scaling: theta of the run, to be written; that of the run which is continued.
        changes_so_far: () -> what user functions have changed, to be written.

    Raises:
        InputError: the file that the run shall continue from is damaged, or of another run.
    """

    changes_so_far: Callable[[], dict[str, Any]] = dict
    mass_scaling: float | None = None

    def __init__(self, mbs: Any, settings: Any, explicit: ExplicitSettings) -> None:
        options = settings.solution.restart
        self._mbs = mbs
        self._name = str(options.name)
        self._period = 0.0
        if options.write:
            self._period = require_positive("solution.restart.writePeriod", options.writePeriod)
        self._continues = bool(options.continueIfAvailable) and Path(self._name).exists()
        self._start = float(settings.timeIntegration.startTime)
        self._end = float(settings.timeIntegration.endTime)
        self._explicit = explicit
        self._identity = self._present_identity() if options.write or self._continues else {}
        self.found: Restart | None = read_restart(self._name) if self._continues else None
        if self.found is not None:
            self._require_same(self.found.arrays)
            self.mass_scaling = self.found.header["massScaling"]

    def _present_identity(self) -> dict[str, dict[str, str]]:
        return scene_identity(self._mbs, self._explicit, self._start)

    def _require_same(self, arrays: Mapping[str, Any]) -> None:
        """Our scene must be as theirs at its start; or, in the same process, as they have left it."""
        theirs, changed = (unpacked_identity(arrays[name]) for name in (_IDENTITY, _CHANGES))
        found = difference(self._identity, theirs, changed)
        if found:
            raise InputError(
                f"restart file '{self._name}' is of another run: {found}. Build the same scene with the same "
                "settings, or remove the file to start anew."
            )
        self._identity = theirs

    def _changes(self) -> dict[str, dict[str, str]]:
        """What user functions have changed since the start."""
        if not has_functions(self._identity):
            return {}
        return changes(self._identity, self._present_identity())

    @cached_property
    def _packed_identity(self) -> Array:
        return packed_identity(self._identity)

    def clock(self, grid: TimeGrid) -> LoopClock | None:
        """Of Exudyn's loop in the run that is continued; None: there is none."""
        if self.found is None:
            return None
        step = self.found.header["loopStep"]
        return LoopClock(grid.start, step, grid.first, self._end, grid.loop_steps)

    @property
    def time(self) -> float:
        """From which the run continues, or starts [s]."""
        if self.found is None:
            return self._start
        grid = TimeGrid(**self.found.header["grid"])
        return grid.time(grid.first)

    @property
    def changes(self) -> Mapping[str, Any]:
        """What user functions had changed when the file was written; empty if nothing, or without a file."""
        return {} if self.found is None else dict(self.found.header.get("changes", {}))

    @property
    def step(self) -> float | None:
        """That of the run which is continued [s]."""
        return None if self.found is None else float(self.found.header["grid"]["h"])

    def grid(self, grid: TimeGrid) -> TimeGrid:
        """The grid of the run which is continued, up to the present end time; or the given one.

        Raises:
            InputError: nothing is left to do, or the end is at no step of it.
        """
        if self.found is None:
            return grid
        old = TimeGrid(**self.found.header["grid"])
        steps = (self._end - old.start) / (old.substeps * old.h)
        if abs(steps - round(steps)) > 1e-6 * max(1.0, steps):
            raise InputError(
                f"endTime = {self._end:g} s is at no step of the run that restart file '{self._name}' "
                f"continues: its steps of Exudyn's loop take {old.substeps * old.h:g} s."
            )
        if round(steps) <= old.first:
            raise InputError(
                f"restart file '{self._name}' is at t = {old.time(old.first):g} s: nothing is left until "
                f"endTime = {self._end:g} s; set a later one, or remove the file to start anew."
            )
        return replace(old, loop_steps=round(steps))

    def steps_until_due(self, grid: TimeGrid, step: int) -> int:
        """Steps of the loop after which the next file is to be written."""
        if not self._period:
            return grid.loop_steps - step
        every = max(1, round(self._period / (grid.substeps * grid.h)))
        return every - step % every

    def is_due(self, grid: TimeGrid, step: int) -> bool:
        """Whether a file is to be written after that step of the loop."""
        if not self._period or step == grid.first:
            return False
        return step == grid.loop_steps or self.steps_until_due(grid, step - 1) == 1

    def write(self, runs: Sequence[Any], grid: TimeGrid, step: int) -> None:
        """Write the state after that step of the loop, which mbs has at present."""
        arrays = packed("mbs", _state_of(self._mbs, exudyn.ConfigurationType.Current))
        changed = self._changes() if step == grid.loop_steps else {}  # a later run of the same mbs finds them
        arrays |= {_IDENTITY: self._packed_identity, _CHANGES: packed_identity(changed)}
        for number, run in enumerate(runs):
            arrays |= packed(str(number), run.memory())
        at = replace(grid, first=step)
        numbers = {field.name: getattr(at, field.name) for field in fields(at)}
        loop_step = (
            self.found.header["loopStep"] if self.found else (self._end - grid.start) / grid.loop_steps
        )
        header = {
            "grid": numbers,
            "loopStep": loop_step,
            "massScaling": self.mass_scaling,
            "changes": self.changes_so_far(),
        }
        write_restart(self._name, Restart(header, arrays))

    def resume(self, runs: Sequence[Any], grid: TimeGrid) -> None:
        """Give the runs the states and memories of the file."""
        arrays = self._arrays
        for number, run in enumerate(runs):
            unpack(str(number), run.memory(), arrays)
            run.resume(grid.time(grid.first))

    @property
    def first_state(self) -> list[list[float]]:
        """Coordinates, velocities and first order states that the run continues with."""
        return [self._arrays[f"mbs/{name}"].tolist() for name in ("ODE2", "ODE2_t", "ODE1")]

    @property
    def _arrays(self) -> Mapping[str, Any]:
        return self.found.arrays if self.found else {}

    @contextmanager
    def initial_state(self) -> Iterator[None]:
        """Exudyn starts a continued run from the state of the file."""
        if self.found is None:
            yield
            return
        initial = exudyn.ConfigurationType.Initial
        saved = _state_of(self._mbs, initial)
        given = {name: self.found.arrays[f"mbs/{name}"] for name in saved}
        _set_state(self._mbs, given, initial)
        try:
            yield
        finally:
            _set_state(self._mbs, saved, initial)


def _state_of(mbs: Any, configuration: Any) -> dict[str, Any]:
    data = mbs.systemData
    return {
        "ODE2": np.array(data.GetODE2Coordinates(configuration)),
        "ODE2_t": np.array(data.GetODE2Coordinates_t(configuration)),
        "ODE2_tt": np.array(data.GetODE2Coordinates_tt(configuration)),
        "ODE1": np.array(data.GetODE1Coordinates(configuration)),
        "AE": np.array(data.GetAECoordinates(configuration)),
        "Data": np.array(data.GetDataCoordinates(configuration)),
    }


def _set_state(mbs: Any, state: Mapping[str, Any], configuration: Any) -> None:
    data = mbs.systemData
    data.SetODE2Coordinates(state["ODE2"], configuration)
    data.SetODE2Coordinates_t(state["ODE2_t"], configuration)
    data.SetODE2Coordinates_tt(state["ODE2_tt"], configuration)
    data.SetODE1Coordinates(state["ODE1"], configuration)
    data.SetAECoordinates(state["AE"], configuration)
    data.SetDataCoordinates(state["Data"], configuration)
