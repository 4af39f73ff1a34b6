"""Floating-point operations of one step, counted by running the kernels on numbers that count.

Run as a program in a process without the compiler (NUMBA_DISABLE_JIT=1), by `count_operations`.
"""

import json
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np

from reference_models.inextensible import build
from reference_models.scenes import load_scene

from . import inner
from .engines import ask

ADD, MULTIPLY, DIVIDE, ROOT = "add", "multiply", "divide", "root"
STEPS = 10

tally = dict.fromkeys((ADD, MULTIPLY, DIVIDE, ROOT), 0)


def _operation(kind: str, compute: Any) -> Any:
    def operate(left: Any, right: Any) -> "Counted":
        is_nothing = kind == ADD and type(right) is float and right == 0.0
        tally[kind] += not is_nothing
        return Counted(compute(float(left), float(right)))

    return operate


def _comparison(compare: Any) -> Any:
    return lambda left, right: compare(float(left), float(right))


class Counted:
    """A number that counts what is done with it; comparisons and signs are free, 0.0 + x too."""

    __array_ufunc__ = None  # numbers of NumPy leave the operation to this class
    __slots__ = ("value",)

    def __init__(self, value: float) -> None:
        self.value = float(value)

    def __float__(self) -> float:
        return self.value

    __add__ = __radd__ = _operation(ADD, lambda x, y: x + y)
    __sub__ = _operation(ADD, lambda x, y: x - y)
    __rsub__ = _operation(ADD, lambda x, y: y - x)
    __mul__ = __rmul__ = _operation(MULTIPLY, lambda x, y: x * y)
    __truediv__ = _operation(DIVIDE, lambda x, y: x / y)
    __rtruediv__ = _operation(DIVIDE, lambda x, y: y / x)
    __lt__ = _comparison(lambda x, y: x < y)
    __gt__ = _comparison(lambda x, y: x > y)

    def __neg__(self) -> "Counted":
        return Counted(-self.value)

    def __abs__(self) -> "Counted":
        return Counted(abs(self.value))


def _counted(array: Any) -> Any:
    """The array with numbers that count."""
    result = np.empty(np.shape(array), dtype=object)
    result.ravel()[:] = [Counted(x) for x in np.ravel(array)]
    return result


def _prepare_kernels() -> None:
    """Local memory, records and functions of NumPy take numbers that count."""

    def root(x: Counted) -> Counted:
        tally[ROOT] += 1
        return Counted(float(x) ** 0.5)

    for name, module in list(sys.modules.items()):
        if name.startswith("exudyn_inext.") and hasattr(module, "local_array"):
            module.local_array = lambda rows, columns: np.empty((rows, columns), dtype=object)
    inner.records.NUMBER = object
    copysign = lambda x, y: Counted(np.copysign(float(x), float(y)))  # noqa: E731
    inner.factorisation.np = SimpleNamespace(sqrt=root, copysign=copysign)


def _counts_of_step(asked: dict[str, Any]) -> dict[str, float]:
    """Operations of one step, the mean over some steps after the first ones."""
    model = build(load_scene(asked["scene"]), asked["elements"])
    cable = inner.read_scene(model.mbs).cables[0]
    integrator = inner.find_integrator(asked["integrator"])
    system = inner.cable_system(cable.cable, 100.0)
    for numbers in (system.chain.nodes, system.chain.elements):
        for field in numbers.dtype.names:
            if numbers.dtype[field].base.hasobject and numbers[field].size:
                numbers[field] = _counted(numbers[field])
    constant = inner.CableLoads(cable).constant
    loads = inner.LoadHistory(_counted(constant), np.zeros((0, len(constant))), np.zeros((1, 1, 0)))
    empty = integrator.allocate(len(constant), len(constant))
    state = type(empty)(*map(_counted, empty))
    state.q[:], state.v[:] = _counted(asked["q"]), _counted(asked["v"])
    integrator.start(system, loads.constant, state)
    history = np.empty((1, 3, len(state.q)), dtype=object)
    for _ in range(2):
        tally.update(dict.fromkeys(tally, 0))
        inner.record(integrator.scheme(), system, loads, state, asked["h"], STEPS, history)
    return {kind: count / STEPS for kind, count in tally.items()}


def count_operations(asked: list[dict[str, Any]]) -> list[dict[str, float]]:
    """Operations of one step, by kind, in a process of its own.

    Args:
        asked: "scene", "integrator", "elements", step "h" [s], and lists "q", "v" to start from.
    """
    return list(ask(__name__, given=asked, NUMBA_DISABLE_JIT="1"))


if __name__ == "__main__":
    _prepare_kernels()
    print(json.dumps([_counts_of_step(one) for one in json.loads(sys.stdin.read())]))
