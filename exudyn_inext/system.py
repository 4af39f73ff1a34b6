"""What an integrator sees of a mechanical system: a small protocol, dispatched on its type.

A system is a NamedTuple; the module that defines it registers an implementation with `implements`.
The same call works in compiled code (resolved when compiling) and in plain Python.
"""

from collections.abc import Callable
from functools import singledispatch
from typing import Any

from numba.extending import overload

from .compiled import kernel


@singledispatch
def index_reduced_rates(system, external, q, v, acceleration, rate):
    """Right-hand side of the index-reduced equations, Eq. (30).

    Args:
        system: the mechanical system.
        external: (n_dof,) external generalised force at the time of (q, v).
        q: (n_dof,) coordinates.   v: (n_dof,) velocities.
        acceleration: (n_dof,) output dv/dt.
        rate: (n_dof,) output dq/dt: the velocity, projected and stabilised.

    Raises:
        NotImplementedError: the type of `system` implements no such right-hand side.
    """
    raise NotImplementedError(f"no index-reduced rates for {type(system).__name__}")


def implements(protocol: Any, system_type: type) -> Callable[[Any], Any]:
    """Register the decorated kernel as `protocol` for systems of `system_type`."""

    def register(function: Any) -> Any:
        compiled = kernel(function)
        protocol.register(system_type)(compiled)
        return compiled

    return register


@overload(index_reduced_rates, strict=False)
def _compile_index_reduced_rates(system, external, q, v, acceleration, rate):
    implementation = index_reduced_rates.dispatch(getattr(system, "instance_class", object))

    def call(system, external, q, v, acceleration, rate):
        implementation(system, external, q, v, acceleration, rate)

    return call
