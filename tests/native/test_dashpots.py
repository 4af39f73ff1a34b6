"""Dashpots of springs that would bound the step by far are implicit, where all items are compiled."""

from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    Force,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodePosition,
    MarkerNodeRigid,
    RevoluteJoint2D,
    RigidBodySpringDamper,
    SphericalJoint,
    SpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CreateInextensibleCable,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SceneError,
    SolveEnsemble,
)
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import add_pendulum, either_cable, restarting_settings, solve_native

SECTION, STRETCH = {"massPerLength": 0.05, "bendingStiffness": 0.02}, 1e4
DAMPING = 30.0  # [N s/m]; by the mass of a node, 5e3 1/s
END = 0.1


def block_on(mbs, dimension):
    inertia = InertiaCuboid(1000, [0.1, 0.1, 0.1])
    in_plane = {"create2D": dimension == 2}
    return mbs.CreateRigidBody(
        inertia=inertia, referencePosition=[1.05, 0, 0], gravity=[0, -9.81, 0], **in_plane
    )


def hang(mbs, dimension, law, native=False, elements=8, damping=DAMPING):
    """A cable with a block at its end, and dashpots; numbers of the middle and the last node."""
    line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": elements}
    line |= {"gravity": [0, -9.81, 0], "groundConstraintsStart": [True] * dimension + [False] * dimension}
    stretches = {} if native else {"axialStiffness": STRETCH}
    nodes, cable = either_cable(mbs, native, dimension, SECTION | stretches, STRETCH, **line)
    middle, end = (mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[k])) for k in (elements // 2, -1))
    block = block_on(mbs, dimension)
    corner = {"bodyNumber": block, "localPosition": [-0.05, 0, 0]}
    markers = [end, mbs.AddMarker(MarkerBodyPosition(**corner))]
    LAWS[law](mbs, dimension, markers, middle, corner, damping)
    return [nodes[elements // 2], nodes[-1]], cable


def to_ground_and_body(mbs, dimension, markers, middle, corner, damping):
    mbs.AddObject((RevoluteJoint2D if dimension == 2 else SphericalJoint)(markerNumbers=markers))
    place = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[0.5, 0, 0]))
    each = {"stiffness": [5.0] * 3, "damping": [damping] * 3}
    mbs.AddObject(CartesianSpringDamper(markerNumbers=[place, middle], **each))
    law = {"stiffness": 10.0, "damping": damping, "referenceLength": 0.5}
    mbs.AddObject(SpringDamper(markerNumbers=[markers[1], middle], **law))


def bushing(mbs, dimension, markers, middle, corner, damping):
    node = mbs.GetMarker(markers[0])["nodeNumber"]
    frames = [mbs.AddMarker(MarkerNodeRigid(nodeNumber=node)), mbs.AddMarker(MarkerBodyRigid(**corner))]
    stiffness, rates = np.diag([500.0] * 3 + [0.2] * 3), np.diag([damping] * 3 + [0.003 * damping] * 3)
    mbs.AddObject(RigidBodySpringDamper(markerNumbers=frames, stiffness=stiffness, damping=rates))


LAWS = {"springs": to_ground_and_body, "bushing": bushing}


@pytest.mark.parametrize(("dimension", "law"), [(2, "springs"), (3, "springs"), (2, "bushing")])
def test_they_move_a_cable_as_exudyn_says(new_mbs, add_sensor, solve, known_answer, dimension, law):
    paths = []
    for native in (False, True):
        mbs = new_mbs()
        nodes, _ = hang(mbs, dimension, law, native, elements=24 if native else 8)
        sensors = [add_sensor(mbs, node) for node in nodes]
        mbs.Assemble()
        if native:
            solve_native(mbs, END, 2.5e-4)
        else:
            report = solve(mbs, END)
            assert report["stepSize"] > 2e-4 and report["bounds"].damping == 0.0
        paths.append(np.hstack([mbs.GetSensorStoredData(sensor) for sensor in sensors]))
    error = np.abs(paths[0] - paths[1]).max() / np.ptp(paths[1][:, 1:], axis=0).max()
    assert error < 0.01
    known_answer(f"{law} with dashpots, {dimension}D, against a native cable", error)


@pytest.mark.parametrize("damping", [1.0, 3.0])
def test_weak_ones_shorten_no_step_for_which_the_mass_is_scaled(new_mbs, solve, damping):
    """The shorter that step, the lighter the scaled mass, and the faster what vibrates beside them."""
    steps = []
    for given in (damping, DAMPING):
        mbs = new_mbs()
        hang(mbs, 2, "springs", elements=24, damping=given)
        mbs.Assemble()
        report = solve(mbs, 0.02)
        assert report["bounds"].damping == 0.0
        steps.append(report["stepSize"])
    assert steps[0] == steps[1]


def mass_on_a_dashpot(mbs, **start):
    """A mass point of 1 g among others, on 10 N s/m: z = 1e4 h / s."""
    add_pendulum(mbs)
    made = mbs.CreateMassPoint(mass=1e-3, referencePosition=[3, 0, 0], returnDict=True, **start)
    law = {"stiffness": [0.0] * 3, "damping": [10.0] * 3}
    mbs.CreateCartesianSpringDamper(itemNumbers=[mbs.CreateGround(), made["bodyNumber"]], **law)
    return made["nodeNumber"]


def test_a_velocity_that_steps_do_not_resolve_loses_two_thirds_in_each(new_mbs, add_sensor, solve):
    """(1 + w) x_(n+1) = (1 + 2 w - 3/2 z) x_n - (w - z/2) x_(n-1) of velocities half way, w = 9/16 z."""
    mbs, step = new_mbs(), 1e-3
    node = mass_on_a_dashpot(mbs, initialVelocity=[2, 0, 0])
    sensor = add_sensor(mbs, node, "Displacement")
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.01, 10, step), stepSize=step, energyTolerance=np.inf)
    x = np.diff(np.asarray(mbs.GetSensorStoredData(sensor))[:, 1])
    z = step * 10.0 / 1e-3
    w = (0.5 + 1.0 / 16.0) * z
    expected = ((1.0 + 2.0 * w - 1.5 * z) * x[1:-1] - (w - 0.5 * z) * x[:-2]) / (1.0 + w)
    assert len(x) == 10 and np.abs(x[2:] - expected).max() < 1e-9 * np.abs(x).max()


