"""How numerical kernels are compiled, and the cache of their machine code.

`kernel` makes an entry point, `inlined` a part of kernels, `optional` one that many cables do not have,
`local_array` small memory on the stack. Where all loops over it are unrolled it has no aliases and is
kept in registers: a long body of such a loop belongs into a function of its own, or the loop stays.
"""

import hashlib
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar, cast

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.serialize import dumps
from numba.extending import lower_builtin, overload, type_callable
from numba.np.arrayobj import make_array, populate_array

from .kernel_cache import cache_folder

FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}  # neither nnan nor ninf: divergence must be seen

NUMBER_BYTES = 8

# Without `_nrt` references to arrays are not counted: that took a third of a step of a short chain.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": FAST_MATH, "nogil": True, "_nrt": False}

_Function = TypeVar("_Function", bound=Callable[..., Any])


CACHE_FOLDER = None if numba.config.DISABLE_JIT else cache_folder()


def _save(cache_file: Any, key: Any, data: Any) -> None:
    """Store machine code under the name of what it is for.

    Numba counts the files instead: processes that compile at once would take the same number, and later
    ones load code that was compiled for other types. A cache that cannot be written to, as the disk is full
    or its folder has been removed meanwhile, is no reason to stop.
    """
    name = cache_file._data_name(int(hashlib.sha256(dumps(key)).hexdigest()[:16], 16))
    with suppress(OSError):
        cache_file._save_data(name, data)
        cache_file._save_index({**cache_file._load_index(), key: name})


def kernel(function: _Function) -> _Function:
    """Compile `function` in nopython mode, cached on disk. Runs as plain Python without the JIT.

    Kernels release Python's global lock, so that threads run them side by side. They make no arrays, and
    do not count references to those of others.
    """
    return _compiled(function, OPTIONS)


def counting_kernel(function: _Function) -> _Function:
    """A `kernel` that makes arrays, or calls functions of NumPy that do, and counts references to them.

    It must not take arrays out of what an `inlined` part returns: those are not counted.
    """
    return _compiled(function, {**OPTIONS, "_nrt": True})


def _compiled(function: _Function, options: dict[str, Any]) -> _Function:
    if numba.config.DISABLE_JIT:
        return function
    shared_setting = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(CACHE_FOLDER or "")
    try:
        compiled = numba.njit(cache=CACHE_FOLDER is not None, **options)(function)
    finally:
        numba.config.CACHE_DIR = shared_setting
    if CACHE_FOLDER is not None:
        cache_file = compiled._cache._cache_file
        cache_file.save = partial(_save, cache_file)
    return compiled


def plain(function: _Function) -> _Function:
    """The Python function behind a kernel, for systems that only Python can evaluate."""
    return getattr(function, "py_func", function)


def inlined(function: _Function) -> _Function:
    """Compile `function` as a part of the kernels that call it."""
    return numba.njit(forceinline=True, **OPTIONS)(function)


@inlined
def clear(memory: Any) -> None:
    """All entries of a local array to zero."""
    for i in range(memory.shape[0]):
        for j in range(memory.shape[1]):
            memory[i, j] = 0.0


def optional(field: str) -> Callable[[_Function], _Function]:
    """Compile f(axes, nodes, elements, ...) as a part of kernels, where the elements' `field` is not empty.

    Elsewhere it does nothing, and takes no time to compile.
    """

    def decorate(function: _Function) -> _Function:
        compiled = inlined(function)

        def part(axes, nodes, elements, *others):
            if elements.dtype[field].shape[0] > 0:
                function(axes, nodes, elements, *others)

        @overload(part, strict=False, jit_options={"forceinline": True, **OPTIONS})
        def choose(axes, nodes, elements, *others):
            def call(axes, nodes, elements, *others):
                compiled(axes, nodes, elements, *others)

            def nothing(axes, nodes, elements, *others):
                pass

            return call if elements.dtype.fields[field].type.shape[0] > 0 else nothing

        part.__name__, part.__doc__ = function.__name__, function.__doc__
        return cast(_Function, part)

    return decorate


def local_array(rows: int, columns: int) -> Any:
    """(rows, columns) uninitialised numbers on the stack of the calling kernel; literal sizes only."""
    return np.empty((rows, columns))


@type_callable(local_array)
def _type_local_array(_context):
    def type_of_result(rows, columns):
        if isinstance(rows, types.IntegerLiteral) and isinstance(columns, types.IntegerLiteral):
            return types.Array(types.float64, 2, "C")
        return None

    return type_of_result


@lower_builtin(local_array, types.IntegerLiteral, types.IntegerLiteral)
def _array_on_stack(context, builder, signature, _arguments):
    def number(value):
        return context.get_constant(types.intp, value)

    rows, columns = (size.literal_value for size in signature.args)
    memory = ir.ArrayType(ir.DoubleType(), rows * columns)
    array = make_array(signature.return_type)(context, builder)
    populate_array(
        array,
        data=builder.gep(
            cgutils.alloca_once(builder, memory, name="local_array"), [cgutils.intp_t(0), cgutils.intp_t(0)]
        ),
        shape=[number(rows), number(columns)],
        strides=[number(NUMBER_BYTES * columns), number(NUMBER_BYTES)],
        itemsize=number(NUMBER_BYTES),
        meminfo=None,
    )
    return array._getvalue()
