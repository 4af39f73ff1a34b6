"""Power line: data, the static start of the native model, and the motion after the ice has gone."""

import dataclasses
import math

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import SensorNode

from exudyn_inext.errors import InputError
from reference_models.conventional.equilibrium import settle
from reference_models.conventional.model import build, build_for_explicit
from reference_models.conventional.settings import Explicit, Implicit
from reference_models.conventional.solve import solve
from reference_models.conventional.zhai import zhai_case
from reference_models.model import sensor_trajectory
from reference_models.scenes import Hanger, Parabolas, PointForce, Sine, load_scene

LINE = load_scene("power_line")
BARE = dataclasses.replace(LINE, start_loads=())
SHORT = dataclasses.replace(LINE, end_time=0.2)
WIDTH, LENGTH = 3.322, LINE.cable.length
WEIGHT = LINE.cable.section.mass_per_length * LENGTH * 9.81


def rest_positions(model):
    """(n + 1, 2) nodal positions [m] in the initial state."""
    output, configuration = exudyn.OutputVariableType.Position, exudyn.ConfigurationType.Initial
    return np.array([model.mbs.GetNodeOutput(node, output, configuration)[:2] for node in model.nodes])


def spring_forces(model):
    """Force [N] on the line of the two pins (2,) each and of the hanger (2,), as springs."""
    positions, stiffness = rest_positions(model), 3e6
    pins = [-stiffness * (positions[k] - target) for k, target in ((0, (0, 0)), (-1, (2 * WIDTH, 0)))]
    rod = positions[len(positions) // 2] - (WIDTH, 0.1)
    length = np.linalg.norm(rod)
    return [*pins, -stiffness * (length - 0.1) * rod / length]


def test_the_sag_is_that_of_equation_40():
    assert LINE.cable.shape.sag == pytest.approx(math.sqrt(3 * (LENGTH - 2 * WIDTH) * WIDTH / 16))
    assert LINE.cable.shape.end == (2 * WIDTH, 0.0, 0.0)


def test_the_parabola_is_parametrised_by_its_arc_length():
    positions, slopes = LINE.cable.nodes(400)
    chords = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    assert np.ptp(chords) < 1e-6 * chords.mean()
    assert chords.sum() == pytest.approx(LENGTH, rel=1e-4)
    np.testing.assert_allclose(
        positions[[100, 200, 300], 1], [-LINE.cable.shape.sag, 0, -LINE.cable.shape.sag]
    )
    directions = np.diff(positions, axis=0)[:199] / chords[:199, None]
    mean_slopes = 0.5 * (slopes[:199] + slopes[1:200])
    np.testing.assert_allclose(directions, mean_slopes, atol=1e-5)


@pytest.mark.parametrize("quadrature", ["full", "reduced", "lobatto"])
@pytest.mark.parametrize("elements", [8, 20, 40])
def test_the_bare_line_hangs_symmetrically_near_the_parabola(elements, quadrature):
    positions = rest_positions(build(BARE, elements, quadrature))
    middle, quarter = elements // 2, elements // 4
    np.testing.assert_allclose(positions[middle], [WIDTH, 0.0], atol=1e-6)
    np.testing.assert_allclose(positions[:, 1], positions[::-1, 1], atol=1e-6)
    assert positions[quarter, 1] == pytest.approx(-LINE.cable.shape.sag, rel=0.05)


def test_ice_pulls_its_span_down_the_other_one_up_and_the_hanger_towards_itself():
    bare, iced = (rest_positions(build(scene, 20, "lobatto")) for scene in (BARE, LINE))
    assert iced[5, 1] < bare[5, 1] - 0.04
    assert iced[15, 1] > bare[15, 1] + 0.04
    assert iced[10, 0] < bare[10, 0] - 0.01
    assert math.dist(iced[10], (WIDTH, 0.1)) == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("scene, load", [(BARE, WEIGHT), (LINE, WEIGHT + 1.162)], ids=["bare", "iced"])
def test_pins_and_hanger_carry_weight_and_ice(scene, load):
    first, last, hanger = spring_forces(build_for_explicit(scene, 20, "lobatto"))
    assert first[1] + last[1] + hanger[1] == pytest.approx(load, rel=1e-3)
    assert first[0] + last[0] + hanger[0] == pytest.approx(0.0, abs=1e-3 * load)
    assert first[0] < 0 < hanger[1]


def test_the_static_sag_converges_under_refinement():
    sags = [rest_positions(build(LINE, n, "full"))[n // 4, 1] for n in (20, 40, 80)]
    assert abs(sags[1] - sags[2]) < 0.1 * abs(sags[0] - sags[1])
    assert rest_positions(build(LINE, 20, "lobatto"))[5, 1] == pytest.approx(sags[2], abs=1e-4)


def test_with_the_ice_left_on_nothing_moves():
    scene = dataclasses.replace(SHORT, loads=LINE.start_loads, start_loads=())
    positions = solve(build(scene, 12, "lobatto"), Implicit(5e-3)).positions
    assert np.ptp(positions, axis=0).max() < 1e-5


def test_after_shedding_the_relieved_span_rises_and_the_end_turns():
    model = build(SHORT, 12, "lobatto")
    end = {"nodeNumber": model.nodes[-1], "outputVariableType": exudyn.OutputVariableType.Coordinates}
    sensor = model.mbs.AddSensor(SensorNode(storeInternal=True, **end))
    initial = exudyn.ConfigurationType.Initial
    equilibrium = model.mbs.systemData.GetODE2Coordinates(initial)
    model.mbs.Assemble()
    model.mbs.systemData.SetODE2Coordinates(equilibrium, initial)
    relieved = solve(model, Implicit(2e-3)).positions
    other = sensor_trajectory(model, "P2").positions
    stored = model.mbs.GetSensorStoredData(sensor)
    times = stored[:, 0]
    slopes = stored[:, 3:] + model.mbs.GetNodeParameter(end["nodeNumber"], "referenceCoordinates")[2:]
    assert relieved[-1, 1] > relieved[0, 1] + 0.01
    assert other[-1, 1] < other[0, 1] - 0.005
    assert times[-1] == pytest.approx(SHORT.end_time)
    np.testing.assert_allclose(np.linalg.norm(slopes, axis=1), 1.0, atol=1e-3)
    assert np.degrees(np.ptp(np.arctan2(slopes[:, 1], slopes[:, 0]))) > 0.5


def test_springs_for_explicit_integrators_change_little():
    implicit = solve(build(SHORT, 12, "lobatto"), Implicit(5e-4))
    verlet = solve(build_for_explicit(SHORT, 12, "lobatto"), Explicit(1.5e-5))
    zhai = zhai_case(SHORT, 12, 1.5e-5, quadrature="lobatto").prepare()()
    np.testing.assert_allclose(verlet.positions, implicit.positions, atol=2e-4)
    np.testing.assert_allclose(zhai.positions, implicit.positions, atol=2e-4)


def test_a_load_with_a_history_rests_at_its_initial_value_and_moves_then():
    shake = PointForce(at=0.25, force=(0.0, 1.0, 0.0), history=Sine(angular_frequency=20.0))
    scene = dataclasses.replace(SHORT, start_loads=(), loads=(shake,))
    positions = solve(build(scene, 8, "lobatto"), Implicit(5e-3)).positions
    assert positions[0, 1] == pytest.approx(rest_positions(build(BARE, 8, "lobatto"))[2, 1], abs=1e-6)
    assert positions[:, 1].max() > positions[0, 1] + 0.005
    assert PointForce(at=0.25, force=(0.0, 1.0, 0.0)).value(7.0) == (0.0, 1.0, 0.0)


def test_impossible_power_lines_are_refused():
    with pytest.raises(InputError, match=r"hanger at 0\.5 is 0\.05 m long, .* it is 0\.1"):
        dataclasses.replace(LINE, supports=(Hanger(at=0.5, length=0.05, anchor=(WIDTH, 0.1, 0.0)),))
    with pytest.raises(InputError, match=r"length = 6\.0 m is too short for 2 spans"):
        dataclasses.replace(LINE.cable, length=6.0)
    with pytest.raises(InputError, match="set starts_from_equilibrium=True"):
        dataclasses.replace(LINE, starts_from_equilibrium=False)
    with pytest.raises(InputError, match="needs a free end"):
        dataclasses.replace(LINE, end_velocity=(0.0, 1.0, 0.0))
    with pytest.raises(InputError, match="sag = 0"):
        Parabolas(width=1.0, sag=0.0)


def test_a_search_that_finds_nothing_says_so(monkeypatch):
    model = build(LINE, 8, "lobatto")
    monkeypatch.setattr("reference_models.conventional.equilibrium._solve", lambda *_: False)
    with pytest.raises(InputError, match="no equilibrium found from the initial shape with 8 elements"):
        settle(model)
