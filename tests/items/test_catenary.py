"""Cables that hang between two points: the equation of the catenary, and equilibria."""

import re

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import Force, MarkerNodePosition
from scipy.integrate import solve_ivp

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    DivergenceError,
    ExplicitSettings,
    InextensibleCable,
    InputError,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.items.catenary import hanging_curve
from reference_models.model import quiet_settings, silence

CASES = {
    "level": ([0, 0, 0], [2, 0, 0], 2.5, [0, -9.81, 0]),
    "nearly straight": ([0, 0, 0], [2, 1, 0], np.sqrt(5.0) * (1 + 1e-9), [0, -1, 0]),
    "slack": ([0, 0, 0], [0.1, 0, 0], 10.0, [0, -1, 0]),
    "steep": ([0, 0, 0], [0.01, 3, 0], 3.2, [0, -1, 0]),
    "downhill in space": ([1, 2, 3], [3, 1, -1], 6.0, [0, 0, -9.81]),
}


@pytest.mark.parametrize("case", CASES)
def test_it_joins_both_ends_and_bends_under_its_weight(case):
    """dsigma/ds is constant: so is the horizontal tension, and the vertical one carries the weight."""
    start, end, length, gravity = CASES[case]
    up = -np.array(gravity) / np.linalg.norm(gravity)
    ends = np.array([start, end], dtype=float)
    positions, slopes = hanging_curve(ends[1] - ends[0], length, up, np.linspace(0.0, length, 41))
    np.testing.assert_allclose(positions[[0, -1]], ends - ends[0], atol=1e-9 * length)
    vertical = slopes @ up
    horizontal = np.linalg.norm(slopes - np.outer(vertical, up), axis=1)
    sigma = vertical / horizontal
    np.testing.assert_allclose(np.diff(sigma), np.diff(sigma).mean(), rtol=1e-6)
    rate = np.diff(sigma).mean() * 40 / length

    def tangent(s, _):
        return np.array([1.0, sigma[0] + rate * s]) / np.hypot(1.0, sigma[0] + rate * s)

    found = solve_ivp(tangent, (0.0, length), [0.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]
    span = np.array(end, dtype=float) - start
    expected = [np.linalg.norm(span - span @ up * up), span @ up]
    np.testing.assert_allclose(found, expected, atol=1e-6 * length)


@pytest.mark.filterwarnings("ignore:.*do not follow the bend")
@pytest.mark.parametrize("elements", [2, 10, 40])
@pytest.mark.parametrize("case", ["level", "slack", "steep", "downhill in space"])
def test_a_cable_of_few_elements_hangs_in_it_without_a_correction(case, elements):
    """Slack and steep ones, too: the length is as given, ends stay, and a run starts from it as it is."""
    start, end, length, gravity = CASES[case]
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=1e-2)
    shape = CableShape.Catenary(start, end, length, elements, gravity)
    cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=section, gravity=gravity)
    assert sum(shape.elementLengths * np.ones(elements)) == pytest.approx(length, rel=1e-12)
    mbs.Assemble()
    report = SolveExplicit(mbs, quiet_settings(1e-3, 1))
    ends = [cable["nodePositions"][k] for k in (0, -1)]
    np.testing.assert_allclose(ends, [start, end], rtol=0.0, atol=1e-12)
    assert max(report["startCorrections"][0].position, report["startCorrections"][0].slope) < 1e-9


def test_nodes_far_from_the_catenary_are_named_and_more_elements_bring_them_there():
    """In a loop that is 5 cm wide and 60 cm deep, nodes lie 21 cm off."""
    says = r"numberOfElements = 16: elements of 0\.125 m do not follow the bend .* up to 0\.21 m off"
    with pytest.warns(UserWarning, match=says):
        CableShape.Catenary([0, 0], [0.05, 0.8], 2.0, 16)
    shape = CableShape.Catenary([0, 0], [0.05, 0.8], 2.0, 512)
    curve = hanging_curve(np.array([0.05, 0.8, 0]), 2.0, np.array([0.0, 1, 0]), np.linspace(0, 2, 513))[0]
    np.testing.assert_allclose(shape.positions, curve, atol=1e-3)


def test_nodes_converge_to_the_catenary():
    start, end, length, gravity = CASES["level"]
    at = {number: np.linspace(0.0, length, number + 1) for number in (10, 20)}
    ends, up = [np.array(end, dtype=float) for end in (start, end)], np.array([0.0, 1.0, 0.0])
    curves = {n: hanging_curve(ends[1] - ends[0], length, up, at[n])[0] for n in at}
    shapes = {n: CableShape.Catenary(start, end, length, n, gravity).positions for n in at}
    errors = [np.abs(shapes[n] - curves[n]).max() for n in at]
    assert 0.0 < 8.0 * errors[1] < errors[0] < 1e-4


