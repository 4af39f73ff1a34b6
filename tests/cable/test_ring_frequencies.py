"""In-plane vibrations of an inextensible ring: w_n^2 = n^2 (n^2 - 1)^2 / (n^2 + 1) EI / (rho_A R^4).

S. P. Timoshenko, D. H. Young, W. Weaver, Vibration Problems in Engineering, Wiley 1974, section 5.21.
"""

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

from exudyn_inext.cable.cable import Cable, CurvatureMeasure, Section
from exudyn_inext.statics import Potential

RADIUS, DENSITY, STIFFNESS = 0.5, 0.212, 3.436


def ring(number, measure, natural_curvature=0.0):
    angle = 2.0 * np.pi * np.arange(number + 1) / number
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    outward[-1], along[-1] = outward[0], along[0]
    return Cable(
        reference=np.stack([RADIUS * outward, along], axis=1),
        element_lengths=np.full(number, 2.0 * np.pi * RADIUS / number),
        section=Section(DENSITY, STIFFNESS, natural_curvature),
        measure=measure,
        length_constraints=number,
        fixed=np.zeros((number + 1, 2), dtype=bool),
        closed=True,
    )


def frequencies(cable):
    """Natural frequencies [rad/s] about the circle, which is in equilibrium."""
    q = cable.reference
    potential = Potential([cable], np.zeros(q.shape), 0.0)
    jacobian = potential.jacobian(q).toarray()
    force = potential.force(q)
    multipliers = np.linalg.lstsq(jacobian.T, force, rcond=None)[0]
    assert np.abs(jacobian.T @ multipliers - force).max() < 1e-2 * np.abs(force).max()
    free = null_space(jacobian, rcond=1e-9)
    matrices = (potential.hessian(q, multipliers).toarray(), potential.mass.toarray())
    squares = eigh(*[free.T @ matrix @ free for matrix in matrices], eigvals_only=True)
    return np.sqrt(np.abs(squares))


def exact(n):
    return np.sqrt(n**2 * (n**2 - 1) ** 2 / (n**2 + 1) * STIFFNESS / (DENSITY * RADIUS**4))


@pytest.mark.kernel
def test_rigid_motions_of_the_ring_have_no_frequency():
    assert frequencies(ring(8, CurvatureMeasure.SECOND_DERIVATIVE))[:3].max() < 1e-2 * exact(2)


@pytest.mark.parametrize("measure", CurvatureMeasure, ids=lambda measure: measure.value)
def test_frequencies_converge_to_the_closed_form(measure):
    errors = {
        number: np.abs(frequencies(ring(number, measure))[3:9:2] / exact(np.arange(2, 5)) - 1.0)
        for number in (10, 20)
    }
    assert errors[20].max() < 2e-3
    assert (errors[20][1:] < 0.13 * errors[10][1:]).all()  # order 3 or better; n = 2 is exact by chance


def test_lowest_frequency_with_ten_elements_is_within_a_thousandth():
    for measure, tolerance in ((CurvatureMeasure.SECOND_DERIVATIVE, 1e-4), (CurvatureMeasure.PRODUCT, 1e-2)):
        found = frequencies(ring(10, measure))[3]
        assert found == pytest.approx(exact(2), rel=tolerance)


def test_natural_curvature_does_not_change_the_vibrations():
    differences = []
    for number in (10, 20):
        straight = frequencies(ring(number, CurvatureMeasure.SECOND_DERIVATIVE))
        curved = frequencies(ring(number, CurvatureMeasure.SECOND_DERIVATIVE, 1.0 / RADIUS))
        differences.append(np.abs(curved[3:9] / straight[3:9] - 1.0).max())
    assert differences[1] < 4e-3
    assert differences[1] < 0.3 * differences[0]
