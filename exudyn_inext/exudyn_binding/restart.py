"""Restart files of a run: when they are written, what they hold, and how a run continues from one.

They follow simulationSettings.solution.restart: `write`, `name`, `writePeriod`, `continueIfAvailable`.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from ..checks import require_positive
from ..errors import InputError
from ..items.cable_data import belongs_to_a_cable, find_cable_item
from ..run.fingerprint import strings_in, text_of, texts_of_function
from ..run.loop_clock import LoopClock
from ..run.restart_file import Restart, packed, read_restart, unpack, write_restart
from ..run.settings import ExplicitSettings
from ..run.time_grid import TimeGrid
from .mbs_state import State, state_of

Identity = Mapping[str, Mapping[str, str]]
"""Item -> its parameters -> their values, as texts."""

_FREE_TO_CHANGE = {"energyTolerance"}
_KINDS = ("Object", "Node", "Marker", "Load")
_NAME, _NUMBER = "name", "number"
_STEP_FUNCTIONS = ("PreStepUserFunction", "PostStepUserFunction", "PostNewtonUserFunction")
_OF_KERNELS = ("objectType", "nodeNumbers")  # all that counts of a cable's object, besides the cable
_NOT_OF_A_CONTACT = {"verboseMode", "visualization"}
_OF_A_SPHERE = ("markerIndex", "contactStiffness", "contactDamping", "radius", "frictionMaterialIndex")


def scene_identity(mbs: Any, explicit: ExplicitSettings, start_time: float) -> dict[str, dict[str, str]]:
    """Identity of a run at its start.

    Args:
        mbs: assembled.   explicit: settings of the run.   start_time: [s].
    """
    given = {
        f.name: text_of(getattr(explicit, f.name)) for f in fields(explicit) if f.name not in _FREE_TO_CHANGE
    }
    contacts = [mbs.GetGeneralContact(number) for number in range(mbs.NumberOfGeneralContacts())]
    counts = {f"{kind.lower()}s": getattr(mbs.systemData, f"NumberOf{kind}s")() for kind in _KINDS}
    counts["general contacts"] = len(contacts)
    numbers = {f"{_NUMBER} of {what}": str(count) for what, count in counts.items()}
    items = {
        f"{kind.lower()} {number}": getattr(mbs, f"Get{kind}")(number)
        for kind in _KINDS
        for number in range(counts[f"{kind.lower()}s"])
    }
    step_functions = {name: getattr(mbs, f"Get{name}")() for name in _STEP_FUNCTIONS}
    identity: dict[str, dict[str, str]] = {"": {"startTime": repr(start_time), **given, **numbers}}
    identity |= {item: {_NAME: data[_NAME]} | _texts(_of_item(data)) for item, data in items.items()}
    identity["mbs"] = _texts(step_functions) | _variables(mbs, [*items.values(), step_functions])
    identity |= {f"general contact {k}": _texts(_of_contact(contact)) for k, contact in enumerate(contacts)}
    if has_functions(identity):
        identity[""]["Python"] = f"{sys.version_info[0]}.{sys.version_info[1]}"
    return identity


def has_functions(identity: Identity) -> bool:
    """Whether it contains user functions, which may change parameters during a run."""
    return any(name.endswith("UserFunction") for parameters in identity.values() for name in parameters)


def difference(mine: Identity, theirs: Identity, meanwhile: Identity) -> str:
    """The first parameter that is another one: which it is, what it was, and what it is; empty if none.

    meanwhile: what the other run has changed since its start; both values are the same to us.
    """
    for item in {**mine, **theirs}:
        old, new, changed = (identity.get(item, {}) for identity in (theirs, mine, meanwhile))
        for name in {**new, **old}:
            was, now = old.get(name), new.get(name)
            if name != _NAME and now not in (was, changed.get(name, was)):
                label = f"{item} '{new[_NAME]}'" if _NAME in new else item
                of_what = f"{name} of {label}" if item else name
                return f"{of_what} was {was or 'not set'}, and is {now or 'not set'} now"
    return ""


def changes(before: Identity, after: Identity) -> dict[str, dict[str, str]]:
    """Parameters that differ, with their values afterwards."""
    found = {item: dict(texts.items() - before.get(item, {}).items()) for item, texts in after.items()}
    return {item: texts for item, texts in found.items() if texts}


def _variables(mbs: Any, items: list[dict[str, Any]]) -> dict[str, str]:
    """Entries of mbs.variables that user functions of the items may read."""
    if not mbs.variables:
        return {}
    functions = [value["function"] for data in items for value in data.values() if _is_user_function(value)]
    read = set[str]().union(*map(strings_in, functions))
    return {f"variables['{name}']": text_of(value) for name, value in mbs.variables.items() if name in read}


def _is_user_function(value: Any) -> bool:
    return isinstance(value, dict) and callable(value.get("function"))


def _texts(data: Mapping[str, Any]) -> dict[str, str]:
    """Parameters as texts; neither names nor drawing, nor functions that are not set."""
    texts: dict[str, str] = {}
    for name, value in data.items():
        if name == _NAME or name.startswith(("V", "temp")):
            continue
        if _is_user_function(value):
            texts |= texts_of_function(name, value["function"])
        elif not (name.endswith("UserFunction") and value == 0):
            texts[name] = text_of(value)
    return texts


def _of_item(data: dict[str, Any]) -> dict[str, Any]:
    """The parameters that count."""
    if "objectType" not in data:
        return data
    if (cable := find_cable_item(data)) is not None:
        own = {name: data[name] for name in _OF_KERNELS}
        return own | _fields(cable.cable) | {"gravity": cable.gravity, "held": cable.held}
    return {"objectType": data["objectType"]} if belongs_to_a_cable(data) else data


def _fields(data: Any, prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in fields(data):
        name, value = f"{prefix}{field.name}", getattr(data, field.name)
        found |= _fields(value, f"{name}.") if is_dataclass(value) else {name: value}
    return found


def _of_contact(contact: Any) -> dict[str, Any]:
    """Settings, friction and spheres; of triangles and cables Exudyn tells nothing but their number."""
    known = contact.GetPythonObject()
    names = [name for name in dir(contact) if not name.startswith(("_", "parallel"))]
    settings = {name: getattr(contact, name) for name in names if name not in _NOT_OF_A_CONTACT}
    found = {name: value for name, value in settings.items() if not callable(value)}
    found |= {
        name: value for name, value in known.items() if name.startswith(("numberOf", "frictionPairings"))
    }
    for number in range(known["numberOfSpheresMarkerBased"]):
        sphere = contact.GetSphereMarkerBased(number, addData=True)
        found |= {f"{name} of sphere {number}": sphere[name] for name in _OF_A_SPHERE}
    return found


class Restarts:
    """Restart files of one run.

    Args:
        mbs: assembled.   settings: exudyn.SimulationSettings.   explicit: of the run.

    Attributes:
        found: what the run continues from, or None.
        mass_scaling: theta of the run, to be written; that of the run which is continued.
        changes: what user functions had changed when the file was written; empty if nothing, or without one.
        changes_so_far: () -> what they have changed, to be written.

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
        continues = bool(options.continueIfAvailable) and Path(self._name).exists()
        self._start = float(settings.timeIntegration.startTime)
        self._end = float(settings.timeIntegration.endTime)
        self._explicit = explicit
        self._identity = self._present_identity() if options.write or continues else {}
        self.found: Restart | None = read_restart(self._name) if continues else None
        self.changes: Mapping[str, Any] = {}
        if self.found is not None:
            header = self.found.header
            self._require_same(header["identity"], header["meanwhile"])
            self.mass_scaling, self.changes = header["massScaling"], header["changes"]
            self._old = TimeGrid(**header["grid"])

    def _present_identity(self) -> dict[str, dict[str, str]]:
        return scene_identity(self._mbs, self._explicit, self._start)

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
    def _evaluated_by(self) -> list[str]:
        """By whom, of each run that is continued."""
        found: list[str] = self.found.header["evaluatedBy"] if self.found else []
        return found

    @property
    def was_coupled(self) -> bool:
        """Whether the run that is continued moves cables together with other items; False without one."""
        return any(self._evaluated_by)

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
        meanwhile: dict[str, dict[str, str]] = {}
        if step == grid.loop_steps and has_functions(
            self._identity
        ):  # a later run of the same mbs finds them
            meanwhile = changes(self._identity, self._present_identity())
        loop_step = (self._end - grid.start) / grid.loop_steps
        header = {
            "grid": asdict(replace(grid, first=step)),
            "loopStep": self.found.header["loopStep"] if self.found else loop_step,
            "massScaling": self.mass_scaling,
            "evaluatedBy": [run.evaluated_by for run in runs],
            "changes": self.changes_so_far(),
            "identity": self._identity,
            "meanwhile": meanwhile,
        }
        arrays = packed("mbs", state_of(self._mbs))
        for number, run in enumerate(runs):
            arrays |= packed(str(number), run.memory())
        write_restart(self._name, Restart(header, arrays))

    def resume(self, runs: Sequence[Any], grid: TimeGrid) -> None:
        """Give the runs the states and memories of the file."""
        arrays = self.found.arrays if self.found else {}
        for number, run in enumerate(runs):
            run.evaluate_by(self._evaluated_by[number])
            unpack(str(number), run.memory(), arrays)
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
