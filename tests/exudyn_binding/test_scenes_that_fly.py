"""Scenes that fly along take the steps of those that do not, and move alike beside what flies with them."""

import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    CoordinateSpringDamper,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CableDrag,
    CableShape,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SetCableDrag,
)
from exudyn_inext.exudyn_binding.scene_runs import compiled_runs
from exudyn_inext.native.flight import may_fly
from reference_models.model import quiet_settings
from tests.exudyn_binding import items

FLIGHT = np.array([0.6, 0.8, 0.0])  # direction
GRAVITY = (0, -9.81, 0)

pytestmark = pytest.mark.filterwarnings("ignore:.*cable .* (is compressed|vibrates along)")  # stiff ones


def turning(velocity, start, end, speed=1.0):
    """A line that flies along, and turns: its end has another speed, along y."""
    ends = {"velocityStart": list(velocity), "velocityEnd": [velocity[0], velocity[1] + speed, velocity[2]]}
    return CableShape.Line(start, end, 6, **ends)


def cart(mbs, add_cable, velocity, axial_stiffness=None):
    """A light mass on a spring at a heavy cart, from which a cable hangs; nodes to look at."""
    section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.05, axialStiffness=axial_stiffness)
    line = turning(velocity, [0, 0, -0.1], [0, 0, -2.1])
    cable = add_cable(mbs, beamTemplate=section, shape=line, gravity=[0, 0, 0])
    inertia = InertiaCuboid(1000.0, [1.0, 0.2, 0.2])
    body = mbs.CreateRigidBody(inertia=inertia, initialVelocity=list(velocity), returnDict=True)
    light = {"referencePosition": [1, 0, 0], "initialVelocity": list(velocity + np.array([0, 5.0, 0]))}
    mass = mbs.CreateMassPoint(mass=0.01, returnDict=True, **light)
    ends = [
        MarkerBodyPosition(bodyNumber=body["bodyNumber"], localPosition=p) for p in ([0, 0, -0.1], [1, 0, 0])
    ]
    hook, end = map(mbs.AddMarker, ends)
    top, point = (
        mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (cable["nodes"][0], mass["nodeNumber"])
    )
    mbs.AddObject(SphericalJoint(markerNumbers=[hook, top]))
    mbs.AddObject(CartesianSpringDamper(markerNumbers=[end, point], stiffness=[100.0] * 3))
    return body["nodeNumber"], mass["nodeNumber"], cable["nodes"][-1]


