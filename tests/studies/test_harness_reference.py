"""References that a study computes."""

import numpy as np
import pytest

from reference_models.trajectory import Trajectory
from studies.harness.reference import self_convergence


def test_uncertainty_of_a_refined_solution_is_what_half_the_refinement_changes():
    times = np.linspace(0.0, 1.0, 5)
    runs = [Trajectory(times, np.full((5, 3), x)) for x in (0.0, 1.0, 3.0)]
    found = self_convergence(*runs, source="made up")
    assert found.trajectory is runs[0]
    assert found.uncertainty == pytest.approx(np.sqrt(3.0) * 4.0)
