"""The smallest eigenvalue says whether an equilibrium is stable."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csc_array as sparse

from exudyn_inext.statics import smallest_eigenvalue
from exudyn_inext.statics.small_motions import small_motions


@pytest.mark.parametrize(("others", "expected"), [([-4.0, 2.0, 7.0], -4.0), ([2.0, 7.0, 30.0], -1e-5)])
def test_round_off_of_a_free_turn_hides_no_unstable_direction(others, expected):
    stiffness = np.diag([-1e-5, *others])
    system = SimpleNamespace(
        hessian=lambda q, multipliers: sparse(stiffness),
        jacobian=lambda q: sparse(np.zeros((0, 4))),
        mass=sparse(np.eye(4)),
        order=np.arange(4),
        indifferent=-1e-3,
    )
    found, direction = smallest_eigenvalue(small_motions(system, np.zeros(4), np.zeros(0)))
    assert found == pytest.approx(expected, rel=1e-6)
    assert np.argmax(np.abs(direction)) == np.argmin(np.abs(np.diag(stiffness) - expected))
