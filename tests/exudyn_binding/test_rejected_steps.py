"""Steps that go wrong are taken again, smaller; only a smallest step ends a run."""

import re
import warnings
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericData,
    NodePointGround,
    ObjectContactCoordinate,
    ObjectContactCurveCircles,
    SensorNode,
    SphericalJoint,
    SpringDamper,
)
from exudyn.rigidBodyUtilities import InertiaCuboid

from exudyn_inext import (
    CreateInextensibleCable,
    DivergenceError,
    ExplicitSettings,
    InextensibleCable,
    SolveExplicit,
)
from exudyn_inext.run import step_control
from exudyn_inext.run.coupled_watch import CoupledWatch
from exudyn_inext.run.paced_run import PacedRun
from exudyn_inext.run.step_control import StepControl
from exudyn_inext.run.watch import JUMP
from exudyn_inext.scene.path_work import SCALE
from reference_models.model import quiet_settings
from studies.robust.scenes import build, lone_rope, mixed_rope
from studies.robustness import periods_before_snap
from tests.exudyn_binding.items import that_remembers

END, PERIOD = 1.5, 0.01
VIOLENT = [5, 6, 18, 20, 29]  # seeds of ropes that snap tight: with the rejections off all of them diverge


def fall(rope, end=END, restart=None, **explicit):
    """Path of the free end (T, 3) and report."""
    _container, mbs, sensor = build(rope)
    settings = quiet_settings(end, 1, PERIOD)
    if restart is not None:
        settings.solution.restart.write = settings.solution.restart.continueIfAvailable = True
        settings.solution.restart.name = str(restart)
        settings.solution.restart.writePeriod = 0.1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        report = SolveExplicit(mbs, settings, ExplicitSettings(**explicit))
    return np.array(mbs.GetSensorStoredData(sensor)[:, 1:4]), report


def torn(**explicit):
    """The tip (3,) of a light rope that a spring tears away from its place, after 10 ms."""
    mbs = exudyn.SystemContainer().AddSystem()
    light = InextensibleCable(massPerLength=0.015, bendingStiffness=1e-3, axialStiffness=3.6e4)
    pinned = {"groundConstraintsStart": [True, True, False, False]}
    nodes = CreateInextensibleCable(mbs, [0, 0, 0], [0.74, -0.575, 0], 9, light, **pinned)["nodes"]
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[-1]))
    anchor = MarkerBodyPosition(bodyNumber=mbs.CreateGround(referencePosition=[0, 0.5, 0]))
    both = {"markerNumbers": [mbs.AddMarker(anchor), tip], "stiffness": [30.0] * 3, "damping": [0.1] * 3}
    mbs.AddObject(CartesianSpringDamper(**both))
    mbs.Assemble()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        report = SolveExplicit(mbs, quiet_settings(0.01, 10), ExplicitSettings(**explicit))
    return mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position), report


def test_a_spring_that_tears_a_light_rope_away_is_met_with_smaller_steps():
    """Longer ones leave no number in its force, in a scene without joints."""
    found, report = torn()
    expected, fine = torn(stepSize=2e-6)
    assert report["steps"] < fine["steps"]
    np.testing.assert_allclose(found, expected, atol=0.02)  # it has moved by 0.66 m


def hooked(damping, law):
    """Report of a rope that a spring of this law pulls tight; nothing is stressed at the start."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=0.01, axialStiffness=2e4)
    pinned = {"groundConstraintsStart": [True, True, False, False], "gravity": [0, -9.81, 0]}
    rope = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, **pinned)
    load = mbs.CreateMassPoint(referencePosition=[1.2, 0, 0], mass=5.0, create2D=True, returnDict=True)
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (rope["nodes"][-1], load["nodeNumber"])]
    spring = {
        "referenceLength": 0.2,
        "stiffness": 2e3,
        "damping": damping,
        "springForceUserFunction": that_remembers(law),
    }
    mbs.AddObject(SpringDamper(markerNumbers=ends, **spring))
    mbs.AddLoad(LoadForceVector(markerNumber=ends[1], loadVector=[20, 0, 0]))
    mbs.Assemble()
    return SolveExplicit(mbs, quiet_settings(0.1, 25))


def damps_in_tension(mbs, t, item, stretch, velocity, stiffness, damping, force):
    return stiffness * stretch + damping * velocity if stretch > 0 else 0.0


def damps_always(mbs, t, item, stretch, velocity, stiffness, damping, force):
    return damping * velocity + (stiffness * stretch if stretch > 0 else 0.0)


@pytest.mark.parametrize("damping", [20.0, 80.0])
def test_steps_are_stable_where_a_function_damps_in_some_states_alone(damping):
    """At the start it does not, so that nobody knows; halved steps were too short, or not short enough."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="damping of")
        known = hooked(damping, damps_always)
    with pytest.warns(UserWarning, match=r"from t = .* s on damping of .* 1/s .* by user functions"):
        report = hooked(damping, damps_in_tension)
    assert report["bounds"].stability_limit > 4 * known["bounds"].stability_limit
    assert report["stepSize"] == pytest.approx(known["stepSize"], rel=0.05)
    assert report["rejections"] == 0


