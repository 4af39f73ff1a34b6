"""Constraints at velocity level move coordinates as under Exudyn's implicit solver."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRotationCoordinate,
    NodePointGround,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid, RotationMatrixZ, RotXYZ2RotationMatrix

from exudyn_inext import (
    CableForces,
    CreateInextensibleCable,
    ExplicitSettings,
    ExplicitSolver,
    ExplicitStepper,
    InextensibleCable,
    SceneError,
    SolveEnsemble,
    SolveEquilibrium,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import either_cable, solve_native
from tests.exudyn_binding.test_restart import restarting

SECTION = {"massPerLength": 0.3, "bendingStiffness": 0.02}
END, STEPS = 0.4, 400
SPEED = 9.0  # mean one of a wheel [rad/s]
TURN = SPEED * (END - np.sin(9.0 * END) / 9.0)
TIP = "tip"
pytestmark = pytest.mark.filterwarnings("ignore:.*initial velocities")


def at_speed(mbs, t, itemNumber, lOffset):
    return (0.9 + lOffset) * np.sin(9.0 * t)


def speeding_up(mbs, t, itemNumber, lOffset):
    return SPEED * (1.0 - np.cos(9.0 * t))


def way_at_speed(t):
    return 0.1 * (1.0 - np.cos(9.0 * t))


class Scene:
    """A cable, a mass at its end, and a constraint at velocity level on its height, or on that of the end.

    tip: node.   height: sensor.   force: sensor of the constraint.
    """

    def __init__(self, mbs, native=False, dimension=2, on=None, **constraint):
        self.mbs = mbs
        line = {"positionStart": [0, 0, 0], "positionEnd": [1.2, 0, 0], "gravity": [0, -9.81, 0]}
        line["groundConstraintsStart"] = [True] * dimension + [False] * dimension
        line["numberOfElements"] = 16 if native else 8
        nodes, self.cable = either_cable(mbs, native, dimension, SECTION, 2e5, **line)
        self.tip = driven = nodes[-1]
        if on != TIP:
            body = mbs.CreateMassPoint(
                mass=0.3,
                referencePosition=[1.2, 0, 0],
                gravity=[0, -9.81, 0],
                create2D=dimension == 2,
                returnDict=True,
            )
            driven = body["nodeNumber"]
            pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (self.tip, driven)]
            axes = [1, 1, dimension - 2]
            mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=axes))
        ground = mbs.AddNode(NodePointGround())
        pair = [
            mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=c))
            for n, c in ((ground, 0), (driven, 1))
        ]
        self.constraint = mbs.AddObject(
            CoordinateConstraint(markerNumbers=pair, velocityLevel=True, **constraint)
        )
        output = {"storeInternal": True, "outputVariableType": exudyn.OutputVariableType.Force}
        self.force = mbs.AddSensor(SensorObject(objectNumber=self.constraint, **output))

    def change(self, name, value_at):
        """Let a pre-step user function set a parameter of the constraint."""
        number = self.constraint
        self.mbs.SetPreStepUserFunction(
            lambda mbs, t: mbs.SetObjectParameter(number, name, value_at(t)) or True
        )

    def solve(self, **explicit):
        self.mbs.Assemble()
        with silence():
            return SolveExplicit(self.mbs, quiet_settings(END, STEPS), ExplicitSettings(**explicit))

    @property
    def place(self):
        return np.array(self.mbs.GetNodeOutput(self.tip, exudyn.OutputVariableType.Position))

    @property
    def forces(self):
        return np.array(self.mbs.GetSensorStoredData(self.force))[1:, 1]


KINDS = {
    "a speed": {"offset": 0.5},
    "at rest": {},
    "a function": {"offsetUserFunction_t": at_speed},
    "a function and an offset": {"offset": 0.2, "offsetUserFunction_t": at_speed},
    "a function of places is not asked": {"offsetUserFunction": at_speed},
}
CHANGES = {
    "speeds": (True, lambda scene: scene.change("offset", lambda t: at_speed(None, t, 0, 0.0))),
    "brakes": (False, lambda scene: scene.change("activeConnector", lambda t: 0.1 < t <= 0.2)),
}


def require_the_same(new_mbs, build, tolerance=3e-3):
    scenes = [build(new_mbs(), native) for native in (False, True)]
    report = scenes[0].solve()
    scenes[1].mbs.Assemble()
    solve_native(scenes[1].mbs, END, END / STEPS)
    np.testing.assert_allclose(scenes[0].place, scenes[1].place, atol=tolerance)
    return scenes, report


@pytest.mark.parametrize(("on", "dimension"), [(None, 3), (TIP, 2)], ids=["a body", "the cable"])
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_driven_moves_as_under_the_implicit_solver(new_mbs, kind, on, dimension):
    def build(mbs, native):
        return Scene(mbs, native, dimension, on, **KINDS[kind])

    scenes, report = require_the_same(new_mbs, build)
    assert "all loads are known" in report["path"]
    assert scenes[0].mbs.GetObjectParameter(scenes[0].constraint, "velocityLevel")
    if kind != "a speed":  # which jumps at the start
        forces, expected = (scene.forces for scene in scenes)
        assert np.sqrt(((forces - expected) ** 2).mean()) < 0.05 * np.abs(expected).max()


@pytest.mark.parametrize("on", [None, TIP], ids=["a body", "the cable"])
@pytest.mark.parametrize("change", CHANGES)
def test_speeds_and_brakes_that_a_step_function_sets_act_as_natively(new_mbs, change, on):
    is_active, act = CHANGES[change]

    def build(mbs, native):
        scene = Scene(mbs, native, on=on, activeConnector=is_active)
        act(scene)
        return scene

    require_the_same(new_mbs, build, 5e-3)


@pytest.mark.parametrize("change", CHANGES)
def test_a_restarted_run_goes_on_bit_for_bit(new_mbs, change, tmp_path):
    is_active, act = CHANGES[change]
    found = []
    for ends in ((END,), (0.5 * END, END)):
        scene = Scene(new_mbs(), activeConnector=is_active)
        act(scene)
        scene.mbs.Assemble()
        for end in ends:
            settings = restarting(
                quiet_settings(end, round(STEPS * end / END), 0.1), tmp_path / str(len(ends))
            )
            with silence():
                report = SolveExplicit(scene.mbs, settings, ExplicitSettings(stepSize=5e-4))
        assert (report["resumedAt"] is None) is (len(ends) == 1)
        found.append(scene.mbs.systemData.GetODE2Coordinates())
    np.testing.assert_array_equal(*found)


def test_steppers_ensembles_and_solvers_of_portions_follow_the_velocity(new_mbs):
    scenes = [Scene(new_mbs(), offsetUserFunction_t=at_speed) for _ in range(3)]
    for scene in scenes:
        scene.mbs.Assemble()
    explicit = ExplicitSettings(stepSize=5e-4)
    stepper = ExplicitStepper(scenes[0].mbs, explicit, interval=END)
    stepper.Start()
    stepper.Step()
    stepper.WriteToSystem()
    result = SolveEnsemble([scenes[1].mbs], quiet_settings(END, 1, END), explicit)
    assert scenes[0].place[1] == pytest.approx(way_at_speed(END), abs=1e-9)
    assert CableForces(scenes[0].mbs, scenes[0].cable, 5)["tension"].min() > 0.0
    height = scenes[1].mbs.systemData.GetNodeLTGODE2(scenes[1].tip)[1]
    assert result["coordinates"][0, -1, height] == pytest.approx(way_at_speed(END), abs=1e-9)
    mbs, solver = scenes[2].mbs, ExplicitSolver(explicit)
    for _ in range(2):  # anew
        settings = quiet_settings(0.5 * END, 10)
        solver.InitializeSolver(mbs, settings)
        for k in range(2):
            settings.timeIntegration.startTime = 0.5 * END * k
            settings.timeIntegration.endTime = 0.5 * END * (k + 1)
            if k == 0:
                solver.InitializeSolverInitialConditions(mbs, settings)
            solver.SolveSteps(mbs, settings)
    solver.FinalizeSolver(mbs, settings)
    assert all(scene.mbs.GetObjectParameter(scene.constraint, "velocityLevel") for scene in scenes)


def test_a_velocity_that_follows_the_state_is_refused_and_mbs_stays_as_it_was(mbs, contents):
    def by_state(mbs, t, itemNumber, lOffset):
        return mbs.systemData.GetTime()

    scene = Scene(mbs, offsetUserFunction_t=by_state)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(
        SceneError, match=r"constrains a velocity by a user function that may depend.*pre-step"
    ):
        scene.solve()
    assert contents(mbs) == before


def test_the_function_of_a_velocity_cannot_be_replaced_during_a_run(mbs):
    scene = Scene(mbs, offsetUserFunction_t=at_speed)
    scene.change("offsetUserFunction_t", lambda t: lambda mbs, t, itemNumber, lOffset: 0.0)
    with pytest.raises(
        SceneError, match=r"'offsetUserFunction_t' of object .* at velocity level, was changed"
    ):
        scene.solve()
    assert mbs.GetObjectParameter(scene.constraint, "velocityLevel")


@pytest.mark.parametrize("on", [None, TIP], ids=["a body", "the cable"])
def test_what_is_driven_stays_where_it_is_in_statics(new_mbs, on):
    """As a constraint of places with an offset of zero; a run goes on from there."""
    driven, held = Scene(new_mbs(), on=on, offset=0.5), Scene(new_mbs(), on=on)
    held.mbs.SetObjectParameter(held.constraint, "velocityLevel", False)
    for scene in (driven, held):
        scene.mbs.Assemble()
        SolveEquilibrium(scene.mbs)
    np.testing.assert_allclose(driven.place, held.place, atol=1e-9)
    assert driven.mbs.GetObjectParameter(driven.constraint, "velocityLevel")
    driven.solve()
    assert driven.place[1] == pytest.approx(0.5 * END, abs=1e-6)


class Wheels:
    """A wheel that turns at a velocity has another one geared to it, from whose rim a cable hangs.

    angles: of both, sensors.   cable: its last node.
    """

    def __init__(self, mbs, native, gear):
        self.mbs = mbs
        ground = mbs.CreateGround()
        wheels, markers = [], []
        for x in (0.0, 0.5):
            wheel = mbs.CreateRigidBody(
                inertia=InertiaCuboid(500, [0.2, 0.2, 0.1]), referencePosition=[x, 0, 0], returnDict=True
            )
            bodies = [ground, wheel["bodyNumber"]]
            mbs.CreateRevoluteJoint(itemNumbers=bodies, position=[x, 0, 0], axis=[0, 0, 1])
            angle = MarkerNodeRotationCoordinate(nodeNumber=wheel["nodeNumber"], rotationCoordinate=2)
            wheels.append(wheel), markers.append(mbs.AddMarker(angle))
        self.nodes = [wheel["nodeNumber"] for wheel in wheels]
        fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for pair, rates in (
            ([fixed, markers[0]], {"offsetUserFunction_t": speeding_up}),
            (markers, {"factor1": gear}),
        ):
            mbs.AddObject(CoordinateConstraint(markerNumbers=pair, velocityLevel=True, **rates))
        line = {"positionStart": [0.55, 0, 0], "positionEnd": [0.55, -0.8, 0], "gravity": [0, -9.81, 0]}
        line["numberOfElements"] = 16 if native else 8
        nodes, _ = either_cable(mbs, native, 3, SECTION, 2e5, **line)
        rim = mbs.AddMarker(
            MarkerBodyPosition(bodyNumber=wheels[1]["bodyNumber"], localPosition=[0.05, 0, 0])
        )
        pair = [rim, mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[0]))]
        mbs.AddObject(SphericalJoint(markerNumbers=pair))
        self.tip = nodes[-1]

    def output(self, node, kind):
        return np.array(self.mbs.GetNodeOutput(node, getattr(exudyn.OutputVariableType, kind)))


@pytest.mark.parametrize("gear", [0.75, -2.0])
def test_angles_go_on_beyond_half_a_turn(new_mbs, gear):
    tips = []
    for native in (False, True):
        scene = Wheels(new_mbs(), native, gear)
        scene.mbs.Assemble()
        if native:
            solve_native(scene.mbs, END, END / STEPS)
        else:
            with silence():
                path = SolveExplicit(scene.mbs, quiet_settings(END, STEPS))["path"]
            assert "in one compiled call" in path
        for node, turn in zip(scene.nodes, (TURN, TURN / gear), strict=True):
            frame = scene.output(node, "RotationMatrix").reshape(3, 3)
            np.testing.assert_allclose(frame, RotationMatrixZ(turn), atol=1e-4)
        tips.append(scene.output(scene.tip, "Position"))
    np.testing.assert_allclose(*tips, atol=3e-3)


def test_angles_geared_by_no_ratio_of_whole_numbers_are_refused(mbs):
    scene = Wheels(mbs, False, np.sqrt(2.0))
    scene.mbs.Assemble()
    with pytest.raises(
        SceneError, match=r"gears two angles by factor1 = 1\.41421, .* whole numbers up to 1000"
    ):
        SolveExplicit(mbs, quiet_settings(END, STEPS))


def test_a_constrained_angle_of_a_tilted_body_is_refused(mbs):
    tilted = RotXYZ2RotationMatrix([0.3, 0.0, 0.0])
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(500, [0.2, 0.2, 0.1]), referenceRotationMatrix=tilted, returnDict=True
    )
    angle = MarkerNodeRotationCoordinate(nodeNumber=body["nodeNumber"], rotationCoordinate=2)
    fixed = MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
    pair = [mbs.AddMarker(fixed), mbs.AddMarker(angle)]
    mbs.AddObject(CoordinateConstraint(markerNumbers=pair, velocityLevel=True))
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"whose axis z is tilted by 0\.3 rad .* 0\.1 rad at most"):
        SolveExplicit(mbs, quiet_settings(END, STEPS))


@pytest.mark.parametrize("rotations", ["EulerParameters", "Rxyz"])
def test_a_constrained_angle_that_tilts_during_a_run_is_warned_of(mbs, rotations):
    """A body that turns about x by 4 rad/s."""
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(500, [0.2, 0.2, 0.1]),
        initialAngularVelocity=[4.0, 0.0, 0.0],
        nodeType=getattr(exudyn.NodeType, f"Rotation{rotations}"),
        returnDict=True,
    )
    angle = MarkerNodeRotationCoordinate(nodeNumber=body["nodeNumber"], rotationCoordinate=2)
    fixed = MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
    mbs.AddObject(CoordinateConstraint(markerNumbers=[mbs.AddMarker(fixed), mbs.AddMarker(angle)]))
    mbs.Assemble()
    with pytest.warns(UserWarning, match=r"whose axis z was tilted by up to 0\.4 rad \(limit 0\.1\)"):
        SolveExplicit(mbs, quiet_settings(0.1, 100))


def test_a_tilt_that_did_not_happen_is_not_warned_of(mbs):
    """Beside a cable that stretches, steps are taken once without the function that stops the body."""
    CreateInextensibleCable(mbs, [1, 0, 0], [2, 0, 0], 2, InextensibleCable(0.1, 0.01, axialStiffness=1e4))
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(500, [0.2, 0.2, 0.1]), initialAngularVelocity=[4.0, 0.0, 0.0], returnDict=True
    )
    angle = MarkerNodeRotationCoordinate(nodeNumber=body["nodeNumber"], rotationCoordinate=2)
    fixed = MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
    mbs.AddObject(CoordinateConstraint(markerNumbers=[mbs.AddMarker(fixed), mbs.AddMarker(angle)]))

    def stop(mbs, t):
        if t > 0.015:
            mbs.systemData.SetODE2Coordinates_t(0.0 * mbs.systemData.GetODE2Coordinates_t())
        return True

    mbs.SetPreStepUserFunction(stop)
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(0.1, 10))
