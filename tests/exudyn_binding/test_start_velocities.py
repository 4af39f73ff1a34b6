"""Initial velocities that violate constraints start as after an impulse there, with a word about it."""

import re
import warnings

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SphericalJoint,
)
from exudyn.utilities import RigidBodyInertia

from exudyn_inext import (
    AddPointMass,
    CableShape,
    CreatePrescribedMotion,
    ExplicitSettings,
    ExplicitStepper,
    SceneError,
)
from exudyn_inext.exudyn_binding.scene import read_scene
from exudyn_inext.integrators import INTEGRATORS
from reference_models.model import quiet_settings, silence
from tests.cables import dense_constraints, dense_mass
from tests.exudyn_binding.items import trajectory

MASS, LENGTH, SPIN = 2.0, 1.0, 3.0
ABOUT_CENTRE = MASS * LENGTH**2 / 12.0
ROTATIONS = [exudyn.NodeType.RotationEulerParameters, exudyn.NodeType.RotationRxyz]
every_integrator = pytest.mark.parametrize("integrator", INTEGRATORS)
both_rotations = pytest.mark.parametrize("rotation", ROTATIONS, ids=["EulerParameters", "Rxyz"])


def energies(said):
    """Kinetic energy before and after [J], and its change [%], out of a warning."""
    pattern = r"kinetic energy from (\S+) J to (\S+) J(?: \((\S+) %\))?"
    return [float(x) for x in re.search(pattern, said).groups() if x is not None]


def pinned_rod(mbs, rotation, joint="revolute", beside=0.5):
    """A slender rod along x that spins about its centre, beside which it is pinned; returns its node."""
    inertia = RigidBodyInertia(mass=MASS, inertiaTensor=np.diag([1e-3, ABOUT_CENTRE, ABOUT_CENTRE]))
    body = mbs.CreateRigidBody(
        inertia=inertia,
        referencePosition=[beside, 0, 0],
        initialAngularVelocity=[0, 0, SPIN],
        nodeType=rotation,
        returnDict=True,
    )
    items = {"itemNumbers": [mbs.CreateGround(), body["bodyNumber"]], "name": "hinge"}
    if joint == "revolute":
        mbs.CreateRevoluteJoint(position=[0, 0, 0], axis=[0, 0, 1], **items)
    else:
        mbs.CreateSphericalJoint(position=[0, 0, 0], **items)
    return body["nodeNumber"]


def first_velocity(mbs, sensor, solve, step=1e-6, **explicit):
    """Of a sensor after a tiny step, and the warnings."""
    with pytest.warns(UserWarning, match="projected") as said:
        report = solve(mbs, step, stepSize=step, **explicit)
    return trajectory(mbs, sensor)[-1, 1:], [str(w.message) for w in said], report


@every_integrator
@both_rotations
@pytest.mark.parametrize("joint", ["revolute", "spherical"])
@pytest.mark.parametrize("beside", [0.5, 0.2])
def test_a_rod_that_spins_keeps_its_angular_momentum_about_the_joint_beside_its_centre(
    mbs, add_sensor, solve, integrator, rotation, joint, beside
):
    """The impulse acts at the joint: J_c w = (J_c + m a^2) w'."""
    sensor = add_sensor(mbs, pinned_rod(mbs, rotation, joint, beside), "AngularVelocity")
    mbs.Assemble()
    found, (said,), report = first_velocity(mbs, sensor, solve, integrator=integrator)
    expected = SPIN * ABOUT_CENTRE / (ABOUT_CENTRE + MASS * beside**2)
    np.testing.assert_allclose(found, [0, 0, expected], atol=1e-8)
    before = 0.5 * ABOUT_CENTRE * SPIN**2
    after = before * expected / SPIN
    assert "initial velocities violate" in said and "'hinge'" in said
    assert energies(said) == pytest.approx([before, after, 100 * (after / before - 1)], rel=1e-3)
    assert report["startCorrections"][-1].velocity > 0.1


