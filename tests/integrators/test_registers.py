"""What makes a step cheap: small matrices in registers, and references to arrays that nobody counts."""

import re

import numba
import numpy as np
import pytest

from exudyn_inext.cable.cable import CurvatureMeasure
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.compiled import OPTIONS, plain
from exudyn_inext.integrators.integrator import no_loads
from exudyn_inext.integrators.rattle import INTEGRATOR, Rattle, advance_rattle
from tests.cables import DIMENSIONS, MEASURES, planar_pendulum


def machine_independent_code(dim: int, measure: CurvatureMeasure) -> str:
    """Optimised LLVM code of the steps of a cable with RATTLE."""
    cable, _ = planar_pendulum(5, dim, measure=measure)
    size = cable.reference.size
    state = INTEGRATOR.allocate(size, size)
    state.q[:] = cable.reference.ravel()
    advance = numba.njit(**OPTIONS)(plain(advance_rattle))
    advance(Rattle(), cable_system(cable, 0.0), no_loads(size, 1), state, 1e-6, 1, np.zeros((1, 3, size)))
    (code,) = advance.inspect_llvm().values()
    return str(code)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
@pytest.mark.parametrize(("dim", "measure"), list(zip(DIMENSIONS, MEASURES, strict=True)))
def test_small_matrices_of_a_step_stay_in_registers_and_references_are_not_counted(dim, measure):
    code = machine_independent_code(dim, measure)
    assert re.findall(r"%local_array\S* = alloca.*", code) == []
    assert "NRT_incref" not in code
