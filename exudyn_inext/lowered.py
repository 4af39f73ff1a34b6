"""All that is taken from inside Numba, which may change: tested with the versions that pyproject.toml allows.

Operations that are lowered by hand: `local_array`, small memory on the stack; `set_multiple` and
`subtract_multiple`, which take four numbers of a row at once, then two, then one: what a processor has no
such instructions for, the compiler splits. Rows are (n,) arrays without gaps, n known when compiling.
`call_at` calls a function by its address, which `address_of` compiles, as C does through a pointer;
`words_of` lays a value out in memory for it, of which compiled code reads fields, see `AtAddress`.
"""

import hashlib
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from copy import copy
from ctypes import c_size_t, memmove
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np
from llvmlite import ir
from llvmlite.binding import Linkage, parse_assembly
from numba import typeof
from numba._dynfunc import make_function
from numba.core import cgutils, event, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult, Flags
from numba.core.datamodel.models import PointerModel
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.core.types.containers import BaseTuple, NamedTuple, UniTuple
from numba.core.types.misc import CPointer, unliteral
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    register_model,
    type_callable,
    typeof_impl,
    unbox,
)

from .garbage import not_collected

FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}  # neither nnan nor ninf: divergence must be seen
WITHOUT_COUNTS = {"_nrt": False}  # of references to arrays: that took a third of a step of a short chain
# Without the entries for Python and C, functions take a third less time to compile.
WITHOUT_C_ENTRY = {"no_cfunc_wrapper": True}
WITH_C_ENTRY = {"no_cfunc_wrapper": False}
WITHOUT_ENTRY = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

NUMBER_BYTES = 8
_FLAGS = tuple(sorted(FAST_MATH))
_LANES = (4, 2, 1)


def set_cache(compiled: Any) -> None:
    """Store machine code under the name of what it is for, and load it without what only compiling needs.

    Numba counts the files instead: processes that compile at once would take the same number, and later
    ones load code that was compiled for other types. A cache that cannot be written to, as the disk is full
    or its folder has been removed meanwhile, is no reason to stop. Before it loads anything, Numba imports
    all that it can compile, which takes longer than a short run.
    """
    cache = compiled._cache
    cache._cache_file.save = partial(_save, cache._cache_file)
    cache.load_overload = partial(_load, cache)


def _load(cache: Any, signature: Any, target: Any) -> Any:
    if _hold_text(signature):  # which is counted where it is handed over
        rtsys.initialize(target)
    with cache._guard_against_spurious_io_errors():
        result = cache._load_overload(signature, target)
        return None if result is None else _of_types(result, signature)


def _of_types(result: Any, kinds: Any) -> Any:
    """A kernel from the cache, see `KernelResult`, with the types of its arguments."""
    result.fndesc.argtypes = kinds
    return result._replace(signature=result.signature.replace(args=kinds))


def _hold_text(kinds: Any) -> bool:
    """Whether values of these types, or what is in them, are text."""
    return any(kind == types.unicode_type or _hold_text(getattr(kind, "types", ())) for kind in kinds)


def _save(cache_file: Any, key: Any, data: Any) -> None:
    name = cache_file._data_name(int(hashlib.sha256(dumps(key)).hexdigest()[:16], 16))
    with suppress(OSError):
        cache_file._save_data(name, data)
        cache_file._save_index({**cache_file._load_index(), key: name})


class Compilation(event.Listener):
    """Listens while kernels are compiled.

    begin: called before the first one.   end: after each one, with the time that it took [s].
    seconds: that all of them took.
    """

    def __init__(self, begin: Callable[[], None], end: Callable[[float], None]) -> None:
        self._begin, self._end, self._depth, self._start = begin, end, 0, 0.0
        self.seconds = 0.0

    def listening(self) -> AbstractContextManager[None]:
        return event.install_listener("numba:compile", self)

    def on_start(self, event: Any) -> None:
        if self._depth == 0:
            if self.seconds == 0.0:
                self._begin()
            self._start = time.perf_counter()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        self._depth -= 1
        if self._depth == 0:
            taken = time.perf_counter() - self._start
            self.seconds += taken
            self._end(taken)


