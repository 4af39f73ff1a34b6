"""The automatic step of cables that stretch does not resolve waves that do not matter."""

import itertools
import math
import warnings

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.utilities import (
    CartesianSpringDamper,
    CoordinateConstraint,
    InertiaCuboid,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    ObjectANCFCable,
    ObjectANCFCable2D,
    SensorNode,
    SensorObject,
    SphericalJoint,
)

from exudyn_inext import (
    AddPointMass,
    CableDrag,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    SetCableDrag,
    SolveExplicit,
)
from exudyn_inext.run.run_watch import RunWatch
from reference_models.model import quiet_settings

PERIOD = 0.02
CLAMPED, PINNED = [True] * 4, [True, True, False, False]
HANGING = {"positionEnd": [1, 0, 0], "gravity": [0, -9.81, 0]}


def cable(mbs, is_native, template, elements, **where):
    """Nodes of a cable."""
    where = {"positionStart": [0, 0, 0], "numberOfElements": elements} | where
    if is_native:
        return GenerateBeamElementsAlongLine(mbs, beamTemplate=template, **where)["nodes"]
    is_spatial = isinstance(template, ObjectANCFCable)
    made = CreateInextensibleCable(
        mbs, beamTemplate=template, extensible=True, dimension=3 if is_spatial else 2, **where
    )
    return made["nodes"]


def path_and_report(build, end, is_native=False, elements=8, steps=None, **explicit):
    """Path (T, 3) of the last node, and the report.

    build: (mbs, is_native, elements) -> nodes.   steps: of the loop.
    """
    mbs = exudyn.SystemContainer().AddSystem()
    node = build(mbs, is_native, elements)[-1]
    position = exudyn.OutputVariableType.Position
    sensor = mbs.AddSensor(SensorNode(nodeNumber=node, outputVariableType=position, storeInternal=True))
    mbs.Assemble()
    settings = quiet_settings(end, steps or round(end / (5e-4 if is_native else PERIOD)), PERIOD)
    report = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of initial velocities
        if is_native:
            settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
            settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
            mbs.SolveDynamic(settings)
        else:
            report = SolveExplicit(mbs, settings, ExplicitSettings(**explicit))
    return np.array(mbs.GetSensorStoredData(sensor))[:, 1:4], report


def strained(mbs, is_native, elements, strain=-0.01):
    """A cable that contracts at the start, against strong axial damping."""
    template = ObjectANCFCable2D(
        massPerLength=0.1,
        bendingStiffness=1e-3,
        axialStiffness=4000.0,
        axialDamping=40.0,
        referenceAxialStrain=strain,
        useReducedOrderIntegration=2,
    )
    return cable(mbs, is_native, template, elements, **HANGING, groundConstraintsStart=PINNED)


def curved(mbs, is_native, elements, stiffness=1e3):
    """A straight cable whose natural curvature acts from the start on."""
    template = ObjectANCFCable2D(
        massPerLength=0.1,
        bendingStiffness=1e-2,
        axialStiffness=stiffness,
        referenceCurvature=1.5,
        useReducedOrderIntegration=2,
    )
    return cable(mbs, is_native, template, elements, **HANGING, groundConstraintsStart=CLAMPED)


def winch(mbs, is_native, elements):
    """A damped cable between a driven slider and a body, which begins with a velocity of its own."""
    gravity = [0, 0, -9.81]
    template = ObjectANCFCable(
        massPerLength=0.2,
        bendingStiffness=0.05,
        bendingDamping=0.002,
        axialStiffness=400.0,
        useReducedOrderIntegration=2,
    )
    nodes = cable(mbs, is_native, template, elements, positionEnd=[1.2, 0, 0], gravity=gravity)
    slider = mbs.CreateMassPoint(mass=0.5, gravity=gravity, returnDict=True)["nodeNumber"]
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    axes = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=slider, coordinate=axis)) for axis in range(3)]
    for axis in axes[:2]:
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, axis]))
    mbs.AddObject(
        CoordinateConstraint(
            markerNumbers=[ground, axes[2]],
            offsetUserFunction=lambda mbs, t, item, offset: 0.4 / 3.0 * (1.0 - math.cos(3.0 * t)),
        )
    )
    body = mbs.CreateRigidBody(
        referencePosition=[1.2, 0, -0.1],
        inertia=InertiaCuboid(2000, [0.05, 0.05, 0.1]),
        gravity=gravity,
        initialVelocity=[0, 0.5, 0],
    )
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (nodes[0], slider, nodes[-1])]
    hook = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[0, 0, 0.1]))
    mbs.AddObject(SphericalJoint(markerNumbers=ends[:2]))
    mbs.AddObject(SphericalJoint(markerNumbers=[ends[2], hook]))
    return nodes


