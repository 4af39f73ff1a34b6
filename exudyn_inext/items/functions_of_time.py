"""Whether a user function f(mbs, t, ...) depends on nothing but the time."""

import builtins
import dis
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property, lru_cache
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple
from warnings import warn_explicit
from weakref import WeakKeyDictionary

import numpy as np

from ..run.fingerprint import all_codes
from ..run.settings import SAY_OF_TIME

_TRUSTED = {"numpy", "math", "cmath", "scipy"}
_OF_STATE = {"open", "input", "eval", "exec", "compile", "globals", "vars", "id", "hash", "next"}
_BUILTINS = set(dir(builtins)) - _OF_STATE
_NUMBERS = (int, float, complex, bool, str, type(None), np.generic)
_CONTAINERS = (list, dict, set, np.ndarray)
_OF_CHANCE = {"random", "rvs", "default_rng"}
_STORING = {"append", "extend", "insert", "pop", "remove", "clear", "update", "setdefault", "add", "fill"}
DEEPEST = 8  # functions that call each other
_WARNED: dict[Any, Any] = {}
_SAID: WeakKeyDictionary[Any, bool | Sequence[Any] | None] = WeakKeyDictionary()  # of each mbs
_FOUND: WeakKeyDictionary[Any, "_Functions"] = WeakKeyDictionary()  # of each mbs, for a while


def take_word(mbs: Any, said: bool | Sequence[Callable[..., Any]] | None) -> None:
    """From now on, `is_of_time_alone` believes what settings say.   said: see `ExplicitSettings`."""
    _SAID[mbs] = said


@contextmanager
def functions_at_rest(mbs: Any) -> Iterator[None]:
    """While it lasts, functions of the user and what they read do not change: each is looked at once."""
    if mbs in _FOUND:
        yield
        return
    _FOUND[mbs] = _Functions(mbs)
    try:
        yield
    finally:
        del _FOUND[mbs]


def python_function(given: dict[str, Any]) -> Callable[..., Any]:
    """The function in what Exudyn gives of it; a symbolic one, which cannot be called, as its evaluation."""
    function: Any = given["function"]
    return function if callable(function) else function.Evaluate


def drive_of(user_function: Any) -> Any:
    """The `native.velocity_level.Drive` of an offset; None: that of no constraint at velocity level.

    It is a function of the time alone, which becomes another one where the velocity is set between steps.
    """
    return getattr(user_function["function"], "drive", None) if user_function else None


def is_of_time_alone(mbs: Any, user_function: Any) -> bool:
    """Whether a user function, as Exudyn gives it, is said to be so, or can be seen to be.

    It can be seen where its code never reads its first argument, and else only data, functions of NumPy,
    SciPy and math, and Python functions of which this is true, stores nothing outside, and draws no random
    numbers. Step functions must not store what is in a function around it, and its data must not be such
    that another function of the same module stores it: that one may be called by a sensor, by a key that is
    pressed, by a thread.
    """
    if not user_function:
        return False
    function = user_function["function"]
    said = word_of(mbs, function)
    if said is not None:
        return said
    if not isinstance(function, FunctionType):
        return False
    found = _FOUND.get(mbs) or _Functions(mbs)
    if function not in found.of_time_alone:
        found.of_time_alone[function] = _is_seen_to_be(function, found)
    return found.of_time_alone[function]


def _is_seen_to_be(function: FunctionType, found: "_Functions") -> bool:
    code = function.__code__
    is_pure = code.co_argcount > 0 and not _reads(code, code.co_varnames[0]) and found.is_pure(function)
    return is_pure and not found.is_of_sensors and not _is_steered(function, found.steering)


def step_functions(mbs: Any) -> list[Any]:
    """Functions of the user that are called before or after each step of Exudyn's loop."""
    given = mbs.GetPreStepUserFunction(), mbs.GetPostStepUserFunction()
    return [one["function"] if isinstance(one, dict) else one for one in given if one]


def _is_steered(function: FunctionType, steering: Sequence[Any], depth: int = 0) -> bool:
    """Whether step functions store into variables, lists or arrays of a function around this one."""
    own = {id(one) for one in _shared(function)} if steering else set()
    for other in steering:
        if not isinstance(other, FunctionType) or depth >= DEEPEST:
            continue
        shared = _shared(other)
        looked = [looked_at(code) for code in all_codes(other.__code__)]
        if any(found.stores or found.is_open for found in looked) and any(id(one) in own for one in shared):
            return True
        if _is_steered(function, [one for one in shared if isinstance(one, FunctionType)], depth + 1):
            return True
    return False