@pytest.mark.parametrize("seed", VIOLENT)
def test_ropes_that_snap_tight_run_to_their_end(seed, fault):
    path, report = fall(lone_rope(seed))
    assert len(path) == round(END / PERIOD) + 1 and np.isfinite(path).all()
    assert report["rejections"] > 0 and report["drift"]["energyGain"] < 0.05
    assert np.linalg.norm(path, axis=1).max() < 1.0 + 1e-6  # it is 1 m long
    fine, _ = fall(lone_rope(seed), stepSize=report["bounds"].accuracy / 4, allowUnstableStep=True)
    calm = periods_before_snap(fine)
    assert np.linalg.norm(path - fine, axis=1)[:calm].max() < 0.01
    fault(f"a rope that snaps tight (seed {seed})", f"{report['rejections']} times smaller steps, to its end")


@pytest.mark.parametrize("seed", [13, 50])
def test_energy_does_not_grow_by_jumps_too_small_to_be_rejected(seed):
    """Stiff ones that snap tight gained 15 % and 8 %, with as many steps."""
    _, report = fall(lone_rope(seed))
    assert report["drift"]["energyGain"] < 0.01


@pytest.mark.parametrize("curvature", [0.3, 1.0])
def test_zhai_begins_again_with_shorter_steps_where_it_gained_energy(curvature, new_mbs, solve):
    """A cable springs to its natural curvature, with a body: it kept 70 % too much, in smaller steps."""

    def tip(**explicit):
        mbs, pinned = new_mbs(), {"groundConstraintsStart": [True, True, False, False]}
        section = InextensibleCable(massPerLength=0.3, bendingStiffness=0.02, referenceCurvature=curvature)
        cable = CreateInextensibleCable(
            mbs, [0, 0, 0], [1, 0, 0], 8, section, gravity=[0, -9.81, 0], **pinned
        )
        body = mbs.CreateMassPoint(
            referencePosition=[1, 0, 0], mass=0.2, gravity=[0, -9.81, 0], create2D=True
        )
        pair = MarkerNodePosition(nodeNumber=cable["nodes"][-1]), MarkerBodyPosition(bodyNumber=body)
        both = [mbs.AddMarker(marker) for marker in pair]
        mbs.AddObject(SphericalJoint(markerNumbers=both, constrainedAxes=[1, 1, 0]))
        mbs.Assemble()
        report = solve(mbs, 1.0, steps=100, **explicit)
        return mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position), report

    fine, _ = tip(stepSize=5e-5)
    found, report = tip(integrator="Zhai")
    np.testing.assert_allclose(found, fine, atol=2e-3)
    assert report["drift"]["energyGain"] < 0.01


def test_without_smaller_steps_the_same_ropes_are_lost(monkeypatch):
    monkeypatch.setattr(step_control, "QUARTERS", 0)
    for seed in VIOLENT:
        with pytest.raises(DivergenceError, match=r"before t = .* smallest ones, went wrong, too"):
            fall(lone_rope(seed))


def test_the_mean_step_of_a_run_that_a_function_ends_is_that_of_its_steps(mbs, add_pendulum, solve):
    add_pendulum(mbs)
    mbs.SetPreStepUserFunction(lambda mbs, t: t < 0.25)
    mbs.Assemble()
    report = solve(mbs, 1.0, steps=100)
    assert report["meanStepSize"] == pytest.approx(report["stepSize"])


