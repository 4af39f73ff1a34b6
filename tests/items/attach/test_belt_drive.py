"""A belt drive: a closed cable around two wheels, one of which drives, and the other one tightens."""

from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadCoordinate,
    MarkerNodeCoordinate,
    MarkerNodeRigid,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectRigidBody2D,
    SensorObject,
)

from exudyn_inext import CableShape, CreateCompanionCables, CreateInextensibleCable, InextensibleCable
from exudyn_inext.native.coupled_scene import CoupledScene
from exudyn_inext.run.coupled_watch import CoupledWatch
from exudyn_inext.run.watch import UNSTABLE
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import trajectory
from tests.items.attach.contact import SEGMENTS, Circle, add_contact

RADIUS, APART, ARC, SPAN = 0.1, 0.3, 8, 6  # of wheels, their distance [m]; elements of an arc and between
SECTION = {"massPerLength": 0.1, "bendingStiffness": 2e-3}
BRISTLES = {"friction_stiffness": 1e5, "friction_damping": 0.0}
TORQUE, PULL, END = 0.2, 40.0, 0.1  # [Nm], [N], [s]


def around():
    """Positions, slopes and lengths of elements, counterclockwise from below the first wheel."""
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, ARC + 1)[:-1]
    right = RADIUS * np.column_stack([np.cos(turn), np.sin(turn)])
    way = APART * np.linspace(0.0, 1.0, SPAN + 1)[:-1]
    below = np.column_stack([way, np.full(SPAN, -RADIUS)])
    apart = np.array([APART, 0.0])
    positions = np.concatenate([below, right + apart, apart - below, -right])
    along = np.column_stack([np.ones(SPAN), np.zeros(SPAN)])
    turning = np.column_stack([-right[:, 1], right[:, 0]]) / RADIUS
    slopes = np.concatenate([along, turning, -along, -turning])
    arcs, spans = np.full(ARC, np.pi * RADIUS / ARC), np.full(SPAN, APART / SPAN)
    return positions, slopes, np.concatenate([spans, arcs, spans, arcs])


def add_wheel(mbs, x, held):
    """A wheel whose coordinates of these numbers are held: its body, and its node."""
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[x, 0, 0]))
    wheel = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=0.5, inertia=2.5e-3))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for axis in held:
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    return wheel, node


def add_native(mbs, positions, slopes, lengths):
    nodes = [
        mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[*r, *slope]))
        for r, slope in zip(positions, slopes, strict=True)
    ]
    return [
        mbs.AddObject(ObjectANCFCable2D(nodeNumbers=list(pair), length=length, axialStiffness=2e4, **SECTION))
        for pair, length in zip(pairwise([*nodes, nodes[0]]), lengths, strict=True)
    ]


@pytest.fixture
def belt_drive(new_mbs, add_sensor):
    """(is native, friction) -> system, sensors of both wheels' coordinates."""

    def build(native=False, friction_stiffness=0.0, friction_damping=1000.0):
        mbs = new_mbs()
        positions, slopes, lengths = around()
        if native:
            elements = add_native(mbs, positions, slopes, lengths)
        else:
            shape = CableShape(positions, slopes, elementLengths=lengths, closed=True)
            cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=InextensibleCable(**SECTION))
            elements = CreateCompanionCables(mbs, cable)
        sensors, share = [], float(lengths.max()) / SEGMENTS
        along = friction_stiffness * share, friction_damping * share
        law = Circle(RADIUS, 5e5 * share, 300.0 * share, 0.4, *along)
        for x, held in ((0.0, (0, 1)), (APART, (1,))):
            wheel, node = add_wheel(mbs, x, held)
            axis, load = (0, PULL) if x else (2, TORQUE)
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
            mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=load))
            add_contact(mbs, elements, law, wheel)
            sensors.append(add_sensor(mbs, node, "Coordinates"))
        mbs.Assemble()
        return mbs, sensors

    return build


def turns(mbs, sensors):
    """Of both wheels [rad], at all outputs."""
    return np.array([trajectory(mbs, sensor)[:, 3] for sensor in sensors])


def test_a_belt_drive_turns_as_a_native_one(belt_drive, solve):
    mbs, sensors = belt_drive()
    report = solve(mbs, END)
    assert "in one compiled call" in report["path"]
    twin, native = belt_drive(native=True)
    settings = quiet_settings(END, 500)
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.timeIntegration.discontinuous.ignoreMaxIterations = True
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    with silence():
        twin.SolveDynamic(settings)
    found, expected = turns(mbs, sensors)[:, -1], turns(twin, native)[:, -1]
    assert expected.min() > 0.1
    np.testing.assert_allclose(found, expected, rtol=0.02)


def test_a_general_contact_that_does_nothing_leaves_it_in_compiled_code(belt_drive, solve):
    found = []
    for has_sphere in (False, True):
        mbs, sensors = belt_drive()
        if has_sphere:
            contact = mbs.AddGeneralContact()
            contact.SetFrictionPairings(np.zeros((1, 1)))
            node = mbs.GetSensor(sensors[0])["nodeNumber"]
            marker = mbs.AddMarker(MarkerNodeRigid(nodeNumber=node))
            contact.AddSphereWithMarker(marker, RADIUS, 1e5, 0.0, 0)
            mbs.Assemble()
        assert "in one compiled call" in solve(mbs, 0.2 * END)["path"]
        found.append(turns(mbs, sensors))
    assert np.abs(found[0]).max() > 0.0
    np.testing.assert_array_equal(*found)


