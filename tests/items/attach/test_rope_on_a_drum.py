"""A rope over a drum that stands still, by Euler-Eytelwein, or over a pulley that turns, by Atwood."""

import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    Force,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    NodeRigidBody2D,
    ObjectRigidBody2D,
    RevoluteJoint2D,
)

from exudyn_inext import CableShape, CreateCompanionCables, CreateInextensibleCable, InextensibleCable
from tests.exudyn_binding.items import trajectory
from tests.items.attach.contact import SEGMENTS, Circle, add_contact, add_general_contact

RADIUS, SIDE, ELEMENTS = 0.1, 0.8, 48  # [m]
FRICTION, MASSES, GRAVITY = 0.3, (1.0, 4.0), 9.81
MASS = 0.01  # of the rope [kg/m]
END = 0.4  # [s]
PULLEY = 0.5  # moment of inertia over the squared radius [kg]


def on_the_drum():
    """Shape of a rope that lies half around the drum, and hangs down on both sides; its length [m]."""
    length = np.pi * RADIUS + 2 * SIDE
    s = np.linspace(0.0, length, ELEMENTS + 1)
    angle = np.clip((s - SIDE) / RADIUS, 0.0, np.pi)
    slopes = np.column_stack([np.sin(angle), np.cos(angle)])
    arc = RADIUS * np.column_stack([-np.cos(angle), np.sin(angle)])
    return CableShape(arc + (s - SIDE - RADIUS * angle)[:, None] * slopes, slopes), length


def hang(mbs, node, mass):
    place = mbs.GetNodeParameter(node, "referenceCoordinates")[:2]
    body = mbs.CreateMassPoint(mass=mass, referencePosition=[*place, 0], create2D=True)
    marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
    mbs.AddLoad(Force(markerNumber=marker, loadVector=[0, -GRAVITY * mass, 0]))
    mbs.AddObject(RevoluteJoint2D(markerNumbers=[marker, mbs.AddMarker(MarkerNodePosition(nodeNumber=node))]))


STRETCH = {"axialStiffness": 1e5, "axialDamping": 30}


def touch(mbs, cable, length, stiffness, share, in_general, centre=None):
    """Contact of a rope with a circle.

    stiffness: by length [N/m^2].   share: damping, of the critical one: segments bounce, or do not.
    in_general: whether it is a GeneralContact.   centre: body that it is on; default: ground.
    """
    elements, damping = CreateCompanionCables(mbs, cable), share * 2.0 * np.sqrt(stiffness * MASS)
    if in_general:
        marker = None if centre is None else mbs.AddMarker(MarkerBodyRigid(bodyNumber=centre))
        add_general_contact(mbs, elements, Circle(0.9995 * RADIUS, stiffness, damping, FRICTION), marker)
        return
    segment = length / ELEMENTS / SEGMENTS
    surface = {"friction": FRICTION, "friction_damping": 1e4 * segment}
    add_contact(
        mbs, elements, Circle(0.9995 * RADIUS, stiffness * segment, damping * segment, **surface), centre
    )


@pytest.mark.parametrize(
    ("stiffness", "share", "stretch", "in_general"),
    [
        (1e6, 0.25, STRETCH, False),
        (1e6, 2.0, STRETCH, False),
        (1e8, 1.05, STRETCH, False),
        (1e6, 0.25, {}, False),
        (1e6, 2.0, {}, False),
        (1e6, 2.0, STRETCH, True),
        (1e6, 0.25, {}, True),
        (1e7, 1.05, {}, True),
    ],
)
def test_the_masses_fall_by_the_friction_of_a_rope_around_a_drum(
    new_mbs, add_sensor, solve, stiffness, share, stretch, in_general
):
    """T_2 = T_1 exp(mu pi), if steps resolve the pressure.

    stiffness, share, in_general: see `touch`.   stretch: of the rope.
    """
    mbs, (shape, length) = new_mbs(), on_the_drum()
    section = InextensibleCable(massPerLength=MASS, bendingStiffness=1e-4, bendingDamping=1e-5, **stretch)
    cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=section, extensible=bool(stretch))
    for node, mass in zip((cable["nodes"][0], cable["nodes"][-1]), MASSES, strict=True):
        hang(mbs, node, mass)
    touch(mbs, cable, length, stiffness, share, in_general)
    sensor = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    most = 10_000 if in_general else 50_000  # explicit contact takes 12 000, 124 000, and 290 000 and more
    assert solve(mbs, END)["steps"] < most
    time, _, y, _ = trajectory(mbs, sensor).T
    late = time > 0.1  # the rope has stretched by then
    found = 2.0 * np.polyfit(time[late], -y[late], 2)[0]
    light, heavy = MASSES
    grip = np.exp(FRICTION * np.pi)
    expected = (heavy - grip * light) / (heavy + grip * light + MASS * length) * GRAVITY
    assert found == pytest.approx(expected, rel=0.03)


def add_pulley(mbs, mass=PULLEY):
    """A body that turns about the origin.   mass: moment of inertia over the squared radius [kg]."""
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[0, 0, 0]))
    body = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=1.0, inertia=mass * RADIUS**2))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for axis in (0, 1):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    return body, node


@pytest.mark.parametrize("stretch", [{}, STRETCH])
@pytest.mark.parametrize(("in_general", "pulley"), [(False, PULLEY), (True, PULLEY), (True, 0.01)])
def test_a_rope_turns_the_pulley_of_an_atwood_machine(
    new_mbs, add_sensor, solve, stretch, in_general, pulley
):
    """a = (m_2 - m_1) g / (m_1 + m_2 + J / R^2 + rope); the rope's weight makes less than 1 % of it."""
    mbs, (shape, length) = new_mbs(), on_the_drum()
    section = InextensibleCable(massPerLength=MASS, bendingStiffness=1e-4, bendingDamping=1e-5, **stretch)
    cable = CreateInextensibleCable(mbs, shape=shape, beamTemplate=section, extensible=bool(stretch))
    light, heavy = 1.0, 1.5
    for node, mass in zip((cable["nodes"][0], cable["nodes"][-1]), (light, heavy), strict=True):
        hang(mbs, node, mass)
    body, turning = add_pulley(mbs, pulley)
    touch(mbs, cable, length, 1e6, 2.0, in_general, body)
    end, turn = add_sensor(mbs, cable["nodes"][-1]), add_sensor(mbs, turning, "Coordinates")
    mbs.Assemble()
    solve(mbs, END)
    (time, _, y, _), angle = trajectory(mbs, end).T, trajectory(mbs, turn)[:, 3]
    late = time > 0.1
    expected = (heavy - light) * GRAVITY / (light + heavy + pulley + MASS * length)
    assert 2.0 * np.polyfit(time[late], -y[late], 2)[0] == pytest.approx(expected, rel=0.01)
    assert -RADIUS * 2.0 * np.polyfit(time[late], angle[late], 2)[0] == pytest.approx(expected, rel=0.01)
