"""The constant matrices of one element are the textbook's."""

import numpy as np
import pytest

from exudyn_inext.element import bending, inertia, inextensibility
from exudyn_inext.element.difference_coordinates import in_differences
from tests import cables

LENGTHS = (0.3, 1.0, 2.5)
PAIRED = [
    (inertia.mass_matrix, cables.mass_matrix),
    (bending.stiffness_matrix, cables.stiffness_matrix),
    (inextensibility.slope_gram_matrix, cables.slope_gram_matrix),
]

pytestmark = pytest.mark.kernel


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize(("matrix", "textbook"), PAIRED, ids=["mass", "stiffness", "slope gram"])
def test_matrix_is_the_closed_form_of_the_textbook(matrix, textbook, length):
    np.testing.assert_allclose(matrix(length), textbook(length), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("length", LENGTHS)
def test_stiffness_tensor_has_the_symmetries_of_eq_14(length):
    k = bending.stiffness_tensor(length)
    scale = np.abs(k).max()
    for order in ((1, 0, 2, 3), (0, 1, 3, 2), (2, 3, 0, 1)):
        np.testing.assert_allclose(k, k.transpose(order), atol=1e-14 * scale)


@pytest.mark.parametrize("dim", cables.DIMENSIONS)
@pytest.mark.parametrize("length", LENGTHS)
def test_tensor_energy_is_the_integral_of_the_squared_product(length, dim):
    q = np.random.default_rng(3).standard_normal((4, dim))
    pairs = 0.5 * q @ q.T
    energy = 0.5 * np.einsum("abmn,ab,mn->", bending.stiffness_tensor(length), pairs, pairs)
    s_x, weight = cables.sampled(length, 1)
    s_xx, _ = cables.sampled(length, 2)
    squares = ((s_x.T @ q) ** 2).sum(axis=1) * ((s_xx.T @ q) ** 2).sum(axis=1)
    assert energy == pytest.approx(0.5 * weight @ squares, rel=1e-11)


@pytest.mark.parametrize("form", [bending.stiffness_matrix, inextensibility.slope_gram_matrix])
def test_difference_coordinates_keep_the_value_of_a_translation_invariant_form(form):
    q = np.random.default_rng(4).standard_normal(4)
    e = np.array([q[2] - q[0], q[1], q[3]])
    assert e @ in_differences(form(0.8)) @ e == pytest.approx(q @ form(0.8) @ q, rel=1e-12)


def test_condensed_tensor_gives_the_same_energy():
    rng = np.random.default_rng(5)
    tensor = in_differences(bending.stiffness_tensor(0.8))
    pairs = np.einsum("ai,bi->ab", *[rng.standard_normal((3, 2))] * 2)
    full = np.einsum("abmn,mn->ab", tensor, pairs)
    condensed = bending.in_pairs(tensor) @ [pairs[m, n] for m, n in bending.PAIRS]
    np.testing.assert_allclose(condensed, [full[a, b] for a, b in bending.PAIRS], rtol=1e-12)