@pytest.mark.parametrize(("build", "most"), [(strained, 600), (curved, 500), (winch, 400)])
def test_steps_are_as_long_as_accuracy_allows(build, most):
    path, report = path_and_report(build, 0.6)
    native, _ = path_and_report(build, 0.6, is_native=True, elements=24)
    assert report["steps"] < most
    extent = np.linalg.norm(native - native[0], axis=1).max()
    assert np.linalg.norm(path - native, axis=1).max() < 0.01 * extent


def test_strains_that_are_damped_at_the_start_cost_no_steps():
    _, report = path_and_report(strained, 0.2)
    _, usual = path_and_report(lambda *which: strained(*which, strain=0.0), 0.2)
    assert report["rejections"] == 0 and report["steps"] < 2 * usual["steps"]  # the strain is tension, too
    assert report["drift"]["energyGain"] < 1e-3


def test_strong_axial_damping_moves_a_cable_as_if_it_kept_its_length():
    """What it makes of strains that were foreseen wrongly was taken for energy, and steps were rejected."""

    def swinging(stretch):
        def build(mbs, is_native, elements):
            section = InextensibleCable(0.1, 1e-3, **stretch)
            where = HANGING | {"groundConstraintsStart": PINNED}
            made = CreateInextensibleCable(mbs, [0, 0, 0], numberOfElements=8, beamTemplate=section, **where)
            for node in made["nodes"][1:]:
                x = mbs.GetNode(node)["referenceCoordinates"][0]
                mbs.SetNodeParameter(node, "initialVelocities", [0, 5.0 * x, 0, 5.0])
            mbs.SetNodeParameter(made["nodes"][0], "initialVelocities", [0, 0, 0, 5.0])
            AddPointMass(mbs, made, 1.0, 0.1)
            return made["nodes"]

        return build

    critical = 2.0 * 1e5 / 1e5  # N s: 2 EA / w, w = 1e5 rad/s of the fastest axial vibration
    path, report = path_and_report(swinging({"axialStiffness": 1e5, "axialDamping": 1e5 * critical}), 0.6)
    fixed, _ = path_and_report(swinging({}), 0.6)
    assert report["rejections"] == 0
    assert report["drift"]["energyGain"] < 1e-3
    assert np.abs(path - fixed).max() < 2e-3


def test_waves_of_a_sudden_start_do_not_decide_on_the_whole_run():
    """They pass at once; two hundred thousand steps resolved them."""
    _, report = path_and_report(curved, 1.0, elements=10)
    assert report["steps"] < 5000


def pulled(what):
    """Where the tip of a pendulum is after 0.3 s, if a load or a support is set again before each step."""
    mbs = exudyn.SystemContainer().AddSystem()
    made = CreateInextensibleCable(
        mbs,
        [0, 0, 0],
        [1.8, 0, 0],
        8,
        InextensibleCable(massPerLength=0.03477, bendingStiffness=0.08665, axialStiffness=1e6),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=PINNED,
    )
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=made["nodes"][-1]))
    load = mbs.AddLoad(LoadForceVector(markerNumber=tip, loadVector=[0, 0, 0]))
    step, signs = 2e-3, itertools.cycle((1.0, -1.0))

    def change(mbs, t):
        if what == "load":
            mbs.SetLoadParameter(load, "loadVector", [1e-12 * next(signs), 0, 0])
        elif what == "support":
            mbs.SetObjectParameter(made["constraintObjects"][0], "offset", 1e-16 * next(signs))
        return True

    mbs.SetPreStepUserFunction(change)
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(0.3, 150), ExplicitSettings(stepSize=step, massScaling=0.3))
    return np.array(mbs.GetNodeOutput(made["nodes"][-1], exudyn.OutputVariableType.Position))


