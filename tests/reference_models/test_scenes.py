"""Scenes are plain data that agrees with the reference computation's own parameters."""

import dataclasses
import json
import math
from importlib.resources import files

import numpy as np
import pytest

from exudyn_inext.errors import InputError
from reference_models.data import reference_trajectory
from reference_models.scenes import SCENES, Cable, Line, Pin, Round, load_scene

PENDULUM = load_scene("planar_pendulum")
SPATIAL = load_scene("spatial_pendulum")
PENDULUMS = pytest.mark.parametrize("scene", [PENDULUM, SPATIAL], ids=lambda scene: scene.name)


@pytest.fixture
def parameters(scene):
    text = files("reference_models.data").joinpath(f"{scene.name}.json").read_text("utf-8")
    return json.loads(text)["parameters"]


@PENDULUMS
def test_section_of_a_pendulum_is_that_of_the_reference(scene, parameters):
    section = scene.cable.section
    derived = {
        "EA": section.axial_stiffness,
        "EI": section.bending_stiffness,
        "rhoA": section.mass_per_length,
    }
    for name, value in derived.items():
        assert value == pytest.approx(parameters[name], rel=1e-12), name


@PENDULUMS
def test_length_and_gravity_of_a_pendulum_are_those_of_the_reference(scene, parameters):
    assert scene.cable.length == parameters["L"]
    down = (0.0, -1.0, 0.0) if scene.is_planar else (0.0, 0.0, -1.0)
    assert scene.gravity == tuple(parameters["g"] * component for component in down)


def test_reference_starts_straight_along_x_and_falls_along_minus_y():
    reference = reference_trajectory(PENDULUM)
    np.testing.assert_allclose(reference.positions[0], [1.8, 0.0, 0.0], atol=1e-12)
    assert reference.times[[0, -1]] == pytest.approx([0.0, PENDULUM.end_time])
    assert reference.positions[20, 1] < -0.1
    assert np.all(reference.positions[:, 2] == 0.0)


def test_spatial_reference_starts_along_x_with_the_velocity_of_the_scene_and_falls_along_minus_z():
    reference = reference_trajectory(SPATIAL)
    np.testing.assert_allclose(reference.positions[0], [1.8, 0.0, 0.0], atol=1e-12)
    assert reference.times[[0, -1]] == pytest.approx([0.0, SPATIAL.end_time])
    time, step = reference.times[1], reference.positions[1] - reference.positions[0]
    assert step[1] / time == pytest.approx(SPATIAL.end_velocity[1], rel=1e-3)
    assert 2 * step[2] / time**2 == pytest.approx(SPATIAL.gravity[2], rel=1e-3)
    assert SPATIAL.end_velocity == (0.0, 3.0, 0.0)


@PENDULUMS
def test_a_reference_never_leaves_the_ball_of_the_cable_length(scene):
    reference = reference_trajectory(scene)
    distance = np.linalg.norm(reference.positions, axis=1)
    assert distance.max() <= scene.cable.length + scene.reference.uncertainty


def test_both_pendulums_are_one_cable():
    assert SPATIAL.cable == PENDULUM.cable
    assert PENDULUM.is_planar and not SPATIAL.is_planar


def test_every_scene_is_found_under_its_name():
    assert {"planar_pendulum", "spatial_pendulum"} <= set(SCENES)
    assert all(load_scene(name).name == name for name in SCENES)


def test_an_unknown_scene_names_those_that_exist():
    with pytest.raises(InputError, match=r"'no_such'.*planar_pendulum"):
        load_scene("no_such")


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", ["radius", "density", "youngs_modulus"])
def test_a_section_refuses_impossible_values(name, value):
    good = {"radius": 1e-3, "density": 1e3, "youngs_modulus": 1e9}
    with pytest.raises(InputError, match=f"{name} = "):
        Round(**(good | {name: value}))


def test_lengths_supports_and_directions_are_checked():
    with pytest.raises(InputError, match="length = -1"):
        Cable(length=-1.0, section=PENDULUM.cable.section)
    with pytest.raises(InputError, match=r"1\.5 must be a fraction"):
        Pin(at=1.5)
    with pytest.raises(InputError, match=r"norm 2\.0"):
        Line(direction=(2.0, 0.0, 0.0))
    with pytest.raises(InputError, match="observes no point"):
        dataclasses.replace(PENDULUM, observe={})


def test_a_scene_without_reference_says_so():
    with pytest.raises(InputError, match="has no reference"):
        reference_trajectory(dataclasses.replace(PENDULUM, reference=None))


def test_a_scene_cannot_be_changed_by_accident():
    with pytest.raises(dataclasses.FrozenInstanceError):
        PENDULUM.end_time = 1.0
    with pytest.raises(TypeError):
        PENDULUM.observe["tip"] = 0.5
