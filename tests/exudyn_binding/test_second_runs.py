"""A run of an mbs begins at the initial configuration, whatever earlier runs have left in it."""

from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    CoordinateConstraint,
    Force,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericData,
    NodePointGround,
    ObjectANCFCable2D,
    SensorBody,
    SphericalJoint,
    TorsionalSpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    AddMarkerOnCable,
    ExplicitSettings,
    ExplicitSolver,
    InputError,
    SceneError,
    SolveEquilibrium,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence


def solve_by_calls(mbs, settings):
    solver = ExplicitSolver(ExplicitSettings(stepSize=1e-3))
    with silence():
        solver.InitializeSolver(mbs, settings)
        solver.SolveSteps(mbs, settings)
        solver.FinalizeSolver(mbs, settings)


@pytest.fixture
def rotor_on_a_cable(mbs, add_pendulum):
    """mbs, and the sensor of a rotor below the end of a cable, on a spring that counts its turns."""
    cable = add_pendulum(mbs, dimension=3, groundConstraintsStart=[True] * 3 + [False] * 3)
    bodies = [
        mbs.CreateRigidBody(
            inertia=InertiaCuboid(500, [0.1, 0.06, 0.04]),
            referencePosition=[1.85, 0, 0],
            gravity=[0, -9.81, 0],
            initialAngularVelocity=[spin, 0, 0],
        )
        for spin in (0, 90)
    ]
    ends = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=k, localPosition=[-0.05, 0, 0])) for k in bodies]
    mbs.AddObject(SphericalJoint(markerNumbers=[AddMarkerOnCable(mbs, cable, 1.8), ends[0]]))
    place = {"itemNumbers": bodies, "position": [1.85, 0, 0], "axis": [1, 0, 0]}
    mbs.CreateRevoluteJoint(**place)
    turns = mbs.AddNode(NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1))
    axis = exudyn.HT(rotation=[[0, 0, 1], [0, 1, 0], [-1, 0, 0]], translation=[0, 0, 0])
    frames = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=k, localHT=axis)) for k in bodies]
    mbs.AddObject(TorsionalSpringDamper(markerNumbers=frames, nodeNumber=turns, stiffness=0.01))
    kind = exudyn.OutputVariableType.AngularVelocity
    sensor = mbs.AddSensor(SensorBody(bodyNumber=bodies[1], storeInternal=True, outputVariableType=kind))
    mbs.Assemble()
    return mbs, sensor


@pytest.mark.parametrize("by_calls", [False, True])
def test_a_second_run_is_the_first_one(rotor_on_a_cable, solve, by_calls):
    mbs, sensor = rotor_on_a_cable
    rows = []
    for _ in range(2):
        settings = quiet_settings(0.1, 50)
        if by_calls:
            solve_by_calls(mbs, settings)
        else:
            solve(mbs, settings=settings, stepSize=1e-3)
        rows.append(np.array(mbs.GetSensorStoredData(sensor)))
    assert mbs.systemData.GetDataCoordinates()[0] != 0.0
    np.testing.assert_array_equal(*rows)


def test_a_run_goes_on_from_where_the_last_one_has_ended(rotor_on_a_cable):
    mbs, sensor = rotor_on_a_cable
    settings, rows, explicit = quiet_settings(0.1, 50), [], ExplicitSettings(stepSize=1e-3)
    with silence():
        SolveExplicit(mbs, settings, explicit)
        whole = mbs.GetSensorStoredData(sensor)
        for start in (0.0, 0.04):
            time = settings.timeIntegration
            time.startTime, time.endTime, time.numberOfSteps = start, start + 0.04, 20
            SolveExplicit(mbs, settings, explicit, updateInitialValues=True)
            rows.append(mbs.GetSensorStoredData(sensor))
    np.testing.assert_array_equal(rows[0][-1], rows[1][0])
    np.testing.assert_allclose(rows[1], whole[4:9], rtol=1e-5, atol=1e-5)
    with pytest.raises(InputError, match="updateInitialValues = 'yes': must be True or False"):
        SolveExplicit(mbs, settings, updateInitialValues="yes")


