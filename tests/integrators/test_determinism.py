"""The same input gives the same bits. Threads and ensembles: tests/exudyn_binding/test_ensemble.py."""

import numpy as np
import pytest

from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.loads.gravity import gravity_force
from tests.cables import State, planar_pendulum
from tests.moving import move_system

ZETA, H, STEPS = 100.0, 2e-3, 500
COEFFICIENTS = {
    *("mass", "free", "ends_group", "stiffness", "tensor", "natural", "damping", "slope_gram"),
    *("curved", "damped", "dragged", "lag"),
    *("reference_length", "per_length", "drift_correction"),  # of the last, each run starts with zeros
}

every_integrator = pytest.mark.parametrize("name", INTEGRATORS)


def pendulum():
    cable, gravity = planar_pendulum(5)
    return State(cable, cable.reference, 0.0 * cable.reference, gravity_force(cable, gravity))


def history(name, system, state):
    return move_system(system, state, H, STEPS, 10, name)


@every_integrator
def test_two_runs_are_the_same_bit_for_bit(name):
    first, second = (history(name, cable_system(pendulum().cable, ZETA), pendulum()) for _ in range(2))
    assert np.ptp(first[:, 0, -1, 0, 1]) > 0.5
    np.testing.assert_array_equal(first, second)


@every_integrator
def test_what_is_left_in_memory_from_another_run_does_not_reach_the_result(name):
    state = pendulum()
    clean, used = (cable_system(state.cable, ZETA) for _ in range(2))
    for records in (used.chain.nodes, used.chain.elements):
        for field in set(records.dtype.names) - COEFFICIENTS:
            records[field] = np.nan
    used.chain.nodes["force"][:, 1] = 0.0  # of the correction: zero, never written
    np.testing.assert_array_equal(history(name, used, state), history(name, clean, state))
