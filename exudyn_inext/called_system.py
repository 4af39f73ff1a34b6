"""Systems behind the addresses of their compiled functions.

Loops over steps, and scenes with cables in them, call a system through a table of such addresses, as a
method is called in C++. So they are compiled once, and for a new type of system its own functions alone.
"""

import weakref
from collections.abc import Callable, Sequence
from functools import cache, partial, wraps
from typing import Any, NamedTuple

import numba
import numpy as np

from .compiled import c_function, inlined, inlined_kernel, kernel
from .lowered import (
    COUNT,
    REAL,
    VECTOR,
    CompiledPart,
    Structure,
    address_of,
    call_at,
    entry_of,
    number_of,
    place_of,
    structure_of,
    taken_apart,
    words_of,
)
from .system import (
    accelerate,
    accelerate_and_project,
    correct_position,
    index_reduced_rates,
    report_energy,
)

MOST_PROTOCOLS = 19
PLACES = (  # in tables; compiled code holds them: they must not depend on what is imported first
    "accelerate",
    "correct_position",
    "report_energy",
    "respond",
    "improve_damping",
    "apply_stiffness",
    "show_matrix",
    "add_contact",
    "finish_step",
    "place_rare_points",
    "move_rare_points",
    "add_contacts",
    "check_friction",
    "press",
    "complete_contacts",
    "reconsider_contacts",
    "settle_contacts",
    "add_connectors",
)
INTEGER = np.dtype(np.int64)


class Called(NamedTuple):
    """Any system, for kernels that shall not depend on its type.

    address: where it lies in memory, as compiled code holds it; without the compiler, the system itself.
    functions: (19,) addresses of its implementations of protocols, by their places; 0: none was asked for.
    """

    address: Any
    functions: np.ndarray


class _Entry(NamedTuple):
    """How a protocol is called by address.

    place: in `Called.functions`.   function: see `address_of`.   kinds: types of its arguments.
    """

    place: int
    function: Any
    kinds: tuple[Any, ...]


_ENTRIES: dict[Any, _Entry] = {}


def by_address(protocol: Any, *kinds: Any) -> int:
    """Let a protocol be called by address; gives its place in the table.

    kinds: types of its arguments, but for the first one, `system`.
    """

    def function(system, given):
        return number_of(protocol(system, *taken_apart(given)))

    place = PLACES.index(protocol.__name__)
    _ENTRIES[protocol] = _Entry(place, c_function(function), kinds)
    return place


def calls(protocol: Any) -> Callable[[Any], Any]:
    """Register the decorated function as `protocol` for `Called`."""

    def register(function: Any) -> Any:
        def call_itself(system, *arguments):
            return protocol(system.address, *arguments)

        compiled = call_itself if numba.config.DISABLE_JIT else inlined_kernel(function)
        protocol.register(Called)(compiled)
        return compiled

    return register


class Implementation(CompiledPart):
    """Part of kernels; called from Python, it runs as compiled for the type of its system alone."""

    protocol: Any

    def __call__(self, system: Any, *arguments: Any) -> Any:
        return self.protocol.dispatch(Called)(called(system, self.protocol), *arguments)


def implements(
    protocol: Any, *system_types: type, compiled: Callable[[Any], Any] | None = None
) -> Callable[[Any], Any]:
    """Register the decorated function as `protocol` for systems of these types.

    compiled: compiles it; default: as what is called by address, or else as a kernel.
    """

    def register(function: Any) -> Any:
        if compiled or _SERVED.get(protocol, protocol) not in _ENTRIES:
            implementation = (compiled or kernel)(function)
        else:
            implementation = inlined(function)
            if not numba.config.DISABLE_JIT:
                implementation.__class__, implementation.protocol = Implementation, protocol
        for system_type in system_types:
            protocol.register(system_type)(implementation)
        return implementation

    return register


