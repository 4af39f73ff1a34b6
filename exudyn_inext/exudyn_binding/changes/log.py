"""Calls that change a running mbs, noted as they are made: the scene is read again after them.

The methods of exudyn.MainSystem are wrapped while any run listens. Not longer: Exudyn's errors and warnings
name the line that has called them. What is called by methods that were bound before is not noted; see
`ChangeFollower.require_all_seen`.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from threading import Lock
from types import MappingProxyType
from typing import Any

import exudyn
import numpy as np

from ...errors import InputError, SceneError
from ...items.cable_data import find_cable_item
from ...items.parameters import CHECK_DIVISIONS, KINDS, Parameter, lacks_numbers

_CONNECTIONS = {"nodeNumber", "nodeNumbers", "bodyNumber", "objectNumber", "markerNumbers"}
_SETTERS = {f"Set{kind}Parameter": kind for kind in KINDS}
_FUNCTION = "function"  # in place of one, which a file cannot hold
_REMEDY = "build all items before the run, and switch them by activeConnector, loads by markerNumber"
_SENSOR = "GetSensorValues"
_NUMBERS = float, int
_OF_MBS = (
    *(f"{what}{kind}" for what in ("Add", "Delete", "Modify") for kind in (*KINDS, "Sensor")),
    *("AddGeneralContact", "DeleteGeneralContact", "Assemble", "Reset", "SetDictionary"),
)


class ChangeLog:
    """What has been changed in an mbs since its run began.

    changed: parameters that have been set to another value, and when the last one was taken [s].
    before: values of what was taken last, before it was set.
    refusal: what was raised by the last call that a run cannot follow, which was not made; or None.
    is_followed: whether the run looks at changes between its steps; if not, they are refused.
    is_idle: whether no step is being taken, so that any call may be made.
    has_jumped: whether something was set then, since somebody has reset this.
    is_outdated: whether one was made then that no run can follow: it has to be built again.
    sensors_of_forces: numbers of those that show accelerations or forces, and whether those of supports.
    show_forces: gives mbs these in its state; called before such a sensor is asked for between steps.
    """

    is_followed = True
    is_idle = False
    is_outdated = False
    sensors_of_forces: Mapping[int, bool] = MappingProxyType({})
    show_forces: Callable[[bool], None]

    def __init__(self, mbs: Any) -> None:
        self.mbs = mbs
        self.changed: dict[Parameter, float] = {}
        self.before: dict[Parameter, Any] = {}
        self.refusal: SceneError | None = None
        self._known: dict[Parameter, Any] = {}  # values when the log was taken last
        self._set: dict[Parameter, Any] = {}  # present values of what has been set since then; None: ask mbs
        self._waiting: dict[Parameter, Any] = {}  # values to be set, see `restore`
        self.has_jumped = False

    @property
    def is_pending(self) -> bool:
        """Whether there is something to take."""
        if self._set and not self.is_outdated:
            present = {key: self._read(key) if x is None else x for key, x in self._set.items()}
            self._set = {key: x for key, x in present.items() if not _is_same(x, self._known[key])}
        return bool(self._set) or self.is_outdated or not self.mbs.systemIsConsistent

    def take(self, time: float, end: float) -> tuple[dict[Parameter, Any], bool]:
        """What had changed since the last time, when `is_pending` was asked for; present values.

        And whether some of it did not before the step until `time` [s], as the next one until `end` [s].

        Raises:
            SceneError: items were added, removed or modified, or something set to what is no number.
        """
        if self.is_outdated:
            self.refuse("other items were found than at the start", "initialise the solver again")
        if not self.mbs.systemIsConsistent:
            self.refuse("items were added, removed or modified", _REMEDY)
        for key, value in self._set.items():
            if lacks_numbers(value, key.kind):
                self.refuse(f"{key} was set to {value}", CHECK_DIVISIONS)
        self.before = {key: self._known[key] for key in self._set}
        self._known |= self._set
        changed, self._set = self._set, {}
        is_new = any(self.changed.get(key, -math.inf) < time - 1.5 * (end - time) for key in changed)
        self.changed |= dict.fromkeys(changed, time)
        return changed, is_new

    def memory(self) -> dict[str, Any]:
        """Present values of what has been changed, and what of it is pending, as JSON has it."""
        pending = (key for key in self._set if not _is_same(self._known[key], key.value(self.mbs)))
        known = [[*key, _as_data(self._known[key])] for key in sorted(pending)]
        return {
            "parameters": [
                [*key, _as_data(key.value(self.mbs)), time] for key, time in sorted(self.changed.items())
            ],
            "pending": known,
        }

    def restore(self, memory: Mapping[str, Any]) -> None:
        """Set the parameters of mbs to what they were when a file was written.

        What was pending is what it was before; `set_pending` sets it.

        Raises:
            InputError: a function had been replaced.
        """
        for *names, value, time in memory["parameters"]:
            key = Parameter(*names)
            if value == _FUNCTION:
                raise InputError(
                    f"restart file: {key} was replaced by another function before the file was written, "
                    "which a file cannot hold: let one function tell the cases apart, or start anew."
                )
            self.changed[key] = time
            key.set(self.mbs, value)
        for *names, before in memory["pending"]:
            key = Parameter(*names)
            self._waiting[key] = key.value(self.mbs)
            if before != _FUNCTION:
                key.set(self.mbs, before)

    def set_pending(self) -> None:
        """Set what was pending when the file was written, as if it had just been changed."""
        for key, value in self._waiting.items():
            self._known[key], self._set[key] = key.value(self.mbs), value
            key.set(self.mbs, value)
        self._waiting = {}

    def note(self, method: str, given: Sequence[Any]) -> None:
        """A method of mbs is about to be called.

        Raises:
            SceneError: a run cannot follow that change; the call must not be made.
        """
        if method not in _SETTERS:
            self.refuse(f"mbs.{method} was called", _REMEDY)
        if self.is_outdated:
            return
        number, name, value = given
        key = Parameter(_SETTERS[method], int(number), name)
        if key not in self._known:
            if name == "name" or name.startswith("V"):
                return
            with suppress(Exception):
                self._known[key] = self._read(key)
        if key not in self._known:
            key.set(self.mbs, value)  # of which Exudyn says what is wrong
            self.refuse(f"{key} was set, which mbs cannot read", "set something else")
        if key not in self.changed and not _is_same(self._known[key], value):
            self._require_possible(key)
            self.changed[key] = -math.inf
        self._set[key] = _as_known(self._known[key], value)
        self.has_jumped |= self.is_idle

    def _read(self, key: Parameter) -> Any:
        return _listed(key.value(self.mbs))

    def doubt(self) -> None:
        """The call that was noted last has failed: mbs knows what has been set."""
        self._set = dict.fromkeys(self._set)

    def _require_possible(self, key: Parameter) -> None:
        if key.name in _CONNECTIONS or self._is_reference(key):
            self.refuse(f"{key} was to be changed", _REMEDY)
        if key.kind == "Object" and find_cable_item(self.mbs.GetObject(key.number)) is not None:
            self.refuse(f"{key}, an inextensible cable, was to be changed", "use loads and connectors")
        if key.name == "velocityLevel":
            self.refuse(
                f"{key} was to be changed", "set it before the run, and use activeConnector to switch"
            )
        if not self.is_followed:
            self.refuse(
                f"{key} was changed while steps are computed ahead",
                "register a pre-step user function, mbs.SetPreStepUserFunction(lambda mbs, t: True)",
            )

    def _is_reference(self, key: Parameter) -> bool:
        """Whether coordinates that move are counted from it, or a mass point is there."""
        if (key.kind, key.name) != ("Node", "referenceCoordinates"):
            return False
        if self.mbs.GetNode(key.number)["nodeType"] != "PointGround":
            return True
        objects = map(self.mbs.GetObject, range(self.mbs.systemData.NumberOfObjects()))
        return any(int(data.get("nodeNumber", -1)) == key.number for data in objects)

    def refused(self, error: Exception) -> bool:
        """Whether an error of Exudyn is what was made of a refusal."""
        return self.refusal is not None and str(self.refusal) in str(error)

    def require_none_refused(self) -> None:
        """Raise once more what was raised by a call, if a user function caught it: the call was not made."""
        if self.refusal is not None:
            raise self.refusal

    def refuse(self, what: str, remedy: str) -> None:
        """Raise SceneError; between steps, remember that the run is not valid any more."""
        if self.is_idle:
            self.is_outdated = True
            return
        time = self.mbs.systemData.GetTime()
        self.refusal = SceneError(
            f"in the step to t = {time:.6g} s, {what}, which a run cannot follow: {remedy}. mbs holds the "
            "state before that step."
        )
        raise self.refusal


_LISTENING: list[ChangeLog] = []
_LOCK = Lock()


@contextmanager
def listening(log: ChangeLog) -> Iterator[None]:
    """Calls are noted meanwhile; the methods are wrapped as long as any log listens."""
    with _LOCK:
        if not _LISTENING:
            _ORIGINAL.update({name: vars(exudyn.MainSystem)[name] for name in _WRAPPED})
            _set_methods(_WRAPPED)
        _LISTENING.append(log)
    try:
        yield
    finally:
        with _LOCK:
            _LISTENING.remove(log)
            if not _LISTENING:
                _set_methods(_ORIGINAL)


def _set_methods(methods: Mapping[str, Any]) -> None:
    for name, method in methods.items():
        setattr(exudyn.MainSystem, name, method)


def _is_same(x: Any, y: Any) -> bool:
    """Whether two values of a parameter are equal: numbers, lists, arrays, functions, or anything else."""
    try:
        if type(x) is type(y) and isinstance(x, (float, list)):
            return bool(x == y)
        if isinstance(x, np.ndarray) and isinstance(y, np.ndarray):
            return x.shape == y.shape and x.tolist() == y.tolist()
        return x is y or bool(np.array_equal(x, y))
    except (TypeError, ValueError):
        return False


def _listed(value: Any) -> Any:
    """Arrays (n,) of real numbers as lists: small ones are compared and multiplied faster."""
    is_vector = isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype == np.float64
    return value.tolist() if is_vector else value


def _as_known(known: Any, value: Any) -> Any:
    """A value as Exudyn gives it, if both are real numbers of one form; None: ask it, which takes longer."""
    if isinstance(known, float):
        return float(value) if isinstance(value, _NUMBERS) else None
    value = value if isinstance(value, list) else _listed(value)
    if not (isinstance(value, list) and isinstance(known, list) and known and isinstance(known[0], float)):
        return None
    numbers = [float(x) for x in value if isinstance(x, _NUMBERS)]
    return numbers if len(numbers) == len(value) == len(known) else None


def _as_data(value: Any) -> Any:
    """Numbers, lists of them, or text; the index of an item is its number."""
    if callable(value):
        return _FUNCTION
    if isinstance(value, str):
        return value
    numbers = np.asarray(value)
    return int(value) if numbers.dtype == object and numbers.ndim == 0 else numbers.tolist()


def _noted(name: str) -> Callable[..., Any]:
    """The method of mbs of that name, told to the log before it is called."""
    original = getattr(exudyn.MainSystem, name)
    names = (f"{_SETTERS[name].lower()}Number", "parameterName", "value") if name in _SETTERS else ()

    @wraps(original)
    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        given = [*args, *(kwargs[key] for key in names if key in kwargs)] if kwargs else args
        is_complete = not names or len(given) == len(names)
        logs = [log for log in _LISTENING if log.mbs is self] if is_complete else []
        for log in logs:
            log.note(name, given)
        try:
            return original(self, *args, **kwargs)
        except Exception:
            for log in logs:
                log.doubt()
            raise

    return call


def _after_forces() -> Callable[..., Any]:
    """`GetSensorValues` of mbs, which then has the forces that the sensor looks at."""
    original = getattr(exudyn.MainSystem, _SENSOR)

    @wraps(original)
    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        number = int(args[0] if args else kwargs.get("sensorNumber", -1))
        for log in _LISTENING:
            if log.mbs is self and number in log.sensors_of_forces:
                log.show_forces(log.sensors_of_forces[number])
        return original(self, *args, **kwargs)

    return call


_WRAPPED = {name: _noted(name) for name in (*_SETTERS, *_OF_MBS)} | {_SENSOR: _after_forces()}
_ORIGINAL: dict[str, Any] = {}  # as they were before the first log listened