class KernelLibrary(JITCodeLibrary):
    """Code of a kernel, with copies of its own of all that it contains.

    Otherwise kernels would share one of their copies, whichever was loaded first; and these differ in bits.
    Stored are the machine code and the names of its entries: what Numba stores beside, for others that
    contain it, takes long to load.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                function.linkage = Linkage.internal
        super()._optimize_final_module()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        self._ensure_finalized()
        entries = (one for one in self._final_module.functions if one.linkage == Linkage.external)
        names = (one.name for one in entries if not one.is_declaration)
        listed = parse_assembly("".join(f'@"{name}" = global i8 0\n' for name in names))
        return self.name, "object", (self._get_compiled_object(), listed.as_bitcode())


class KernelResult(CompileResult):
    """Is stored without types of arguments, which whoever loads it has, and without what nobody asks for.

    Numba takes long to load types, and imports the modules of all parts for environments without constants.
    """

    __slots__ = ()

    def _reduce(self) -> tuple[Any, ...]:
        code, description, environment, signature, *flags, _, reload, environments = super()._reduce()
        short = copy(description)
        short.argtypes = ()
        kept = tuple(one for one in environments if one.consts)
        return code, short, environment, signature.replace(args=()), *flags, "", reload, kept


# Passes that change nothing here: there are no closures, no `with`, nothing that Numba inlines as source.
_NEEDLESS = {
    *("WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction"),
    *("InlineInlinables", "FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass"),
    *("InlineOverloads", "NopythonRewrites", "DumpParforDiagnostics"),
}


class _Options(Flags):
    """Options that stay as they are. Numba looks them up for each call, and would compare all of them."""

    def copy(self) -> "_Options":
        return self

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__


_OPTIONS: dict[str, _Options] = {}  # by what they say


class ShortCompiler(Compiler):
    """Numba's compiler without needless passes."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = _OPTIONS.setdefault(self.state.flags.summary(), _Options(self.state.flags))

    def define_pipelines(self) -> Any:
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [one for one in pipeline.passes if one[0].__name__ not in _NEEDLESS]
            pipeline.finalize()
        return pipelines


class KernelCompiler(ShortCompiler):
    """Compiles into a `KernelLibrary`, which can be stored.

    It lets the parts of a new kernel find their constants, as Numba does for a kernel from the cache.
    Meanwhile Python does not look for garbage: Numba makes many objects that stay, and so it took a tenth
    of the time.
    """

    def __init__(self, typing: Any, target: Any, _library: Any, *others: Any) -> None:
        library = KernelLibrary(target.codegen(), "kernel")
        library.enable_object_caching()
        super().__init__(typing, target, library, *others)

    def compile_extra(self, func: Any) -> Any:
        with not_collected():
            result = super().compile_extra(func)
        for environment in result._find_referenced_environments():
            result.library.codegen.set_env(environment.env_name, environment)
        return KernelResult(*result)


