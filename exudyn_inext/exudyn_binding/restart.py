"""Restart files of a run: when they are written, what they hold, and how a run continues from one.

They follow simulationSettings.solution.restart: `write`, `name`, `writePeriod`, `continueIfAvailable`.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import exudyn
import numpy as np

from ..checks import require_positive
from ..errors import InputError
from .restart_file import Restart, packed, read_restart, unpack, write_restart
from .settings import ExplicitSettings
from .time_grid import TimeGrid

_FREE_TO_CHANGE = {"retries", "energyTolerance"}
_NUMBERS_OF_ITEMS = ("Objects", "Nodes", "Markers", "Loads")


class Restarts:
    """Restart files of one run.

    Args:
        mbs: assembled.   settings: exudyn.SimulationSettings.   explicit: of the run.
        scene: its inextensible cables, as plain data.

    Attributes:
        found: what the run continues from, or None.
        changes_so_far: () -> what user functions have changed, to be written.

    Raises:
        InputError: the file that the run shall continue from is damaged, or of another run.
    """

    changes_so_far: Callable[[], dict[str, Any]] = dict

    def __init__(self, mbs: Any, settings: Any, explicit: ExplicitSettings, cables: Sequence[Any]) -> None:
        options = settings.solution.restart
        self._mbs = mbs
        self._name = str(options.name)
        self._period = 0.0
        if options.write:
            self._period = require_positive("solution.restart.writePeriod", options.writePeriod)
        self._continues = bool(options.continueIfAvailable) and Path(self._name).exists()
        self._start = float(settings.timeIntegration.startTime)
        self._end = float(settings.timeIntegration.endTime)
        self._identity = _identity(mbs, explicit, cables) if options.write or self._continues else {}
        self.found: Restart | None = read_restart(self._name) if self._continues else None
        if self.found is not None:
            self._require_same(self.found.header)

    def _require_same(self, header: Mapping[str, Any]) -> None:
        mine = {**self._identity, "startTime": self._start}
        theirs = {**header["identity"], "startTime": header["grid"]["start"]}
        for what, value in mine.items():
            if theirs.get(what) != value:
                raise InputError(
                    f"restart file '{self._name}' is of another run: {what} was {theirs.get(what)}, and is "
                    f"{value} now. Build the same scene with the same settings, or remove the file to start "
                    "anew."
                )

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
        for number, run in enumerate(runs):
            arrays |= packed(str(number), run.memory())
        at = replace(grid, first=step)
        numbers = {field.name: getattr(at, field.name) for field in fields(at)}
        header = {"identity": self._identity, "grid": numbers, "changes": self.changes_so_far()}
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


def _identity(mbs: Any, explicit: ExplicitSettings, cables: Sequence[Any]) -> dict[str, Any]:
    """What must not change between two parts of a run, by names for messages."""
    settings = {f.name: repr(getattr(explicit, f.name)) for f in fields(explicit)}
    numbers = {
        f"number of {kind.lower()}": getattr(mbs.systemData, f"NumberOf{kind}")()
        for kind in _NUMBERS_OF_ITEMS
    }
    kinds = [mbs.GetObject(k)["objectType"] for k in range(mbs.systemData.NumberOfObjects())]
    return {
        **{name: value for name, value in settings.items() if name not in _FREE_TO_CHANGE},
        **numbers,
        "kinds of objects": _digest(kinds),
        **{f"cable '{cable.name}'": _digest([cable.cable, cable.item.gravity]) for cable in cables},
    }


def _digest(data: Any) -> str:
    return hashlib.sha256("\n".join(_parts(data)).encode()).hexdigest()[:16]


def _parts(data: Any) -> Iterator[str]:
    """Numbers and names of plain data; functions are left out."""
    if isinstance(data, np.ndarray):
        yield f"{data.shape} {data.tobytes().hex()}"
    elif is_dataclass(data):
        for field in fields(data):
            yield field.name
            yield from _parts(getattr(data, field.name))
    elif isinstance(data, list | tuple):
        yield str(len(data))
        for part in data:
            yield from _parts(part)
    elif not callable(data):
        yield repr(data)
