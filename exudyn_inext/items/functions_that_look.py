"""Step functions of the user, and at what they may look: at accelerations and forces of constraints, too."""

import dis
from abc import ABCMeta
from collections.abc import Iterator
from enum import IntEnum
from functools import cached_property, partial
from types import (
    BuiltinFunctionType,
    CodeType,
    FunctionType,
    MemberDescriptorType,
    MethodType,
    ModuleType,
    SimpleNamespace,
)
from typing import Any

import exudyn
import numpy as np

from ..run.fingerprint import all_codes
from .functions_of_time import (
    functions_at_rest,
    has_sensor_functions,
    is_of_time_alone,
    known_to,
    looked_at,
    package_of,
    python_function,
    step_functions,
    word_of,
)

_TRUSTED = {"builtins", "numpy", "math", "exudyn"}
_NAMES = """
    SetLoadParameter SetObjectParameter SetMarkerParameter SetNodeParameter
    GetLoadParameter GetObjectParameter GetMarkerParameter GetNodeParameter
    systemData GetTime GetODE2Coordinates GetODE2Coordinates_t SetODE2Coordinates SetODE2Coordinates_t
    GetSensorValues GetNodeOutput GetObjectOutputBody OutputVariableType
    Position Displacement Velocity VelocityLocal Rotation RotationMatrix AngularVelocity AngularVelocityLocal
    Coordinates Coordinates_t variables __class__
"""  # of mbs, and of what it gives
_OF_MBS = set(_NAMES.split())
_OF_DATA = {
    name for kind in (np.ndarray, float, str, list, tuple, dict, set) for name in dir(kind) if name[0] != "_"
}
_TYPES = {
    getattr(exudyn.OutputVariableType, name) for name in _OF_MBS if hasattr(exudyn.OutputVariableType, name)
}
_SENSOR = "GetSensorValues"
_OF_STATE = {_SENSOR, "GetNodeOutput", "GetObjectOutputBody", "systemData"}  # of these of mbs
_OF_POINTS = {"Node", "Body", "Marker"}  # sensors that show motion, if their output is one of it
_BY_NAME = {"getattr", "setattr", "delattr", "vars", "globals", "locals", "__import__"}
_OPEN = {"eval", "exec", "compile", "open", "input", *_BY_NAME}
_DATA = {int, float, complex, str, bool, type(None), type(NotImplemented)}
_OF_DATACLASSES = {"dataclasses", "reprlib"}  # modules of what these classes show themselves by
_GLOBAL = {"LOAD_GLOBAL", "LOAD_NAME"}
_CALLS = {"CALL", "PRECALL", "CALL_METHOD"}
_IMMUTABLE, _BY_CLASS = 1 << 8, 1 << 9  # flags of types: of C code, and of a class statement if not


class Look(IntEnum):
    """At nothing; at places and velocities; at sensors of others, too; at anything, as forces."""

    NOTHING = 0
    MOTION = 1
    SENSORS = 2
    ANYTHING = 3


def look_of_step_functions(mbs: Any) -> Look:
    """At what functions may look that are called between steps."""
    return max((look_of(function, mbs) for function in step_functions(mbs)), default=Look.NOTHING)


def look_of_item_functions(mbs: Any) -> Look:
    """At what functions of loads and objects may look that are called in steps; not those of this package.

    At anything, if they set something: it may act at once.
    """
    functions = asked_item_functions(mbs)
    return max((look_of(one, mbs, may_set=False) for one in functions), default=Look.NOTHING)


def asked_item_functions(mbs: Any) -> list[Any]:
    """Functions of loads and objects that may not be of time alone; not those of this package."""
    data = mbs.systemData
    items = [mbs.GetLoad(k) for k in range(data.NumberOfLoads())]
    items += [mbs.GetObject(k) for k in range(data.NumberOfObjects())]
    given = [one for item in items for key, one in item.items() if "UserFunction" in key and key[0] != "V"]
    with functions_at_rest(mbs):
        asked = [one for one in given if isinstance(one, dict) and not is_of_time_alone(mbs, one)]
    return [one for one in map(python_function, asked) if package_of(one) != __name__.split(".")[0]]


def look_of(function: Any, mbs: Any, may_set: bool = True) -> Look:
    """At what a function f(mbs, t) may look, as far as its code shows.

    may_set: whether one that sets something counts as others do; otherwise it may look at anything.

    That is not anything if it reads only data, numbers of items, functions of NumPy and math and of its own
    kind, and takes only what is known of mbs. Methods, `functools.partial`, and objects that are called are
    looked into, and of objects all attributes that this code names.
    """
    reached = _Reached(mbs)
    if not (reached.is_known(function) and reached.has_known_names()):
        return Look.ANYTHING
    if not may_set and any(name.startswith("Set") for name in reached.names):
        return Look.ANYTHING
    if not reached.names & _OF_STATE:
        return Look.NOTHING
    return Look.SENSORS if _SENSOR in reached.names and not reached.asks_for_motion() else Look.MOTION


