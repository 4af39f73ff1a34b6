"""What a watched run says: reports, messages; among bodies as for cables alone."""

from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePoint2DSlope1,
    NodePointGround,
    ObjectANCFCable2D,
    ObjectConnectorCartesianSpringDamper,
    SensorNode,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    AttachToBody,
    CreateInextensibleCable,
    CreatePrescribedMotion,
    DivergenceError,
    ExplicitSettings,
    InextensibleCable,
    ReplaceNativeCables,
    SolveExplicit,
)
from reference_models.inextensible import build
from reference_models.model import quiet_settings
from reference_models.scenes import load_scene
from tests.exudyn_binding.items import load_node

LIMIT = 0.00274159  # of the step of the pendulum with N = 5 [s]


def test_a_run_reports_how_well_it_kept_energy_and_constraints(twin, solve):
    calm = solve(twin().mbs, 5.0)["drift"]
    assert calm["energyGain"] < 1e-6 and calm["energyLoss"] < 1e-5 and calm["constraints"] < 1e-9
    zhai = solve(twin().mbs, 5.0, integrator="Zhai", stepSize=2.5e-3)["drift"]
    assert 1e-4 < zhai["energyGain"] < 1e-3
    assert 1e-6 < zhai["constraints"] < 1e-3


def test_a_long_run_says_how_near_the_step_came_to_the_present_stability_limit(twin, solve):
    """The limit is lowest where the cable is straight; the pendulum starts so, and swings through it."""
    report = solve(twin().mbs, settings=quiet_settings(60.0, 1, 0.1), stepSize=2.5e-3)
    at_start = report["stepSize"] / report["bounds"].bending
    assert 0.9 * at_start < report["drift"]["stepOverLimit"] < 1.05 * at_start


def test_slow_growth_is_explained_with_time_cable_element_quantity_cause_and_remedy(twin, solve):
    built = twin()
    message = (
        r"diverged before t = [\d.]+ s\. cable 'object0': it has more energy than the work done on "
        r"it explains, by [\d.]+% of the energy of its motion \(limit 9\.00%\).*between nodes "
        r"\d and \d\. Likely cause: Zhai, at [89]\d% of the stability limit"
        r".*integrator='RATTLE'.*mbs holds the last good output, that of t = ([\d.]+) s"
    )
    with pytest.raises(DivergenceError, match=message):
        solve(built.mbs, 100.0, integrator="Zhai", stepSize=2.5e-3)
    rows = np.asarray(built.mbs.GetSensorStoredData(built.tip))
    assert 15.0 < rows[-1, 0] == pytest.approx(built.mbs.systemData.GetTime(), abs=0.011)
    assert np.abs(rows[:, 1:3]).max() < 1.81


def test_without_tolerance_the_energy_is_not_looked_at(twin, solve, without_smaller_steps):
    with pytest.raises(DivergenceError, match=r"not finite|is violated"):
        solve(twin().mbs, 100.0, integrator="Zhai", stepSize=2.5e-3, energyTolerance=np.inf)


def test_a_step_above_the_limit_is_named_as_the_cause(twin, solve, without_smaller_steps):
    with (
        pytest.warns(UserWarning, match="stability limit"),
        pytest.raises(
            DivergenceError, match=r"step of 0\.005 s is above the stability limit.*0\.002[78]\d* s"
        ),
    ):
        solve(twin().mbs, 1.0, stepSize=5e-3, allowUnstableStep=True)


def test_a_scheme_that_gains_energy_slowly_is_warned_of_once(twin, solve):
    """The paper's Zhai at its own step: it goes on."""
    with pytest.warns(UserWarning, match=r"energy has grown by (0\.9|1\.)\d*%.*RATTLE") as caught:
        report = solve(twin().mbs, 30.0, integrator="Zhai", stepSize=2.5e-3)
    assert len(caught) == 1 and 0.003 < report["drift"]["energyGain"] < 0.09


def swing_among_bodies(mbs, add_cable, kind):
    """A cable whose upper end is held by a spring, or moved, and a brick at the lower one."""
    held = {"groundConstraintsStart": [True, True, False, False]} if kind == "pinned" else {}
    cable = add_cable(mbs, **held)
    if kind == "on a spring":
        ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround()))
        node = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][0]))
        spring = {"stiffness": [200.0] * 3, "damping": [0.2] * 3}
        mbs.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=[ground, node], **spring))
    elif kind == "on a moving support":
        CreatePrescribedMotion(mbs, cable["nodes"][0], lambda t: [0.1 * (1.0 - np.cos(6.0 * t)), 0.0])
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]),
        referencePosition=[1.85, 0, 0],
        gravity=[0, -9.81, 0],
        nodeType=exudyn.NodeType.RotationRxyz,
        returnDict=True,
    )
    AttachToBody(mbs, cable, "end", body["bodyNumber"], [-0.05, 0, 0])
    mbs.Assemble()
    return cable


@pytest.mark.parametrize("kind", ["pinned", "on a spring", "on a moving support"])
def test_among_bodies_springs_joints_and_moving_supports_the_account_is_balanced(mbs, add_cable, solve, kind):
    swing_among_bodies(mbs, add_cable, kind)
    drift = solve(mbs, 0.8, stepSize=5e-4)["drift"]
    assert drift["energyGain"] < 2e-3 and drift["energyLoss"] < 2e-3
    assert 0.0 < drift["constraints"] < 1e-8


