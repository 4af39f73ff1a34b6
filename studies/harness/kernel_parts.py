"""The parts of one evaluation of Eq. (30), each repeated in one compiled call."""

from collections.abc import Callable

import numpy as np

from exudyn_inext.chain.assembly import assemble, leave_targets
from exudyn_inext.chain.cable import Cable
from exudyn_inext.chain.factorisation import factorise
from exudyn_inext.chain.linked_cable import cable_system
from exudyn_inext.chain.saddle_point import solve_both_columns
from exudyn_inext.compiled import kernel
from exudyn_inext.system import index_reduced_rates
from reference_models.trajectory import Array

ZETA = 100.0


@kernel
def _rates(times, system, external, q, v, acceleration, rate):
    for _ in range(times):
        index_reduced_rates(system, external, q, v, acceleration, rate)


@kernel
def _assembly(times, chain, external, q, v):
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    for _ in range(times):
        assemble(axes, nodes, elements, external, q, v, 0, leave_targets, 0.0)


@kernel
def _factorisation(times, chain):
    for _ in range(times):
        factorise(chain.axes, chain.nodes, chain.elements)


@kernel
def _substitution(times, chain, x, y):
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    for _ in range(times):
        solve_both_columns(axes, nodes, elements, x, y)


def rates_task(cable: Cable, external: Array, q: Array, v: Array) -> Callable[[int], None]:
    """times -> None: index_reduced_rates alone.   external, q, v: (n_dof,)."""
    system = cable_system(cable, ZETA)
    a, rate = np.zeros(q.size), np.zeros(q.size)
    return lambda times: _rates(times, system, external, q, v, a, rate)


def part_tasks(cable: Cable, external: Array, q: Array, v: Array) -> dict[str, Callable[[int], None]]:
    """Name of a part -> times -> None; of a chain without links.   external, q, v: (n_dof,)."""
    system = cable_system(cable, ZETA)
    chain = system.chain
    force, known, rates = (array.reshape(chain.shape) for array in (external, q, v))
    x, y = np.zeros(chain.shape), np.zeros(chain.shape)
    index_reduced_rates(system, external, q, v, x.ravel(), y.ravel())
    return {
        "assembly": lambda times: _assembly(times, chain, force, known, rates),
        "factorisation": lambda times: _factorisation(times, chain),
        "substitution": lambda times: _substitution(times, chain, x, y),
    }
