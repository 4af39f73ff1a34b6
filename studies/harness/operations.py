"""Floating-point operations of one step, counted by running the kernels on numbers that count.

Run as a program in a process without the compiler (NUMBA_DISABLE_JIT=1), by `count_operations`.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

ADD, MULTIPLY, DIVIDE, ROOT = "add", "multiply", "divide", "root"
STEPS = 10
_ROOT_FOLDER = Path(__file__).parents[2]

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


def _root(x: Counted) -> Counted:
    tally[ROOT] += 1
    return Counted(float(x) ** 0.5)


def _counted(array: Any) -> Any:
    """The array with numbers that count."""
    result = np.empty(np.shape(array), dtype=object)
    result.ravel()[:] = [Counted(x) for x in np.ravel(array)]
    return result


def _prepare_kernels() -> None:
    """Local memory, records and functions of NumPy take numbers that count."""
    from exudyn_inext.chain import factorisation, records

    for name, module in list(sys.modules.items()):
        if name.startswith("exudyn_inext.") and hasattr(module, "local_array"):
            module.local_array = lambda rows, columns: np.empty((rows, columns), dtype=object)
    records.NUMBER = object
    factorisation.np = SimpleNamespace(
        sqrt=_root, copysign=lambda x, y: Counted(np.copysign(float(x), float(y)))
    )


def _count_numbers(records: Any) -> Any:
    """Let the numbers of a record array count."""
    for field in records.dtype.names:
        if records.dtype[field].base.hasobject and records[field].size:
            records[field] = _counted(records[field])
    return records


def _counted_run(asked: dict[str, Any]) -> tuple[Any, ...]:
    """Integrator, system, loads and state of a run in numbers that count."""
    from exudyn_inext.chain.linked_cable import cable_system
    from exudyn_inext.exudyn_binding.cable_loads import CableLoads
    from exudyn_inext.exudyn_binding.scene import read_scene
    from exudyn_inext.integrators import find_integrator
    from exudyn_inext.integrators.integrator import LoadHistory
    from reference_models.inextensible import build
    from reference_models.scenes import load_scene

    model = build(load_scene(asked["scene"]), asked["elements"])
    cable = read_scene(model.mbs).cables[0]
    integrator = find_integrator(asked["integrator"])
    system = cable_system(cable.cable, 100.0)
    for records in (system.chain.nodes, system.chain.elements):
        _count_numbers(records)
    constant = CableLoads(cable).constant
    loads = LoadHistory(_counted(constant), np.zeros((0, len(constant))), np.zeros((1, 1, 0)))
    empty = integrator.allocate(len(constant), len(constant))
    state = type(empty)(*map(_counted, empty))
    state.q[:], state.v[:] = _counted(asked["q"]), _counted(asked["v"])
    integrator.start(system, loads.constant, state)
    return integrator, system, loads, state


def _counts_of_step(asked: dict[str, Any]) -> dict[str, float]:
    """Operations of one step, the mean over some steps after the first ones."""
    from exudyn_inext.integrators.integrator import record

    integrator, system, loads, state = _counted_run(asked)
    history = np.empty((1, 3, len(state.q)), dtype=object)
    for _ in range(2):
        tally.update(dict.fromkeys(tally, 0))
        record(integrator.scheme(), system, loads, state, asked["h"], STEPS, history)
    return {kind: count / STEPS for kind, count in tally.items()}


def count_operations(asked: list[dict[str, Any]]) -> list[dict[str, float]]:
    """Operations of one step, by kind, in a process of its own.

    Args:
        asked: "scene", "integrator", "elements", step "h" [s], and lists "q", "v" to start from.
    """
    process = subprocess.run(
        [sys.executable, "-m", __name__],
        input=json.dumps(asked),
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        cwd=_ROOT_FOLDER,
        capture_output=True,
        text=True,
        check=True,
    )
    return list(json.loads(process.stdout))


if __name__ == "__main__":
    import exudyn_inext  # noqa: F401  its modules must be there before they are prepared

    _prepare_kernels()
    print(json.dumps([_counts_of_step(one) for one in json.loads(sys.stdin.read())]))
