"""What is taken from inside Numba: row operations against NumPy, and nothing of it elsewhere."""

import gc
import re
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from llvmlite.binding import Linkage
from numba.core.errors import TypingError
from numba.extending import overload

import exudyn_inext
from exudyn_inext import compiled
from exudyn_inext.arrays import record_type
from exudyn_inext.compiled import inlined, inlined_kernel, kernel, placed
from exudyn_inext.lowered import place_of, set_multiple, subtract_multiple

pytestmark = pytest.mark.kernel
LENGTHS = range(1, 13)


@kernel
def combine(places, rows, factor):
    """rows[0] -= factor rows[1]; rows[2] = factor rows[1]."""
    subtract_multiple(places, rows[0], factor, rows[1])
    set_multiple(places, rows[2], factor, rows[1])


@pytest.mark.parametrize("length", LENGTHS)
def test_rows_of_any_length_and_nothing_beside_them(length):
    rows = np.random.default_rng(length).standard_normal((3, length + 2))
    expected = rows.copy()
    expected[0, :length] -= 0.7 * rows[1, :length]
    expected[2, :length] = 0.7 * rows[1, :length]
    combine((0,) * length, rows, 0.7)
    np.testing.assert_allclose(rows, expected, rtol=1e-14, atol=1e-15)


def test_rows_with_gaps_are_no_rows():
    columns = np.zeros((3, 3)).T

    @kernel
    def subtract(places, rows):
        subtract_multiple(places, rows[0], 1.0, rows[1])

    if hasattr(subtract, "py_func"):
        with pytest.raises(TypingError):
            subtract((0, 0, 0), columns)


class Pair(NamedTuple):
    first: np.ndarray
    second: np.ndarray


class Inner(NamedTuple):
    rows: np.ndarray
    number: int
    pair: Pair


class Outer(NamedTuple):
    table: np.ndarray
    inner: Inner
    factor: float
    sizes: tuple[int, ...]
    record: np.ndarray


@kernel
def read_and_write(outer, result):
    """Something of each field; the table is written to."""
    inner, total = outer.inner, 0.0
    for k in range(len(inner.pair)):
        total += inner.pair[k][-1]
    result[0], result[1] = outer.factor * inner.rows[inner.number], total
    result[2], result[3] = outer.sizes[1] * outer.table[1, 2], outer.record[1].place
    outer.table[1, 2] = 7.0


def test_a_kernel_reads_the_fields_of_what_is_placed():
    record = np.zeros(2, record_type([("place", np.int64)]))
    record["place"] = 1, 5
    inner = Inner(np.arange(4.0), 3, Pair(np.ones(2), np.full(3, 2.0)))
    found = np.zeros((2, 4))
    for place, result in zip((placed, lambda value: value), found, strict=True):
        outer = Outer(np.arange(6.0).reshape(2, 3), inner, 0.5, (2, 4), record)
        read_and_write(place(outer), result)
        assert outer.table[1, 2] == 7.0
    np.testing.assert_array_equal(found, [[1.5, 3.0, 20.0, 5.0]] * 2)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_field_that_what_is_placed_does_not_have_is_named():
    @kernel
    def read(pair):
        return pair.third[0]

    with pytest.raises(TypingError, match="third"):
        read(placed(Inner(np.ones(1), 0, Pair(np.ones(1), np.ones(1)))))


@inlined
def positive(x):
    if x <= 0.0:
        raise ValueError("not positive")
    return x


@inlined_kernel
def inverse(x):
    return 1.0 / positive(x)


@kernel
def difference_of_inverses(x, y):
    return inverse(x) - inverse(y)


def test_a_part_works_in_kernels_and_from_python():
    assert difference_of_inverses(2.0, 4.0) == 0.25
    assert inverse(2.0) == 0.5 and positive(2.0) == 2.0
    for function in (inverse, positive):
        with pytest.raises(ValueError, match="not positive"):
            function(-2.0)
    with pytest.raises(ValueError, match="not positive"):
        difference_of_inverses(2.0, -4.0)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_part_is_translated_in_kernels_only():
    difference_of_inverses(2.0, 4.0)
    inverse(2.0)
    for part in (positive, inverse.part):
        for result in part.overloads.values():
            assert not result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
    for result in inverse.overloads.values():
        assert result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_part_is_compiled_once_for_all_numbers_in_calls(monkeypatch):
    monkeypatch.setattr(compiled, "CACHE_FOLDER", None)

    @inlined
    def times(x, factor):
        return factor * x

    @kernel
    def multiples(x):
        return times(x, 2) + times(x, 3)

    assert multiples(1.5) == 7.5
    assert len(times.overloads) == 1


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_no_garbage_is_collected_while_a_kernel_is_compiled(monkeypatch):
    monkeypatch.setattr(compiled, "CACHE_FOLDER", None)

    collects = []

    def typed():
        pass

    @overload(typed)
    def choose():
        collects.append(gc.isenabled())
        return lambda: 1.0

    @kernel
    def one():
        return typed()

    assert one() == 1.0
    assert collects and not any(collects)
    assert gc.isenabled()


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_part_may_print(capfd):
    """It needs the environment of the function then, which the kernel has to bring along."""

    @inlined
    def show(x):
        print("here", x)

    @kernel
    def call(x):
        show(x)

    call(3)
    assert capfd.readouterr().out == "here 3\n"


def test_a_kernel_has_copies_of_its_own_of_what_it_contains():
    """Otherwise it would run the copy of another kernel, if that was loaded before, and give other bits."""

    @numba.njit
    def fibonacci(n):  # that no compiler dissolves in its caller
        return n if n < 2 else fibonacci(n - 1) + fibonacci(n - 2)

    @kernel
    def call(n):
        return fibonacci(n) + fibonacci(n + 1)

    assert call(10) == 144
    if numba.config.DISABLE_JIT:
        return
    (compiled,) = call.overloads.values()
    linkages = {function.linkage for function in compiled.library.get_defined_functions()}
    assert Linkage.linkonce_odr not in linkages and Linkage.external in linkages


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_kernel_that_another_calls_is_told_how_to_be_compiled():
    """What is stored of it has nothing that could be part of another."""

    @kernel
    def half(x):
        return 0.5 * x

    @kernel
    def call(x):
        return half(x)

    assert half(3.0) == 1.5
    with pytest.raises(TypeError, match=r"half is a kernel, .* inlined_kernel"):
        call(3.0)


def test_only_one_module_takes_something_from_inside_numba():
    package = Path(exudyn_inext.__file__).parent
    inside = ("numba.core", "numba.np", "llvmlite", "_nrt", "._cache", "no_cpython_wrapper")
    found = {file.name for file in package.rglob("*.py") if any(name in file.read_text() for name in inside)}
    assert found == {"lowered.py"}


def test_numba_is_one_of_the_versions_that_are_allowed():
    """What is inside may change with every release: the next one is to be tried before it is allowed."""
    allowed = next(given for given in metadata.requires("exudyn_inext") if given.startswith("numba"))
    least, below = (int(re.search(sign + r"0\.(\d+)", allowed)[1]) for sign in (">=", "<"))
    assert least <= int(numba.__version__.split(".")[1]) < below


def test_arrays_are_where_numpy_says():
    records = np.zeros(4, [("x", float, 3), ("k", int)])
    arrays = np.zeros((3, 4)), np.zeros((4, 6))[1::2, ::3], np.zeros(0), np.array(1.0), records, records["k"]
    for array in arrays:
        assert place_of(array) == array.ctypes.data
