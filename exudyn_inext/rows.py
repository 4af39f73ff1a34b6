"""Row operations of small matrices as vector instructions, which compiled kernels are made of.

Rows are (n,) arrays without gaps, n known when compiling. Four numbers are taken at once, then two, then
one: what a processor has no such instructions for, the compiler splits.
"""

from collections.abc import Iterator
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.types.containers import UniTuple
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array

from .compiled import FAST_MATH

_FLAGS = tuple(sorted(FAST_MATH))
_LANES = (4, 2, 1)


def set_multiple(places: tuple[int, ...], y: Any, factor: float, x: Any) -> None:
    """y = factor x for rows as long as `places`."""
    for i in range(len(places)):
        y[i] = factor * x[i]


def subtract_multiple(places: tuple[int, ...], y: Any, factor: float, x: Any) -> None:
    """y -= factor x for rows as long as `places`."""
    for i in range(len(places)):
        y[i] -= factor * x[i]


def _type_row_operation(_context: Any) -> Any:
    def type_of_result(places: Any, y: Any, factor: Any, x: Any) -> Any:
        rows = all(isinstance(row, types.Array) and row.ndim == 1 and row.layout == "C" for row in (y, x))
        return types.none if rows and isinstance(places, UniTuple) else None

    return type_of_result


type_callable(set_multiple)(_type_row_operation)
type_callable(subtract_multiple)(_type_row_operation)


def _pieces(length: int) -> Iterator[tuple[int, int]]:
    """First place and number of lanes of the vectors that make up a row."""
    first = 0
    for lanes in _LANES:
        while length - first >= lanes:
            yield first, lanes
            first += lanes


def _pointer(context: Any, builder: Any, kind: Any, row: Any, first: int, vector: Any) -> Any:
    """To a vector within a row."""
    data = make_array(kind)(context, builder, row).data
    return builder.bitcast(builder.gep(data, [context.get_constant(types.intp, first)]), vector.as_pointer())


def _in_all_lanes(builder: Any, value: Any, vector: Any) -> Any:
    index = ir.IntType(32)
    undefined = ir.Constant(vector, ir.Undefined)
    one = builder.insert_element(undefined, value, ir.Constant(index, 0))
    everywhere = ir.Constant(ir.VectorType(index, vector.count), [0] * vector.count)
    return builder.shuffle_vector(one, undefined, everywhere)


def _lower(context: Any, builder: Any, signature: Any, arguments: Any, subtracts: bool) -> Any:
    places, y_kind, _, x_kind = signature.args
    _, y, factor, x = arguments
    for first, lanes in _pieces(places.count):
        vector = ir.VectorType(ir.DoubleType(), lanes)
        target = _pointer(context, builder, y_kind, y, first, vector)
        source = builder.load(_pointer(context, builder, x_kind, x, first, vector), align=8)
        result = builder.fmul(_in_all_lanes(builder, factor, vector), source, flags=_FLAGS)
        if subtracts:
            result = builder.fsub(builder.load(target, align=8), result, flags=_FLAGS)
        builder.store(result, target, align=8)
    return context.get_dummy_value()


_ARGUMENTS = UniTuple, types.Array, types.Float, types.Array


@lower_builtin(set_multiple, *_ARGUMENTS)
def _lower_set_multiple(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _lower(context, builder, signature, arguments, subtracts=False)


@lower_builtin(subtract_multiple, *_ARGUMENTS)
def _lower_subtract_multiple(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _lower(context, builder, signature, arguments, subtracts=True)