def test_a_mass_falls_on_a_dashpot_by_the_closed_form(new_mbs, add_sensor, solve, known_answer):
    """m g / d (t - m / d) after long; each of its velocities and accelerations is one of that motion."""
    mbs = new_mbs()
    node = mass_on_a_dashpot(mbs, gravity=[0, -9.81, 0])
    sensor = add_sensor(mbs, node, "Displacement")
    mbs.Assemble()
    report = solve(mbs, END, steps=50)
    t, speed = END, 1e-3 * 9.81 / 10.0
    error = abs(mbs.GetSensorValues(sensor)[1] + speed * (t - 1e-4)) / (speed * t)
    assert report["bounds"].damping == 0.0 and error < 0.01
    assert mbs.GetNodeOutput(node, exudyn.OutputVariableType.Velocity)[1] == pytest.approx(-speed, rel=1e-6)
    known_answer("mass that falls on a dashpot", error)


def test_their_order_is_two(new_mbs, solve):
    """Of steps that are too large for explicit dashpots, the limit of which is 1e-6 s."""
    places = []
    for step in (1e-4, 5e-5, 2.5e-6):
        mbs = new_mbs()
        hang(mbs, 2, "bushing")
        mbs.Assemble()
        report = solve(mbs, 0.02, stepSize=step, massScaling=0.3)
        assert report["bounds"].damping == 0.0 and not report["rejections"]
        places.append(places_of(mbs))
    errors = [np.abs(one - places[-1]).max() for one in places[:-1]]
    assert errors[1] < 0.35 * errors[0]


def test_many_of_them_and_those_at_knots_move_a_cable_as_explicit_ones_do(new_mbs, solve):
    """Of a cable with more rows than its nodes leave for others, and of three cables in one point."""
    scenes = crowded, star
    for scene in scenes:
        places = []
        for given in ({}, {"stepSize": 2e-6, "massScaling": 0.3}):
            mbs = new_mbs()
            scene(mbs)
            mbs.Assemble()
            report = solve(mbs, 0.03, **given)
            places.append(np.array(mbs.systemData.GetODE2Coordinates()))
            assert given or report["bounds"].damping == 0.0
        assert np.abs(places[0] - places[1]).max() < 0.02 * np.abs(places[1]).max()


def crowded(mbs):
    """30 dashpots on the nodes of a cable."""
    template = InextensibleCable(**SECTION)
    cable = CreateInextensibleCable(
        mbs, [0, 0, 0], [1, 0, 0], 30, template, [0, -9.81, 0], [True, True, False, False]
    )
    ground = mbs.CreateGround()
    for k, node in enumerate(cable["nodes"][1:], 1):
        place = mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=[k / 30, 0, 0]))
        markers = [place, mbs.AddMarker(MarkerNodePosition(nodeNumber=node))]
        mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, stiffness=[0.0] * 3, damping=[20.0] * 3))


def star(mbs):
    """Three cables that begin in one point, and dashpots between their ends."""
    template, ends = InextensibleCable(**SECTION), ([1, 0, 0], [0, -1, 0], [0, 0, 1])
    cables = [
        CreateInextensibleCable(mbs, [0, 0, 0], end, 4, template, [0, -9.81, 0], dimension=3) for end in ends
    ]
    for k in (1, 2):
        first, last = (
            [mbs.AddMarker(MarkerNodePosition(nodeNumber=cables[i]["nodes"][at])) for i in (0, k)]
            for at in (0, -1)
        )
        mbs.AddObject(SphericalJoint(markerNumbers=first))
        law = {"stiffness": 1.0, "damping": 20.0, "referenceLength": 1.4}
        mbs.AddObject(SpringDamper(markerNumbers=last, **law))