@pytest.mark.parametrize("what", ["load", "support"])
def test_steps_go_on_as_before_after_next_to_nothing_has_changed(what):
    np.testing.assert_allclose(pulled(what), pulled(None), rtol=0.0, atol=1e-11)


def jerked(mbs, is_native, elements, mass=1.0, stiffness=1e4):
    """A cable of 0.1 kg with a body at its end, which pulls it tight again and again."""
    template = ObjectANCFCable2D(
        massPerLength=0.1, bendingStiffness=1e-2, axialStiffness=stiffness, useReducedOrderIntegration=2
    )
    nodes = cable(mbs, is_native, template, elements, **HANGING, groundConstraintsStart=PINNED)
    body = mbs.CreateMassPoint(referencePosition=[1, 0, 0], mass=mass, gravity=[0, -9.81, 0], returnDict=True)
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (nodes[-1], body["nodeNumber"])]
    mbs.AddObject(SphericalJoint(markerNumbers=ends))
    return nodes


def heavy(mbs, is_native, elements):
    """As `jerked`, with 10 000 times the mass of the cable."""
    return jerked(mbs, is_native, elements, mass=1000.0, stiffness=5e6)


@pytest.mark.parametrize(("build", "end", "most"), [(jerked, 1.3, 5000), (heavy, 0.6, 30000)])
def test_a_run_that_a_jerk_spoils_begins_again_with_shorter_steps(build, end, most):
    """Shorter steps for a while set hidden energy free, and no step was short enough then."""
    path, report = path_and_report(build, end)
    native, _ = path_and_report(build, end, is_native=True, elements=16)
    assert report["rejections"] == 0 and report["steps"] < most
    extent = np.linalg.norm(native - native[0], axis=1).max()
    assert np.linalg.norm(path - native, axis=1).max() < 0.01 * extent


@pytest.mark.parametrize(("build", "end"), [(jerked, 1.3), (heavy, 0.6)])
@pytest.mark.parametrize(
    "explicit", [{"adaptiveStep": True}, {"adaptiveStep": True, "stepSize": 3e-3}, {"stepSize": 1e-3}]
)
def test_steps_that_become_shorter_set_no_hidden_energy_free(build, end, explicit):
    """They tore cables away, or no step was short enough any more."""
    path, report = path_and_report(build, end, **explicit)
    native, _ = path_and_report(build, end, is_native=True, elements=16)
    assert report["drift"]["energyGain"] < 0.03
    extent = np.linalg.norm(native - native[0], axis=1).max()
    assert np.linalg.norm(path - native, axis=1).max() < 0.01 * extent


def led(mbs, is_native, elements):
    """A mass hangs on a rope, and a spring leads it, whose offset a step function sets."""
    section = {"massPerLength": 0.2, "bendingStiffness": 0.05, "axialStiffness": 4e5, "axialDamping": 10.0}
    template = ObjectANCFCable2D(**section)
    where = {"positionEnd": [0, -2, 0], "gravity": [0, -9.81, 0], "groundConstraintsStart": PINNED}
    nodes = cable(mbs, is_native, template, elements, **where)
    mass = mbs.CreateMassPoint(
        referencePosition=[0, -2, 0], mass=0.05, gravity=[0, -9.81, 0], create2D=True, returnDict=True
    )
    on_mass, end = (
        mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (mass["nodeNumber"], nodes[-1])
    )
    mbs.AddObject(SphericalJoint(markerNumbers=[on_mass, end], constrainedAxes=[1, 1, 0]))
    place = MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[0, -2, 0])
    spring = {"stiffness": [2e4, 0, 0], "damping": [100.0, 0, 0]}
    leader = mbs.AddObject(CartesianSpringDamper(markerNumbers=[mbs.AddMarker(place), end], **spring))

    def lead(mbs, t):
        mbs.SetObjectParameter(leader, "offset", [0.4 * t**3, 0, 0])
        return True

    mbs.SetPreStepUserFunction(lead)
    return nodes


