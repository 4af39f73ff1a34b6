"""Rigid links against closed forms, against the pendulums' references, and what they refuse."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import jn_zeros

from exudyn_inext import DivergenceError
from exudyn_inext.errors import InputError
from reference_models.peers import rigid_links
from reference_models.peers.rigid_links import (
    RigidLinks,
    build,
    has_integrator,
    largest_frequency,
    largest_step,
    rigid_links_case,
)
from reference_models.scenes import Clamp, Section, load_scene
from reference_models.trajectory import Case, Trajectory
from studies.harness.reference import distance_to_reference, from_data

mujoco = pytest.importorskip("mujoco", reason="pip install 'exudyn_inext[peers]'")

PLANAR, SPATIAL = load_scene("planar_pendulum"), load_scene("spatial_pendulum")
WEIGHTLESS = replace(PLANAR, gravity=(0.0, 0.0, 0.0))
CLAMPED = replace(WEIGHTLESS, supports=(Clamp(at=0.0),))


def path(scene, chain):
    return rigid_links_case(scene, chain).prepare()()()


def mass_of(model, data):
    return np.column_stack([_times_mass(model, data, unit) for unit in np.eye(model.nv)])


def _times_mass(model, data, vector):
    result = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, result, vector)
    return result


def frequencies(model, data, stiffness):
    return np.sqrt(np.abs(eigh(stiffness, mass_of(model, data), eigvals_only=True)))


@pytest.mark.parametrize("links", [1, 3, 10])
@pytest.mark.parametrize("scene", [CLAMPED, replace(CLAMPED, gravity=(0.0, 0.0, -1e-9))], ids=["2D", "3D"])
def test_a_cantilever_bends_as_the_trapezoidal_rule_says(scene, links):
    model, data = build(scene, RigidLinks(links, 1e-3))
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, jacobian, None, 0)
    deflection = jacobian[1] ** 2 @ (1.0 / np.ravel(model.jnt_stiffness))
    exact = scene.cable.length**3 / (3.0 * scene.cable.section.bending_stiffness)
    assert deflection == pytest.approx(exact * (1.0 + 0.5 / links**2), rel=1e-12)


@pytest.mark.parametrize("links", [1, 7])
def test_a_straight_chain_turns_about_its_pin_like_a_rod(links):
    section = PLANAR.cable.section
    turning = np.eye(links)[0]
    inertia = turning @ mass_of(*build(PLANAR, RigidLinks(links, 1e-3))) @ turning
    assert inertia == pytest.approx(section.mass_per_length * PLANAR.cable.length**3 / 3.0, rel=1e-12)


@pytest.mark.parametrize(("scene", "root"), [(CLAMPED, 1.875104), (WEIGHTLESS, 3.926602)])
def test_the_first_bending_frequency_of_beams_is_found_with_second_order(scene, root, known_answer):
    section, errors = scene.cable.section, []
    exact = (root / scene.cable.length) ** 2 * math.sqrt(section.bending_stiffness / section.mass_per_length)
    for links in (20, 40):
        model, data = build(scene, RigidLinks(links, 1e-3))
        found = frequencies(model, data, np.diag(np.ravel(model.jnt_stiffness)))
        errors.append(abs(found[found > 0.1 * exact][0] / exact - 1.0))
    order = math.log2(errors[0] / errors[1])
    known_answer("rigid links, first frequency of a beam", errors[1], order)
    assert errors[1] < 1e-3 and order > 1.9


def test_a_chain_without_bending_stiffness_swings_like_a_hanging_rope(known_answer):
    section = Section(PLANAR.cable.section.mass_per_length, 1e-9, 1.0)
    downwards = replace(PLANAR.cable.shape, direction=(0.0, -1.0, 0.0))
    scene = replace(PLANAR, cable=replace(PLANAR.cable, section=section, shape=downwards))
    exact = 0.5 * jn_zeros(0, 3) * math.sqrt(9.81 / scene.cable.length)
    errors = []
    for links in (20, 40):
        model, data = build(scene, RigidLinks(links, 1e-3))
        found = frequencies(model, data, stiffness_of(model, data))
        errors.append(np.max(np.abs(found[:3] / exact - 1.0)))
    order = math.log2(errors[0] / errors[1])
    known_answer("rigid links, frequencies of a hanging rope", errors[1], order)
    assert errors[1] < 5e-3 and order > 1.8


def stiffness_of(model, data, move=1e-6):
    """Change of the joints' forces with the joints, about the initial state."""
    columns = []
    for unit in np.eye(model.nv):
        forces = []
        for sign in (1.0, -1.0):
            data.qpos[:] = sign * move * unit
            mujoco.mj_forward(model, data)
            forces.append(data.qfrc_bias - data.qfrc_passive)
        columns.append((forces[0] - forces[1]) / (2.0 * move))
    data.qpos[:] = 0.0
    mujoco.mj_forward(model, data)
    stiffness = np.column_stack(columns)
    return 0.5 * (stiffness + stiffness.T)


