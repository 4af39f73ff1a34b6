"""Springs that would bound the step by far are implicit, where all items are compiled."""

from functools import partial

import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    CoordinateSpringDamper,
    DistanceConstraint,
    GenericJoint,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    RevoluteJoint2D,
    RigidBodySpringDamper,
    SphericalJoint,
    SpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CreateInextensibleCable,
    InextensibleCable,
    SolveEquilibrium,
    StepSizeError,
)
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import add_pendulum, restarting_settings

GRAVITY, END = [0, -9.81, 0], 0.2
SECTION = {"massPerLength": 0.05, "bendingStiffness": 0.02}
STIFF = 1e7  # [N/m]: explicit steps would be 100 times shorter


def at_a_point(mbs, stiffness, markers, nodes, dimension):
    if stiffness is None:
        mbs.AddObject((RevoluteJoint2D if dimension == 2 else SphericalJoint)(markerNumbers=markers))
    else:
        mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, stiffness=[stiffness] * 3))


def at_a_distance(mbs, stiffness, markers, nodes, dimension):
    mbs.SetMarkerParameter(markers[0], "localPosition", [-0.1, 0, 0])
    if stiffness is None:
        mbs.AddObject(DistanceConstraint(markerNumbers=markers, distance=0.1))
    else:
        mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=0.1, stiffness=stiffness))


def in_all_directions(mbs, stiffness, markers, nodes, dimension):
    if stiffness is None:
        axes = [1, 1, 0, 0, 0, 1] if dimension == 2 else [1] * 6
        mbs.AddObject(GenericJoint(markerNumbers=markers, constrainedAxes=axes))
    else:
        law = np.diag([stiffness] * 3 + [1e-2 * stiffness] * 3)
        mbs.AddObject(RigidBodySpringDamper(markerNumbers=markers, stiffness=law))


def of_coordinates(mbs, stiffness, markers, nodes, dimension):
    for k in (0, 1):
        pair = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k)) for node in nodes]
        if stiffness is None:
            mbs.AddObject(CoordinateConstraint(markerNumbers=pair))
        else:
            mbs.AddObject(CoordinateSpringDamper(markerNumbers=pair, stiffness=stiffness))


STRETCHES = {"axialStiffness": 1e4}
KINDS = [
    (2, at_a_point, {}),
    (3, at_a_point, STRETCHES),
    (2, at_a_distance, {}),
    (3, at_a_distance, STRETCHES),
    (2, in_all_directions, {}),
    (3, in_all_directions, STRETCHES),
    (2, of_coordinates, {}),
]


def pendulum(mbs, dimension, hold, stiffness, **stretches):
    """A body that a spring holds, and a cable on a spring at its end; stiffness: None: they are joints."""
    ground = mbs.CreateGround()
    inertia = InertiaCuboid(1000, [0.2, 0.05, 0.05])
    of_body = {"inertia": inertia, "referencePosition": [0.1, 0, 0], "create2D": dimension == 2}
    body = mbs.CreateRigidBody(gravity=GRAVITY, returnDict=True, **of_body)
    template = InextensibleCable(**SECTION, **stretches)
    cable = CreateInextensibleCable(mbs, [0.2, 0, 0], [1, 0, 0], 6, template, GRAVITY, dimension=dimension)
    numbers = {"bodyNumber": body["bodyNumber"]}
    sides = [mbs.AddMarker(MarkerBodyRigid(**numbers, localPosition=[x, 0, 0])) for x in (-0.1, 0.1)]
    held = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=ground)), sides[0]]
    hold(mbs, stiffness, held, [mbs.AddNode(NodePointGround()), body["nodeNumber"]], dimension)
    end = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][0]))
    at_a_point(mbs, stiffness, [sides[1], end], [], dimension)
    mbs.Assemble()


def places_of(mbs):
    return np.array(mbs.systemData.GetODE2Coordinates())