def test_beside_step_functions_steps_that_become_shorter_set_no_hidden_energy_free():
    """Such a run does not begin again. It took 7000 steps, and said that energy had grown by 43 %."""
    path, report = path_and_report(led, 1.0, steps=200)
    assert report["steps"] < 2000
    assert report["drift"]["energyGain"] < 1e-3
    small, _ = path_and_report(led, 1.0, steps=200, stepSize=2e-4)
    np.testing.assert_allclose(path, small, atol=4e-5)  # a ten thousandth of the way


def test_work_that_is_missed_between_two_looks_at_the_energy_does_not_shorten_the_steps():
    """A riser of 60 t in water, whose top heaves by 3 m: axial waves make the power of its top jump."""
    mbs, frequency = exudyn.SystemContainer().AddSystem(), 2.0 * np.pi / 10.0
    riser = InextensibleCable(200.0, 1e5, bendingDamping=1e4, axialStiffness=1e9)
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [0, -300, 0], 40, riser, gravity=[0, -8.3, 0])
    SetCableDrag(mbs, cable, CableDrag(1.2, 0.01, diameter=0.3, fluidDensity=1025.0))
    markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))]
    for axis in range(2):
        top = MarkerNodeCoordinate(nodeNumber=cable["nodes"][0], coordinate=axis)
        markers.append(mbs.AddMarker(top))
    mbs.AddObject(CoordinateConstraint(markerNumbers=markers[:2]))
    heave = CoordinateConstraint(
        markerNumbers=[markers[0], markers[2]],
        offsetUserFunction=lambda mbs, t, item, offset: 1.5 * (1.0 - math.cos(frequency * t)),
    )
    mbs.AddObject(heave)
    mbs.Assemble()
    report = SolveExplicit(mbs, quiet_settings(8.0, 16, 0.5))
    assert report["steps"] < 1.1 * 8.0 / report["bounds"].accuracy
    assert report["drift"]["energyGain"] == 0.0


def test_joints_pull_with_the_momentum_that_they_give_to_a_body_on_a_damped_cable():
    """Bending damping acts on the curvature alone, and not on how the stretch varies along the cable."""
    mbs, gravity, period = exudyn.SystemContainer().AddSystem(), np.array([0, 0, -9.81]), 5e-4
    template = ObjectANCFCable(
        massPerLength=0.5, bendingStiffness=0.05, bendingDamping=0.02, axialStiffness=2.5e4
    )
    pinned = {"groundConstraintsStart": [True] * 3 + [False] * 3, "gravity": gravity.tolist()}
    nodes = cable(mbs, False, template, 12, positionEnd=[1, 0, 0], **pinned)
    body = mbs.CreateMassPoint(referencePosition=[1, 0, 0], mass=1.0, gravity=gravity, returnDict=True)
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (nodes[-1], body["nodeNumber"])]
    joint = mbs.AddObject(SphericalJoint(markerNumbers=ends))
    force, velocity = exudyn.OutputVariableType.Force, exudyn.OutputVariableType.Velocity
    pull = mbs.AddSensor(SensorObject(objectNumber=joint, outputVariableType=force, storeInternal=True))
    speed = SensorNode(nodeNumber=body["nodeNumber"], outputVariableType=velocity, storeInternal=True)
    sensor = mbs.AddSensor(speed)
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(0.3, 600, period))
    pulls, speeds = (np.array(mbs.GetSensorStoredData(one))[:, 1:] for one in (pull, sensor))
    given = speeds[-1] - speeds[0] - 0.3 * gravity
    np.testing.assert_allclose(-np.trapezoid(pulls, dx=period, axis=0), given, atol=1e-3 * given.max())


@pytest.mark.parametrize(
    ("stiffness", "remedy"), [(4.0, "take a smaller stepSize"), (1e5, "take stepSize = .* resolves axial")]
)
def test_whoever_is_warned_of_energy_is_told_of_smaller_steps_than_were_taken(stiffness, remedy, monkeypatch):
    """Where they resolve axial waves, the step that does is no remedy."""
    mbs = exudyn.SystemContainer().AddSystem()
    template = InextensibleCable(0.05, 1e-3, axialStiffness=stiffness)
    cable(mbs, False, template, 10, **HANGING, groundConstraintsStart=PINNED)
    mbs.Assemble()
    grown = {"energyGain": 0.1, "energyLoss": 0.0, "constraints": 0.0}
    monkeypatch.setattr(RunWatch, "figures", lambda watch: grown)
    with pytest.warns(UserWarning, match=rf"energyTolerance 0\.30%\): {remedy}"):
        SolveExplicit(mbs, quiet_settings(0.1, 20))


