"""Contact of planar cables with circles, and friction between them.

An element is as many straight segments as it has data. n leads from the circle's centre to the nearest point
of a segment, t = (-n_y, n_x), and g is the distance of that point from the circle. Where a segment touches,

    f_n = k g + d v_n                                    along n
    f_t = mu_v v_t + mu_k (x - x_stick)  while it sticks, or  +-mu |f_n|  while it slides, along t

pull its ends towards the circle, and the circle towards them. v is its velocity relative to the circle, x the
place of contact along both. Which segments touch, stick or slide, and since where, are data that change
where contact settles, once a step: see Exudyn's ObjectContactFrictionCircleCable2D.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, record_type
from ..called_system import implements, of_parts
from ..compiled import inlined, protocol
from ..lowered import COUNT, VECTOR, local_array
from .points import add_wrench

NOW, START = range(2)  # data at present, and at the start of the step
APART, STICKS = -2.0, 0.0  # what data say of a segment, besides the direction +-1 of its slip
SHARE = 0.5 + 0.0625  # of h d, see `implicit_contacts`

CONTACT = record_type(
    [
        ("circle", np.int64),  # point
        ("nodes", np.int64, (2,)),  # first coordinates of both
        ("segments", np.int64),  # how many
        ("first", np.int64),  # segment among all; of its ends, one more for each contact before it
        ("place", np.int64),  # first of its data: gaps of all segments, then states, then where they stick
        ("has_friction", np.int64),  # its data, too
        ("pointwise", np.int64),  # whether ends are pulled along their own normals
        ("checked", np.int64),  # row of `Contacts.sums`, or -1
        ("radius", np.float64),
        ("offset", np.float64),
        ("stiffness", np.float64),
        ("damping", np.float64),
        ("friction", np.float64),
        ("friction_stiffness", np.float64),
        ("viscosity", np.float64),
        ("length", np.float64),  # of a segment
        ("height", np.float64),  # of the ends above the cable's axis
        ("implicit", np.bool_),  # whether it may be, see `implicit_contacts`
        ("stretches", np.bool_),  # whether its cable does
        ("lag", np.float64),  # the step h [s] where it is; 0: it is explicit
        ("mass", np.float64),  # of a segment [kg]
        ("wrench", np.float64, (6,)),
    ]
)
END = record_type(
    [
        ("weights", np.float64, (2, 4)),  # of positions and slopes of both nodes: for r and r_x
        ("x", np.float64, (3, 2)),  # position, velocity, acceleration
        ("slope", np.float64, (2,)),  # r_x
        ("force", np.float64, (2,)),
    ]
)
SEGMENT = record_type(
    [
        ("gap", np.float64),
        ("share", np.float64),  # of its length, where it is nearest
        ("sense", np.float64),  # in which the place of contact moves along the circle
        ("normal", np.float64, (2,)),
        ("rate", np.float64, (2,)),  # v_n, v_t
        ("force", np.float64, (2,)),  # f_n, f_t
        ("acceleration", np.float64, (2,)),  # B a along n and t
        ("mass", np.float64, (2,)),  # W along n and t
        ("damping", np.float64, (2,)),  # what of it is due to damping
    ]
)


class Contacts(NamedTuple):
    """records, ends, segments: of all contacts.   data: see `Items`.   sums: see `native.friction_check`.

    points, cables: of the scene.
    """

    records: Any
    ends: Any
    segments: Any
    data: Array
    sums: Array
    points: Any = None
    cables: Any = None


@protocol
def add_contacts(contacts, q, v, a, settles, force):
    """Add the generalised forces of all contacts to force (n,); the points are placed and move.

    a: (n,) accelerations that v contains, where damping is implicit.
    settles: whether data are brought up to date before, 1 or 0.
    """


@protocol
def check_friction(contacts, weight):
    """Look at friction at the end of a step.   weight: of what lasts, in steps; 0: it is not looked at."""


ADDING = of_parts(add_contacts, VECTOR, VECTOR, VECTOR, COUNT, VECTOR)
of_parts(check_friction, COUNT)


@inlined
def combine(nodes, weights, x, i):
    """Component i of the weighted sum of coordinates x (n,) of an element's nodes."""
    one, other = nodes[0], nodes[1]
    left = weights[0] * x[one + i] + weights[1] * x[one + 2 + i]
    return left + weights[2] * x[other + i] + weights[3] * x[other + 2 + i]