def bent(mbs, add_cable, velocity, dim, gravity=GRAVITY, **section):
    """Nodes of a cable along x that flies along, and bends to and fro."""
    template = InextensibleCable(massPerLength=0.2, bendingStiffness=2.0, **section)
    line = {"positionStart": [-1, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": 8}
    nodes = add_cable(mbs, beamTemplate=template, dimension=dim, gravity=list(gravity), **line)["nodes"]
    for node, x in zip(nodes, np.linspace(-1.0, 1.0, 9), strict=True):
        speeds = np.zeros((2, dim))
        speeds[0] = velocity[:dim]
        speeds[:, 1] += 6.0 * x**2 - 2.0, 12.0 * x
        mbs.SetNodeParameter(node, "initialVelocities", speeds.ravel().tolist())
    return nodes


def rope_and_wheel(mbs, add_cable, velocity):
    """A cable that stretches, and a body that turns fast, not about its centre of mass."""
    nodes = bent(mbs, add_cable, velocity, 3, axialStiffness=1e5)
    inertia = InertiaCuboid(500.0, [0.1, 0.2, 0.1]).Translated([0.1, 0.05, 0.0])
    start = {"referencePosition": [1, 0.1, 0], "initialAngularVelocity": [0, 0, 30.0]}
    start |= {"initialVelocity": list(np.add(velocity, [-3.0, 4.0, 0])), "gravity": list(GRAVITY)}
    body = mbs.CreateRigidBody(inertia=inertia, returnDict=True, **start)
    hook = MarkerBodyPosition(bodyNumber=body["bodyNumber"], localPosition=[0, -0.1, 0])
    ends = [mbs.AddMarker(end) for end in (hook, MarkerNodePosition(nodeNumber=nodes[-1]))]
    mbs.AddObject(SphericalJoint(markerNumbers=ends))
    return body["nodeNumber"], nodes[4]


def alone(mbs, add_cable, velocity, **what):
    return bent(mbs, add_cable, velocity, 2, **what)[::4]


@pytest.fixture
def fly(new_mbs, add_cable, add_sensor, solve):
    """(scene, speed, ...) -> report, and (k, times, 3) paths as seen from a frame that flies along."""

    def run(scene, speed, end_time=1.0, explicit=(), tie=None, **what):
        mbs, velocity = new_mbs(), speed * FLIGHT
        nodes = scene(mbs, add_cable, velocity, **what)
        if tie:
            tie(mbs, nodes[0])
        sensors = [add_sensor(mbs, node) for node in nodes]
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(end_time, 1, 0.02), **dict(explicit))
        stored = (np.asarray(mbs.GetSensorStoredData(sensor)) for sensor in sensors)
        return report, np.array([one[:, 1:] - np.outer(one[:, 0], velocity) for one in stored])

    return run


def same_flight(flying, resting, tolerance=1e-8):
    """Of reports and paths; tolerance: relative to the ways."""
    (found, path), (expected, own) = flying, resting
    assert (found["steps"], found["rejections"]) == (expected["steps"], expected["rejections"])
    np.testing.assert_allclose(path, own, rtol=0.0, atol=tolerance * np.ptp(own))


@pytest.mark.parametrize("axial_stiffness", [None, 2e5])
def test_a_cart_that_flies_resolves_the_mass_on_its_spring(fly, axial_stiffness):
    """It is one of 100 rad/s, whose way beside the cart is 1 % of that which all fly."""
    resting = fly(cart, 0.0, axial_stiffness=axial_stiffness)
    same_flight(fly(cart, 40.0, axial_stiffness=axial_stiffness), resting)


@pytest.mark.parametrize("axial_stiffness", [None, 1e5])
@pytest.mark.parametrize("gravity", [(0, 0, 0), GRAVITY])
def test_a_cable_that_flies_takes_the_steps_of_one_that_rests_or_falls(fly, gravity, axial_stiffness):
    what = {"gravity": gravity, "axialStiffness": axial_stiffness}
    resting = fly(alone, 0.0, **what)
    for speed in (40.0, 800.0):
        same_flight(fly(alone, speed, **what), resting)


@pytest.mark.parametrize("integrator", ["Zhai", "RK4"])
def test_it_does_so_by_steps_that_gain_energy(fly, integrator):
    explicit = {"integrator": integrator}
    same_flight(fly(alone, 40.0, 0.5, explicit), fly(alone, 0.0, 0.5, explicit))


def test_masses_that_change_and_weights_work_as_if_nothing_flew(fly):
    """Where all of the energy is a thousand times that of the motion that one sees."""
    same_flight(fly(rope_and_wheel, 800.0), fly(rope_and_wheel, 0.0), tolerance=1e-5)


def test_forces_that_jump_work_as_if_nothing_flew(new_mbs, add_cable):
    """A force between two steps does not act on the way of the step before."""

    def pushed(speed):
        mbs, random = new_mbs(), np.random.default_rng(0)
        nodes = alone(mbs, add_cable, speed * FLIGHT)
        mbs.Assemble()
        stepper = ExplicitStepper(mbs, ExplicitSettings(), interval=0.02, duration=1.0)
        stepper.Start()
        for _ in range(50):
            stepper.SetNodeForce(nodes[0], [*random.normal(size=2), 0.0])
            stepper.Step()
        return stepper.State()[0].reshape(-1, 2, 2)[:, 0] - speed * FLIGHT[:2]

    np.testing.assert_allclose(pushed(100.0), pushed(0.0), rtol=0.0, atol=1e-8)


def spring_to_ground(mbs, node):
    """So soft that it is none."""
    ends = MarkerNodePosition(nodeNumber=node), MarkerBodyPosition(bodyNumber=mbs.CreateGround())
    spring = {"markerNumbers": list(map(mbs.AddMarker, ends)), "stiffness": [1e-12] * 3}
    mbs.AddObject(CartesianSpringDamper(**spring))


def spring_of_a_coordinate(mbs, node):
    ends = (
        MarkerNodeCoordinate(nodeNumber=node, coordinate=0),
        MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0),
    )
    mbs.AddObject(CoordinateSpringDamper(markerNumbers=list(map(mbs.AddMarker, ends))))


def force_of_time(mbs, node):
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=lambda mbs, t, load: [0, 0, 0]))


def step_function(mbs, node):
    mbs.SetPreStepUserFunction(lambda mbs, t: True)


def general_contact(mbs, node):
    mbs.AddGeneralContact()


@pytest.mark.parametrize(
    "tie", [spring_to_ground, spring_of_a_coordinate, force_of_time, step_function, general_contact]
)
def test_what_is_tied_does_not_fly(mbs, add_cable, tie):
    nodes = cart(mbs, add_cable, FLIGHT)
    assert may_fly(mbs)
    tie(mbs, nodes[1])
    assert not may_fly(mbs)


def pin(mbs, cable):
    for coordinate in (0, 1):
        ends = mbs.AddNode(NodePointGround()), cable["nodes"][-1]
        markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=k, coordinate=coordinate)) for k in ends]
        mbs.AddObject(CoordinateConstraint(markerNumbers=markers))


def hang(mbs, cable):
    items.hang(mbs, cable["nodes"][-1], [1.8, 1, 0], 1.0)


def drag(mbs, cable):
    SetCableDrag(mbs, cable, CableDrag(1.2, 0.01, diameter=0.02, fluidDensity=1.2))


def nothing(mbs, cable):
    pass


@pytest.mark.parametrize("tie", [nothing, pin, hang, drag])
def test_a_cable_that_is_held_or_dragged_does_not_fly(mbs, add_cable, tie):
    tie(mbs, add_cable(mbs))
    mbs.Assemble()
    [run] = compiled_runs(mbs, 0.0, 0.0, ExplicitSettings(), "a test", "here")
    run.state.v[:] = np.tile([3.0, 4.0, 0.0, 0.0], 6)
    expected = run.state.v if tie is nothing else np.zeros(24)
    np.testing.assert_allclose(run.flight, expected, rtol=1e-14)


def test_what_is_tied_moves_relative_to_the_ground(fly):
    """Its errors are compared with the ways there, which are longer here."""
    (tied, _), (free, _) = (fly(cart, 40.0, tie=tie) for tie in (spring_to_ground, None))
    assert 4 * tied["steps"] < free["steps"]