def lifted_and_blown(is_native, mass=600.0, **explicit):
    """Pull (T, 3) of an unstretched rope that a load hangs on, in a wind that depends on its speed."""
    mbs, gravity, end = exudyn.SystemContainer().AddSystem(), [0, -9.81, 0], 1.0
    template = ObjectANCFCable2D(
        massPerLength=1.2, bendingStiffness=5.0, bendingDamping=0.1, axialStiffness=4e5
    )
    line = {"positionEnd": [0, -5, 0], "gravity": gravity, "groundConstraintsStart": PINNED}
    nodes = cable(mbs, is_native, template, 6, **line)
    where = {"referencePosition": [0, -5, 0], "gravity": gravity}
    load = mbs.CreateMassPoint(mass=mass, create2D=True, returnDict=True, **where)
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (nodes[-1], load["nodeNumber"])]
    joint = mbs.AddObject(SphericalJoint(markerNumbers=ends, constrainedAxes=[1, 1, 0]))
    velocity = exudyn.OutputVariableType.Velocity

    def wind(mbs, t, loadVector):
        speed = mbs.GetNodeOutput(load["nodeNumber"], velocity)[0]
        return [500.0 * math.sin(2.0 * t) ** 2 - 20.0 * speed, 0, 0]

    mbs.AddLoad(LoadForceVector(markerNumber=ends[1], loadVectorUserFunction=wind))
    force = exudyn.OutputVariableType.Force
    sensor = mbs.AddSensor(SensorObject(objectNumber=joint, outputVariableType=force, storeInternal=True))
    mbs.Assemble()
    settings = quiet_settings(end, 1000 if is_native else 100, 0.01)
    if is_native:
        mbs.SolveDynamic(settings)
    else:
        SolveExplicit(mbs, settings, ExplicitSettings(**explicit))
    return np.array(mbs.GetSensorStoredData(sensor))[1:, 1:]


def test_steps_become_shorter_as_a_load_pulls_its_rope_tight():
    """The force was off by 30 %, without a word: at the start, where the step is chosen, nothing pulls."""
    pull, native = lifted_and_blown(False), lifted_and_blown(True)
    assert np.abs(pull - native).max() < 0.01 * np.abs(native).max()


def test_a_given_step_that_is_too_long_for_a_rope_that_is_pulled_tight_is_told_of():
    with pytest.warns(UserWarning, match=r"pulled so tight that the stability limit fell to 0\.00.* below"):
        lifted_and_blown(False, mass=700.0, stepSize=1.0 / 300.0, energyTolerance=1.0)


@pytest.mark.parametrize("axial_damping", [0.0, 5.0])
def test_accelerations_of_a_cable_whose_support_is_moved_are_the_rates_of_its_velocities(axial_damping):
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(1.0, 2.0, bendingDamping=0.02, axialStiffness=4e3, axialDamping=axial_damping)
    nodes = cable(mbs, False, section, 6, **HANGING)
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    held = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=k)) for k in (0, 1)]
    _, up = (mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker])) for marker in held)

    def lift(mbs, t):
        mbs.SetObjectParameter(up, "offset", 0.02 * (1.0 - math.cos(20.0 * t)))
        return True

    mbs.SetPreStepUserFunction(lift)
    kinds = exudyn.OutputVariableType.Coordinates_t, exudyn.OutputVariableType.Coordinates_tt
    node = {"nodeNumber": nodes[-1], "storeInternal": True}
    sensors = [mbs.AddSensor(SensorNode(**node, outputVariableType=kind)) for kind in kinds]
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(0.1, 200, 5e-4))
    rows, accelerations = (np.array(mbs.GetSensorStoredData(sensor)) for sensor in sensors)
    rates = (rows[2:] - rows[:-2])[:, 1:] / 1e-3
    lacking = (rates - accelerations[1:-1, 1:])[20:]
    assert (np.linalg.norm(lacking, axis=0) < 0.1 * np.linalg.norm(accelerations[:, 1:], axis=0)).all()