def test_it_hangs_far_from_the_origin_as_beside_it():
    """As in coordinates of a map."""
    far = np.array([4e5, 5.3e6, 0.0])
    beside = CableShape.Catenary([0, 0], [1, 0.2], 1.3, 12)
    shape = CableShape.Catenary(far, np.add(far, [1, 0.2, 0]), 1.3, 12)
    np.testing.assert_allclose(shape.positions - far, beside.positions, atol=1e-8)
    np.testing.assert_allclose(shape.slopes, beside.slopes, atol=1e-8)


@pytest.mark.filterwarnings("ignore:.*do not follow the bend")
@pytest.mark.parametrize("elements", [8, 64, 65, 256])
@pytest.mark.parametrize("length", [1e-3, 0.1, 1.0, 1e3])
def test_it_hangs_in_the_same_shape_at_any_size(length, elements):
    """Also in a fold that no element resolves, 1e-3 of the length wide."""
    ends = np.array([[0.0, 0.0], [1e-3, 0.3]])
    shape = CableShape.Catenary(*(length * ends), length, elements)
    in_metres = CableShape.Catenary(*ends, 1.0, elements)
    np.testing.assert_allclose(shape.positions / length, in_metres.positions, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(shape.slopes, in_metres.slopes, rtol=0.0, atol=1e-6)


def test_a_straight_one_is_a_line():
    shape = CableShape.Catenary([0, 0], [0, -2], 2.0, 4)
    np.testing.assert_allclose(shape.positions[:, 1], [0, -0.5, -1, -1.5, -2])
    np.testing.assert_allclose(shape.slopes, [[0, -1, 0]] * 5)


def test_a_cable_that_hardly_bends_rests_in_it():
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    shape = CableShape.Catenary([0, 0], [2, 0.5], 3.0, 32)
    pinned = {f"groundConstraints{end}": [True, True, False, False] for end in ("Start", "End")}
    section = InextensibleCable(massPerLength=1.0, bendingStiffness=1e-6)
    cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=section, gravity=[0, -9.81, 0], **pinned)
    mbs.Assemble()
    with silence():
        SolveEquilibrium(mbs)
    kind = exudyn.OutputVariableType.Position
    found = np.array([mbs.GetNodeOutput(node, kind) for node in cable["nodes"]])
    np.testing.assert_allclose(found, shape.positions, atol=2e-4)


@pytest.mark.parametrize(
    ("end", "length", "message"),
    [
        ([2, 0], 1.9, r"length = 1\.9 m is less than 2 m, the distance"),
        ([0, 1], 2.0, r"one above the other \(horizontal distance 0 m, at least 2e-06 m\).*move one end"),
        ([2, 0], -1.0, r"length \[m\] = -1"),
    ],
)
def test_what_cannot_hang_is_refused(end, length, message):
    with pytest.raises(InputError, match=message):
        CableShape.Catenary([0, 0], end, length, 8)
    with pytest.raises(InputError, match=r"elements of 1 m are too long .*use more elements"):
        CableShape.Catenary([0, 0], [0.01, 0], 1.0, 1)
    with pytest.raises(InputError, match="gravity"):
        CableShape.Catenary([0, 0], [1, 0], 2.0, 8, gravity=[0, 0])


@pytest.mark.parametrize(("sag", "slope", "angle"), [(0.8, [1, 0], 54), (0.8, [-1, 0], 169)])
def test_a_sagging_shape_with_other_tangents_names_them(sag, slope, angle):
    x = np.linspace(0.0, 2.0, 9)
    points = np.column_stack([x, -sag * (1.0 - (x - 1.0) ** 2)])
    shape = CableShape(points, np.tile(slope, (9, 1)))
    says = rf"slopes\[\d\] = .* is no tangent of the shape: it is {angle} degrees off .*Catenary"
    section = InextensibleCable(massPerLength=1.0, bendingStiffness=1e-2)
    with pytest.raises(InputError, match=says):
        CreateInextensibleCable(exudyn.SystemContainer().AddSystem(), shape=shape, beamTemplate=section)


@pytest.mark.parametrize("step", [None, 1e-4])
def test_a_run_that_diverges_at_the_automatic_step_names_it(step):
    """A cable that is hit much harder than its weight, from one step to the next."""
    mbs = exudyn.SystemContainer().AddSystem()
    pinned = {f"groundConstraints{end}": [True, True, False, False] for end in ("Start", "End")}
    shape = CableShape.Catenary([0, 0], [1, 0], 1.2, 8)
    section = InextensibleCable(massPerLength=0.3, bendingStiffness=0.05)
    nodes = CreateInextensibleCable(mbs, shape=shape, beamTemplate=section, **pinned)["nodes"]
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[4]))
    mbs.AddLoad(Force(markerNumber=marker, loadVectorUserFunction=lambda m, t, f: [0, 1e5 * (t > 0.05), 0]))
    mbs.Assemble()
    settings = ExplicitSettings(stepSize=step, rejectSteps=False)
    with silence(), pytest.raises(DivergenceError) as caught:
        SolveExplicit(mbs, quiet_settings(0.1, 10), settings)
    named = re.search(
        r"automatic step of this run was \S+ s, decided by .*: a stepSize has", str(caught.value)
    )
    assert bool(named) == (step is None)
