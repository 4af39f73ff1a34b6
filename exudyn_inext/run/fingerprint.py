"""Texts that tell values and user functions apart, the same in every process: no addresses, no hash seeds.

Of a function count its code (bytecode, constants, names) and what it uses: values of its closure, defaults,
attributes, and the global variables that it reads. So do functions and classes of the user's own modules that
it calls; those of installed packages go by their names. Of an object count the attributes, if its class is
the user's, NumPy's or SciPy's. What else there is (open files, an mbs, symbolic functions, objects of
compiled modules) goes by the name of its type.
"""

import dis
import enum
import hashlib
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from functools import lru_cache, partial
from itertools import chain, filterfalse
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

LONGEST = 80  # characters of a value that is shown as it is
DEEPEST = 60  # objects within objects; what lies deeper goes by the name of its type

_SHARED = (tuple, frozenset, CodeType)  # constants, which a compiler may share or not
_PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis), np.number, np.bool_)
_DATA_OF_PACKAGES = {"numpy", "scipy"}
_PACKAGE = Path(__file__).parents[1]
_IMPLICIT = {"__dict__", "__weakref__", "__doc__", "__module__", "__firstlineno__", "__static_attributes__"}


def text_of(value: Any) -> str:
    """The value itself, if it is plain and short; else a name and a hash."""
    if _is_plain(value):
        shown = repr(value.tolist() if isinstance(value, np.ndarray | np.generic) else value)
        if len(shown) <= LONGEST:
            return shown
    return f"{_name_of(value)} {hash_of(value)}"


def texts_of_function(name: str, function: Callable[..., Any]) -> dict[str, str]:
    """A user function of that name as texts: one of its code, and one of each value that it uses."""
    core, used = _parts(function)
    own = f"{_name_of(function)} {hash_of(*core)}"
    return {name: own} | {f"'{what}' in {name}": text_of(value) for what, value in used.items()}


def strings_in(function: Callable[..., Any]) -> set[str]:
    """String constants in the code of a function."""
    inner = getattr(function, "func", getattr(function, "__func__", function))
    code = getattr(inner, "__code__", None) or getattr(type(inner).__call__, "__code__", None)
    constants = [constant for one in all_codes(code) for constant in one.co_consts] if code else []
    return {constant for constant in constants if isinstance(constant, str)}


@lru_cache(maxsize=256)
def all_codes(code: CodeType) -> tuple[CodeType, ...]:
    """The code, and what is defined within it."""
    inner = [const for const in code.co_consts if isinstance(const, CodeType)]
    return code, *(found for const in inner for found in all_codes(const))


def hash_of(*values: Any) -> str:
    """16 digits."""
    digest, seen = hashlib.sha256(), dict[int, tuple[int, Any]]()
    for word in chain.from_iterable(_words(value, seen) for value in values):
        digest.update(word.encode("utf-8", "surrogatepass") + b"\0")
    return digest.hexdigest()[:16]


def _is_plain(value: Any, depth: int = 3) -> bool:
    if isinstance(value, np.ndarray):
        return value.size <= LONGEST and value.dtype.kind in "biufc"
    if isinstance(value, list | tuple):
        return depth > 0 and len(value) <= LONGEST and all(_is_plain(entry, depth - 1) for entry in value)
    return isinstance(value, _PLAIN)


def _name_of(value: Any) -> str:
    if isinstance(value, partial):
        return f"partial of {_name_of(value.func)}"
    named = value if callable(value) and hasattr(value, "__qualname__") else type(value)
    return f"{getattr(named, '__qualname__', '?')}"


def _words(value: Any, seen: dict[int, tuple[int, Any]], depth: int = 0) -> Iterator[str]:
    """What a value consists of.

    seen: numbers of objects, by id: those that come again are not described again. It keeps them alive, as
        another object could have the same id.
    """
    if isinstance(value, _PLAIN):
        yield repr(value.item() if isinstance(value, np.generic) else value)
    elif depth > DEEPEST:
        yield _full_name(type(value))
    elif id(value) in seen:
        yield f"again {seen[id(value)][0]}"
    else:
        if not isinstance(value, _SHARED):
            seen[id(value)] = (len(seen), value)
        core, used = _parts(value)
        for part in (type(value).__name__, *core, *chain.from_iterable(used.items())):
            yield from _words(part, seen, depth + 1)


_Parts = tuple[list[Any], dict[str, Any]]


def _parts(value: Any) -> _Parts:
    """What a value is, and other values that it uses, by names."""
    value = getattr(value, "py_func", value)  # behind a compiled function
    match value:
        case FunctionType():
            return _parts_of_function(value)
        case MethodType():
            (core, used), (owner, attributes) = _parts(value.__func__), _parts(value.__self__)
            return [*core, *owner], used | attributes
        case partial():
            core, used = _parts(value.func)
            arguments = {f"argument {k}": argument for k, argument in enumerate(value.args)}
            return [*core, len(value.args)], used | arguments | value.keywords
        case type():
            return [_full_name(value)], dict(_of_class(value))
        case enum.Enum() | ModuleType() | BuiltinFunctionType():
            return [_full_name(value), getattr(value, "value", None)], {}
    content = _content(value)
    return _parts_of_instance(value) if content is None else (content, {})


