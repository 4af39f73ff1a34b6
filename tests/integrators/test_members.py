"""Members of an ensemble move as they do alone, and one that diverges leaves the others be."""

import numpy as np
import pytest

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.called_system import addresses_of, called
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import LoadHistory, record
from exudyn_inext.integrators.rattle import Rattle
from exudyn_inext.run.members import member, record_members, stacked
from exudyn_inext.run.watch import build_watch
from exudyn_inext.system import report_energy
from tests.cables import MEASURES, random_state

pytestmark = pytest.mark.kernel

H, STEPS, INTERVALS = 1e-3, 2, 3
RATTLE = INTEGRATORS["RATTLE"]


def start(seed, broken=False):
    """System, loads that change with time, and state of a cable of two elements."""
    state = random_state(seed, 2, 2, MEASURES[0], supports="pinned")
    cable = CableSystem(build_chain(state.cable), 0.0)
    memory = RATTLE.allocate(state.q.size, state.q.size)
    memory.q[:], memory.v[:] = state.cable.reference.ravel(), state.v.ravel()
    force = np.full(state.q.size, np.nan) if broken else state.external.ravel()
    pattern = np.ones((1, state.q.size))
    loads = LoadHistory(force, pattern, np.linspace(0.0, 1.0, STEPS * INTERVALS)[:, None, None])
    RATTLE.start(cable, force, memory)
    return cable, loads, memory


def alone(seed):
    cable, loads, memory = start(seed)
    history = np.zeros((INTERVALS, 3, memory.q.size))
    record(RATTLE, RATTLE.scheme(), cable, loads, memory, H, STEPS, history)
    return history


def test_members_move_as_they_do_alone_bit_by_bit():
    members = [start(1), start(2, broken=True), start(3)]
    systems = [called(cable, *RATTLE.calls, report_energy) for cable, _, _ in members]
    addresses, functions = addresses_of(systems), systems[0].functions
    loads, memories = (stacked(column) for column in list(zip(*members, strict=True))[1:])
    watches = stacked([build_watch(memory, 4, np.inf) for _, _, memory in members])
    output, good = np.full((2, 3, INTERVALS, memories.q.shape[1]), 7.0), np.zeros(3, dtype=int)
    record_members(RATTLE.scheme(), addresses, functions, loads, memories, H, STEPS, watches, output, good)
    for place, seed in ((0, 1), (2, 3)):
        np.testing.assert_array_equal(output[:, place], alone(seed)[:, :2].transpose(1, 0, 2))
    assert good.tolist() == [INTERVALS, 0, INTERVALS]
    assert (output[:, 1] == 7.0).all()


def test_a_member_is_a_view_of_the_stack():
    first, second = start(1), start(2)
    stack = stacked([first[0], second[0]])
    of_stack = member(stack, 1)
    assert of_stack.zeta == second[0].zeta
    np.testing.assert_array_equal(of_stack.chain.nodes["mass"], second[0].chain.nodes["mass"])
    of_stack.chain.nodes["mass"][:] = 5.0
    assert (stack.chain.nodes["mass"][1] == 5.0).all() and not (stack.chain.nodes["mass"][0] == 5.0).all()


def test_an_iteration_that_gives_up_says_so_and_goes_no_further():
    scheme = Rattle(tolerance=1e-30, iterations=2)
    cable, loads, memory = start(1)
    history = np.zeros((INTERVALS, 3, memory.q.size))
    assert RATTLE.trouble(scheme, memory) == ""
    record(RATTLE, scheme, cable, loads, memory, H, STEPS, history)
    assert np.isnan(history[:, 0]).all()
    message = RATTLE.trouble(scheme, memory)
    assert f"violated by {memory.residual[0]:.3g} after 2 iterations (tolerance 1e-30)" in message
    assert 1e-30 < memory.residual[0] < 1e-2
