"""User functions of springs are asked once a step, or linearised there where they are stiff."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateSpringDamper,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    RevoluteJoint2D,
    RigidBodySpringDamper,
    SphericalJoint,
    SpringDamper,
    TorsionalSpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CreateInextensibleCable,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SceneError,
    SolveEnsemble,
    SolveExplicit,
)
from exudyn_inext.multibody.connectors import CONNECTOR
from exudyn_inext.run.spring_functions import AskedSpring, _Tangent
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import restarting_settings, that_remembers

GRAVITY, END = [0, -9.81, 0], 0.2


def hardens(x):
    """More than the square of a way; odd."""
    return x * (1.0 + 4.0 * x * x)


def along_distance(pair, k, d):
    def law(mbs, t, number, way, speed, stiffness, damping, force):
        return stiffness * hardens(way) + damping * speed + force

    given = {"referenceLength": 0.15, "stiffness": k, "damping": d, "force": 0.3, "velocityOffset": 0.02}
    return SpringDamper(markerNumbers=pair[:2], **given, springForceUserFunction=law)


def cartesian(pair, k, d):
    def law(mbs, t, number, way, speed, stiffness, damping, offset):
        return [stiffness[i] * hardens(way[i]) + damping[i] * speed[i] for i in range(3)]

    given = {"stiffness": [k, 2.0 * k, 3.0 * k], "damping": [d] * 3, "offset": [0.02, 0.01, 0.0]}
    return CartesianSpringDamper(markerNumbers=pair[:2], **given, springForceUserFunction=law)


def of_coordinates(pair, k, d):
    def law(mbs, t, number, way, speed, stiffness, damping, offset):
        return stiffness * hardens(way - offset) + damping * speed

    given = {"stiffness": k, "damping": d, "offset": 0.02}
    return CoordinateSpringDamper(markerNumbers=pair[2:], **given, springForceUserFunction=law)


def in_all_directions(pair, k, d):
    def law(mbs, t, number, way, angles, speed, spin, stiffness, damping, rot0, rot1, offset):
        stretch, rate = np.hstack([way, angles]) - offset, np.hstack([speed, spin])
        frame = np.asarray(rot1) @ np.asarray(rot0).T
        return np.asarray(stiffness) @ hardens(stretch) + np.asarray(damping) @ rate + 1e-2 * frame[0, 1]

    matrix = np.diag([1.0, 2.0, 1.0, 0.02, 0.02, 0.02])
    matrix[1, 5] = matrix[5, 1] = 0.1
    given = {"stiffness": k * matrix, "damping": d * matrix, "offset": [0.02, 0, 0, 0, 0, 0.1]}
    return RigidBodySpringDamper(markerNumbers=pair[:2], **given, springForceTorqueUserFunction=law)


def about_an_axis(pair, k, d):
    def law(mbs, t, number, angle, spin, stiffness, damping, offset):
        return stiffness * hardens(angle - offset) + damping * spin

    given = {"stiffness": 0.05 * k, "damping": 0.05 * d, "offset": 0.2}
    return TorsionalSpringDamper(markerNumbers=pair[:2], **given, springTorqueUserFunction=law)


KINDS = [along_distance, cartesian, of_coordinates, in_all_directions, about_an_axis]


def rope_and_body(mbs, dimension, hold):
    """A body at the end of a rope, to which hold(mbs, its node, its markers, marker of the rope) ties it."""
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=0.01)
    pinned = {"groundConstraintsStart": [True] * dimension + [False] * dimension}
    line = [0, 0, 0], [1, 0, 0], 6
    rope = CreateInextensibleCable(mbs, *line, section, GRAVITY, dimension=dimension, **pinned)
    of_body = {"inertia": InertiaCuboid(1000, [0.2, 0.05, 0.05]), "create2D": dimension == 2}
    body = mbs.CreateRigidBody(referencePosition=[1.1, 0, 0], gravity=GRAVITY, returnDict=True, **of_body)
    markers = [
        mbs.AddMarker(MarkerBodyRigid(bodyNumber=body["bodyNumber"], localPosition=[x, 0, 0]))
        for x in (-0.1, 0.1)
    ]
    hold(mbs, body["nodeNumber"], markers, mbs.AddMarker(MarkerNodePosition(nodeNumber=rope["nodes"][-1])))
    mbs.Assemble()


def jointed(spring):
    """The body hangs on a joint; the spring leads from ground to it."""

    def hold(mbs, node, markers, end):
        joint = RevoluteJoint2D if mbs.GetNode(node)["nodeType"].endswith("2D") else SphericalJoint
        mbs.AddObject(joint(markerNumbers=[end, markers[0]]))
        anchor = MarkerBodyRigid(bodyNumber=mbs.CreateGround(), localPosition=[1.1, 0.2, 0])
        at_rest = MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
        places = [mbs.AddMarker(anchor), markers[1], mbs.AddMarker(at_rest)]
        places.append(mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=1)))
        spring(mbs, places)

    return hold


def places_of(mbs):
    return np.array(mbs.systemData.GetODE2Coordinates())


@pytest.fixture
def moved(new_mbs, solve):
    """(dimension, hold, ...) -> coordinates at the end, and report."""

    def run(dimension, hold, end=END, **explicit):
        mbs = new_mbs()
        rope_and_body(mbs, dimension, hold)
        report = solve(mbs, end, **explicit)
        return places_of(mbs), report

    return run


def asked_by_exudyn(item):
    for name in [
        name for name in vars(item) if name.endswith("UserFunction") and callable(getattr(item, name))
    ]:
        setattr(item, name, that_remembers(getattr(item, name)))
    return item


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_functions_act_as_where_exudyn_asks_them(moved, kind, dimension):
    """Explicit steps: each function sees the end of the step."""
    found = []
    for convert in (lambda item: item, asked_by_exudyn):
        hold = jointed(lambda mbs, pair, to=convert: mbs.AddObject(to(kind(pair, 20.0, 0.2))))
        found.append(moved(dimension, hold, stepSize=5e-4))
    (places, report), (expected, evaluated) = found
    assert "asked in each, sees no more" in report["path"]
    assert "may change something" in evaluated["path"]
    free, _ = moved(dimension, jointed(lambda *_: None), stepSize=5e-4)
    assert np.abs(places - expected).max() < 1e-4 * np.abs(expected - free).max()


def tied_by(k, law=None, damping=0.0):
    """The body is tied to the rope by a spring; k: None: by a joint."""

    def hold(mbs, node, markers, end):
        if k is None:
            joint = RevoluteJoint2D if mbs.GetNode(node)["nodeType"].endswith("2D") else SphericalJoint
            mbs.AddObject(joint(markerNumbers=[end, markers[0]]))
            return
        given = {"stiffness": [k] * 3, "damping": [damping] * 3}
        given |= {"springForceUserFunction": law} if law else {}
        mbs.AddObject(CartesianSpringDamper(markerNumbers=[end, markers[0]], **given))

    return hold


def along_axes(mbs, t, number, way, speed, stiffness, damping, offset):
    return [k * u + d * v for k, u, d, v in zip(stiffness, way, damping, speed, strict=True)]


def across_axes(mbs, t, number, way, speed, stiffness, damping, offset):
    """Ten times as stiff along (1, 1, 1), which couples the axes."""
    middle = 3.0 * sum(way)
    return [k * (u + middle) + d * v for k, u, d, v in zip(stiffness, way, damping, speed, strict=True)]


@pytest.mark.parametrize(("dimension", "law", "damping"), [(2, along_axes, 0.0), (3, across_axes, 30.0)])
def test_stiff_functions_bound_the_step_no_more_than_joints(moved, dimension, law, damping):
    expected, jointed_report = moved(dimension, tied_by(None))
    for k in (1e6, 1e9):
        places, report = moved(dimension, tied_by(k, law, damping))
        assert report["steps"] <= 2 * jointed_report["steps"]
        assert np.abs(places - expected).max() < 2e-3 * np.abs(expected).max()
        linear, _ = moved(dimension, tied_by(k, None, damping))
        assert np.abs(places - linear).max() < 1e-5


def test_tangents_of_functions_damp_as_dashpots_do(moved):
    """A bushing of 0.01 s and 0.1 m: neither stiff nor soft; steps of either kind are small enough."""
    given = 5e2, along_axes, 1e3
    places, report = moved(2, tied_by(*given), massScaling=0.3, stepSize=1e-3)
    expected, _ = moved(2, tied_by(given[0], None, given[2]), massScaling=0.3, stepSize=2.5e-5)
    assert report["steps"] == round(END / 1e-3)
    assert np.abs(places - expected).max() < 2e-3 * np.abs(expected).max()


def at_a_lever(arm, k):
    """(6, 6) of a bushing that holds a point at that arm along x [m]."""
    lever = np.eye(6)
    lever[1, 5], lever[2, 4] = arm, -arm
    matrix: np.ndarray = k * lever.T @ np.diag([1.0, 1.0, 1.0, 0.02, 0.02, 0.02]) @ lever
    return matrix


def on_a_lever(k, arm_of_damping):
    """A second body on a bushing whose stiffness, and damping, are those of one at a lever: they couple."""

    def hold(mbs, node, markers, end):
        is_planar = mbs.GetNode(node)["nodeType"].endswith("2D")
        mbs.AddObject((RevoluteJoint2D if is_planar else SphericalJoint)(markerNumbers=[end, markers[0]]))
        of_body = {"inertia": InertiaCuboid(1000, [0.2, 0.05, 0.05]), "create2D": is_planar}
        body = mbs.CreateRigidBody(referencePosition=[1.3, 0, 0], gravity=GRAVITY, **of_body)
        side = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[-0.1, 0, 0]))
        law = {"stiffness": at_a_lever(0.3, k), "damping": 1e-4 * at_a_lever(arm_of_damping, k)}
        mbs.AddObject(RigidBodySpringDamper(markerNumbers=[markers[1], side], **law))

    return hold


@pytest.mark.parametrize(("dimension", "arm_of_damping"), [(2, 0.3), (3, 0.3), (2, -0.2), (3, 0.0)])
def test_stiffness_that_couples_axes_does_not_bound_the_step(moved, dimension, arm_of_damping):
    """Also where the damping has other directions."""
    places, report = moved(dimension, on_a_lever(1e8, arm_of_damping))
    given = {"stepSize": 1e-5, "massScaling": 0.3}
    expected, explicit = moved(dimension, on_a_lever(1e6, arm_of_damping), **given)
    assert report["steps"] < 0.1 * END / explicit["bounds"].undamped
    assert np.abs(places - expected).max() < 5e-3 * np.abs(expected).max()


def test_a_function_without_force_changes_nothing(moved):
    """To look at springs leaves what the next step begins with as it was."""

    def nothing(mbs, t, number, *others):
        return 0.0

    def tie(law):
        def spring(mbs, pair):
            mbs.AddObject(SpringDamper(markerNumbers=pair[:2], **law))

        return jointed(spring)

    places, report = moved(3, tie({"stiffness": 5.0, "springForceUserFunction": nothing}), stepSize=1e-3)
    assert "asked in each" in report["path"]
    np.testing.assert_allclose(places, moved(3, tie({}), stepSize=1e-3)[0], rtol=0, atol=1e-11)


def test_functions_see_the_motion_at_the_end_of_the_step(moved):
    """A damper that asks mbs for the velocity, in place of its own arguments."""

    def by_sensor(node):
        def law(mbs, t, number, way, speed, *others):
            assert t == pytest.approx(mbs.systemData.GetTime())
            return 3.0 * mbs.GetNodeOutput(node, exudyn.OutputVariableType.Velocity)[1]

        return law

    def hold(law_of):
        def spring(mbs, pair):
            node = mbs.GetMarker(pair[3])["nodeNumber"]
            mbs.AddObject(CoordinateSpringDamper(markerNumbers=pair[2:], **law_of(node)))

        return jointed(spring)

    places, _ = moved(2, hold(lambda node: {"springForceUserFunction": by_sensor(node)}), stepSize=5e-4)
    expected, _ = moved(2, hold(lambda node: {"damping": 3.0}), stepSize=5e-4)
    np.testing.assert_allclose(places, expected, atol=2e-4)


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        ([1.0, 2.0], r"the user function of object .* returned \[1.0, 2.0\] .* must return 1 number"),
        ("much", r"returned 'much' at t = 0.0"),
        (None, r"returned None at t = 0.0"),
    ],
)
def test_what_is_no_force_is_refused_by_name(moved, returned, said):
    """At the start Exudyn itself refuses it."""
    law = {"springForceUserFunction": lambda mbs, t, *_: returned if t > 0.05 else 0.0}
    with pytest.raises(SceneError, match=said):
        moved(2, jointed(lambda mbs, pair: mbs.AddObject(SpringDamper(markerNumbers=pair[:2], **law))))


def test_step_functions_that_set_objects_leave_the_functions_to_exudyn(new_mbs, solve):
    """Their parameters follow a line within a step."""
    mbs = new_mbs()
    numbers = []
    rope_and_body(
        mbs, 2, jointed(lambda mbs, pair: numbers.append(mbs.AddObject(along_distance(pair, 5, 0))))
    )
    mbs.SetPreStepUserFunction(lambda mbs, t: mbs.SetObjectParameter(numbers[0], "stiffness", 5 + t) or True)
    assert "Exudyn evaluates them because of object" in solve(mbs, 0.02, steps=2)["path"]


def test_parameters_that_functions_are_given_are_those_of_the_present_run(new_mbs, solve):
    ways = []
    for values in ((20.0, 40.0), (40.0,)):
        mbs, numbers = new_mbs(), []
        rope_and_body(
            mbs, 2, jointed(lambda mbs, pair, n=numbers: n.append(mbs.AddObject(along_distance(pair, 1, 0))))
        )
        for value in values:
            mbs.SetObjectParameter(numbers[0], "stiffness", value)
            solve(mbs, END, stepSize=1e-3)
        ways.append(places_of(mbs))
    np.testing.assert_array_equal(*ways)


STIFFNESSES, GIVEN = (1e5, 1e6, 1e7), {"stepSize": 1e-3, "massScaling": 0.3}


@pytest.mark.parametrize("threads", [1, 2])
def test_members_of_ensembles_ask_their_own_functions(moved, new_mbs, threads):
    def build(k):
        mbs = new_mbs()
        rope_and_body(mbs, 2, tied_by(k, across_axes, 30.0))
        return mbs

    settings = quiet_settings(END, 20)
    given = build, settings, ExplicitSettings(**GIVEN), STIFFNESSES, 0, threads
    found = SolveEnsemble(*given)["coordinates"][:, -1]
    expected = [moved(2, tied_by(k, across_axes, 30.0), **GIVEN)[0] for k in STIFFNESSES]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    assert np.ptp(found, axis=0).max() > 1e-6


def test_steppers_ask_functions_that_see_their_own_motion(moved, new_mbs):
    mbs = new_mbs()
    rope_and_body(mbs, 3, jointed(lambda mbs, pair: mbs.AddObject(in_all_directions(pair, 20.0, 0.2))))
    stepper = ExplicitStepper(mbs, explicitSettings=ExplicitSettings(**GIVEN), interval=END / 10)
    stepper.Start()
    for _ in range(10):
        stepper.Step()
    stepper.WriteToSystem()
    hold = jointed(lambda mbs, pair: mbs.AddObject(in_all_directions(pair, 20.0, 0.2)))
    np.testing.assert_allclose(places_of(mbs), moved(3, hold, **GIVEN)[0], rtol=0, atol=1e-12)


def test_steppers_refuse_functions_that_see_more(new_mbs):
    def law(mbs, t, number, way, *others):
        return 3.0 * way * mbs.GetNodeOutput(0, exudyn.OutputVariableType.Position)[0]

    mbs = new_mbs()
    at = {"stiffness": 3.0, "springForceUserFunction": law}
    rope_and_body(
        mbs, 2, jointed(lambda mbs, pair: mbs.AddObject(SpringDamper(markerNumbers=pair[:2], **at)))
    )
    with pytest.raises(SceneError, match=r"ExplicitStepper cannot ask object .*: use SolveExplicit"):
        ExplicitStepper(mbs)


def test_restart_files_do_not_change_a_bit(new_mbs, tmp_path):
    def run(end, file):
        mbs = new_mbs()
        rope_and_body(mbs, 3, tied_by(1e6, across_axes, 30.0))
        SolveExplicit(mbs, restarting_settings(tmp_path / file, end, END / 4))
        return places_of(mbs)

    whole = run(END, "whole.npz")
    run(END / 2, "parts.npz")
    np.testing.assert_array_equal(run(END, "parts.npz"), whole)


def test_springs_are_constant_again_without_a_step():
    """In steps of no length nothing is implicit: no tangent is left of those before."""
    connectors = np.zeros(1, CONNECTOR)
    spring = AskedSpring(0, [0], "spring", lambda t, stretch, rate, frames: stretch[0] ** 2, False)
    tangent = _Tangent(connectors, 0)
    for step, slope in ((1e-3, 2.0), (0.0, 0.0)):
        connectors["stretch"][0, 0] = 1.0
        tangent.take(spring, 0.0, step)
        assert connectors["force"][0, 0] == 1.0
        assert connectors["stiffness"][0, 0, 0] == pytest.approx(slope, rel=1e-6)