@both_rotations
@pytest.mark.parametrize("joint", ["revolute", "spherical"])
def test_a_body_beside_its_joint_starts_as_with_the_native_solver(
    new_mbs, add_sensor, solve, rotation, joint
):
    """Generalized-alpha with constraints on velocities is on them after its first step."""
    ours, native = new_mbs(), new_mbs()
    sensors = []
    for mbs in (ours, native):
        rod = pinned_rod(mbs, rotation, joint, 0.3)
        sensors += [add_sensor(mbs, rod, output) for output in ("AngularVelocity", "Velocity")]
    for mbs in (ours, native):
        mbs.Assemble()
    found, _, _ = first_velocity(ours, sensors[0], solve)
    settings = quiet_settings(1e-6, 1)
    settings.timeIntegration.generalizedAlpha.useIndex2Constraints = True
    settings.timeIntegration.generalizedAlpha.useNewmark = True
    with silence():
        native.SolveDynamic(settings)
    np.testing.assert_allclose(found, trajectory(native, sensors[2])[-1, 1:], atol=1e-6)
    np.testing.assert_allclose(
        trajectory(ours, sensors[1])[-1, 1:], trajectory(native, sensors[3])[-1, 1:], atol=1e-6
    )


@pytest.fixture
def catch(new_mbs, add_cable, solve):
    """(step, scaling) -> velocities of a free cable, whose end catches a point, and of that; and energies."""

    def run(step, scaling=0.0):
        mbs = new_mbs()
        cable = add_cable(mbs, gravity=[0, 0, 0])
        point = mbs.CreateMassPoint(mass=0.05, referencePosition=[1.8, 0, 0], initialVelocity=[0, 2, 0])
        pair = MarkerNodePosition(nodeNumber=cable["nodes"][-1]), MarkerBodyPosition(bodyNumber=point)
        markers = list(map(mbs.AddMarker, pair))
        mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0], name="catch"))
        mbs.Assemble()
        with pytest.warns(UserWarning, match=r"initial velocities violate .*'catch'.*by -?1 ") as said:
            solve(mbs, step, stepSize=step, massScaling=scaling)
        v = np.array(mbs.systemData.GetODE2Coordinates_t())
        return v[:24].reshape(6, 2, 2), v[24:], energies(str(said[0].message))

    return run


def test_what_is_tied_at_two_speeds_keeps_its_momentum(catch):
    cable, point, energy = catch(1e-7)
    np.testing.assert_allclose(cable[-1, 0, 1], point[1], atol=1e-9)
    of_elements = 0.5 * (cable[1:, 0, 1] + cable[:-1, 0, 1]) + 0.03 * (cable[:-1, 1, 1] - cable[1:, 1, 1])
    assert 0.0348 * 0.36 * of_elements.sum() + 0.05 * point[1] == pytest.approx(0.05 * 2.0, rel=1e-9)
    assert energy[0] == pytest.approx(0.5 * 0.05 * 4.0) and energy[1] < energy[0]


def test_impulses_at_the_start_meet_the_mass_without_scaling(catch):
    assert catch(0.01, 0.3)[2] == catch(1e-4)[2]


def oracle(cable, v, time=0.0):
    """v + M^-1 C_q^T mu on the constraints of a cable, without the package's solves; (n, 2, dim)."""
    q, mass = cable.reference, dense_mass(cable)
    rows = dense_constraints(cable, q, v, time)
    response = np.linalg.solve(mass, rows.jacobian.T)
    multipliers = np.linalg.lstsq(rows.jacobian @ response, rows.rate, rcond=1e-12)[0]
    nearest = v.ravel() - response @ multipliers
    energy = [0.5 * x @ mass @ x for x in (v.ravel(), nearest)]
    return nearest.reshape(v.shape), energy


