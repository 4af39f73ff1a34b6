"""CreateInextensibleCable mirrors GenerateBeamElementsAlongLine."""

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D

from exudyn_inext import CableShape
from exudyn_inext.items.cable_data import find_cable_item
from exudyn_inext.items.shape import check_shape

NATIVE = {"massPerLength": 2.0, "bendingStiffness": 3.0, "axialStiffness": 4.0}
PIN = {2: [True, True, False, False], 3: [True] * 3 + [False] * 3}


def item(mbs, cable):
    """The CableItem behind the created object."""
    return find_cable_item(mbs.GetObject(cable["elements"][0]))


def arc(elements, angle=2.0, radius=1.5):
    """Nodes of a circular arc: positions, slopes."""
    phi = np.linspace(0.3, 0.3 + angle, elements + 1)
    positions = radius * np.column_stack([np.cos(phi), np.sin(phi)])
    return CableShape(positions, np.column_stack([-np.sin(phi), np.cos(phi)]))


@pytest.mark.parametrize(("dimension", "end"), [(2, [1, 2, 0]), (3, [1, 2, -0.5])])
def test_result_has_the_keys_and_nodes_of_the_native_function(new_mbs, add_cable, dimension, end):
    native, ours = new_mbs(), new_mbs()
    element = (ObjectANCFCable2D if dimension == 2 else ObjectANCFCable)(**NATIVE)
    expected = GenerateBeamElementsAlongLine(
        native, [0.5, 1, 0], end, 7, element, groundConstraintsStart=PIN[dimension]
    )
    line = {"positionStart": [0.5, 1, 0], "positionEnd": end, "numberOfElements": 7}
    cable = add_cable(ours, **line, groundConstraintsStart=PIN[dimension])
    assert list(cable) == list(expected)
    assert list(map(int, cable["nodes"])) == list(map(int, expected["nodes"]))
    np.testing.assert_allclose(cable["nodePositions"], expected["nodePositions"], atol=1e-14)
    assert len(cable["constraintObjects"]) == len(expected["constraintObjects"]) == dimension
    assert len(cable["elements"]) == 1
    assert cable["loads"] == []
    for node in cable["nodes"]:
        assert ours.GetNode(node)["nodeType"] == native.GetNode(node)["nodeType"]
        np.testing.assert_allclose(
            ours.GetNodeParameter(node, "referenceCoordinates"),
            native.GetNodeParameter(node, "referenceCoordinates"),
            atol=1e-14,
        )


@pytest.mark.parametrize(
    ("changes", "dimension"),
    [
        ({}, 2),
        ({"dimension": 3}, 3),
        ({"dimension": 2}, 2),
        ({"gravity": [0, 0, -9.81]}, 3),
        ({"positionEnd": [1, 0, 1]}, 3),
        ({"positionStart": [0, 0], "positionEnd": [1, 1]}, 2),
        ({"shape": CableShape.Line([0, 0], [1, 0], 2, velocityEnd=[0, 0, 1])}, 3),
        ({"shape": arc(4)}, 2),
    ],
)
def test_dimension_follows_from_the_input_unless_stated(mbs, add_cable, changes, dimension):
    cable = add_cable(mbs, **changes)
    name = {2: "Point2DSlope1", 3: "PointSlope1"}[dimension]
    assert {mbs.GetNode(node)["nodeType"] for node in cable["nodes"]} == {name}
    assert item(mbs, cable).cable.dimension == dimension


@pytest.mark.parametrize("native", [ObjectANCFCable2D, ObjectANCFCable])
def test_native_templates_give_mass_and_bending_stiffness(mbs, add_cable, native):
    section = item(mbs, add_cable(mbs, beamTemplate=native(**NATIVE))).cable.section
    assert (section.mass_per_length, section.bending_stiffness) == (2.0, 3.0)


def test_an_oblique_line_has_equal_elements_and_its_direction_as_slope(mbs, add_cable):
    cable = add_cable(mbs, positionStart=[1, 1, 1], positionEnd=[3, 2, 3], numberOfElements=4)
    model = item(mbs, cable).cable
    np.testing.assert_allclose(model.element_lengths, 0.75, rtol=1e-14)
    np.testing.assert_allclose(model.reference[:, 1], np.tile([2, 1, 2], (5, 1)) / 3, atol=1e-15)
    np.testing.assert_allclose(model.reference[-1, 0], [3, 2, 3])


def test_a_shape_gives_positions_slopes_and_velocities_to_the_nodes(mbs, add_cable):
    shape = arc(5)
    velocities, rates = np.full((6, 2), 0.25), np.zeros((6, 2))
    cable = add_cable(
        mbs,
        shape=CableShape(shape.positions, shape.slopes, None, velocities, rates),
        gravity=[0, 0, 0],
    )
    mbs.Assemble()
    for k, node in enumerate(cable["nodes"]):
        reference = mbs.GetNodeParameter(node, "referenceCoordinates")
        np.testing.assert_array_equal(reference, [*shape.positions[k], *shape.slopes[k]])
        velocity = mbs.GetNodeOutput(
            node, exudyn.OutputVariableType.Velocity, exudyn.ConfigurationType.Initial
        )
        np.testing.assert_array_equal(velocity, [0.25, 0.25, 0])


def test_computed_element_lengths_approach_the_arc_length_with_fourth_order():
    errors = [abs(check_shape(arc(n)).lengths.sum() - 3.0) for n in (4, 8, 16)]
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[1]) > 3.8
    assert np.log2(errors[1] / errors[2]) > 3.8


def test_given_element_lengths_are_kept(mbs, add_cable):
    shape = arc(8)
    cable = add_cable(mbs, shape=CableShape(shape.positions, shape.slopes, 3.0 / 8))
    np.testing.assert_array_equal(item(mbs, cable).cable.element_lengths, 3.0 / 8)


def test_drawing_is_one_finite_line_through_the_nodes(mbs, add_cable, solve, coordinates):
    cable = add_cable(mbs, shape=arc(3))
    mbs.Assemble()
    solve(mbs, 0.05)
    data = mbs.systemData
    data.SetODE2Coordinates(data.GetODE2Coordinates(), exudyn.ConfigurationType.Visualization)
    draw = mbs.GetObject(cable["elements"][0])["VgraphicsDataUserFunction"]["function"]
    (line,) = draw(mbs, cable["elements"][0])
    points = np.reshape(line["data"], (-1, 3))
    q = coordinates(mbs, cable["nodes"])
    assert line["type"] == "Line"
    assert np.isfinite(points).all()
    per_element = len(points) // 3
    np.testing.assert_allclose(points[::per_element, :2], q[:-1, 0], atol=1e-14)
    np.testing.assert_allclose(points[per_element - 1 :: per_element, :2], q[1:, 0], atol=1e-14)
    drawn = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert drawn == pytest.approx(3.0, rel=5e-3)