def test_steps_grow_again_after_a_snap():
    """Otherwise the run would take many times as many; the report tells the smallest and the mean step."""
    _, report = fall(lone_rope(20))
    nominal, mean = report["bounds"].accuracy, report["meanStepSize"]
    assert report["stepSize"] < 0.3 * nominal
    assert mean == END / report["steps"] > nominal / 3.0
    assert f"h = {mean:.4g} s on average, {report['stepSize']:.4g} s at least" in str(report)


def test_the_state_after_rejected_steps_is_the_one_before_them(tmp_path):
    """A run that is cut by restart files, between rejected steps, too, has the same bits."""
    rope = lone_rope(20)
    whole, _ = fall(rope, restart=tmp_path / "whole.npz")
    parts = [fall(rope, end, restart=tmp_path / "rope.npz")[0] for end in (0.4, 0.8, END)]
    joined = np.concatenate(parts)
    np.testing.assert_array_equal(joined, whole)


def test_a_step_above_the_stability_limit_is_taken_in_smaller_ones(twin, solve):
    built, fine = twin(), twin()
    with pytest.warns(UserWarning, match="stability limit"):
        report = solve(built.mbs, 1.0, stepSize=5e-3, allowUnstableStep=True)
    assert report["rejections"] > 0 and report["stepSize"] < 2.8e-3
    solve(fine.mbs, 1.0, stepSize=1e-3)
    coarse, exact = (np.asarray(b.mbs.GetSensorStoredData(b.tip)) for b in (built, fine))
    assert np.abs(coarse - exact).max() < 0.02


@pytest.mark.parametrize("seed", range(8))
def test_scenes_with_bodies_springs_and_contact_run_to_their_end(seed):
    path, _ = fall(mixed_rope(seed), end=0.8)
    assert len(path) == 81 and np.isfinite(path).all()
    assert np.linalg.norm(path, axis=1).max() < 1.0 + 1e-6


def test_a_joint_that_jerks_is_met_with_smaller_steps_among_bodies(mbs, add_pendulum, solve, add_sensor):
    """A mass point that falls along the cable until it pulls it tight."""
    from exudyn_inext import AttachToBody

    cable = add_pendulum(mbs, positionEnd=[0.6, 1.6, 0.0], numberOfElements=10)
    point = mbs.CreateMassPoint(mass=1.0, referencePosition=[0.6, 1.6, 0.0], gravity=[0, -9.81, 0])
    AttachToBody(mbs, cable, "end", point)
    node = mbs.GetObject(point)["nodeNumber"]
    sensor = add_sensor(mbs, node)
    mbs.Assemble()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        report = solve(mbs, settings=quiet_settings(1.2, 1, 0.01))
    path = np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4]
    length = np.hypot(0.6, 1.6)
    assert len(path) == 121 and np.linalg.norm(path, axis=1).max() < length * (1.0 + 1e-3)
    assert report["drift"]["constraints"] < 0.05


def add_general_contact(mbs, body, gap, law):
    contact = mbs.AddGeneralContact()
    contact.SetFrictionPairings(np.zeros((1, 1)))
    contact.SetSearchTreeCellSize(numberOfCells=[4, 4, 4])
    ground = mbs.CreateMassPoint(referencePosition=[5.0, -0.2 - gap, 0.0], mass=1e6)
    for one in (body, ground):
        marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=one))
        contact.AddSphereWithMarker(marker, radius=0.1, frictionMaterialIndex=0, **law)


def add_coordinate_contact(mbs, body, gap, law):
    places = [(mbs.AddNode(NodePointGround()), 0), (mbs.GetObject(body)["nodeNumber"], 1)]
    markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=k)) for n, k in places]
    data = mbs.AddNode(NodeGenericData(initialCoordinates=[gap], numberOfDataCoordinates=1))
    mbs.AddObject(ObjectContactCoordinate(markerNumbers=markers, nodeNumber=data, offset=-gap, **law))


def add_light_mass(mbs, add_contact):
    """Of 0.1 g, dropped by 1 mm, whose energy nobody sees beside that of another body."""
    mbs.CreateMassPoint(referencePosition=[9.0, 0.0, 0.0], initialVelocity=[0.0, 1.0, 0.0], mass=10.0)
    light = mbs.CreateMassPoint(referencePosition=[5.0, 0.0, 0.0], mass=1e-4, gravity=[0.0, -9.81, 0.0])
    add_contact(mbs, light, 1e-3, {"contactStiffness": 3e3, "contactDamping": 4.0})
    mbs.Assemble()
    return light