@inlined
def _place_ends(contact, ends, q):
    """r + y n at height y above the axis, n = (-r_x,y, r_x,x) / |r_x|."""
    for e in range(len(ends)):
        end = ends[e]
        for i in range(2):
            end.x[0, i] = combine(contact.nodes, end.weights[0], q, i)
        if contact.height != 0.0:
            x, y = combine(contact.nodes, end.weights[1], q, 0), combine(contact.nodes, end.weights[1], q, 1)
            raised = contact.height / np.sqrt(x * x + y * y)
            end.slope[0], end.slope[1] = x, y
            end.x[0, 0] -= raised * y
            end.x[0, 1] += raised * x


@inlined
def _move_ends(contact, ends, v, order):
    """r_t - y w r_x / |r_x|, w the angular velocity of the slope.   order: 2 if v are accelerations."""
    for e in range(len(ends)):
        end = ends[e]
        for i in range(2):
            end.x[order, i] = combine(contact.nodes, end.weights[0], v, i)
        if contact.height != 0.0:
            u, w = combine(contact.nodes, end.weights[1], v, 0), combine(contact.nodes, end.weights[1], v, 1)
            x, y = end.slope[0], end.slope[1]
            square = x * x + y * y
            turning = contact.height * (x * w - y * u) / (square * np.sqrt(square))
            end.x[order, 0] -= turning * x
            end.x[order, 1] -= turning * y


@inlined
def _measure(contact, circle, one, other, segment):
    """Where a segment is nearest to the circle."""
    along_x, along_y = other.x[0, 0] - one.x[0, 0], other.x[0, 1] - one.x[0, 1]
    x, y = circle.x[0, 0] - one.x[0, 0], circle.x[0, 1] - one.x[0, 1]
    square = along_x * along_x + along_y * along_y
    share = (along_x * x + along_y * y) / square if square > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    x, y = share * along_x - x, share * along_y - y
    distance = np.sqrt(x * x + y * y)
    if distance > 0.0:
        x, y = x / distance, y / distance
    segment.gap = distance - contact.radius - contact.offset
    segment.share = share
    segment.normal[0], segment.normal[1] = x, y
    segment.sense = -1.0 if x * along_y - y * along_x > 0.0 else 1.0


@inlined
def _set_rates(contact, circle, one, other, segment):
    """Velocity of the nearest point relative to the circle, which turns about its own axis."""
    x, y, turn = segment.normal[0], segment.normal[1], circle.orientation
    spin = circle.spin[0] * turn[0, 2] + circle.spin[1] * turn[1, 2] + circle.spin[2] * turn[2, 2]
    u = one.x[1, 0] + segment.share * (other.x[1, 0] - one.x[1, 0]) - circle.x[1, 0]
    w = one.x[1, 1] + segment.share * (other.x[1, 1] - one.x[1, 1]) - circle.x[1, 1]
    segment.rate[0], segment.rate[1] = u * x + w * y, w * x - u * y - contact.radius * spin


@inlined
def _set_accelerations(one, other, segment):
    """Of the nearest point by those of the cable, along n and t."""
    x, y = segment.normal[0], segment.normal[1]
    u = one.x[2, 0] + segment.share * (other.x[2, 0] - one.x[2, 0])
    w = one.x[2, 1] + segment.share * (other.x[2, 1] - one.x[2, 1])
    segment.acceleration[0], segment.acceleration[1] = u * x + w * y, w * x - u * y


@inlined
def _slip(contact, circle, segment, since):
    """x - x_stick, less whole turns, and x.   since: x_stick [m]."""
    n, turn = segment.normal, circle.orientation
    angle = np.arctan2(n[0] * turn[0, 1] + n[1] * turn[1, 1], n[0] * turn[0, 0] + n[1] * turn[1, 0])
    place = contact.radius * angle + segment.sense * segment.share * contact.length
    around = 2.0 * np.pi * contact.radius
    slip = place - since
    return slip - np.floor(slip / around + 0.5) * around, place


@inlined
def _normal_force(contact, segment):
    return contact.stiffness * segment.gap + contact.damping * segment.rate[0]


@inlined
def _settle_friction(contact, circle, segment, data, at):
    """Whether a segment that touches sticks, and where.   at: place of its gap."""
    state, place = at + contact.segments, at + 2 * contact.segments
    limit = contact.friction * abs(_normal_force(contact, segment))
    since = x = data[START, place]
    slip = segment.rate[1]
    force = contact.viscosity * slip
    if contact.friction_stiffness != 0.0:
        slip, x = _slip(contact, circle, segment, since)
        if data[START, state] == APART:
            slip, since = 0.0, x
        force += contact.friction_stiffness * slip
    data[NOW, state], data[NOW, place] = STICKS, since
    if abs(force) > limit:
        data[NOW, state] = np.sign(slip)
        data[NOW, place] = x
        if contact.friction_stiffness != 0.0:
            data[NOW, place] = x - np.sign(slip) * limit / contact.friction_stiffness