class PartLibrary(JITCodeLibrary):
    """Code of a part: kernels that contain it optimise and translate it; on its own it is never run."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True


class CalledLibrary(PartLibrary):
    """Code of a part that kernels call and do not dissolve: it gives the same bits in all of them."""

    def add_ir_module(self, ir_module: Any) -> None:
        for function in ir_module.functions:
            if function.blocks:
                function.attributes.add("noinline")
        super().add_ir_module(ir_module)


class PartCompiler(ShortCompiler):
    """Compiles into a `PartLibrary`."""

    library: ClassVar[type[PartLibrary]] = PartLibrary

    def __init__(self, typing: Any, target: Any, _library: Any, *others: Any) -> None:
        super().__init__(typing, target, self.library(target.codegen(), "part"), *others)
        self.state.targetctx.get_executable = _no_executable


class CalledPartCompiler(PartCompiler):
    """Compiles into a `CalledLibrary`."""

    library = CalledLibrary


def _no_executable(library: Any, description: Any, environment: Any) -> Any:
    """What stands for a part where Numba keeps a function that Python can call."""
    return make_function(description.lookup_module(), description.qualname, "", 0, environment, (library,))


def entry_of(function: Any, arguments: tuple[Any, ...]) -> Any:
    """The machine code of a kernel for the types of these arguments; of what is no kernel, the function."""
    if not isinstance(function, CPUDispatcher) or isinstance(function, CompiledPart):
        return function
    key = function, _kinds(arguments)
    if key not in _ENTRIES:
        _ENTRIES[key] = function.compile(tuple(map(function.typeof_pyval, arguments)))
    return _ENTRIES[key]


_ENTRIES: dict[Any, Any] = {}  # Numba takes long to find types
_FLAGS_OF_TYPE = 0x001 | 0x002 | 0x400  # of an array: contiguous as in C, as in Fortran; may be written to


def _kinds(argument: Any) -> Any:
    """What decides on the type of an argument, to be compared fast."""
    if isinstance(argument, tuple):
        kinds = [
            (one.dtype, one.ndim, one.flags.num & _FLAGS_OF_TYPE) if type(one) is np.ndarray else _kinds(one)
            for one in argument
        ]
        return type(argument), *kinds
    if isinstance(argument, np.ndarray):
        return argument.dtype, argument.ndim, argument.flags.num & _FLAGS_OF_TYPE
    if isinstance(argument, np.generic):
        return argument.dtype
    return argument.structure if isinstance(argument, Placed) else type(argument)


class Kernel(CPUDispatcher):
    """A compiled function that Python calls, and no other compiled one."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Numba asks for it where it compiles a call.

        Raises:
            TypeError: always, with the remedy.
        """
        name = self.py_func.__name__
        raise TypeError(f"{name} is a kernel, which no other can call: compile it as inlined_kernel")


class CompiledPart(CPUDispatcher):
    """A compiled function without an entry for Python, where it runs as plain Python.

    Numbers that are written out in a call are no types of their own: they are constants once it is inlined.
    """

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return super().get_call_template(tuple(map(unliteral, args)), kws)


class PartAndKernel(CPUDispatcher):
    """A compiled function with an entry for Python; what kernels contain is its `part`."""

    part: CompiledPart

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return self.part.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        return self.part.get_overload(sig)


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
    data = context.make_array(kind)(context, builder, row).data
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


def copy_memory(target: int, source: int, size: int) -> None:
    """Copy that many bytes between two addresses, which do not overlap."""
    memmove(int(target), int(source), int(size))


@type_callable(copy_memory)
def _type_copy_memory(_context: Any) -> Any:
    return lambda target, source, size: types.none


@lower_builtin(copy_memory, types.Integer, types.Integer, types.Integer)
def _lower_copy_memory(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    target, source = (builder.inttoptr(address, cgutils.voidptr_t) for address in arguments[:2])
    cgutils.raw_memcpy(builder, target, source, arguments[2], 1)
    return context.get_dummy_value()


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
    array = context.make_array(signature.return_type)(context, builder)
    context.populate_array(
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


COUNT, REAL, VECTOR = types.intp, types.float64, types.Array(types.float64, 1, "C")
"""Types of arguments of functions that are called by address."""


def _handed_over(kinds: Any) -> Any:
    """The type of all arguments together: of a vector its first number's address, and how many there are."""
    of_vector = CPointer(types.float64), types.intp
    parts = [of_vector if isinstance(kind, types.Array) else (unliteral(kind),) for kind in kinds]
    return BaseTuple.from_types([one for part in parts for one in part])


@intrinsic
def call_at(_context, address, system, arguments):
    """The number that a function returns, which lies at an address, see `address_of`.

    system: address of the first argument.   arguments: tuple of the others, numbers and vectors.
    """
    kind = _handed_over(arguments.types)

    def generate(context, builder, _signature, values):
        given = []
        for place, own in enumerate(arguments.types):
            value = builder.extract_value(values[2], place)
            array = context.make_array(own)(context, builder, value) if isinstance(own, types.Array) else None
            given += [value] if array is None else [array.data, array.nitems]
        whole = context.make_tuple(builder, kind, given)
        function = ir.FunctionType(ir.DoubleType(), [cgutils.voidptr_t, whole.type]).as_pointer()
        first = builder.inttoptr(values[1], cgutils.voidptr_t)
        return builder.call(builder.inttoptr(values[0], function), [first, whole])

    return types.float64(address, system, arguments), generate


@intrinsic
def taken_apart(_context, given):
    """The tuple of arguments that `call_at` has handed over."""
    rest = iter(given.types)
    kinds = [VECTOR if isinstance(kind, CPointer) and next(rest) else kind for kind in rest]
    result = BaseTuple.from_types(kinds)

    def generate(context, builder, _signature, values):
        parts = (builder.extract_value(values[0], place) for place in range(len(given.types)))
        arguments = []
        for kind in kinds:
            value = next(parts)
            if kind == VECTOR:
                array, size = context.make_array(kind)(context, builder), next(parts)
                stride = context.get_constant(types.intp, NUMBER_BYTES)
                places = {"shape": [size], "strides": [stride], "itemsize": stride}
                context.populate_array(array, data=value, meminfo=None, **places)
                value = array._getvalue()
            arguments.append(value)
        return context.make_tuple(builder, result, arguments)

    return result(given), generate


@intrinsic
def number_of(_context, returned):
    """What a function has returned, or 0 if that is nothing."""
    is_nothing = isinstance(returned, types.NoneType)

    def generate(context, _builder, _signature, values):
        return context.get_constant(types.float64, 0.0) if is_nothing else values[0]

    return types.float64(returned), generate