def _content(value: Any) -> list[Any] | None:
    """What is in a container, in code, or in an object of Exudyn's; None for anything else."""
    match value:
        case np.ndarray():
            is_plain = not value.dtype.hasobject
            data = hashlib.sha256(value.tobytes()).hexdigest() if is_plain else value.ravel().tolist()
            return [value.shape, value.dtype.str, data]
        case list() | tuple():
            return [len(value), *value]
        case set() | frozenset():
            return sorted(map(hash_of, value))
        case Mapping():
            return list(chain.from_iterable(value.items()))
        case CodeType():
            return [value.co_code, getattr(value, "co_exceptiontable", b""), value.co_names, value.co_consts]
    return _content_of_exudyn(value) if type(value).__module__.partition(".")[0] == "exudyn" else None


def _content_of_exudyn(value: Any) -> list[Any] | None:
    """Numbers of a list, matrix, section, index or choice of Exudyn's; None of anything else."""
    if hasattr(value, "GetPythonObject"):
        return [value.GetPythonObject()]
    if type(value).__name__ == "BeamSection":
        return [value.GetDictionary()]
    return [int(value)] if hasattr(value, "__index__") else None


def _parts_of_function(function: FunctionType) -> _Parts:
    code, used = function.__code__, dict(_closure(function))
    parameters = code.co_varnames[: code.co_argcount]
    defaults = function.__defaults__ or ()
    used |= dict(zip(parameters[len(parameters) - len(defaults) :], defaults, strict=True))
    used |= (function.__kwdefaults__ or {}) | vars(function)
    if _is_installed(code.co_filename):
        return [_full_name(function)], used
    return [code], used | dict(chain.from_iterable(_globals(function, one) for one in all_codes(code)))


def _parts_of_instance(value: Any) -> _Parts:
    kind = type(value)
    has_data = not _is_of_installed(kind) or is_dataclass(value) or isinstance(value, SimpleNamespace)
    if not has_data and kind.__module__.partition(".")[0] not in _DATA_OF_PACKAGES:
        return [_full_name(kind)], {}
    slots = (slot for base in kind.__mro__ for slot in _slots(base))
    of_slots = {slot: getattr(value, slot) for slot in slots if hasattr(value, slot)}
    return [kind, str(getattr(value, "__name__", ""))], of_slots | getattr(value, "__dict__", {})


def _slots(kind: type) -> tuple[str, ...]:
    slots = vars(kind).get("__slots__", ())
    return tuple(slot for slot in ((slots,) if isinstance(slots, str) else slots) if slot not in _IMPLICIT)


def _of_class(kind: type) -> Iterator[tuple[str, Any]]:
    """Methods and data of the classes that are the user's; functions of properties and static methods."""
    for base in filterfalse(_is_of_installed, reversed(kind.__mro__)):
        for name, entry in vars(base).items():
            if name not in _IMPLICIT:
                function = getattr(entry, "fget", None) or getattr(entry, "__func__", entry)
                yield f"{base.__qualname__}.{name}", function


def _full_name(value: Any) -> str:
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None) or str(type(value))
    return f"{getattr(value, '__module__', '')}.{name}"


def _closure(function: FunctionType) -> Iterator[tuple[str, Any]]:
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        try:
            yield name, cell.cell_contents
        except ValueError:  # not set yet
            yield name, None


def _globals(function: FunctionType, code: CodeType) -> Iterator[tuple[str, Any]]:
    """Global variables that the code reads, and what it may read of the user's modules."""
    names = [
        step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")
    ]
    for name in dict.fromkeys(names):
        value = function.__globals__.get(name)
        yield name, value
        if isinstance(value, ModuleType) and not _is_of_installed(value):
            read = [attribute for attribute in code.co_names if attribute in vars(value)]
            yield from ((f"{name}.{attribute}", vars(value)[attribute]) for attribute in read)


def _is_of_installed(value: Any) -> bool:
    """Whether a class or module does not stand in a file of the user's."""
    if isinstance(value, type):
        module = sys.modules.get(value.__module__)
        return module is not None and value.__module__ != "__main__" and _is_of_installed(module)
    return _is_installed(getattr(value, "__file__", None) or "<frozen>")


@lru_cache(maxsize=1024)
def _is_installed(filename: str) -> bool:
    """Whether a source belongs to Python, to an installed package, or to this one."""
    if filename.startswith("<"):
        return filename.startswith("<frozen")
    path = Path(filename).resolve()
    if not {"site-packages", "dist-packages"}.isdisjoint(path.parts):
        return True
    roots = [_PACKAGE, *(Path(sysconfig.get_path(kind)).resolve() for kind in ("stdlib", "platstdlib"))]
    return any(path.is_relative_to(root) for root in roots)