@inlined
def _settle(contact, circle, segment, data, at):
    """What data say of a segment.   at: place of its gap."""
    is_open = segment.gap > 0.0
    if not contact.has_friction:
        if is_open == (data[NOW, at] <= 0.0):
            data[NOW, at] = segment.gap
        return
    data[NOW, at] = segment.gap
    if is_open or (contact.friction_stiffness == 0.0 and contact.viscosity == 0.0):
        data[NOW, at + contact.segments] = APART
    else:
        _settle_friction(contact, circle, segment, data, at)


@inlined
def _set_mass(contact, segment, axis, damping, spring):
    """W along n or t."""
    lag = SHARE * contact.lag
    segment.damping[axis] = lag * damping
    segment.mass[axis] = lag * (damping + contact.lag * spring)


@inlined
def _rub(contact, circle, segment, data, state, at):
    """Set f_t; its damping and its stiffness."""
    if abs(state) == 1:
        segment.force[1] = state * contact.friction * abs(segment.force[0])
        speed, force = abs(segment.rate[1]), abs(segment.force[1])
        return (force / speed if force < contact.viscosity * speed else contact.viscosity), 0.0
    segment.force[1] = contact.viscosity * segment.rate[1]
    if state == int(STICKS) and contact.friction_stiffness != 0.0:
        slip, _ = _slip(contact, circle, segment, data[NOW, at + 2 * contact.segments])
        segment.force[1] += contact.friction_stiffness * slip
        return contact.viscosity, contact.friction_stiffness
    return contact.viscosity, 0.0


@inlined
def _set_force(contact, circle, segment, data, at):
    """Of a segment that touches."""
    segment.force[0], segment.force[1] = _normal_force(contact, segment), 0.0
    damping, spring = 0.0, 0.0
    if contact.has_friction:
        state = int(data[NOW, at + contact.segments])
        damping, spring = _rub(contact, circle, segment, data, state, at)
    _set_mass(contact, segment, 0, contact.damping, contact.stiffness)
    _set_mass(contact, segment, 1, damping, spring)


@inlined
def _pull_end(contact, circle, end, weight, segment):
    """The share of a segment's force on one of its ends, and on the circle."""
    x, y = segment.normal[0], segment.normal[1]
    if contact.pointwise:
        x, y = end.x[0, 0] - circle.x[0, 0], end.x[0, 1] - circle.x[0, 1]
        distance = np.sqrt(x * x + y * y)
        if distance > 0.0:
            x, y = x / distance, y / distance
    normal, along = weight * segment.force[0], weight * segment.force[1]
    u, w = normal * x - along * y, normal * y + along * x
    end.force[0] -= u
    end.force[1] -= w
    contact.wrench[0] += u
    contact.wrench[1] += w
    contact.wrench[5] += contact.radius * along


@inlined
def _pull(contact, circle, one, other, segment):
    """Without friction, Exudyn pulls the circle again by what earlier segments do to a common end."""
    if not contact.has_friction:
        contact.wrench[0] -= one.force[0]
        contact.wrench[1] -= one.force[1]
    _pull_end(contact, circle, one, 1.0 - segment.share, segment)
    _pull_end(contact, circle, other, segment.share, segment)


@inlined
def add_end(contact, end, x, y, row):
    """Add what a force (x, y) on an end does to the coordinates of its element.   row: (1, 8).

    By the transposed derivatives of `_move_ends`.
    """
    along, u, w = 0.0, end.slope[0], end.slope[1]
    if contact.height != 0.0:
        square = u * u + w * w
        along = contact.height * (u * x + w * y) / (square * np.sqrt(square))
    for k in range(4):
        weight, turning = end.weights[0, k], end.weights[1, k]
        row[0, 2 * k] += weight * x + turning * along * w
        row[0, 2 * k + 1] += weight * y - turning * along * u


