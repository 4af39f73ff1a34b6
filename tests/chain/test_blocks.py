"""A step goes over the chain block by block: how many nodes are in a block must not matter."""

from dataclasses import replace

import numba
import numpy as np
import pytest

from exudyn_inext.chain import index_reduction
from exudyn_inext.chain.attached import Drag
from exudyn_inext.chain.index_reduction import NODES_AT_ONCE
from exudyn_inext.chain.linked_cable import cable_system
from exudyn_inext.system import accelerate_and_project
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    dense_rates,
    linked_state,
    random_state,
    relative_error,
    structured_rates,
    with_section,
)

ZETA = 5.0


def states(dim, number):
    """With all that elements may have; with groups of elements for each length; with links."""
    damped = with_section(random_state(81, number, dim, MEASURES[0], None, "clamped"), bending_damping=0.3)
    yield replace(damped, cable=replace(damped.cable, drag=Drag(0.7, 0.2, (0.5, -1.0, 0.3)[:dim])))
    yield random_state(82, number, dim, MEASURES[1], number // 2, "free")
    yield linked_state(83, number, dim, MEASURES[0], "closed with a moving hanger and a rod")


def projected(state):
    system = cable_system(state.cable, ZETA)
    a, end = 0.1 * state.v.ravel(), np.zeros(state.q.size)
    accelerate_and_project(system, state.inputs, state.q.ravel(), state.v.ravel(), 0.05, a, end)
    return a, end


@pytest.mark.kernel
@pytest.mark.skipif(not numba.config.DISABLE_JIT, reason="compiled code has the size of a block built in")
@pytest.mark.parametrize("dim", DIMENSIONS)
@pytest.mark.parametrize("nodes", [1, 2, 3, 5, 7])
def test_blocks_of_any_size_give_the_same_up_to_the_order_of_sums(monkeypatch, dim, nodes):
    for state in states(dim, 6):
        monkeypatch.setattr(index_reduction, "NODES_AT_ONCE", 100)
        whole = [*structured_rates(state, ZETA)[:2], *projected(state)]
        monkeypatch.setattr(index_reduction, "NODES_AT_ONCE", nodes)
        for found, expected in zip(
            [*structured_rates(state, ZETA)[:2], *projected(state)], whole, strict=True
        ):
            assert relative_error(found, expected) < 1e-12


@pytest.mark.parametrize("dim", DIMENSIONS)
@pytest.mark.parametrize("nodes", [NODES_AT_ONCE + k for k in (-1, 0, 1, 2)] + [2 * NODES_AT_ONCE + 1])
def test_chains_of_about_a_block_agree_with_the_dense_solve(dim, nodes):
    state = random_state(84, nodes - 1, dim, MEASURES[0], None, "pinned")
    acceleration, rate, _ = structured_rates(state, ZETA)
    expected, expected_rate, *_ = dense_rates(state, ZETA)
    assert relative_error(acceleration, expected) < 1e-10
    assert relative_error(rate, expected_rate) < 1e-10