@pytest.fixture
def by_both(belt_drive, solve, monkeypatch):
    """(look at mbs, settings) -> what it saw after a compiled run, and after one that Exudyn evaluates.

    RK4 takes contact explicitly in both of them.
    """

    def run(look, steps=10, **explicit):
        found = []
        for path in ("in one compiled call", "this test"):
            mbs, sensors = belt_drive(**BRISTLES)
            forces = [add_force_sensor(mbs, number) for number in contacts_of(mbs)]
            mbs.Assemble()
            settings = quiet_settings(3e-3, steps)
            report = solve(mbs, settings=settings, stepSize=3e-5, integrator="RK4", **explicit)
            assert path in report["path"]
            found.append(look(mbs, sensors, forces, report))
            monkeypatch.setattr(CoupledScene, "compiled", lambda *_: (None, "this test"))
        return found

    return run


def contacts_of(mbs):
    numbers = range(mbs.systemData.NumberOfObjects())
    return [n for n in numbers if "Contact" in mbs.GetObject(n)["objectType"]]


def add_force_sensor(mbs, number):
    local = exudyn.OutputVariableType.ForceLocal
    return mbs.AddSensor(SensorObject(objectNumber=number, outputVariableType=local, storeInternal=True))


def test_a_compiled_belt_drive_turns_as_exudyn_says(by_both):
    found = by_both(lambda mbs, sensors, *_: turns(mbs, sensors))
    assert np.abs(found[0][1]).max() > 0.0
    np.testing.assert_allclose(*found, rtol=0, atol=1e-9 * np.abs(found[1]).max())


def test_sensors_show_the_forces_of_compiled_contact_at_all_outputs(by_both):
    found = by_both(lambda mbs, _, forces, __: np.array([trajectory(mbs, force) for force in forces]))
    assert (found[0][:, :, 1:] != 0.0).any(axis=2).any(axis=0)[1:].all()
    np.testing.assert_allclose(*found, rtol=0, atol=1e-7 * np.abs(found[1]).max())


def test_contact_that_is_changed_is_evaluated_by_exudyn_from_then_on(belt_drive, solve, monkeypatch):
    def loosen(mbs, t):
        if 1.4e-3 < t < 1.6e-3:
            for number in contacts_of(mbs):
                mbs.SetObjectParameter(number, "frictionCoefficient", 0.05)
        return True

    found = []
    for path in ("may look at it", "items that were changed", "this test"):
        mbs, sensors = belt_drive(**BRISTLES)
        if found:
            mbs.SetPreStepUserFunction(loosen)
        else:
            mbs.SetPreStepUserFunction(lambda mbs, t: True)
        settings = quiet_settings(3e-3, 20)
        assert path in solve(mbs, settings=settings, stepSize=3e-5, integrator="RK4")["path"]
        found.append(turns(mbs, sensors))
        if len(found) == 2:
            monkeypatch.setattr(CoupledScene, "compiled", lambda *_: (None, "this test"))
    unchanged, ours, theirs = found
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max())
    assert np.abs(ours - unchanged).max() > 1e-4 * np.abs(theirs).max()


def test_what_contact_remembers_is_that_of_the_last_good_state(by_both, monkeypatch):
    """A look at the run refuses what came before; half the step follows."""
    is_well, refusals = CoupledWatch.is_well_at, []

    def refuse_once(watch, t, h, state, at_once=False):
        if not refusals:
            refusals.append(t)
            return watch._condemn(state, UNSTABLE, 2.0)
        return is_well(watch, t, h, state, at_once)

    def look(mbs, sensors, forces, report):
        refusals.clear()
        assert report["rejections"] == 1
        return np.array(mbs.systemData.GetDataCoordinates())

    monkeypatch.setattr(CoupledWatch, "is_well_at", refuse_once)
    found = by_both(look, steps=1)
    np.testing.assert_allclose(*found, rtol=0, atol=1e-9)


def test_two_halves_of_a_belt_drive_are_the_whole_run_bit_for_bit(belt_drive, solve, tmp_path):
    def restarting(end):
        settings = quiet_settings(end, 1)
        restart = settings.solution.restart
        restart.name, restart.writePeriod = str(tmp_path / "belt.restart"), 3e-3
        restart.write = restart.continueIfAvailable = True
        return settings

    def state(mbs):
        data = mbs.systemData
        return np.array(
            [*data.GetODE2Coordinates(), *data.GetODE2Coordinates_t(), *data.GetDataCoordinates()]
        )

    whole, _ = belt_drive(**BRISTLES)
    solve(whole, settings=quiet_settings(6e-3, 1), stepSize=3e-5)
    for end in (3e-3, 6e-3):
        part, _ = belt_drive(**BRISTLES)
        report = solve(part, settings=restarting(end), stepSize=3e-5)
    assert report["resumedAt"] == pytest.approx(3e-3)
    np.testing.assert_array_equal(state(part), state(whole))