_ADDRESSES: dict[Any, int] = {}  # of protocols for structures of systems
_TABLES: dict[int, tuple[Any, Structure]] = {}  # references to those of systems, by their identities
_BEHIND: dict[int, Any] = {}  # systems, by the identities of their functions


def _address(protocol: Any, structure: Structure) -> int:
    key = protocol, structure
    if key not in _ADDRESSES:
        entry = _ENTRIES[protocol]
        _ADDRESSES[key] = address_of(entry.function, structure.address, *entry.kinds)
    return _ADDRESSES[key]


def _table_of(system: Any) -> tuple[np.ndarray, Structure]:
    """Functions, behind which the system lies, and its structure; the system is kept as long as these."""
    if id(system) in _TABLES:
        reference, structure = _TABLES[id(system)]
        return reference(), structure
    structure, words = structure_of(system), words_of(system)
    assert len(words) == -(-structure.size // INTEGER.itemsize)
    functions = np.array([0] * MOST_PROTOCOLS + words, INTEGER)[:MOST_PROTOCOLS]
    _TABLES[id(system)], _BEHIND[id(functions)] = (weakref.ref(functions), structure), system
    weakref.finalize(functions, _forget, id(system), id(functions)).atexit = False
    return functions, structure


def _forget(system: int, functions: int) -> None:
    del _TABLES[system], _BEHIND[functions]


def behind(one: Called) -> Any:
    """The system that is called."""
    return one.address if numba.config.DISABLE_JIT else _BEHIND[id(one.functions)]


def called(system: Any, *protocols: Any) -> Any:
    """A system for kernels that call it by address; what only Python can evaluate stays as it is.

    Args:
        system: its arrays are used; it is kept as long as the result's table is.
        protocols: those that will be called.
    """
    if isinstance(system, Called) or not isinstance(system, tuple):
        return system
    if numba.config.DISABLE_JIT:
        return Called(system, np.zeros(MOST_PROTOCOLS, INTEGER))
    if not _are_called(type(system), protocols):
        return system
    functions, _ = _table_of(system)
    provide(functions, system, *protocols)
    return Called(place_of(functions) + functions.nbytes, functions)


@cache
def _are_called(kind: type, protocols: tuple[Any, ...]) -> bool:
    """Whether systems of this type implement all of these protocols for whoever calls them by address."""
    return all(isinstance(protocol.dispatch(kind), Implementation) for protocol in protocols)


@cache
def _is_implemented(kind: type, protocol: Any) -> bool:
    return protocol.dispatch(kind) is not protocol.dispatch(object)


def addresses_of(row: Sequence[Called]) -> Any:
    """(k,) addresses of systems; without the compiler, the systems."""
    addresses: Any = [one.address for one in row]
    return addresses if numba.config.DISABLE_JIT else np.array(addresses, INTEGER)


def provide(functions: np.ndarray, system: Any, *protocols: Any) -> None:
    """Compile these protocols for the type of a system, and put their addresses into a table."""
    for one in protocols:
        serving = _SERVED.get(one, one)
        place = _ENTRIES[serving].place
        if not functions[place] and _is_implemented(system.__class__, serving):
            functions[place] = 1 if numba.config.DISABLE_JIT else _address(serving, _table_of(system)[1])


def keep_with(array: np.ndarray, *others: Any) -> None:
    """Let these live as long as the array does."""
    weakref.finalize(array, lambda *_: None, *others).atexit = False


class Bound:
    """A protocol of one system, as a function of the other arguments; found out at the first call."""

    def __init__(self, protocol: Any, system: Any) -> None:
        self._protocol, self._system = protocol, system
        self._function: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:
        if self._function is None:
            known = called(self._system, self._protocol)
            function = self._protocol.dispatch(type(known))
            self._function = partial(entry_of(function, (known, *arguments)), known)
        return self._function(*arguments)


def called_part(part: Any, *protocols: Any) -> Called:
    """A part of a scene, called by address; if it has no records, nothing of it is compiled."""
    known: Called = called(part)
    if len(part.records):
        provide(known.functions, part, *protocols)
    return known


def called_as(one: Called, part: Any) -> Called:
    """Another part of the same type, called by the same functions."""
    known: Called = called(part)
    known.functions[:] = one.functions
    return known


def takes_any_system(*protocols: Any) -> Callable[[Any], Any]:
    """Compile f(system, ...) as a kernel that calls these protocols by address, once for all systems."""

    def decorate(function: Any) -> Any:
        compiled = kernel(function)

        @wraps(function)
        def call(system: Any, *arguments: Any) -> Any:
            return compiled(called(system, *protocols), *arguments)

        call.__dict__.update(py_func=function, kernel=compiled)
        return call

    return decorate


def kernel_behind(function: Any) -> Any:
    """What `takes_any_system` has compiled, for whoever has a system as `Called`."""
    return vars(function).get("kernel", function)


@inlined
def call_protocol(system, place, arguments):
    """What the function of a protocol returns; if there is none, the last argument is no number any more."""
    address = system.functions[place]
    if address == 0:
        arguments[-1][0] = np.nan
        return np.nan
    return call_at(address, system.address, arguments)


def called_by_address(protocol: Any, *kinds: Any) -> int:
    """As `by_address`; all kernels call the protocol so, of systems that must implement it."""
    place = by_address(protocol, *kinds)

    @calls(protocol)
    def call(system, *arguments):
        return call_protocol(system, place, arguments)

    return place


def of_parts(protocol: Any, *kinds: Any) -> int:
    """As `by_address`, of parts of a scene, which need not implement it; then it returns 0."""
    place = by_address(protocol, *kinds)

    def call(part, *arguments):
        address = part.functions[place]
        return call_at(address, part.address, arguments) if address != 0 else 0.0

    def call_itself(part, *arguments):
        return protocol(part.address, *arguments) if part.functions[place] else 0.0

    protocol.register(Called)(call_itself if numba.config.DISABLE_JIT else inlined_kernel(call))
    return place


_SERVED = {index_reduced_rates: accelerate, accelerate_and_project: accelerate}
ACCELERATION = by_address(accelerate, VECTOR, VECTOR, VECTOR, REAL, COUNT, VECTOR, VECTOR)
CORRECTION = by_address(correct_position, VECTOR, VECTOR, REAL, REAL, VECTOR)
REPORT_ENERGY = by_address(report_energy, *[VECTOR] * 6)


@calls(accelerate)
def accelerate_called(system, external, q, v, duration, stabilises, acceleration, rate):
    call_protocol(system, ACCELERATION, (external, q, v, duration, stabilises, acceleration, rate))


def _rates(system, external, q, v, acceleration, rate):
    accelerate(system, external, q, v, 0.0, 1, acceleration, rate)


def _accelerate_and_project(system, external, q, v, duration, acceleration, end_velocity):
    accelerate(system, external, q, v, duration, 0, acceleration, end_velocity)


calls(index_reduced_rates)(_rates)
calls(accelerate_and_project)(_accelerate_and_project)


def accelerates(*system_types: type) -> Callable[[Any], Any]:
    """Register the decorated function as `accelerate`, and with it both protocols that it serves."""

    def register(function: Any) -> Any:
        implements(index_reduced_rates, *system_types)(_rates)
        implements(accelerate_and_project, *system_types)(_accelerate_and_project)
        return implements(accelerate, *system_types)(function)

    return register


@calls(correct_position)
def correct_called(system, external, q, tolerance, learning, correction):
    return call_protocol(system, CORRECTION, (external, q, tolerance, learning, correction))


@calls(report_energy)
def report_energy_called(system, external, q, v, a, force, energy_report):
    call_protocol(system, REPORT_ENERGY, (external, q, v, a, force, energy_report))
