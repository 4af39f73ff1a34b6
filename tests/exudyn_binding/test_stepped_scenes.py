"""ExplicitStepper among bodies, springs, joints and loads."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodePosition,
    SpringDamper,
)
from exudyn.utilities import InertiaCuboid

from examples import capstan
from exudyn_inext import (
    AttachToBody,
    ExplicitSettings,
    ExplicitStepper,
    SolveEnsemble,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence

STEP, STEPS = 1e-3, 200


@pytest.fixture
def build(new_mbs, add_pendulum):
    """(force=None) -> (mbs, node of a body at the cable's end); a spring and a load as functions of time."""

    def make(force=None, dimension=3):
        mbs = new_mbs()
        held = [True] * dimension + [False] * dimension
        cable = add_pendulum(mbs, dimension=dimension, groundConstraintsStart=held)
        body = mbs.CreateRigidBody(
            inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]),
            referencePosition=[1.825, 0, 0],
            initialAngularVelocity=[1, 0, 0],
            gravity=[0, -9.81, 0],
            returnDict=True,
        )
        AttachToBody(mbs, cable, "end", body["bodyNumber"], [-0.025, 0, 0])
        ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround(referencePosition=[0, 1, 0])))
        middle = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][2]))
        mbs.AddObject(SpringDamper(markerNumbers=[ground, middle], stiffness=5, damping=0.1))
        centre = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body["bodyNumber"]))
        wave = lambda mbs, t, load: [0.3 * np.sin(20 * t), 0, 0]  # noqa: E731
        mbs.AddLoad(LoadForceVector(markerNumber=centre, loadVectorUserFunction=wave))
        if force is not None:
            mbs.AddLoad(LoadForceVector(markerNumber=centre, loadVectorUserFunction=force))
        mbs.Assemble()
        return mbs, body["nodeNumber"], cable

    return make


def solved(mbs, explicit):
    with silence():
        SolveExplicit(mbs, quiet_settings(STEPS * STEP, 1), explicit)
    return np.array(mbs.systemData.GetODE2Coordinates())


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai"])
def test_a_scene_of_bodies_moves_as_under_the_solver_in_any_portions(build, integrator):
    explicit = ExplicitSettings(integrator, stepSize=STEP, massScaling=0.3)
    run = build()[0]
    expected = solved(run, explicit)
    mbs, _, _ = build()
    before = mbs.systemData.GetODE2Coordinates()
    stepper = ExplicitStepper(mbs, explicit)
    for portions in ([200], [1, 99, 37, 63]):
        stepper.Start()
        for steps in portions:
            stepper.Step(steps)
        np.testing.assert_array_equal(mbs.systemData.GetODE2Coordinates(), before)
    q, _, time = stepper.State()
    assert time == pytest.approx(STEPS * STEP) and q.shape == (6, 2, 3)
    stepper.WriteToSystem()
    np.testing.assert_allclose(mbs.systemData.GetODE2Coordinates(), expected, atol=1e-12)
    forces = [np.array(one.systemData.GetAECoordinates()) for one in (mbs, run)]  # of joints and supports
    np.testing.assert_allclose(*forces, atol=1e-9 * np.abs(forces[1]).max())
    end = mbs.systemData.GetNodeLTGODE2(5)[:3]
    np.testing.assert_allclose(q[-1, 0] - [1.8, 0, 0], expected[end], atol=1e-12)


def test_a_force_on_a_body_acts_as_a_load_that_follows_the_time(build):
    def push(t):
        return [2.0 * np.sin(30 * t), 1.0, 0.5]

    explicit = ExplicitSettings(stepSize=STEP, massScaling=0.3)
    expected = solved(build(lambda mbs, t, load: push(t))[0], explicit)
    mbs, node, _ = build()
    stepper = ExplicitStepper(mbs, explicit)
    stepper.SetNodeForce(node, push(0.0))
    stepper.Start()
    for k in range(STEPS):
        stepper.SetNodeForce(node, push((k + 1) * STEP))
        stepper.Step()
    stepper.WriteToSystem()
    found = np.array(mbs.systemData.GetODE2Coordinates())
    np.testing.assert_allclose(found, expected, atol=1e-11)
    assert np.abs(found - solved(build()[0], explicit)).max() > 1e-2


def test_a_force_on_a_node_of_a_cable_among_bodies_is_one_of_the_scene(build):
    mbs, _, cable = build()
    stepper = ExplicitStepper(mbs, ExplicitSettings(stepSize=STEP, massScaling=0.3))
    stepper.Start()
    stepper.Step(STEPS)
    free = stepper.State()[0].copy()
    stepper.SetNodeForce(cable["nodes"][3], [0, 0, 0.2])
    stepper.Start()
    stepper.Step(STEPS)
    assert np.abs(stepper.State()[0] - free).max() > 1e-2
    stepper.SetNodeForce(cable["nodes"][3], [0, 0, 0])
    stepper.Start()
    stepper.Step(STEPS)
    np.testing.assert_array_equal(stepper.State()[0], free)


def test_contact_moves_as_in_solve_explicit_in_ensembles_too():
    """A cable that slides over a cylinder, whose friction remembers where it sticks."""
    systems = [exudyn.SystemContainer().AddSystem() for _ in range(2)]
    for mbs in systems:
        capstan.build(mbs, elements=10)
        mbs.Assemble()
    slide, end = ExplicitSettings(stepSize=1e-4), 0.05
    with silence():
        SolveExplicit(systems[0], quiet_settings(end, 10), slide)
    stepper = ExplicitStepper(systems[1], slide, interval=end / 10)
    stepper.Start()
    stepper.Step(3)
    stepper.Start()
    stepper.Step(10)
    stepper.WriteToSystem()
    data = [mbs.systemData for mbs in systems]
    for read in ("GetAECoordinates", "GetODE2Coordinates", "GetODE2Coordinates_t", "GetDataCoordinates"):
        expected, found = (np.array(getattr(one, read)()) for one in data)
        np.testing.assert_array_equal(found, expected)
    touching = np.array(data[1].GetDataCoordinates(exudyn.ConfigurationType.Initial))
    assert np.abs(found - touching).max() > 0.1  # segments have closed, stuck and slipped
    member = SolveEnsemble(systems[1:], quiet_settings(end, 10), slide, derivatives=2)
    for name, read in (("coordinates", "GetODE2Coordinates"), ("accelerations", "GetODE2Coordinates_tt")):
        np.testing.assert_array_equal(member[name][0, -1], getattr(data[0], read)())


def test_start_begins_from_the_initial_configuration_as_it_is_then(build):
    """As for episodes of a controller; that of the time when the stepper was made was taken."""
    explicit = ExplicitSettings(stepSize=STEP)
    mbs, _, _ = build()
    stepper = ExplicitStepper(mbs, explicit)
    solved(mbs, explicit)
    data = mbs.systemData
    data.SetSystemState(data.GetSystemState(), exudyn.ConfigurationType.Initial)
    found = []
    for one in (stepper, ExplicitStepper(mbs, explicit)):
        one.Start()
        one.Step(20)
        found.append(one.State()[0].copy())
    np.testing.assert_allclose(*found, atol=1e-9)