def names_read_by(function: Any, mbs: Any) -> set[str]:
    """Names of attributes, and of output variables, that a function reads, as far as its code shows.

    Also of the output variables of sensors that it asks.
    """
    reached = _Reached(mbs)
    reached.is_known(function)
    reached.has_known_names()
    return reached.names | {
        one["outputVariableType"].name for one in reached.asked_sensors() or () if "outputVariableType" in one
    }


def may_change_anything(function: Any, mbs: Any) -> bool:
    """Whether a function may set or store what others read, as far as its code shows."""
    reached = _Reached(mbs)
    if not (reached.is_known(function) and reached.has_known_names()):
        return True
    return reached.stores or any(name.startswith("Set") for name in reached.names)


class _Reached:
    """What a function of the user reaches: by variables of its code, and by attributes of objects.

    names: of the attributes that its code takes.   stores: whether it stores into anything but variables.
    """

    def __init__(self, mbs: Any) -> None:
        self.names: set[str] = set()
        self.stores = False
        self._mbs = mbs
        self._sensors: list[Any] = []  # what is asked for values; None: not known
        self._seen: dict[int, Any] = {}  # by their addresses, which they keep
        self._objects: list[Any] = [SimpleNamespace(variables=mbs.variables)]  # and those of the user
        self._members: set[str] = set()  # of modules and objects
        self._of_exudyn = {*dir(mbs), *dir(mbs.systemData)}

    def has_known_names(self) -> bool:
        """Whether code takes only known attributes, which are known themselves."""
        done = set[tuple[int, str]]()
        while ahead := {(k, name) for k in range(len(self._objects)) for name in self.names} - done:
            for k, name in ahead:
                values = list(_attributes(self._objects[k], name))
                if not all(map(self.is_known, values)):
                    return False
                if values:
                    self._members.add(name)
            done |= ahead
        others = {name for name in self._members - self._of_exudyn if not name.startswith("__")}
        return self.names <= _OF_MBS | _OF_DATA | others

    def asks_for_motion(self) -> bool:
        """Whether all sensors that are asked for values are known, and show places and velocities."""
        shown = self.asked_sensors()
        return shown is not None and all(
            one["sensorType"] in _OF_POINTS and one["outputVariableType"] in _TYPES for one in shown
        )

    def asked_sensors(self) -> list[dict[str, Any]] | None:
        """Data of sensors that are asked for values; None: one of them is not known."""
        number = self._mbs.systemData.NumberOfSensors()
        if any(one is None or not 0 <= int(one) < number for one in self._sensors):
            return None
        return [self._mbs.GetSensor(int(one)) for one in self._sensors]

    def is_known(self, value: Any) -> bool:
        """Whether a value is, as far as it does not depend on attributes."""
        if id(value) in self._seen:
            return True
        self._seen[id(value)] = value
        parts = _parts(value)
        if parts is not None:
            return all(map(self.is_known, parts))
        if isinstance(value, FunctionType):
            return package_of(value) == "numpy" or self._is_known_function(value)
        if isinstance(value, ModuleType):
            if value is not exudyn:
                self._members.update(dir(value), dir(getattr(value, "linalg", value)))
            return package_of(value) in _TRUSTED
        if _is_of_user(type(value)):
            self._objects.append(value)
            return all(map(self.is_known, _called_unnamed(type(value))))
        if isinstance(value, exudyn.OutputVariableType):
            self.names.add(value.name)
        elif package_of(type(value)) == "exudyn":
            self._of_exudyn.update(dir(value))
        return _is_plain(value)

    def _is_known_function(self, function: FunctionType) -> bool:
        outer = known_to(function)
        given = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
        if outer is None:
            return False
        known = [self.is_known(one) for one in given]
        for code in all_codes(function.__code__):
            self._sensors += _asked_sensors(code, outer if code is function.__code__ else {})
            known.append(self._is_known_code(code, outer))  # looks at all of it, for the names
        return all(known)

    def _is_known_code(self, code: CodeType, outer: dict[str, Any]) -> bool:
        named = [i for i in dis.get_instructions(code) if i.opcode in dis.hasname]
        self.names.update(i.argval for i in named if i.opname not in _GLOBAL)
        self.stores |= looked_at(code).stores or looked_at(code).is_open
        read = {i.argval for i in named if i.opname in _GLOBAL}.union(code.co_freevars) & outer.keys()
        known = [self.is_known(outer[name]) for name in read]
        return not read & _OPEN and all(known)