def cable_model(mbs):
    """The cable of an assembled mbs with its supports, as the tests' formulas take it."""
    (cable,) = read_scene(mbs).cables
    return cable.cable


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("held", ["pin", "clamp", "two pins"])
@pytest.mark.parametrize("with_mass", [False, True], ids=["", "point mass"])
def test_a_cable_starts_as_after_impulses_at_its_constraints(mbs, add_cable, solve, dim, held, with_mass):
    """Sagging, and thrown at random: every constraint is violated."""
    flags = {"pin": [True] * dim + [False] * dim, "clamp": [True] * 2 * dim}
    flags["two pins"] = flags["pin"]
    x = np.linspace(-0.8, 0.8, 6)
    circle = np.stack([np.sin(x), -np.cos(x), 0 * x], axis=1)
    slopes = np.stack([np.cos(x), np.sin(x), 0 * x], axis=1)
    thrown = np.random.default_rng(4).standard_normal((6, 2, 3))
    thrown[:, :, dim:] = 0.0
    cable = add_cable(
        mbs,
        shape=CableShape(circle, slopes),
        dimension=dim,
        groundConstraintsStart=flags[held],
        groundConstraintsEnd=flags[held] if held == "two pins" else None,
    )
    if with_mass:
        AddPointMass(mbs, cable, 1.0, 0.1)
    for node, v in zip(cable["nodes"], thrown[:, :, :dim], strict=True):
        mbs.SetNodeParameter(node, "initialVelocities", v.ravel().tolist())
    mbs.Assemble()
    expected, energy = oracle(cable_model(mbs), np.ascontiguousarray(thrown[:, :, :dim]))
    with pytest.warns(UserWarning, match=r"initial velocities of cable 'object\d' violate the .* by") as said:
        solve(mbs, 1e-12, stepSize=1e-12)
    found = np.array(mbs.systemData.GetODE2Coordinates_t()).reshape(expected.shape)
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())
    assert energies(str(said[0].message))[:2] == pytest.approx(energy, rel=1e-4)


def test_a_thrown_cable_on_a_pin_starts_as_with_the_native_solver(new_mbs, add_pendulum, solve):
    """The same cable with its constraints as native objects, and the native implicit solver."""
    found = []
    for enforcement in ("projection", "algebraic"):
        mbs = new_mbs()
        cable = add_pendulum(mbs, enforcement=enforcement, gravity=[0, 0, 0])
        for k, node in enumerate(cable["nodes"]):
            mbs.SetNodeParameter(node, "initialVelocities", [0.3, 2.0 - 0.5 * k, 0.2, 1.0])
        mbs.Assemble()
        settings = quiet_settings(1e-9, 1)
        settings.timeIntegration.generalizedAlpha.useIndex2Constraints = True
        settings.timeIntegration.generalizedAlpha.useNewmark = True
        if enforcement == "projection":
            with pytest.warns(UserWarning, match="projected"):
                solve(mbs, settings=settings, stepSize=1e-9)
        else:
            with silence():
                mbs.SolveDynamic(settings)
        found.append(np.array(mbs.systemData.GetODE2Coordinates_t()))
    np.testing.assert_allclose(found[0], found[1], atol=1e-6 * np.abs(found[1]).max())
    assert np.abs(found[1]).max() > 1.0


def test_a_closed_cable_starts_on_its_closure(mbs, add_cable, solve):
    ring = add_cable(mbs, shape=CableShape.Circle([0, 0], 0.5, 8), gravity=[0, 0, 0])
    mbs.SetNodeParameter(ring["nodes"][0], "initialVelocities", [1, 0, 0, 1])
    mbs.Assemble()
    with pytest.warns(UserWarning, match="initial velocities .* violate"):
        report = solve(mbs, 0.05)
    assert report["drift"]["constraints"] < 1e-6


def test_a_support_that_starts_with_a_jerk_takes_the_cable_along(mbs, add_cable, solve):
    cable = add_cable(mbs, gravity=[0, 0, 0])
    CreatePrescribedMotion(mbs, cable["nodes"][0], lambda t: [0.5 * t, 0.0])
    mbs.Assemble()
    said = r"initial velocities .* violate the prescribed motion .*by 0\.5 .*from 0 J to 0\.0078\d* J\. "
    with pytest.warns(UserWarning, match=said):
        solve(mbs, 0.01)
    final = np.array(mbs.systemData.GetODE2Coordinates_t()).reshape(6, 2, 2)
    np.testing.assert_allclose(final[:, 0], np.tile([0.5, 0.0], (6, 1)), atol=1e-8)