@pytest.mark.parametrize(("dimension", "hold", "stretches"), KINDS)
def test_scenes_move_as_with_joints_however_stiff_they_are(new_mbs, solve, dimension, hold, stretches):
    steps, places = [], []
    for stiffness in (None, STIFF, 1e3 * STIFF):
        mbs = new_mbs()
        pendulum(mbs, dimension, hold, stiffness, **stretches)
        steps.append(solve(mbs, END)["steps"])
        places.append(places_of(mbs))
    assert steps[1] == steps[2] <= 1.5 * steps[0]
    largest = np.abs(places[0]).max()
    assert np.abs(places[1] - places[0]).max() < 1e-3 * largest
    assert np.abs(places[2] - places[0]).max() < 1e-3 * largest


def masses_on_a_spring(mbs, stiffness, speed=0.0, stretch=0.0, masses=(1e-2, 1e-2), **damped):
    """Two mass points among others, 0.2 m apart, which turn about each other; their node numbers."""
    add_pendulum(mbs)
    made = [
        mbs.CreateMassPoint(
            mass=mass, referencePosition=[3 + x, 0, 0], initialVelocity=[0, speed * x, 0], returnDict=True
        )
        for mass, x in zip(masses, (-0.1, 0.1), strict=True)
    ]
    markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=one["bodyNumber"])) for one in made]
    law = {"stiffness": stiffness, "referenceLength": 0.2 - stretch} | damped
    mbs.AddObject(SpringDamper(markerNumbers=markers, **law))
    mbs.Assemble()
    return [one["nodeNumber"] for one in made]


def lengths(mbs, sensors):
    one, other = (np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:] for sensor in sensors)
    return np.linalg.norm(other - one, axis=1)


def test_vibrations_follow_the_difference_equation(new_mbs, add_sensor, solve):
    """x_(n+1) - 2 x_n + x_(n-1) = -z / (1 + 0.3 z) x_n, with z = h^2 k / m of the reduced mass m."""
    mbs, step, stiffness = new_mbs(), 1e-3, 1e5
    nodes = masses_on_a_spring(mbs, stiffness, stretch=1e-6)
    sensors = [add_sensor(mbs, node) for node in nodes]
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.02, 20, step), stepSize=step, energyTolerance=np.inf)
    x = lengths(mbs, sensors) - (0.2 - 1e-6)
    z = step**2 * stiffness / 5e-3
    expected = (2.0 - z / (1.0 + 0.3 * z)) * x[1:-1] - x[:-2]
    assert z == pytest.approx(20.0) and len(x) == 21
    assert np.abs(x[2:] - expected).max() < 1e-6 * np.abs(x).max()


@pytest.mark.parametrize("bodies", [False, True])
def test_what_turns_with_a_spring_keeps_its_length(new_mbs, add_sensor, solve, bodies):
    """m w^2 r / k longer: steps that left the turning of the spring out made 0.3 (h w)^2 of its length."""
    mbs, speed, stiffness = new_mbs(), 50.0, 1e8
    nodes = (bodies_on_a_bushing if bodies else masses_on_a_spring)(mbs, stiffness, speed)
    sensors = [add_sensor(mbs, node) for node in nodes]
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(0.1, 100), stepSize=1e-3)
    assert report["stepSize"] == pytest.approx(1e-3)
    change = np.abs(lengths(mbs, sensors) - 0.2).max()
    assert change < 0.05 * 0.3 * (1e-3 * speed) ** 2 * 0.2


def bodies_on_a_bushing(mbs, stiffness, speed):
    """Two bodies, which turn about each other; the bushing holds them at a common point."""
    add_pendulum(mbs)
    made = [
        mbs.CreateRigidBody(
            inertia=InertiaCuboid(1000, [0.05, 0.02, 0.02]),
            referencePosition=[3 + x, 0, 0],
            initialVelocity=[0, speed * x, 0],
            initialAngularVelocity=[0, 0, speed],
            returnDict=True,
        )
        for x in (-0.1, 0.1)
    ]
    markers = [
        mbs.AddMarker(MarkerBodyRigid(bodyNumber=one["bodyNumber"], localPosition=[-x, 0, 0]))
        for one, x in zip(made, (-0.1, 0.1), strict=True)
    ]
    law = np.diag([stiffness] * 3 + [1e-2 * stiffness] * 3)
    mbs.AddObject(RigidBodySpringDamper(markerNumbers=markers, stiffness=law))
    mbs.Assemble()
    return [one["nodeNumber"] for one in made]