def _shared(function: FunctionType) -> list[Any]:
    """Variables of the functions around it that one reads; lists, arrays and functions that these hold."""
    cells = [cell for cell in function.__closure__ or () if cell != CellType()]
    values = [cell.cell_contents for cell in cells]
    return cells + [value for value in values if isinstance(value, (*_CONTAINERS, FunctionType))]


def word_of(mbs: Any, function: Any) -> bool | None:
    """Whether it is of time alone: what is known of the package's own, and users say of theirs; or None."""
    if getattr(function, "of_time_alone", False):
        return True
    said = _SAID.get(mbs)
    if isinstance(said, bool):
        return said
    if any(function == one for one in said or ()):
        return True
    return _attribute_of(function)


def _attribute_of(function: Any) -> bool | None:
    """The attribute that stood for the setting until release 0.1."""
    declared = getattr(function, "dependsOnTimeOnly", None)
    if declared is None:
        return None
    code = getattr(function, "__code__", None)
    file, line = (code.co_filename, code.co_firstlineno) if code else (type(function).__name__, 1)
    said = f"{getattr(function, '__name__', function)}.dependsOnTimeOnly is deprecated: {SAY_OF_TIME}."
    warn_explicit(said, DeprecationWarning, file, line, function.__module__, _WARNED)
    return declared is True


def has_sensor_functions(mbs: Any) -> bool:
    """Whether sensors call functions of the user; those that only look say so by an attribute."""
    sensors = (mbs.GetSensor(k) for k in range(mbs.systemData.NumberOfSensors()))
    functions = [
        one["sensorUserFunction"]["function"] for one in sensors if one["sensorType"] == "UserFunction"
    ]
    return not all(getattr(function, "onlyLooks", False) for function in functions)


class Code(NamedTuple):
    """What a function does outside of itself, but for those within it.

    assigned: global names.   stores: whether into anything.   outer, free: names that it reads, of its module
    and of functions around it.   is_open: whether it does what a function of time alone cannot do.
    """

    assigned: frozenset[str]
    stores: bool
    outer: frozenset[str]
    free: frozenset[str]
    is_open: bool


@lru_cache(maxsize=256)
def looked_at(code: CodeType) -> Code:
    """What the code of a function does."""
    instructions = list(dis.get_instructions(code))

    def names(*operations: str) -> frozenset[str]:
        return frozenset(i.argval for i in instructions if i.opname in operations)

    assigned, around = names("STORE_GLOBAL", "DELETE_GLOBAL"), set(code.co_freevars)
    changed = names("STORE_ATTR", "IMPORT_NAME", "IMPORT_FROM") | names("STORE_DEREF") & around
    return Code(
        assigned,
        stores=any(i.opname == "STORE_SUBSCR" or i.argval in _STORING for i in instructions),
        outer=names("LOAD_GLOBAL", "LOAD_NAME"),
        free=names("LOAD_DEREF", "LOAD_CLASSDEREF") & around,
        is_open=bool(assigned or changed or names("LOAD_ATTR", "LOAD_METHOD") & _OF_CHANCE),
    )


@lru_cache(maxsize=256)
def _reads(code: CodeType, name: str) -> bool:
    """Whether the code, or a function within it, reads this variable of its own."""
    if name in code.co_cellvars:
        return True
    loads = (i.argval for i in dis.get_instructions(code) if i.opname.startswith("LOAD_FAST"))
    return any(name in value if isinstance(value, tuple) else name == value for value in loads)