def address_of(function: Any, system: Any, *kinds: Any) -> int:
    """Address of the machine code of f(system, given), `given` as `call_at` hands arguments over.

    system: type of it.   kinds: types of the arguments.
    """
    signature = system, _handed_over(kinds)
    function.compile(signature)
    compiled = function.overloads[signature]
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))


class AtAddress(CPointer):
    """A named tuple that lies in memory and stays as it is: each field is read where it is asked for.

    By value, a function takes all numbers of all arrays in it, some hundreds for a scene.
    """

    def __init__(self, kind: Any) -> None:
        super().__init__(kind)
        self.instance_class = kind.instance_class
        self.name = f"{kind.instance_class.__name__} {hashlib.sha256(str(kind).encode()).hexdigest()[:16]}"

    @property
    def key(self) -> str:
        """What types are compared by: fast, as Numba does it for each call."""
        return self.name


register_model(AtAddress)(PointerModel)


@infer_getattr
class _Field(AttributeTemplate):
    key = AtAddress

    def generic_resolve(self, at: AtAddress, name: str) -> Any:
        if name not in at.dtype.fields:
            return None
        kind = at.dtype.types[at.dtype.fields.index(name)]
        return AtAddress(kind) if isinstance(kind, NamedTuple) else kind


@lower_getattr_generic(AtAddress)
def _read_field(context: Any, builder: Any, at: AtAddress, address: Any, name: str) -> Any:
    place = at.dtype.fields.index(name)
    kind, field = at.dtype.types[place], cgutils.gep_inbounds(builder, address, 0, place)
    is_tuple = isinstance(kind, NamedTuple)
    return field if is_tuple else _read(builder, field, context.get_data_type(kind))


def _read(builder: Any, address: Any, kind: Any) -> Any:
    """A value that nothing changes; number by number, as marks on reading a whole one get lost."""
    if isinstance(kind, ir.Aggregate):
        value = ir.Constant(kind, ir.Undefined)
        for place, part in enumerate(kind.elements):
            own = _read(builder, cgutils.gep_inbounds(builder, address, 0, place), part)
            value = builder.insert_value(value, own, place)
        return value
    value = builder.load(address)
    value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value


class Structure:
    """What compiled code knows of values of one type.   kind: that type."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind

    @property
    def address(self) -> Any:
        """The type of an address where such values lie."""
        return AtAddress(self.kind)

    @cached_property
    def size(self) -> int:
        """Bytes that a value takes in memory."""
        context = cpu_target.target_context
        return int(context.get_abi_sizeof(context.get_value_type(self.kind)))


class Placed:
    """A named tuple for kernels that take it by its address, see `AtAddress`; its arrays are used.

    structure: of it.   address: where it lies.
    """

    def __init__(self, value: Any) -> None:
        self._value, self._words = value, np.array(words_of(value), np.int64)
        self.structure, self.address = structure_of(value), place_of(self._words)


@typeof_impl.register(Placed)
def _type_of_placed(placed: Placed, _context: Any) -> Any:
    return placed.structure.address


@unbox(AtAddress)
def _address_of_placed(kind: Any, placed: Any, tools: Any) -> Any:
    number = tools.pyapi.object_getattr_string(placed, "address")
    address = tools.pyapi.long_as_voidptr(number)
    tools.pyapi.decref(number)
    return NativeValue(tools.builder.bitcast(address, tools.context.get_value_type(kind)))


def place_of(array: np.ndarray) -> int:
    """Address of its numbers, the first thing in an array for C; NumPy takes ten times as long to say it."""
    return c_size_t.from_address(id(array) + object.__basicsize__).value


def words_of(value: Any) -> list[int]:
    """A value as compiled code holds it in memory, in words of eight bytes, without references to it."""
    if isinstance(value, np.ndarray):
        return [0, 0, value.size, value.itemsize, place_of(value), *value.shape, *value.strides]
    if isinstance(value, tuple):
        return [word for one in value for word in words_of(one)]
    return np.array([value]).view(np.int64).tolist() if isinstance(value, float) else [int(value)]


def structure_of(value: Any) -> Structure:
    """The same one for all values of a type."""
    key = _kinds(value)
    if key not in _STRUCTURES:
        _STRUCTURES[key] = Structure(typeof(value))
    return _STRUCTURES[key]


_STRUCTURES: dict[Any, Structure] = {}  # Numba takes long to find types, and to compare them