def test_a_force_that_runs_away_among_bodies_is_no_fault_of_the_energy(mbs, add_pendulum, solve):
    """Exudyn's work counts: a strong force gives much energy, and the account stays balanced."""
    cable = add_pendulum(mbs)
    mbs.CreateMassPoint(mass=1.0, referencePosition=[0, 0, 0])
    load_node(mbs, cable["nodes"][-1], [0, 1, 0], loadVectorUserFunction=lambda mbs, t, f: [0, 5.0 * t, 0])
    mbs.Assemble()
    drift = solve(mbs, settings=quiet_settings(0.3, 30), stepSize=5e-4)["drift"]
    assert drift["energyGain"] < 2e-3


def test_work_is_known_where_a_load_turns_around_within_an_inspection():
    """The ring with a step of an eightieth of its load's period: 160 steps are two of them."""
    model = build(load_scene("vibrating_ring"), 12)
    explicit = ExplicitSettings("RATTLE", stepSize=2.5e-3, massScaling=0.25)
    drift = SolveExplicit(model.mbs, quiet_settings(0.6, 60), explicit)["drift"]
    assert drift["energyGain"] < 1e-3 and drift["energyLoss"] < 1e-3


@pytest.mark.parametrize("rate", [3.0, 20.0, 60.0])
def test_a_support_that_moves_fast_is_no_fault_of_the_energy(mbs, add_cable, solve, rate):
    cable = add_cable(mbs)
    CreatePrescribedMotion(mbs, cable["nodes"][0], lambda t: [0.02 * (1.0 - np.cos(rate * t)), 0.0])
    mbs.Assemble()
    assert solve(mbs, 1.0, integrator="RATTLE")["drift"]["energyGain"] < 1e-3


def end_of_shaken_bar(is_native, steps, **settings):
    """Tip after 0.01 s of a steel bar whose base begins to swing at 12.6 m/s, as in ANCFcantileverTestDyn.

    And the report of the run.
    """
    mbs = exudyn.SystemContainer().AddSystem()
    nodes = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[0.125 * k, 0, 1, 0])) for k in range(17)]
    section = {"massPerLength": 78.0, "bendingStiffness": 1.725e6, "axialStiffness": 2.07e9}
    for pair in pairwise(nodes):
        mbs.AddObject(ObjectANCFCable2D(length=0.125, nodeNumbers=list(pair), **section))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for coordinate in (0, 1, 3):
        swing = (lambda mbs, t, number, offset: 0.1 * np.sin(40.0 * np.pi * t)) if coordinate == 1 else 0
        own = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, own], offsetUserFunction=swing))
    report = {}
    if is_native:
        mbs.Assemble()
        mbs.SolveDynamic(quiet_settings(0.01, steps))
    else:
        ReplaceNativeCables(mbs)
        mbs.Assemble()
        report = SolveExplicit(mbs, quiet_settings(0.01, steps), ExplicitSettings(**settings))
    return mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Displacement), report


@pytest.mark.filterwarnings("ignore:.*have been projected onto the constraints")
@pytest.mark.parametrize("step", [1.25e-5, 5e-6, 2.5e-6])
def test_power_of_a_support_that_trembles_is_no_jump_of_the_energy(step):
    """Steps were rejected, or said to gain energy, and those of 5e-6 s to diverge."""
    end, report = end_of_shaken_bar(False, 400, stepSize=step, massScaling=0.3, rejectSteps=True)
    expected, _ = end_of_shaken_bar(True, 4000)
    assert report["rejections"] == 0
    assert report["drift"]["energyGain"] < 1e-3 and report["drift"]["energyLoss"] < 1e-3
    np.testing.assert_allclose(end, expected, atol=3e-3 * 0.1)  # of the swing


def tip_of_pendulum(swing, end, dimension):
    """Sideways path of the tip over the first deflection `swing` [rad], each second; and the report."""
    mbs = exudyn.SystemContainer().AddSystem()
    cable = CreateInextensibleCable(
        mbs,
        [0, 0, 0],
        [2.0 * np.sin(swing), -2.0 * np.cos(swing), 0],
        8,
        InextensibleCable(massPerLength=1.2, bendingStiffness=0.05),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True] * dimension + [False] * dimension,
        dimension=dimension,
    )
    tip = SensorNode(
        nodeNumber=cable["nodes"][-1],
        storeInternal=True,
        outputVariableType=exudyn.OutputVariableType.Position,
    )
    sensor = mbs.AddSensor(tip)
    mbs.Assemble()
    report = SolveExplicit(mbs, quiet_settings(end, round(end), 1.0))
    return mbs.GetSensorStoredData(sensor)[:, 1] / (2.0 * swing), report


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_smallest_motions_are_no_divergence(dimension):
    """Round-off of places does work on a cable at rest; of its motion, that may be any share."""
    small, report = tip_of_pendulum(1e-9, 60.0, dimension)
    large, _ = tip_of_pendulum(1e-5, 60.0, dimension)
    assert report["rejections"] == 0
    assert small == pytest.approx(large, abs=1e-3)