class _Functions:
    """What is found of the functions of an mbs, while these and what they read do not change.

    steering: see `step_functions`.   of_time_alone: whether functions are, as far as they were looked at.
    """

    def __init__(self, mbs: Any) -> None:
        self._mbs, self.steering = mbs, step_functions(mbs)
        self.of_time_alone: dict[FunctionType, bool] = {}
        self._called: dict[FunctionType, Sequence[FunctionType] | None] = {}
        self._read: dict[tuple[CodeType, int], list[Any] | None] = {}
        self._stored: dict[int, set[str]] = {}

    @cached_property
    def is_of_sensors(self) -> bool:
        """Whether functions of sensors may change what others read."""
        return has_sensor_functions(self._mbs)

    def is_pure(self, function: FunctionType) -> bool:
        """Whether it, and what it calls, read only data and such functions, and store nothing outside."""
        reached, ahead = set[FunctionType](), [function]
        while ahead:
            one = ahead.pop()
            if one in reached:
                continue
            reached.add(one)
            if one not in self._called:
                self._called[one] = self._called_by(one)
            called = self._called[one]
            if called is None:
                return False
            ahead += called
        return True

    def _called_by(self, function: FunctionType) -> Sequence[FunctionType] | None:
        """Python functions that it reads from outside; None if it does what a pure one cannot do."""
        around = _around(function)
        if around is None:
            return None
        called: list[FunctionType] = []
        for code in all_codes(function.__code__):
            of_module, looked = self._of_module(code, function.__globals__), looked_at(code)
            if of_module is None:
                return None
            cells = {name: around[name] for name in looked.free if name in around}
            if not all(_is_pure_value(name, value) for name, value in cells.items()):
                return None
            values = of_module + list(cells.values())
            if looked.stores and any(isinstance(value, list | dict | np.ndarray) for value in values):
                return None
            called += filter(_is_of_user, values)
        return called

    def _of_module(self, code: CodeType, module: dict[str, Any]) -> list[Any] | None:
        """Values that code reads of its module, and built-in ones; None as of `_called_by`."""
        key = code, id(module)
        if key not in self._read:
            self._read[key] = self._read_of_module(looked_at(code), module)
        return self._read[key]

    def _read_of_module(self, found: "Code", module: dict[str, Any]) -> list[Any] | None:
        if found.is_open:
            return None
        names = [name for name in found.outer if name in module or hasattr(builtins, name)]
        values = {name: module[name] if name in module else getattr(builtins, name) for name in names}
        data = {name for name, value in values.items() if _is_data(value)}
        if data and id(module) not in self._stored:
            self._stored[id(module)] = _stored_in(module)
        if data and data & self._stored[id(module)]:
            return None
        is_pure = all(_is_pure_value(name, value) for name, value in values.items())
        return list(values.values()) if is_pure else None


def _around(function: FunctionType) -> dict[str, Any] | None:
    """Values of the variables of functions around it that a function reads; None if one has no value yet."""
    try:
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
    except ValueError:
        return None
    return dict(zip(function.__code__.co_freevars, cells, strict=True))


def known_to(function: FunctionType) -> dict[str, Any] | None:
    """Values of the names that a function reads from outside; None if one has no value yet."""
    around = _around(function)
    return None if around is None else {**vars(builtins), **function.__globals__, **around}


def package_of(value: Any) -> str:
    """That something is from; of a module, the package that contains it."""
    name = value.__name__ if isinstance(value, ModuleType) else value.__module__
    return str(name).split(".")[0]


def _stored_in(module: dict[str, Any]) -> set[str]:
    """Names of a module's data that its functions assign, or that those read that store into something."""
    names: set[str] = set()
    for value in list(module.values()):
        members = list(vars(value).values()) if isinstance(value, type) else [value]
        functions = [one for one in members if isinstance(one, FunctionType) and one.__globals__ is module]
        for found in (looked_at(code) for one in functions for code in all_codes(one.__code__)):
            read = found.outer if found.stores else ()
            names |= found.assigned | {name for name in read if isinstance(module.get(name), _CONTAINERS)}
    return names


def _is_pure_value(name: str, value: Any) -> bool:
    """Whether a value that code reads from outside depends on nothing else, or is a function of the user."""
    if isinstance(value, ModuleType):
        return package_of(value) in _TRUSTED
    if _is_data(value):
        return True
    if _is_trusted(value):
        return not isinstance(value, np.ndarray)
    is_builtin = name in _BUILTINS and value is getattr(builtins, name, None)
    return is_builtin or isinstance(value, FunctionType)


def _is_of_user(value: Any) -> bool:
    return isinstance(value, FunctionType) and not _is_trusted(value)


def _is_trusted(value: Any) -> bool:
    """Whether it, or its type, is of a package that depends on nothing else."""
    return package_of(value if getattr(value, "__module__", None) else type(value)) in _TRUSTED


def _is_data(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_is_data, value))
    if isinstance(value, dict):
        return all(_is_data(key) and _is_data(one) for key, one in value.items())
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "biufc"
    return isinstance(value, _NUMBERS)
