"""Values of the constraints against integrals and figures that can be had by hand."""

import numpy as np
import pytest

from exudyn_inext.constraints import constraints_of_cable
from tests.cables import MEASURES, fine_quadrature, hermite, random_state, straight_cable

NAMES = "abcdef"


def values_of(kind, cable, q):
    """Of the constraints of one kind."""
    found = constraints_of_cable(cable)
    return found.value(q)[found.rows[kind]]


def places_of(kind, cable):
    """Where the constraints of one kind act, in words."""
    found = constraints_of_cable(cable)
    descriptions = [found.describe(row, NAMES) for row in range(found.number)]
    return [where for name, where in descriptions if name == kind]


pytestmark = pytest.mark.kernel


def squared_slope_integrals(cable, q):
    """(N,) int |r_x|^2 dx by quadrature."""
    integrals = []
    for k, size in enumerate(cable.element_lengths):
        x, weight = fine_quadrature(size)
        shape = np.array([p.deriv()(x) for p in hermite(size)])
        r_x = shape.T @ np.concatenate([q[k], q[k + 1]])
        integrals.append(weight @ (r_x**2).sum(axis=1))
    return np.array(integrals)


@pytest.mark.parametrize("dim", [2, 3])
def test_length_constraint_is_the_change_of_the_integral_over_its_group(dim):
    state = random_state(21, 5, dim, MEASURES[0], n_bar=2)
    change = squared_slope_integrals(state.cable, state.q)
    change -= squared_slope_integrals(state.cable, state.cable.reference)
    expected = [change[:3].sum(), change[3:].sum()]
    np.testing.assert_allclose(values_of("length", state.cable, state.q), expected, rtol=1e-10)


def test_groups_are_contiguous_and_as_equal_as_possible():
    for number in (1, 5, 12):
        for groups in range(1, number + 1):
            group = straight_cable(number, 2, length_constraints=groups).group_of_element()
            sizes = np.bincount(group)
            assert np.all(np.diff(group) >= 0)
            assert len(sizes) == groups
            assert sizes.max() - sizes.min() <= 1


def test_nodal_constraint_is_the_squared_slope_less_one():
    cable = straight_cable(2, 2, "clamped")
    q = cable.reference.copy()
    q[1, 1], q[2, 1] = (0.6, 0.8), (3.0, 4.0)
    np.testing.assert_allclose(values_of("nodal inextensibility", cable, q), [0.0, 24.0], atol=1e-14)
    assert places_of("nodal inextensibility", cable) == ["slope of node b", "slope of node c"]


def test_pin_and_clamp_measure_the_distance_from_the_reference():
    pinned, clamped = straight_cable(2, 3, "pinned"), straight_cable(2, 3, "clamped")
    q = pinned.reference.copy()
    q[0, 0] += [1.0, 2.0, 3.0]
    q[0, 1] += [4.0, 5.0, 6.0]
    np.testing.assert_allclose(values_of("pin", pinned, q), [1, 2, 3])
    np.testing.assert_allclose(values_of("clamp", clamped, q), [1, 2, 3, 4, 5, 6])
    assert places_of("pin", straight_cable(2, 3, "pinned within"))[2] == "position z of node b"
    assert places_of("clamp", clamped)[4] == "slope y of node a"
    assert not places_of("pin", clamped) and not places_of("clamp", pinned)


def test_a_length_constraint_names_its_elements():
    assert places_of("length", straight_cable(5, 2, length_constraints=2)) == [
        "elements between nodes a and d",
        "elements between nodes d and f",
    ]


def test_a_cable_without_supports_and_length_constraints_has_nodal_ones_only():
    found = constraints_of_cable(straight_cable(3, 2, length_constraints=0))
    assert {name: rows.tolist() for name, rows in found.rows.items()} == {
        "nodal inextensibility": [0, 1, 2, 3]
    }


def test_a_guide_holds_the_slope_alone():
    guided = straight_cable(3, 2, "pinned and guided")
    numbers = {name: len(rows) for name, rows in constraints_of_cable(guided).rows.items()}
    assert numbers == {"length": 3, "nodal inextensibility": 3, "pin": 2, "guide": 2}
    q = guided.reference + np.array([[5.0, 5.0], [0.1, 0.2]])
    np.testing.assert_allclose(values_of("guide", guided, q), [0.1, 0.2])
