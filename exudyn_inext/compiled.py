"""How numerical kernels are compiled, and the cache of their machine code.

`kernel` makes an entry point, `inlined` a part of kernels, `inlined_kernel` and `called_kernel` what is both,
`optional` a part that many cables do not have, `protocol` what types implement. Parts are optimised in the
kernels that contain them only; a kernel that others call is optimised before, too: that pays for long ones
that several call.

Where all loops over a `lowered.local_array` are unrolled it has no aliases and is kept in registers: a long
body of such a loop belongs into a function of its own, or the loop stays.
"""

from collections.abc import Callable
from functools import cache, singledispatch, wraps
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba.extending import overload

from .kernel_cache import cache_folder
from .lowered import (
    FAST_MATH,
    WITH_C_ENTRY,
    WITHOUT_C_ENTRY,
    WITHOUT_COUNTS,
    WITHOUT_ENTRY,
    CalledPartCompiler,
    CompiledPart,
    Kernel,
    KernelCompiler,
    PartAndKernel,
    PartCompiler,
    Placed,
    entry_of,
    set_cache,
)

_ARITHMETIC = {"error_model": "numpy", "fastmath": FAST_MATH, "nogil": True}
OPTIONS: dict[str, Any] = {
    "pipeline_class": KernelCompiler,
    **_ARITHMETIC,
    **WITHOUT_COUNTS,
    **WITHOUT_C_ENTRY,
}
_OF_PARTS: dict[str, Any] = {
    "pipeline_class": PartCompiler,
    "forceinline": True,
    **_ARITHMETIC,
    **WITHOUT_COUNTS,
    **WITHOUT_ENTRY,
}
_OF_CALLED_PARTS: dict[str, Any] = {**_OF_PARTS, "pipeline_class": CalledPartCompiler, "forceinline": False}

_Function = TypeVar("_Function", bound=Callable[..., Any])


CACHE_FOLDER = None if numba.config.DISABLE_JIT else cache_folder()


def kernel(function: _Function) -> _Function:
    """Compile `function` in nopython mode, cached on disk. Runs as plain Python without the JIT.

    Kernels release Python's global lock, so that threads run them side by side. They make no arrays, and
    do not count references to those of others.
    """
    return _compiled(function, OPTIONS)


def c_function(function: _Function) -> _Function:
    """A `kernel` for callers that have its address alone, see `lowered.address_of`; it returns a number."""
    return _compiled(function, {**OPTIONS, **WITH_C_ENTRY})


def _compiled(function: _Function, options: dict[str, Any]) -> _Function:
    if numba.config.DISABLE_JIT:
        return function
    shared_setting = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(CACHE_FOLDER or "")
    try:
        compiled = numba.njit(cache=CACHE_FOLDER is not None, **options)(function)
    finally:
        numba.config.CACHE_DIR = shared_setting
    compiled.__class__ = Kernel
    if CACHE_FOLDER is not None:
        set_cache(compiled)
    return compiled


class Prepared:
    """A kernel whose arguments have the types of its first call: they are not looked at any more.

    To find out the types of a scene's records takes three times as long as a step of a small one.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self._entry: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:
        if self._entry is None:
            self._entry = entry_of(self._function, arguments)
        return self._entry(*arguments)


def placed(value: Any) -> Any:
    """A named tuple for kernels that take it by its address: they read what they need of many arrays."""
    return value if numba.config.DISABLE_JIT else Placed(value)


def plain(function: _Function) -> _Function:
    """The Python function behind a kernel, for systems that only Python can evaluate."""
    return getattr(function, "py_func", function)


@cache
def in_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """The Python function behind a kernel, which calls those behind others: nothing is compiled.

    Of a protocol that any system implements, it calls that.
    """
    code, known = plain(function).__code__, plain(function).__globals__
    named = {name: _of_any_system(known[name]) for name in code.co_names if name in known}
    others = {name: in_python(one) for name, one in named.items() if one is not None}
    return FunctionType(code, {**known, **others})


def _of_any_system(known: Any) -> Any:
    """A kernel, or what a protocol is for any system; None of others."""
    if not hasattr(known, "registry"):
        return known if hasattr(known, "py_func") else None
    default = known.registry[object]
    return None if hasattr(default, "__wrapped__") else default


def inlined(function: _Function) -> _Function:
    """Compile `function` as a part of the kernels that call it; called from Python, it is plain Python."""
    compiled = numba.njit(**_OF_PARTS)(function)
    if not numba.config.DISABLE_JIT:
        compiled.__class__ = CompiledPart
    return compiled


def inlined_kernel(function: _Function) -> _Function:
    """As `inlined`; called from Python, it is a `kernel`."""
    return _part_and_kernel(function, _OF_PARTS)


def called_kernel(function: _Function) -> _Function:
    """As `inlined_kernel`, but kernels call it as it is: it gives the same bits within others as alone."""
    return _part_and_kernel(function, _OF_CALLED_PARTS)


def _part_and_kernel(function: _Function, options: dict[str, Any]) -> _Function:
    compiled = kernel(function)
    if not numba.config.DISABLE_JIT:
        part = numba.njit(**options)(function)
        part.__class__ = CompiledPart
        compiled.__class__, compiled.part = PartAndKernel, part  # type: ignore[attr-defined]
    return compiled


@inlined
def clear(memory: Any) -> None:
    """All entries of a local array to zero."""
    for i in range(memory.shape[0]):
        for j in range(memory.shape[1]):
            memory[i, j] = 0.0


def _nothing(axes, nodes, elements, *others):
    pass


def optional(field: str, otherwise: Callable[..., Any] = _nothing) -> Callable[[_Function], _Function]:
    """Compile f(axes, nodes, elements, ...) as a part of kernels, where the elements' `field` is not empty.

    otherwise: `inlined`, takes its place elsewhere, where f takes no time to compile.
    """

    def decorate(function: _Function) -> _Function:
        def part(axes, nodes, elements, *others):
            chosen = function if elements.dtype[field].shape[0] > 0 else otherwise
            return chosen(axes, nodes, elements, *others)

        @overload(part, strict=False, jit_options=_OF_PARTS)
        def choose(axes, nodes, elements, *others):
            is_there = elements.dtype.fields[field].type.shape[0] > 0
            return function if is_there else plain(otherwise)

        part.__name__, part.__doc__ = function.__name__, function.__doc__
        return cast(_Function, part)

    return decorate


def protocol(declaration: _Function) -> Any:
    """A function that types of its first argument implement, in Python and in compiled code.

    Without an implementation it raises NotImplementedError.
    """

    @wraps(declaration)
    def missing(system, *others):
        raise NotImplementedError(f"no {declaration.__name__} for {type(system).__name__}")

    function = singledispatch(missing)

    @overload(function, strict=False, jit_options=_OF_PARTS)
    def choose(*arguments):
        return plain(function.dispatch(getattr(arguments[0], "instance_class", object)))

    return function