@pytest.mark.parametrize("scene", [PLANAR, SPATIAL], ids=lambda scene: scene.name)
def test_the_pendulums_are_approached_with_second_order(scene):
    brief, reference = replace(scene, end_time=1.0), from_data(scene).trajectory
    errors = [
        distance_to_reference(path(brief, RigidLinks(links, h)), reference).maximum
        for links, h in ((10, 5e-3), (20, 1.25e-3))
    ]
    assert errors[1] < 2e-3
    assert 1.8 < math.log2(errors[0] / errors[1]) < 2.2


def test_universal_joints_move_as_hinges_do_in_a_plane():
    brief = replace(PLANAR, end_time=0.5)
    plane = path(brief, RigidLinks(8, 2.5e-3))
    space = path(replace(brief, gravity=(0.0, -9.81, 1e-300)), RigidLinks(8, 2.5e-3))
    np.testing.assert_allclose(space.positions, plane.positions, atol=1e-5)


def test_the_motion_starts_with_the_velocity_of_the_scene():
    model, data = build(SPATIAL, RigidLinks(7, 1e-3))
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, jacobian, None, 0)
    np.testing.assert_allclose(jacobian @ data.qvel, SPATIAL.end_velocity, atol=1e-12)
    assert np.count_nonzero(data.qvel) == 1


@pytest.mark.parametrize("integrator", ["RK4", "Euler", "implicitfast", "implicit"])
def test_the_stability_limit_is_where_disturbances_begin_to_grow(integrator):
    chain = RigidLinks(10, 1e-3, integrator)
    limit = largest_step(WEIGHTLESS, chain)
    model, data = build(WEIGHTLESS, chain)
    assert largest_frequency(model, data) > 0.0
    growth = {}
    for part in (0.98, 1.04):
        model, data = build(WEIGHTLESS, chain)
        model.opt.timestep = part * limit
        data.qpos[:] = 1e-8 * (-1.0) ** np.arange(model.nv)
        mujoco.mj_step(model, data, 25)
        growth[part] = np.abs(data.qpos).max() / 1e-8
    assert growth[0.98] < 20.0 and growth[1.04] > 100.0


def test_of_other_integrators_no_limit_is_known():
    if not has_integrator("discrete"):
        pytest.skip(f"MuJoCo {mujoco.__version__} has no integrator 'discrete'")
    assert largest_step(WEIGHTLESS, RigidLinks(5, 1e-3, "discrete")) == math.inf


def test_a_divergence_is_told_and_leaves_no_file(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DivergenceError, match=r"MuJoCo warns of BADQ.*use a smaller step"):
        path(PLANAR, RigidLinks(20, 1e-2))
    assert list(tmp_path.iterdir()) == [] and capfd.readouterr() == ("", "")


def test_steps_divide_the_time_between_samples():
    case = rigid_links_case(PLANAR, RigidLinks(5, 3.4e-3))
    assert isinstance(case, Case) and (case.step_size, case.steps) == (0.01 / 3, 1500)
    trajectory = path(replace(PLANAR, end_time=0.05), RigidLinks(5, 3.4e-3))
    assert isinstance(trajectory, Trajectory) and len(trajectory.times) == 6
    np.testing.assert_allclose(trajectory.positions[0], [1.8, 0.0, 0.0])


@pytest.mark.parametrize("name", ["vibrating_ring", "power_line"])
def test_other_scenes_are_refused(name):
    with pytest.raises(InputError, match=f"'{name}': rigid links start along a Line"):
        build(load_scene(name), RigidLinks(8, 1e-3))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"links": 0}, "links = 0"),
        ({"step_size": -1.0}, "step_size = -1.0"),
        ({"rotary_inertia": math.nan}, "rotary_inertia = nan"),
        ({"integrator": "Heun"}, "'Heun' is unknown to MuJoCo"),
    ],
)
def test_bad_chains_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        build(PLANAR, RigidLinks(**({"links": 5, "step_size": 1e-3} | changes)))


def test_without_mujoco_the_remedy_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert not rigid_links.is_installed()
    with pytest.raises(InputError, match=r"pip install 'exudyn_inext\[peers\]'"):
        build(PLANAR, RigidLinks(5, 1e-3))