def test_whoever_looks_at_forces_does_not_change_the_motion(new_mbs, add_sensor, solve):
    """Of damped cables that nothing but a dashpot connects: their damping was taken twice."""
    places = []
    for looks in (False, True):
        mbs = new_mbs()
        damped = {"beamTemplate": InextensibleCable(**SECTION, bendingDamping=1e-4), "dimension": 2}
        ends = [add_pendulum(mbs, **damped)["nodes"][-1] for _ in range(2)]
        markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in ends]
        mbs.AddLoad(Force(markerNumber=markers[0], loadVector=[0, 1, 0]))
        law = {"stiffness": [0.0] * 3, "damping": [DAMPING] * 3}
        mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, **law))
        if looks:
            add_sensor(mbs, ends[0], "Acceleration")
        mbs.Assemble()
        solve(mbs, END, steps=10, stepSize=1e-3)
        places.append(places_of(mbs))
    np.testing.assert_array_equal(*places)


@pytest.fixture
def scene(new_mbs):
    """() -> assembled mbs with dashpots."""

    def build():
        mbs = new_mbs()
        hang(mbs, 2, "springs")
        mbs.Assemble()
        return mbs

    return build


def places_of(mbs):
    return np.array(mbs.systemData.GetODE2Coordinates())


GIVEN = {"stepSize": 5e-4, "massScaling": 0.3}


def test_a_stepper_and_an_ensemble_move_as_solve_explicit_does(scene, solve):
    mbs, stepped = scene(), scene()
    solve(mbs, 0.02, **GIVEN)
    stepper = ExplicitStepper(stepped, interval=0.02, explicitSettings=ExplicitSettings(**GIVEN))
    stepper.Start()
    stepper.Step()
    stepper.WriteToSystem()
    np.testing.assert_allclose(places_of(stepped), places_of(mbs), atol=1e-13)
    members = SolveEnsemble([scene(), scene()], quiet_settings(0.02, 1), ExplicitSettings(**GIVEN))
    np.testing.assert_allclose(members["coordinates"][1, -1], places_of(mbs), atol=1e-13)


def test_a_run_that_was_cut_goes_on_bit_for_bit(scene, solve, tmp_path):
    whole, first, second = scene(), scene(), scene()
    solve(whole, settings=quiet_settings(0.04, 4), **GIVEN)
    cut = partial(restarting_settings, tmp_path / "run.restart", period=0.01)
    solve(first, settings=cut(0.02), **GIVEN)
    report = solve(second, settings=cut(0.04), **GIVEN)
    assert report["resumedAt"] == pytest.approx(0.02)
    np.testing.assert_array_equal(places_of(second), places_of(whole))


def test_springs_may_change_between_steps(scene, solve):
    """Four times the damping at half time, as by explicit steps that change it, too."""

    def change(mbs, t):
        if t > 0.02:
            last = mbs.systemData.NumberOfObjects() - 1
            mbs.SetObjectParameter(last, "damping", 4.0 * DAMPING)
        return True

    found = []
    for given in (GIVEN | {"stepSize": 1e-4}, GIVEN | {"stepSize": 5e-6}):
        mbs = scene()
        mbs.SetPreStepUserFunction(change)
        solve(mbs, 0.04, steps=4, **given)
        found.append(places_of(mbs))
    assert np.abs(found[0] - found[1]).max() < 1e-3 * np.abs(found[1]).max()


def law(mbs, t, number, stretch, rate, stiffness, damping, offset):
    return 0.9 * stiffness * stretch + 0.9 * damping * rate


def set_law(mbs, t):
    if t > 0.005:
        mbs.SetObjectParameter(mbs.systemData.NumberOfObjects() - 1, "springForceUserFunction", law)
    return True


def test_a_function_that_is_set_during_a_run_shortens_its_steps(scene, solve):
    """Exudyn takes over from compiled items, and damps explicitly."""
    places, steps = [], []
    for given in ({}, {"stepSize": 5e-6, "massScaling": 0.3}):
        mbs = scene()
        mbs.SetPreStepUserFunction(set_law)
        steps.append(solve(mbs, 0.05, steps=10, **given)["stepSize"])
        places.append(places_of(mbs))
    assert 5e-6 < steps[0] < 1e-4
    assert np.abs(places[0] - places[1]).max() < 0.01 * np.abs(places[1]).max()


def test_a_given_step_that_is_too_long_then_is_refused_and_the_remedy_works(scene, solve):
    mbs, again = scene(), scene()
    for one in (mbs, again):
        one.SetPreStepUserFunction(set_law)
    with pytest.raises(SceneError, match=r"dashpots, .* explicit \(limit .*e-05 s\): set stepSize below"):
        solve(mbs, 0.01, steps=2, **GIVEN)
    solve(again, 0.01, steps=2, stepSize=5e-5)