def test_an_equilibrium_does_not_depend_on_a_run_before_it(rotor_on_a_cable, solve):
    mbs, _ = rotor_on_a_cable
    initial = exudyn.ConfigurationType.Initial
    start = mbs.systemData.GetSystemState(initial)
    solve(mbs, settings=quiet_settings(0.1, 50), stepSize=1e-3)
    places = []
    for _ in range(2):
        mbs.systemData.SetSystemState(start, initial)
        with pytest.warns(UserWarning, match="initial velocities"):
            SolveEquilibrium(mbs)
        places.append(mbs.systemData.GetODE2Coordinates())
    np.testing.assert_array_equal(*places)


def test_an_offset_that_a_run_has_left_is_refused_and_the_remedy_works(mbs, add_cable, solve):
    nodes = add_cable(mbs)["nodes"]
    ground = mbs.AddNode(NodePointGround())
    markers = [
        mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=0)) for node in (ground, nodes[0])
    ]
    support = mbs.AddObject(CoordinateConstraint(markerNumbers=markers))
    mbs.SetPreStepUserFunction(lambda mbs, t: mbs.SetObjectParameter(support, "offset", 0.5 * t) or True)
    mbs.Assemble()
    solve(mbs, 0.1, steps=10)
    end = mbs.systemData.GetODE2Coordinates()
    with pytest.raises(SceneError, match=r"node 0 .*by 0\.05 .*set an offset back that .* earlier run"):
        solve(mbs, 0.1, steps=10)
    mbs.SetObjectParameter(support, "offset", 0.0)
    solve(mbs, 0.1, steps=10)
    np.testing.assert_array_equal(mbs.systemData.GetODE2Coordinates(), end)


def test_velocities_that_a_native_run_has_left_are_taken_without_a_warning(mbs, add_pendulum, solve):
    """Its steps leave 1e-5 of their constraints' rates: it was advised to correct the initial values."""
    add_pendulum(mbs, enforcement="algebraic")
    mbs.Assemble()
    settings = quiet_settings(0.4, 200)
    with silence():
        mbs.SolveDynamic(settings)
    data = mbs.systemData
    data.SetSystemState(data.GetSystemState(), exudyn.ConfigurationType.Initial)
    settings.timeIntegration.startTime, settings.timeIntegration.endTime = 0.4, 0.5
    assert solve(mbs, settings=settings)["success"]


def two_runs(mbs, cable, solve):
    """End of a falling cable, on which a force acts in the second run; nobody calls mbs.Assemble().

    To assemble mbs sets the initial values to those of the nodes, so that the second run begins anew.
    """
    settings = quiet_settings(0.1, 100)
    with silence():
        solve(settings, updateInitialValues=True)
        end = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        mbs.AddLoad(Force(markerNumber=end, loadVector=[0, 0.05, 0]))
        settings.timeIntegration.startTime, settings.timeIntegration.endTime = 0.1, 0.2
        solve(settings, updateInitialValues=True)
    return mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position)


def test_a_system_is_assembled_as_by_exudyns_solvers(mbs, new_mbs, add_pendulum):
    cable = add_pendulum(mbs)
    given = {
        "positionStart": [0, 0, 0],
        "positionEnd": [1.8, 0, 0],
        "numberOfElements": 10,
        "gravity": [0, -9.81, 0],
        "groundConstraintsStart": [True, True, False, False],
    }
    template = ObjectANCFCable2D(
        massPerLength=0.03477, bendingStiffness=0.08665, axialStiffness=86645, useReducedOrderIntegration=2
    )
    twin = new_mbs()
    native = two_runs(
        twin, GenerateBeamElementsAlongLine(twin, beamTemplate=template, **given), twin.SolveDynamic
    )
    found = two_runs(mbs, cable, partial(SolveExplicit, mbs))
    np.testing.assert_allclose(found, native, atol=1e-3)
    assert found[1] > -0.02  # without the force it is at -0.05


def test_an_equilibrium_is_that_of_a_system_that_it_assembles(mbs, new_mbs, add_pendulum):
    found = []
    for one, is_assembled in ((mbs, False), (new_mbs(), True)):
        cable = add_pendulum(one)
        if is_assembled:
            one.Assemble()
        with silence():
            SolveEquilibrium(one)
        found.append(one.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position))
    np.testing.assert_array_equal(*found)
    assert found[0][1] < -1.79
