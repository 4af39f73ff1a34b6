"""What a cable is: checks of numbers, groups of elements, places on elements, frozen data."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from exudyn_inext.cable.attached import Drag, PointMass, place_on_elements
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.link import Link, rest
from exudyn_inext.checks import require_positive
from exudyn_inext.errors import InputError
from tests.cables import straight_cable

pytestmark = pytest.mark.kernel


@pytest.mark.parametrize(
    "value", [0, 0.0, -1.0, np.inf, -np.inf, np.nan, True, "1", None, 1j, [1.0]], ids=repr
)
def test_what_is_no_positive_number_is_refused(value):
    with pytest.raises(InputError, match=r"length = .*: must be a finite number > 0; check value and units"):
        require_positive("length", value)


@pytest.mark.parametrize("value", [1, 0.5, 1e-30, np.float32(2.0), np.int64(3)], ids=repr)
def test_positive_numbers_become_floats(value):
    found = require_positive("length", value)
    assert type(found) is float and found == value


def test_groups_of_elements_are_as_equal_as_possible():
    groups = {0: [-1] * 5, 1: [0] * 5, 2: [0, 0, 0, 1, 1], 3: [0, 0, 1, 1, 2], 5: [0, 1, 2, 3, 4]}
    for number, expected in groups.items():
        np.testing.assert_array_equal(
            straight_cable(5, 2, length_constraints=number).group_of_element(), expected
        )


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        (0.0, (0, 0.0)),
        (-0.1, (0, 0.0)),
        (0.25, (0, 0.25)),
        (1.0, (0, 1.0)),
        (1.5, (1, 0.25)),
        (3.0, (1, 1.0)),
        (6.0, (2, 0.75)),
        (7.1, (2, 1.0)),
    ],
)
def test_points_are_found_on_their_elements_and_pulled_onto_the_cable(point, expected):
    lengths = np.array([1.0, 2.0, 4.0])
    assert place_on_elements(point, lengths) == pytest.approx(expected)


def test_a_chain_knows_the_shape_of_its_coordinates():
    assert build_chain(straight_cable(4, 3)).shape == straight_cable(4, 3).reference.shape


def test_a_law_of_drag_is_completed_with_a_flow_in_the_plane():
    np.testing.assert_array_equal(Drag(0.7, 0.2, (0.5, -1.0)).law(), [[0.7, 0.2, 0.0], [0.5, -1.0, 0.0]])


def test_a_resting_anchor_rests():
    anchor = rest(np.array([1.0, 2.0]))
    np.testing.assert_array_equal(anchor.at(3.7), [[1.0, 2.0], [0.0, 0.0], [0.0, 0.0]])
    assert anchor.rests and anchor.is_pure


def test_cables_and_what_they_carry_cannot_be_changed_and_are_only_equal_to_themselves():
    cable, anchor = straight_cable(2, 2), rest(np.zeros(2))
    link = Link("rod", (0,), np.ones((1, 2)), anchor, np.ones(2))
    for data, name in (
        (cable, "length_constraints"),
        (cable.section, "bending_stiffness"),
        (PointMass(0.1, 0.2), "mass"),
        (Drag(0.1, 0.2, (0.0, 0.0)), "normal"),
        (link, "length"),
        (anchor, "rests"),
    ):
        with pytest.raises(FrozenInstanceError):
            setattr(data, name, 1.0)
    assert cable == cable and cable != straight_cable(2, 2)
    assert link != Link("rod", (0,), np.ones((1, 2)), anchor, np.ones(2))
    assert anchor != replace(anchor)
    assert link.length == np.inf and link.follows == -1