def height_of(mbs, body):
    return mbs.GetObjectOutputBody(body, exudyn.OutputVariableType.Displacement, [0, 0, 0])[1]


@pytest.mark.parametrize("add_contact", [add_general_contact, add_coordinate_contact])
def test_contact_does_not_throw_a_light_body_off_beside_heavy_ones(mbs, add_pendulum, solve, add_contact):
    add_pendulum(mbs)
    light = add_light_mass(mbs, add_contact)
    solve(mbs, 0.03, steps=30)
    assert height_of(mbs, light) == pytest.approx(-1e-3, abs=2e-5)


def test_a_body_that_contact_throws_off_in_given_steps_is_named_with_one_that_helps(mbs, add_pendulum, solve):
    add_pendulum(mbs)
    light = add_light_mass(mbs, add_coordinate_contact)
    with pytest.warns(UserWarning, match="contact threw node .* off at .* m/s") as caught:
        solve(mbs, 0.03, steps=30, stepSize=1e-3, rejectSteps=False)
    assert height_of(mbs, light) > 0.1
    advised = float(re.search(r"stepSize = ([\d.e-]+)", str(caught[0].message))[1])
    solve(mbs, 0.03, steps=30, stepSize=advised, rejectSteps=False)
    assert height_of(mbs, light) == pytest.approx(-1e-3, abs=2e-5)


def add_cam_and_follower(mbs):
    """A circle that turns off its centre moves a block along x, which a spring presses onto it; no cable."""
    inertia = InertiaCuboid(1000.0, [0.08, 0.06, 0.06])
    cam, follower = (
        mbs.CreateRigidBody(referencePosition=[x, 0, 0], inertia=inertia, create2D=True) for x in (0.0, 0.1)
    )
    for body, coordinate, offset in (
        (cam, 0, {}),
        (cam, 1, {}),
        (cam, 2, {"velocityLevel": True, "offset": 25.0}),
    ):
        mbs.CreateCoordinateConstraint(itemNumbers=[None, body], coordinates=[None, coordinate], **offset)
    for coordinate in (1, 2):
        mbs.CreateCoordinateConstraint(itemNumbers=[None, follower], coordinates=[None, coordinate])
    ends = dict(itemNumbers=[mbs.CreateGround(), follower], localPosition0=[0.2, 0, 0])
    mbs.CreateSpringDamper(**ends, referenceLength=0.12, stiffness=1000.0, damping=20.0)
    places = (follower, [0, 0, 0]), (cam, [0.02, 0, 0])
    markers = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=place)) for body, place in places]
    data = mbs.AddNode(NodeGenericData(initialCoordinates=[-1, 0, 0], numberOfDataCoordinates=3))
    face = exudyn.MatrixContainer(np.array([[-0.04, 0.03, -0.04, -0.03]]))
    contact = dict(circlesRadii=[0.04], segmentsData=face, contactStiffness=2e6, contactDamping=1e4)
    mbs.AddObject(ObjectContactCurveCircles(markerNumbers=markers, nodeNumber=data, **contact))
    mbs.Assemble()
    return follower


def test_contact_throws_off_no_held_coordinates_by_round_off_without_cables(mbs):
    follower = add_cam_and_follower(mbs)
    mbs.systemData.SetODE2Coordinates_t([0, 0, 25.0, 0, 0, 0], exudyn.ConfigurationType.Initial)
    mbs.SolveDynamic(quiet_settings(0.02, 1000))
    place = mbs.GetObjectOutputBody(follower, exudyn.OutputVariableType.Displacement, [0, 0, 0])[0]
    report = SolveExplicit(mbs, quiet_settings(0.02, 100))
    assert report["steps"] == 100 and report["rejections"] == 0
    moved = mbs.GetObjectOutputBody(follower, exudyn.OutputVariableType.Displacement, [0, 0, 0])[0]
    assert moved == pytest.approx(place, rel=0.01)


