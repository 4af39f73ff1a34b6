"""Many systems of one type in one compiled call: an ensemble.

The arrays of all members are stacked along a new first axis; a member is a slice of each of them, of the
same compiled type as a system that stands alone, so that the same machine code moves it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import types
from numba.extending import overload

from ..called_system import Called
from ..compiled import counting_kernel, inlined
from .watch import record_watched


def stacked(members: Sequence[Any]) -> Any:
    """NamedTuples of equal structure as one, each array with a new first axis; the rest from the first."""
    first = members[0]
    if isinstance(first, np.ndarray):
        return np.stack(members, dtype=first.dtype)
    if hasattr(first, "_fields"):
        return type(first)(*[stacked(parts) for parts in zip(*members, strict=True)])
    return first


def member(stack: Any, m: Any) -> Any:
    """Member `m` of what `stacked` made: its arrays are views into the stack."""
    if isinstance(stack, np.ndarray):
        return stack[m]
    return type(stack)(*_parts(stack, m)) if hasattr(stack, "_fields") else stack


def _parts(fields: Any, m: Any) -> Any:
    return tuple(member(field, m) for field in fields)


@overload(member)
def _compile_member(stack, m):
    if isinstance(stack, types.Array):
        return lambda stack, m: stack[m]
    if isinstance(stack, types.BaseNamedTuple):
        build = stack.instance_class
        return lambda stack, m: build(*_parts(tuple(stack), m))
    return lambda stack, m: stack


@overload(_parts)
def _compile_parts(fields, m):
    if len(fields) == 0:
        return lambda fields, m: ()
    return lambda fields, m: (member(fields[0], m), *_parts(fields[1:], m))


@inlined
def _copy(states, interval, output):
    """Keep one interval of a member."""
    for d in range(len(output)):
        for i in range(states.shape[1]):
            output[d, interval, i] = states[d, i]


@counting_kernel
def record_members(scheme, systems, functions, loads, states, h, steps, watches, output, good):
    """Advance one member after the other, as `record_watched` does, each until its end or its divergence.

    Args:
        scheme, h, steps: see `record_watched`; the same for all members.
        systems: (members,) addresses.   functions: of all of them, see `Called`.
        loads, states, watches: of all members, see `stacked`.
        output: (derivatives, members, intervals, n_dof) q, v, a at the end of each interval, as many of
            them as it has room for; on entry what shall stand where a member has not got to.
        good: (members,) output: number of intervals that ended well.
    """
    history = np.empty((output.shape[2], 3, output.shape[3]))
    for m in range(output.shape[1]):
        system, state, watch = Called(systems[m], functions), member(states, m), member(watches, m)
        good[m] = record_watched(scheme, system, member(loads, m), state, h, steps, history, watch)
        for interval in range(good[m]):
            _copy(history[interval], interval, output[:, m])
