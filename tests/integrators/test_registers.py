"""What makes a step cheap: small matrices in registers, and references to arrays that nobody counts."""

import re

import numba
import numpy as np
import pytest

from exudyn_inext.cable.cable import Cable
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.compiled import OPTIONS, plain
from exudyn_inext.integrators.integrator import no_loads
from exudyn_inext.integrators.rattle import Rattle, advance_rattle, allocate
from tests.cables import DIMENSIONS, MEASURES, planar_pendulum


def machine_independent_code(cable: Cable) -> str:
    """Optimised LLVM code of the steps of `cable` with RATTLE."""
    size = cable.reference.size
    state = allocate(size, size)
    state.q[:] = cable.reference.ravel()
    advance = numba.njit(**OPTIONS)(plain(advance_rattle))
    advance(Rattle(), cable_system(cable, 0.0), no_loads(size, 1), state, 1e-6, 1, np.zeros((1, 3, size)))
    (code,) = advance.inspect_llvm().values()
    return str(code)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
@pytest.mark.parametrize("dim", DIMENSIONS)
@pytest.mark.parametrize("measure", MEASURES)
def test_small_matrices_of_a_step_stay_in_registers(dim, measure):
    cable, _ = planar_pendulum(5, dim, measure=measure)
    code = machine_independent_code(cable)
    assert re.findall(r"%local_array\S* = alloca.*", code) == []


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_references_to_arrays_are_not_counted():
    cable, _ = planar_pendulum(5)
    assert "NRT_incref" not in machine_independent_code(cable)