@inlined
def _add_to_nodes(contact, ends, force):
    """The forces of all ends."""
    row = local_array(1, 8)
    for i in range(8):
        row[0, i] = 0.0
    for e in range(len(ends)):
        if ends[e].force[0] != 0.0 or ends[e].force[1] != 0.0:
            add_end(contact, ends[e], ends[e].force[0], ends[e].force[1], row)
    for i in range(8):
        force[contact.nodes[i // 4] + i % 4] += row[0, i]


@inlined
def _clear_forces(contact, ends):
    for e in range(len(ends)):
        ends[e].force[0] = ends[e].force[1] = 0.0
    for i in range(6):
        contact.wrench[i] = 0.0


@inlined
def _touch(contact, circle, ends, segments, data, settles):
    """Forces of all segments, of which some touch."""
    _clear_forces(contact, ends)
    for s in range(contact.segments):
        segment, one, other, at = segments[s], ends[s], ends[s + 1], contact.place + s
        _set_rates(contact, circle, one, other, segment)
        if settles:
            _settle(contact, circle, segment, data, at)
        if data[NOW, at] <= 0.0:
            _set_force(contact, circle, segment, data, at)
            if contact.lag > 0.0:
                _set_accelerations(one, other, segment)
                for i in range(2):
                    segment.force[i] -= segment.damping[i] * segment.acceleration[i]
            _pull(contact, circle, one, other, segment)
        else:
            segment.force[0] = segment.force[1] = 0.0


@inlined
def pull_by_masses(contact, circle, ends, segments, data, a, force):
    """Add W B a of all segments that touch to force (n,).   a: (n,) accelerations."""
    touches = False
    for s in range(contact.segments):
        touches = touches or data[NOW, contact.place + s] <= 0.0
    if not touches:
        return
    _clear_forces(contact, ends)
    _move_ends(contact, ends, a, 2)
    for s in range(contact.segments):
        segment, one, other = segments[s], ends[s], ends[s + 1]
        if data[NOW, contact.place + s] <= 0.0:
            normal, along = segment.force[0], segment.force[1]
            _set_accelerations(one, other, segment)
            for i in range(2):
                segment.force[i] = segment.mass[i] * segment.acceleration[i]
            _pull(contact, circle, one, other, segment)
            segment.force[0] += normal
            segment.force[1] += along
    _add_to_nodes(contact, ends, force)
    add_wrench(circle, contact.wrench, 1.0, force)


@inlined
def _let_go(contact, segments, data, settles):
    """Of a contact whose segments are all apart."""
    for s in range(contact.segments):
        segments[s].force[0] = segments[s].force[1] = 0.0
        if settles and contact.has_friction:
            data[NOW, contact.place + s] = segments[s].gap
            data[NOW, contact.place + contact.segments + s] = APART


@inlined
def _any_touches(contact, circle, ends, segments, data):
    """Measure all segments; whether one touches now or did so when contact settled last."""
    touches = False
    for s in range(contact.segments):
        _measure(contact, circle, ends[s], ends[s + 1], segments[s])
        touches = touches or not segments[s].gap > 0.0 or data[NOW, contact.place + s] <= 0.0
    return touches


@implements(add_contacts, Contacts)
def add_circle_contacts(contacts, q, v, a, settles, force):
    points, data = contacts.points, contacts.data
    for c in range(len(contacts.records)):
        contact = contacts.records[c]
        circle, first, number = points[contact.circle], contact.first, contact.segments
        segments, ends = contacts.segments[first : first + number], contacts.ends[first + c :]
        ends = ends[: number + 1]
        _place_ends(contact, ends, q)
        if _any_touches(contact, circle, ends, segments, data):
            _move_ends(contact, ends, v, 1)
            if contact.lag > 0.0:
                _move_ends(contact, ends, a, 2)
            _touch(contact, circle, ends, segments, data, settles)
            _add_to_nodes(contact, ends, force)
            add_wrench(circle, contact.wrench, 1.0, force)
        else:
            _let_go(contact, segments, data, settles)


@inlined
def _check_segment(contact, segment, weight, closes, state, sums):
    """Powers of friction, see `native.friction_check`."""
    force, velocity = segment.force[1], segment.rate[1]
    power = force * velocity
    if abs(state) == 1.0 and power < 0.0:
        sums[0] -= weight * power
    if closes:
        above = abs(force) - contact.friction * abs(segment.force[0])
        sums[1] += max(above, 0.0) * abs(velocity)
        sums[2] += abs(power)
    elif state != APART:
        sums[2] += weight * abs(power)


@inlined
def _check(contact, segments, data, weight, sums):
    """Of one contact, see `check_friction`."""
    lasts = False
    for s in range(contact.segments):
        at = contact.place + contact.segments + s
        state = data[NOW, at]
        closes = state == STICKS and data[START, at] == APART
        lasts = lasts or (state != APART and not closes)
        if state != APART and (closes or weight > 0.0):
            _check_segment(contact, segments[s], weight, closes, state, sums)
    if lasts and weight > 0.0:
        sums[3] += 1.0


@implements(check_friction, Contacts)
def check_friction_on_circles(contacts, weight):
    for c in range(len(contacts.records)):
        contact = contacts.records[c]
        if contact.checked >= 0:
            segments = contacts.segments[contact.first : contact.first + contact.segments]
            _check(contact, segments, contacts.data, weight, contacts.sums[contact.checked])