def _asked_sensors(code: CodeType, outer: dict[str, Any]) -> Iterator[Any]:
    """What each call mbs.GetSensorValues(sensor) in code names: an index, or a number; None: anything else.

    outer: values of names that the code reads from outside.
    """
    taken = [i for i in dis.get_instructions(code) if i.opname != "PUSH_NULL"]
    for method, given, call in zip(taken, taken[1:], [*taken[2:], taken[-1]], strict=False):
        if method.argval == _SENSOR and method.opcode in dis.hasname:
            is_named = given.opname in ("LOAD_DEREF", "LOAD_GLOBAL")
            value = outer.get(given.argval) if is_named else given.argval
            kind = "SensorIndex" if is_named else "int"
            yield value if type(value).__name__ == kind and call.opname in _CALLS else None


def _parts(value: Any) -> list[Any] | None:
    """What a container or a function that is made of another one consists of; None: it is something else."""
    if isinstance(value, MethodType):
        return [value.__func__, value.__self__]
    if isinstance(value, partial):
        return [value.func, value.args, value.keywords]
    if isinstance(value, property):
        return [value.fget, value.fset]
    if isinstance(value, cached_property):
        return [value.func]
    if isinstance(value, staticmethod | classmethod):
        return [value.__func__]
    if type(value) in (list, tuple, set):
        return list(value)
    return list(value.values()) if type(value) is dict else None


def _is_of_user(kind: type) -> bool:
    """Whether a class, and those that it is derived from, are written in Python."""
    if kind is SimpleNamespace:
        return True
    return kind is not object and all(
        type(base) in (type, ABCMeta) and base.__flags__ & _BY_CLASS and not base.__flags__ & _IMMUTABLE
        for base in kind.__mro__[:-1]
    )


def _called_unnamed(kind: type) -> Iterator[Any]:
    """Methods of a class that are called without their names: by operators, calls, loops."""
    for base in kind.__mro__[:-1]:
        for name, value in vars(base).items():
            is_function = name.startswith("__") and name != "__init__" and isinstance(value, FunctionType)
            if is_function and value.__globals__["__name__"] not in _OF_DATACLASSES:
                yield value


def _attributes(owner: Any, name: str) -> Iterator[Any]:
    """What that attribute of an object is, of itself and of its classes."""
    own = getattr(owner, "__dict__", {})
    if name in own:
        yield own[name]
    for base in type(owner).__mro__[:-1]:
        if name in vars(base):
            value = vars(base)[name]
            yield getattr(owner, name, None) if isinstance(value, MemberDescriptorType) else value


def _is_plain(value: Any) -> bool:
    """Whether a value is data, a type, an item of Exudyn, or a function of Python or NumPy in C."""
    if isinstance(value, exudyn.OutputVariableType):
        return value in _TYPES
    if isinstance(value, type):
        return package_of(value) in _TRUSTED
    is_built_in = isinstance(value, BuiltinFunctionType | np.ufunc) and not _is_bound(value)
    is_of_exudyn = package_of(type(value)) == "exudyn" and not callable(value)
    return is_built_in or is_of_exudyn or type(value) in _DATA or isinstance(value, np.generic | np.ndarray)


def _is_bound(value: Any) -> bool:
    owner = getattr(value, "__self__", None)
    return owner is not None and not isinstance(owner, ModuleType)


class FunctionsOfSteps:
    """Those of an mbs whose functions and what they read do not change meanwhile.

    Their code shows that they look at nothing of the state, nor store anything, and no other function that is
    called within steps stores anything.
    """

    def __init__(self, mbs: Any) -> None:
        self._mbs = mbs

    def __contains__(self, user_function: Any) -> bool:
        """Whether a user function, as Exudyn gives it, is one of them."""
        function = python_function(user_function)
        if word_of(self._mbs, function) is False or look_of(function, self._mbs) > Look.NOTHING:
            return False
        return self._none_changes_anything

    @cached_property
    def may_set_objects(self) -> bool:
        """Whether step functions may, along whose way their parameters would go within a step."""
        mbs = self._mbs
        return any(
            look_of(one, mbs) == Look.ANYTHING or "SetObjectParameter" in names_read_by(one, mbs)
            for one in step_functions(mbs)
        )

    @cached_property
    def _none_changes_anything(self) -> bool:
        if has_sensor_functions(self._mbs):
            return False
        return not any(may_change_anything(one, self._mbs) for one in asked_item_functions(self._mbs))
