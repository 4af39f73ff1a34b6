"""Whether a user function f(mbs, t, ...) depends on nothing but the time."""

import builtins
import dis
from collections.abc import Callable, Sequence
from functools import lru_cache
from types import CodeType, FunctionType, ModuleType
from typing import Any
from warnings import warn_explicit
from weakref import WeakKeyDictionary

import numpy as np

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


def take_word(mbs: Any, said: bool | Sequence[Callable[..., Any]] | None) -> None:
    """From now on, `is_of_time_alone` believes what settings say.   said: see `ExplicitSettings`."""
    _SAID[mbs] = said


def is_of_time_alone(mbs: Any, user_function: Any) -> bool:
    """Whether a user function, as Exudyn gives it, is said to be so, or can be seen to be.

    It can be seen where its code never reads its first argument, and else only data, functions of NumPy,
    SciPy and math, and Python functions of which this is true, stores nothing outside, and draws no random
    numbers. The data must not be such that another function of the same module stores it: that one may be
    called by a sensor, by a key that is pressed, by a thread.
    """
    if not user_function:
        return False
    function = user_function["function"]
    said = _said_of(function, _SAID.get(mbs))
    if said is not None:
        return said
    if not isinstance(function, FunctionType) or _has_sensor_functions(mbs):
        return False
    code = function.__code__
    return code.co_argcount > 0 and not _reads(code, code.co_varnames[0]) and _is_pure(function, 0)


def _said_of(function: Any, said: bool | Sequence[Any] | None) -> bool | None:
    """What the package knows of its own functions, and users say of theirs; None: nothing."""
    if getattr(function, "of_time_alone", False):
        return True
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


def _has_sensor_functions(mbs: Any) -> bool:
    """Whether sensors call functions of the user; those that only look say so by an attribute."""
    sensors = (mbs.GetSensor(k) for k in range(mbs.systemData.NumberOfSensors()))
    functions = [
        one["sensorUserFunction"]["function"] for one in sensors if one["sensorType"] == "UserFunction"
    ]
    return not all(getattr(function, "onlyLooks", False) for function in functions)


@lru_cache(maxsize=256)
def _instructions(code: CodeType) -> tuple[dis.Instruction, ...]:
    return tuple(dis.get_instructions(code))


def _reads(code: CodeType, name: str) -> bool:
    """Whether the code, or a function within it, reads this variable of its own."""
    if name in code.co_cellvars:
        return True
    loads = (i.argval for i in _instructions(code) if i.opname.startswith("LOAD_FAST"))
    return any(name in value if isinstance(value, tuple) else name == value for value in loads)


def _is_pure(function: FunctionType, depth: int) -> bool:
    """Whether it reads only data and pure functions, and stores nothing outside."""
    known = known_to(function)
    if known is None:
        return False
    codes = _all_codes(function.__code__)
    data = {name for code in codes for name in _outer_names(code) if _is_data(known.get(name))}
    if data and data & _stored_in(function.__globals__):
        return False
    return all(_is_pure_code(code, known, depth) for code in codes)


def known_to(function: FunctionType) -> dict[str, Any] | None:
    """Values of the names that a function reads from outside; None if one has no value yet."""
    try:
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
    except ValueError:
        return None
    inner = dict(zip(function.__code__.co_freevars, cells, strict=True))
    return {**vars(builtins), **function.__globals__, **inner}


def package_of(value: Any) -> str:
    """That something is from; of a module, the package that contains it."""
    name = value.__name__ if isinstance(value, ModuleType) else value.__module__
    return str(name).split(".")[0]


def _stored_in(module: dict[str, Any]) -> set[str]:
    """Names of a module's data that its functions assign, or that those read that store into something."""
    names: set[str] = set()
    for value in list(module.values()):
        members = list(vars(value).values()) if isinstance(value, type) else [value]
        for function in members:
            if isinstance(function, FunctionType) and function.__globals__ is module:
                for code in _all_codes(function.__code__):
                    names |= _stored_by(code, module)
    return names


def _stored_by(code: CodeType, module: dict[str, Any]) -> set[str]:
    """Of one function: what it assigns; all lists and the like that it reads, if it stores into anything."""
    instructions = _instructions(code)
    stored = {i.argval for i in instructions if i.opname in ("STORE_GLOBAL", "DELETE_GLOBAL")}
    if any(i.opname == "STORE_SUBSCR" or i.argval in _STORING for i in instructions):
        stored |= {name for name in _outer_names(code) if isinstance(module.get(name), _CONTAINERS)}
    return stored


def _outer_names(code: CodeType) -> set[str]:
    return {i.argval for i in _instructions(code) if i.opname in ("LOAD_GLOBAL", "LOAD_NAME")}


def _all_codes(code: CodeType) -> list[CodeType]:
    """The code, and what is defined within it."""
    inner = [const for const in code.co_consts if isinstance(const, CodeType)]
    return [code, *(found for const in inner for found in _all_codes(const))]


def _is_pure_code(code: CodeType, known: dict[str, Any], depth: int) -> bool:
    stores, reads_lists = False, False
    for instruction in _instructions(code):
        operation, name = instruction.opname, instruction.argval
        if operation in ("STORE_GLOBAL", "STORE_ATTR", "DELETE_GLOBAL", "IMPORT_NAME", "IMPORT_FROM"):
            return False
        if operation == "STORE_DEREF" and name in code.co_freevars:
            return False
        if operation in ("LOAD_ATTR", "LOAD_METHOD") and name in _OF_CHANCE:
            return False
        stores |= operation == "STORE_SUBSCR" or name in _STORING
        is_outer = operation in ("LOAD_GLOBAL", "LOAD_NAME")
        is_outer |= operation in ("LOAD_DEREF", "LOAD_CLASSDEREF") and name in code.co_freevars
        if is_outer and name in known:
            if not _is_pure_value(name, known[name], depth):
                return False
            reads_lists |= isinstance(known[name], list | dict | np.ndarray)
    return not (stores and reads_lists)


def _is_pure_value(name: str, value: Any, depth: int) -> bool:
    """Whether a value that code reads from outside depends on nothing else."""
    if isinstance(value, ModuleType):
        return package_of(value) in _TRUSTED
    if _is_data(value):
        return True
    if package_of(value if getattr(value, "__module__", None) else type(value)) in _TRUSTED:
        return not isinstance(value, np.ndarray)
    if isinstance(value, FunctionType):
        return depth < DEEPEST and _is_pure(value, depth + 1)
    return name in _BUILTINS and value is getattr(builtins, name, None)


def _is_data(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_is_data, value))
    if isinstance(value, dict):
        return all(_is_data(key) and _is_data(one) for key, one in value.items())
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "biufc"
    return isinstance(value, _NUMBERS)