def test_their_order_is_two(new_mbs, solve):
    """Of steps that explicit springs would not be stable with."""
    places = []
    for step in (1e-3, 5e-4, 1e-5):
        mbs = new_mbs()
        pendulum(mbs, 2, at_a_point, 1e4)
        solve(mbs, 0.1, stepSize=step, massScaling=0.3)
        places.append(places_of(mbs))
    errors = [np.abs(one - places[-1]).max() for one in places[:-1]]
    assert errors[1] < 0.3 * errors[0]


def test_the_pull_of_stretched_springs_bounds_the_step(new_mbs, solve):
    """It makes what they connect vibrate across them, w^2 = k x / (L m), with the reduced mass m."""
    mbs = new_mbs()
    masses_on_a_spring(mbs, STIFF, stretch=1e-3)
    report = solve(mbs, 1e-4)
    expected = np.sqrt(STIFF * 1e-3 / (0.2 * 5e-3))
    assert report["bounds"].largest_frequency == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("stretch", "is_quiet"), [(0.0, True), (1e-2, False)])
def test_those_that_vibrate_are_explicit(new_mbs, add_sensor, solve, stretch, is_quiet):
    """With as much energy as the rest, as the closed form 1e-2 cos(w t), with the frequency of the scheme."""
    mbs, stiffness = new_mbs(), 1e5
    nodes = masses_on_a_spring(mbs, stiffness, stretch=stretch)
    sensors = [add_sensor(mbs, node) for node in nodes]
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(0.05, 50, 1e-3))
    frequency = np.sqrt(stiffness / 5e-3)
    assert (report["stepSize"] * frequency > 2.0) == is_quiet
    if not is_quiet:
        h, t = report["stepSize"], np.linspace(0.0, 0.05, 51)
        expected = stretch * np.cos(2.0 * np.arcsin(0.5 * h * frequency) / h * t)
        assert np.abs(lengths(mbs, sensors) - 0.2 + stretch - expected).max() < 0.02 * stretch


def test_a_static_state_stays_at_rest(new_mbs, solve):
    mbs = new_mbs()
    pendulum(mbs, 2, in_all_directions, 1e5)
    SolveEquilibrium(mbs)
    at_rest = places_of(mbs)
    report = solve(mbs, END)
    assert report["stepSize"] > 5e-4 and np.abs(places_of(mbs) - at_rest).max() < 1e-6


def test_a_given_step_is_taken_and_zhai_refuses_it(new_mbs, solve):
    """Zhai's method is explicit in all springs."""
    mbs = new_mbs()
    pendulum(mbs, 2, at_a_point, STIFF)
    assert solve(mbs, 0.02, stepSize=5e-4, massScaling=0.3)["steps"] == 40
    with pytest.raises(StepSizeError, match="stability limit of 'Zhai'"):
        solve(mbs, 0.02, stepSize=5e-4, massScaling=0.3, integrator="Zhai")


@pytest.mark.parametrize("stretch", [0.0, 1e-3])
def test_a_run_that_was_cut_goes_on_bit_for_bit(new_mbs, solve, tmp_path, stretch):
    def scene():
        mbs = new_mbs()
        masses_on_a_spring(mbs, 1e5, stretch=stretch)
        return mbs

    whole, first, second = scene(), scene(), scene()
    solve(whole, settings=quiet_settings(0.2, 4))
    cut = partial(restarting_settings, tmp_path / "run.restart", period=0.05)
    solve(first, settings=cut(0.1))
    assert solve(second, settings=cut(0.2))["resumedAt"] == pytest.approx(0.1)
    np.testing.assert_array_equal(places_of(second), places_of(whole))
