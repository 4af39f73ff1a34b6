"""Step functions of the user, and whether they may look at accelerations, or at forces of constraints."""

from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import exudyn
import numpy as np

from .functions_of_time import DEEPEST, known_to, package_of

_TRUSTED = {"builtins", "numpy", "math", "exudyn"}
_NAMES = """
    SetLoadParameter SetObjectParameter SetMarkerParameter SetNodeParameter
    GetLoadParameter GetObjectParameter GetMarkerParameter GetNodeParameter
    systemData GetTime GetODE2Coordinates GetODE2Coordinates_t SetODE2Coordinates SetODE2Coordinates_t
    GetSensorValues GetNodeOutput GetObjectOutputBody OutputVariableType
    Position Displacement Velocity Rotation AngularVelocity Coordinates Coordinates_t
    append extend tolist copy T dot sum min max items values keys get
"""  # of mbs, of what it gives, and of lists and arrays
_OF_MBS = set(_NAMES.split())
_TYPES = {
    getattr(exudyn.OutputVariableType, name) for name in _OF_MBS if hasattr(exudyn.OutputVariableType, name)
}
_OPEN = {"getattr", "eval", "exec", "vars", "globals", "locals", "__import__", "compile", "open", "input"}
_DATA = (int, float, complex, str, bool, type(None), np.ndarray, np.generic, list, tuple, dict, set)


def may_look_at_forces(function: Any) -> bool:
    """Whether a function f(mbs, t) may, as far as its code shows; sensors are not looked into.

    It does not if it reads nothing but data, numbers of items, functions of NumPy and math and of its own
    kind, and takes only what is known of mbs; all else may be anything.
    """
    return not isinstance(function, FunctionType) or not _is_known(function, 0)


def _is_known(function: FunctionType, depth: int) -> bool:
    outer = known_to(function)
    given = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
    if outer is None or not all(_is_known_value(value, depth) for value in given):
        return False
    return _is_known_code(function.__code__, outer, depth)


def _is_known_code(code: CodeType, outer: dict[str, Any], depth: int) -> bool:
    modules = [value for value in map(outer.get, code.co_names) if isinstance(value, ModuleType)]
    members = {name for module in modules if module is not exudyn for name in dir(module)}
    for name in (*code.co_names, *code.co_freevars):
        if name in outer:
            if name in _OPEN or not _is_known_value(outer[name], depth):
                return False
        elif name not in _OF_MBS and name not in members and name in code.co_names:
            return False
    inner = [const for const in code.co_consts if isinstance(const, CodeType)]
    return all(_is_known_code(one, outer, depth) for one in inner)


def _is_known_value(value: Any, depth: int) -> bool:
    if isinstance(value, ModuleType):
        return package_of(value) in _TRUSTED
    if isinstance(value, FunctionType):
        return package_of(value) == "numpy" or (depth < DEEPEST and _is_known(value, depth + 1))
    if isinstance(value, list | tuple | set):
        return all(_is_known_value(one, depth) for one in value)
    if isinstance(value, dict):
        return all(_is_known_value(one, depth) for one in value.values())
    if isinstance(value, exudyn.OutputVariableType):
        return value in _TYPES
    if isinstance(value, type):
        return package_of(value) in _TRUSTED
    is_built_in = isinstance(value, BuiltinFunctionType | np.ufunc) and not _is_bound(value)
    is_of_exudyn = package_of(type(value)) == "exudyn" and not callable(value)
    return is_built_in or is_of_exudyn or isinstance(value, _DATA)


def _is_bound(value: Any) -> bool:
    owner = getattr(value, "__self__", None)
    return owner is not None and not isinstance(owner, ModuleType)
