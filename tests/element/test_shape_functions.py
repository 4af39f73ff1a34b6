"""Hermite shape functions interpolate nodal positions and slopes, and their derivatives are theirs."""

import numpy as np
import pytest

from exudyn_inext.element.external_force import point_force, uniform_force
from exudyn_inext.element.shape_functions import (
    first_derivatives,
    quadrature,
    second_derivatives,
    shape_functions,
)
from tests.cables import hermite

LENGTHS = (0.3, 1.0, 2.5)
XI = np.linspace(0.0, 1.0, 11)

pytestmark = pytest.mark.kernel


@pytest.mark.parametrize("length", LENGTHS)
def test_each_shape_function_has_one_nodal_value_or_slope(length):
    values = shape_functions([0.0, 1.0], length)
    slopes = first_derivatives([0.0, 1.0], length)
    nodal = np.stack([values[:, 0], slopes[:, 0], values[:, 1], slopes[:, 1]])
    np.testing.assert_allclose(nodal, np.eye(4), atol=1e-14)


@pytest.mark.parametrize("length", LENGTHS)
def test_shape_functions_and_derivatives_are_the_cubics_of_the_interpolation_conditions(length):
    for order, function in enumerate((shape_functions, first_derivatives, second_derivatives)):
        expected = [p.deriv(order)(XI * length) if order else p(XI * length) for p in hermite(length)]
        np.testing.assert_allclose(function(XI, length), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize(
    ("function", "derivative"),
    [(shape_functions, first_derivatives), (first_derivatives, second_derivatives)],
)
def test_derivatives_agree_with_differences(length, function, derivative):
    step = 1e-5
    difference = (function(XI + step, length) - function(XI - step, length)) / (2 * step * length)
    np.testing.assert_allclose(derivative(XI, length), difference, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("length", LENGTHS)
def test_rigid_positions_and_linear_fields_are_reproduced(length):
    shape = shape_functions(XI, length)
    np.testing.assert_allclose(shape[0] + shape[2], 1.0, rtol=1e-14)
    np.testing.assert_allclose([0.0, 1.0, length, 1.0] @ shape, XI * length, atol=1e-14)


@pytest.mark.parametrize("length", LENGTHS)
def test_quadrature_is_exact_to_degree_seven(length):
    xi, weight = quadrature(length)
    for degree in range(8):
        assert weight @ (xi * length) ** degree == pytest.approx(length ** (degree + 1) / (degree + 1))


def test_force_of_a_uniform_load_is_the_integral_of_the_shape_functions():
    expected = [shape.integ()(1.3) for shape in hermite(1.3)]
    np.testing.assert_allclose(uniform_force(1.3), expected, rtol=1e-12)


def test_point_force_is_the_shape_functions_times_the_force():
    force = np.array([2.0, -3.0, 0.5])
    expected = [p(0.25 * 1.4) * force for p in hermite(1.4)]
    np.testing.assert_allclose(point_force(force, 0.25, 1.4), expected, rtol=1e-12)
