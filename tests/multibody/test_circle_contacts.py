"""A straight segment on a circle pushes, sticks and slides as the formulas say, and the circle pulls back."""

import numpy as np
import pytest

from exudyn_inext.element.shape_functions import first_derivatives, shape_functions
from exudyn_inext.multibody.cables import cables_in_a_row
from exudyn_inext.multibody.circle_contacts import (
    CONTACT,
    END,
    SEGMENT,
    Contacts,
    add_circle_contacts,
)
from exudyn_inext.multibody.points import POINT

pytestmark = pytest.mark.kernel
RADIUS, DEPTH, LENGTH = 0.2, 1e-3, 1.0  # [m]
STIFFNESS, FRICTION, VISCOSITY, BRISTLE = 1e4, 0.3, 2.0, 500.0
PUSH = STIFFNESS * DEPTH
NO_CABLES = cables_in_a_row([], [])


def on_top(height=0.0, **changes):
    """One segment along x on top of a fixed circle, from x = -0.4 m: contacts and coordinates."""
    points = np.zeros(1, POINT)
    points["orientation"] = np.eye(3)
    record = np.zeros(1, CONTACT)
    given = {"radius": RADIUS, "stiffness": STIFFNESS, "friction": FRICTION, "viscosity": VISCOSITY}
    given |= {"nodes": [0, 4], "segments": 1, "has_friction": 1, "checked": -1, "length": LENGTH}
    for name, value in (given | {"height": height} | changes).items():
        record[name] = value
    ends = np.zeros(2, END)
    for end, xi in zip(ends, (0.0, 1.0), strict=True):
        end["weights"][:] = shape_functions(xi, LENGTH), first_derivatives(xi, LENGTH)
    data = np.tile([0.1, -2.0, 0.0], (2, 1))
    y = RADIUS - DEPTH - height
    q = np.array([-0.4, y, 1.0, 0.0, LENGTH - 0.4, y, 1.0, 0.0])
    return Contacts(record, ends, np.zeros(1, SEGMENT), data, np.zeros((0, 4)), points, NO_CABLES), q


def settle(contacts, q, v):
    """Forces on the cable (2,), and force and torque on the circle (3,), after it has settled."""
    force = np.zeros(8)
    add_circle_contacts(contacts, q, v, v, 1, force)
    contacts.data[1] = contacts.data[0]
    return force.reshape(4, 2)[::2].sum(axis=0), contacts.records["wrench"][0, [0, 1, 5]]


def along(speed):
    return np.tile([speed, 0.0, 0.0, 0.0], 2)


@pytest.mark.parametrize("height", [0.0, 0.01])
def test_what_slides_is_held_by_the_share_of_the_push(height):
    scene = on_top(height)
    on_cable, on_circle = settle(*scene, along(5.0))
    np.testing.assert_allclose(on_cable, [-FRICTION * PUSH, PUSH], rtol=1e-9)
    np.testing.assert_allclose(on_circle, [FRICTION * PUSH, -PUSH, -RADIUS * FRICTION * PUSH], rtol=1e-9)


def test_what_sticks_is_held_by_its_way_and_its_speed():
    contacts, q = on_top(friction_stiffness=BRISTLE)
    on_cable, _ = settle(contacts, q, along(0.5))
    assert on_cable[0] == pytest.approx(-0.5 * VISCOSITY)
    q[::4] += 1e-3
    on_cable, _ = settle(contacts, q, along(0.0))
    assert on_cable[0] == pytest.approx(-1e-3 * BRISTLE)
    q[::4] += 1e-2  # beyond the limit it slides, and remembers where it would stick
    on_cable, _ = settle(contacts, q, along(0.0))
    assert on_cable[0] == pytest.approx(-FRICTION * PUSH)
    q[::4] -= 2e-3
    on_cable, _ = settle(contacts, q, along(0.0))
    assert on_cable[0] == pytest.approx(-FRICTION * PUSH + 2e-3 * BRISTLE)


def test_what_is_apart_is_left_alone_and_forgets():
    contacts, q = on_top(friction_stiffness=BRISTLE)
    settle(contacts, q, along(0.0))
    assert contacts.data[0, 1] == 0.0
    q[1::4] += 2.0 * DEPTH
    on_cable, _ = settle(contacts, q, along(0.0))
    assert not on_cable.any()
    np.testing.assert_allclose(contacts.data[:, :2], [[DEPTH, -2.0]] * 2)


def test_forces_do_the_work_that_the_gap_takes():
    """Of an inclined, curved element raised above its axis, without friction."""
    contacts, q = on_top(0.03, friction=0.0, viscosity=0.0)
    q += 0.05 * np.cos(np.arange(8.0))
    force, way, h = np.zeros(8), np.sin(1.0 + np.arange(8.0)), 1e-6
    contacts.data[:, 0] = -1.0  # as if it touched
    add_circle_contacts(contacts, q, along(0.0), along(0.0), 0, force)
    gaps = []
    for side in (-h, h):
        add_circle_contacts(contacts, q + side * way, along(0.0), along(0.0), 0, np.zeros(8))
        gaps.append(contacts.segments["gap"][0])
    energy = 0.5 * STIFFNESS * np.square(gaps)
    assert force @ way == pytest.approx(-np.diff(energy)[0] / (2.0 * h), rel=1e-6)