def test_a_displacement_for_a_position_is_refused_with_the_remedy(mbs, add_cable, solve):
    cable = add_cable(mbs)
    CreatePrescribedMotion(mbs, cable["nodes"][-1], lambda t: [0.0, 0.1 * t * t])
    mbs.Assemble()
    with pytest.raises(
        SceneError, match=r"by 1.* let the motion begin there .* positions, not displacements"
    ):
        solve(mbs, 0.01)


def test_velocities_within_the_tolerance_are_projected_in_silence(mbs, add_pendulum, solve):
    cable = add_pendulum(mbs)
    mbs.SetNodeParameter(cable["nodes"][0], "initialVelocities", [0, 1e-4, 0, 0])
    mbs.Assemble()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (correction,) = solve(mbs, 0.01, startTolerance=1e-3)["startCorrections"]
    assert correction.velocity >= 1e-4


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["cable", "joint"])
def test_velocities_that_are_no_numbers_are_refused(mbs, add_pendulum, solve, contents, where, bad):
    cable = add_pendulum(mbs)
    node = cable["nodes"][2]
    if where == "joint":
        node = pinned_rod(mbs, exudyn.NodeType.RotationRxyz)
    size = len(mbs.GetNodeParameter(node, "initialVelocities"))
    mbs.SetNodeParameter(node, "initialVelocities", [bad, *[0.0] * (size - 1)])
    mbs.Assemble()
    of_body = rf"initial velocity of node {node} .* is (nan|inf), no finite number"
    said = r"initial velocities .*violate.* by nan \(limit" if where == "cable" else of_body
    with pytest.raises(SceneError, match=said):
        solve(mbs)


def test_a_stepper_projects_as_well(mbs, add_pendulum):
    cable = add_pendulum(mbs)
    mbs.SetNodeParameter(cable["nodes"][0], "initialVelocities", [0, 0.5, 0, 0])
    mbs.Assemble()
    with pytest.warns(UserWarning, match=r"pin constraint at the position y of node 0 by 0\.5 "):
        stepper = ExplicitStepper(mbs, explicitSettings=ExplicitSettings(stepSize=1e-4))
    assert stepper.startCorrections[0].velocity >= 0.5


def held_points(mbs, v):
    """Two native points tied by nothing, of which one coordinate is held that moves."""
    point = mbs.CreateMassPoint(mass=2.0, initialVelocity=[3, v, 0], returnDict=True)
    ground = MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
    pair = ground, MarkerNodeCoordinate(nodeNumber=point["nodeNumber"], coordinate=1)
    mbs.AddObject(CoordinateConstraint(markerNumbers=list(map(mbs.AddMarker, pair)), name="rail"))
    return point["nodeNumber"]


def test_native_items_start_on_what_holds_them_in_compiled_code(mbs, solve, add_sensor):
    sensor = add_sensor(mbs, held_points(mbs, 4.0))
    mbs.Assemble()
    said = r"violate object \d 'rail' .*by 1 \(limit 1e-06\).*from 25 J to 9 J \(-64\.00 %\)"
    with pytest.warns(UserWarning, match=said) as warned:
        report = solve(mbs, 0.1, stepSize=0.01)
    assert len(warned) == 1
    assert "in one compiled call" in report["path"]
    np.testing.assert_allclose(trajectory(mbs, sensor)[-1, 1:], [0.3, 0, 0], atol=1e-12)


def test_native_items_that_are_not_where_they_are_held_are_refused(mbs, solve):
    node = held_points(mbs, 0.0)
    mbs.SetNodeParameter(node, "initialCoordinates", [0, 0.1, 0])
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"initial coordinates violate object \d 'rail' .* by 0\.1 "):
        solve(mbs, 0.1, stepSize=0.01)