@pytest.mark.parametrize(("nominal", "is_advised"), [(1e-3, True), (6e-5, False)])
def test_no_step_is_advised_that_is_longer_than_the_one_that_went_wrong(nominal, is_advised):
    watch = SimpleNamespace(resolving_step=8.5e-5, hides_energy=True, trouble=JUMP)
    control = SimpleNamespace(offset=0.0, present=1e-9, largest=nominal / 4, divisor=4, is_smallest=True)
    seen = dict(names_of_places=[], cable_runs=[], straight_cables=list, _rejects=True, jump=None)
    said = PacedRun.known_cause(SimpleNamespace(watch=watch, control=control, looks_ahead=True, **seen), 0.0)
    assert ("take stepSize = 8.5e-05" in said) == is_advised


def test_longer_steps_are_tried_less_often_if_they_fail_again():
    control = StepControl()
    tried = []
    control.reject()
    for _ in range(200):
        if control.is_nominal:  # goes wrong again
            tried.append(control.rejections)
            control.reject()
        else:
            control.accept()
    assert 3 <= len(tried) <= 12


@pytest.mark.parametrize(
    ("factor", "stretches", "is_unstable"), [(-0.6, True, False), (-1.2, True, True), (-0.6, False, True)]
)
def test_accelerations_that_turn_round_are_unstable_if_they_grow(factor, stretches, is_unstable):
    """Those of axial vibrations that become smaller are damped, however fast they change in a step."""
    h, before = 1e-3, np.array([100.0, 0.0])
    watch = object.__new__(CoupledWatch)
    watch.stretches, watch.watch = stretches, SimpleNamespace(flight=np.zeros((2, 2)))
    watch.before, watch._limit, watch._energy_tolerance = np.array([np.zeros(2), before]), 2.0, 0.01
    watch._lacks = np.zeros(SCALE + 1)
    watch._evaluated = SimpleNamespace(kinetic_energy=lambda q, v: 0.5 * (v @ v))
    state = SimpleNamespace(q=0.2 * h**2 * before, a=factor * before)
    assert (watch._excess(h, state) > 1.0) == is_unstable


def test_adaptive_steps_are_rejected_too():
    path, report = fall(lone_rope(20), adaptiveStep=True)
    assert len(path) == round(END / PERIOD) + 1 and np.isfinite(path).all()
    assert report["drift"]["energyGain"] < 0.05


@pytest.fixture
def shaken(new_mbs, add_pendulum):
    """(settings) -> path of a load on a cable whose upper end is moved before each step, and report."""

    def move(**explicit):
        mbs = new_mbs()
        made = add_pendulum(mbs, dimension=2, groundConstraintsStart=[False] * 4)
        ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=made["nodes"][k])) for k in (0, -1)]
        axes, bodies = [1, 1, 0], []
        for marker, x in zip(ends, (0.0, 1.8), strict=True):
            body = mbs.CreateMassPoint(
                referencePosition=[x, 0, 0], mass=0.3, gravity=[0, -9.81, 0], create2D=True, returnDict=True
            )
            pair = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=body["bodyNumber"])), marker]
            mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=axes))
            bodies.append(body)
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        holds = []
        for c in range(2):
            held = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=bodies[0]["nodeNumber"], coordinate=c))
            holds.append(mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, held])))
        position = exudyn.OutputVariableType.Position
        sensor = mbs.AddSensor(
            SensorNode(nodeNumber=bodies[1]["nodeNumber"], outputVariableType=position, storeInternal=True)
        )

        def shake(mbs, t):
            mbs.SetObjectParameter(holds[0], "offset", float(0.1 * (1.0 - np.cos(6.0 * t))))
            return True

        mbs.SetPreStepUserFunction(shake)
        mbs.Assemble()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            report = SolveExplicit(mbs, quiet_settings(0.6, 60, 0.01), ExplicitSettings(**explicit))
        return np.array(mbs.GetSensorStoredData(sensor)[:, 1:3]), report

    return move


def test_steps_above_the_limit_are_rejected_where_joints_are_moved_step_by_step(shaken):
    """They are smooth there, so that unstable vibrations show before they have changed the energy."""
    expected, report = shaken()
    assert report["rejections"] == 0
    largest = report["bounds"].stability_limit
    found, report = shaken(stepSize=1.3 * largest, allowUnstableStep=True)
    assert report["rejections"] > 0
    np.testing.assert_allclose(found, expected, atol=2e-3)
    assert abs(report["drift"]["energyLoss"]) < 1e-3
    with pytest.raises(DivergenceError):
        shaken(stepSize=1.3 * largest, allowUnstableStep=True, rejectSteps=False)
