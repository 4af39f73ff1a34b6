"""Contact of planar cables with circles, and friction, as Exudyn's GeneralContact has them.

An element is as many straight segments as the contact says. What counts of each is the part within r + y of
the circle's centre, r its radius and y the half height of the cable. At both ends of the part and in its
middle, n leads from the centre to the point, t = (-n_y, n_x), g is the distance of the point from a circle of
radius r + y, and v its velocity relative to the circle. Per length,

    f_n = k g + d v_n,    f_t = -f_n (mu / z) v_t,

or f_t = -f_n mu sign(v_t) if one of the three |v_t| reaches z, pull the cable towards the circle, and the
circle towards the cable, weighted by Simpson's rule and by the element's shape functions there. A part whose
mean f_n pulls does not act. Nothing is remembered. z is the contact's frictionProportionalZone.

Implicit damping, see `implicit_contacts`, takes the velocities by which the next places are found: with
d' = d + h k / 2, B x the motion of a point by the cable's coordinates, and v that contains h/2 a_before,

    (M + W B^T B) a = F - B^T (f - W B a_before / 2),   W = h d'.

That is of order 1, but overshoots nothing: what a damper that only presses has thrown off keeps its velocity.
Whether a part acts follows from the same velocities, so that an evaluation may take several solves, in which
joints pull as in the step before: without the pull at its ends, a cable would leave the circle. Where a
part would pull if it acted, and be pressed if it did not, a share of its forces acts that lets their mean be
zero.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, record_type
from ..called_system import implements
from ..compiled import inlined
from ..lowered import local_array
from .cables import one_chain, provides
from .circle_contacts import add_contacts, combine
from .implicit_contacts import (
    AGAIN,
    CONTACT,
    NOTHING,
    add_contact,
    complete_contacts,
    ease_of_turning,
    press,
    reconsider_contacts,
)
from .points import add_wrench

POINTS = 3  # of a part
MOST_DRAG = 0.6  # rate of drag, times the step: from 2/3 on, the spin of a light circle sways, see below
OFF = 0.1  # of the force that presses, by which friction may follow from another one

PAIR = record_type(
    [
        ("circle", np.int64),  # point
        ("nodes", np.int64, (2,)),  # first coordinates of both
        ("radius", np.float64),
        ("reach", np.float64),  # r + y
        ("stiffness", np.float64),  # [N/m^2]
        ("damping", np.float64),  # [N s/m^2]
        ("viscosity", np.float64),  # mu / z [s/m]
        ("zone", np.float64),  # z [m/s]
        ("implicit", np.bool_),  # whether its damping may be
        ("lag", np.float64),  # the step h [s] where it is; 0: it is explicit
        ("wrench", np.float64, (6,)),
    ]
)
"""An element and a circle."""
ELEMENT = record_type(
    [
        ("nodes", np.int64, (2,)),
        ("segments", np.int64),  # how many
        ("first", np.int64),  # of its ends
        ("pairs", np.int64, (2,)),  # first of them, and the one after the last
        ("length", np.float64),
        ("box", np.float64, (2, 2)),  # least and largest x and y of its ends
    ]
)
END = record_type([("weights", np.float64, (4,)), ("x", np.float64, (2, 2))])
"""Of a segment.   weights: of positions and slopes of both nodes.   x: position and velocity."""
POINT = record_type(
    [
        ("xi", np.float64),  # abscissa in the element, 0 to 1
        ("weights", np.float64, (4,)),  # shape functions of the element there
        ("normal", np.float64, (2,)),
        ("rate", np.float64, (2,)),  # v_n, v_t
        ("before", np.float64, (2,)),  # accelerations that these contain, along n and t
        ("force", np.float64),  # f_n
        ("pressing", np.float64),  # f_n at the velocities to come, where it acts
        ("rubbing", np.float64),  # f_n by which friction acts
        ("weight", np.float64),  # in Simpson's rule [m]
        ("resistance", np.float64),  # f_t / v_t
    ]
)
PART = record_type(
    [
        ("pair", np.int64),
        ("points", POINT, (POINTS,)),
        ("share", np.float64),  # of its forces that acts: 1 or 0, or what lies between, see `_weigh`
        ("tried", np.int64, (2,)),  # which of these, at this state
        ("sums", np.float64, (2,)),  # of the three f_n, if it did not act and if it did
        ("force", np.float64),  # int f_n dx, if it did [N]
        ("is_fast", np.int64),  # whether v_t reaches z
        ("rubs", np.int64),  # whether friction follows from what presses
    ]
)


class GeneralContacts(NamedTuple):
    """records: PAIR, those of an element one after the other.   elements, ends: of all.

    parts: memory.   number: (1,) how many there are at present.   points, cables: of the scene.
    """

    records: Any
    elements: Any
    ends: Any
    parts: Any
    number: np.ndarray
    points: Any = None
    cables: Any = None


def general_contacts(records: Any, elements: Any, weights: Array) -> GeneralContacts:
    """The contacts of these pairs and elements.   weights: (ends, 4) of all ends."""
    ends = np.zeros(len(weights), END)
    ends["weights"] = weights
    pairs = elements["pairs"][:, 1] - elements["pairs"][:, 0]
    parts = np.zeros(int((elements["segments"] * pairs).sum()), PART)
    return GeneralContacts(records, elements, ends, parts, np.zeros(1, np.int64))


def rate_of_drag(contacts: Any, bodies: Any) -> float:
    """Largest rate r at which friction takes a circle that turns along, at the last evaluation [1/s].

    Its spin w is explicit: beside heavy cables at rest, w_(n+1) = w_n - h r (2 w_n - w_(n-1)) while it does
    not slip, which sways from h r = 2/3 on.

    contacts: of any kind; 0 if not these.   bodies: of the scene.
    """
    number = int(contacts.number[0]) if isinstance(contacts, GeneralContacts) else 0
    if not number:
        return 0.0
    parts = contacts.parts[:number]
    records, points = contacts.records[parts["pair"]], parts["points"]
    along = (points["weight"] * np.maximum(points["resistance"], 0.0)).sum(axis=1)
    drag, circles = parts["share"] * along * records["radius"] ** 2, records["circle"]
    drags = [(circle, drag[circles == circle].sum()) for circle in np.unique(circles)]
    return float(max(one * ease_of_turning(contacts.points[circle], bodies) for circle, one in drags))


@inlined
def _place_ends(element, ends, q):
    """Positions, and the box around them."""
    box = element.box
    for e in range(len(ends)):
        end = ends[e]
        for i in range(2):
            x = combine(element.nodes, end.weights, q, i)
            end.x[0, i] = x
            box[0, i] = x if e == 0 else min(box[0, i], x)
            box[1, i] = x if e == 0 else max(box[1, i], x)


@inlined
def _move_ends(element, ends, v):
    for e in range(len(ends)):
        for i in range(2):
            ends[e].x[1, i] = combine(element.nodes, ends[e].weights, v, i)


@inlined
def _is_near(element, pair, circle):
    """Whether the circle reaches into the box of the element."""
    x, y, box, reach = circle.x[0, 0], circle.x[0, 1], element.box, pair.reach
    along = box[0, 0] - reach <= x <= box[1, 0] + reach
    return along and box[0, 1] - reach <= y <= box[1, 1] + reach


@inlined
def _part_within(pair, circle, one, other):
    """Where the part begins and ends, as shares of the segment; nothing: both are zero."""
    along_x, along_y = other.x[0, 0] - one.x[0, 0], other.x[0, 1] - one.x[0, 1]
    x, y = circle.x[0, 0] - one.x[0, 0], circle.x[0, 1] - one.x[0, 1]
    square, middle = along_x * along_x + along_y * along_y, along_x * x + along_y * y
    below = middle * middle - square * (x * x + y * y - pair.reach * pair.reach)
    if not below > 0.0:
        return 0.0, 0.0
    root = np.sqrt(below)
    begin, end = (middle - root) / square, (middle + root) / square
    if begin >= 1.0 or end <= 0.0:
        return 0.0, 0.0
    return max(begin, 0.0), min(end, 1.0)


@inlined
def _damping(pair):
    """Where damping is implicit, stiffness is so for the half step by which velocities are ahead."""
    return pair.damping + 0.5 * pair.lag * pair.stiffness


@inlined
def _place_point(point, pair, circle, one, other, share):
    """Normal, rates and f_n of a point of a segment."""
    x = one.x[0, 0] + share * (other.x[0, 0] - one.x[0, 0]) - circle.x[0, 0]
    y = one.x[0, 1] + share * (other.x[0, 1] - one.x[0, 1]) - circle.x[0, 1]
    distance = np.sqrt(x * x + y * y)
    if distance > 0.0:
        x, y = x / distance, y / distance
    u = one.x[1, 0] + share * (other.x[1, 0] - one.x[1, 0]) - circle.x[1, 0]
    w = one.x[1, 1] + share * (other.x[1, 1] - one.x[1, 1]) - circle.x[1, 1]
    point.normal[0], point.normal[1] = x, y
    point.rate[0], point.rate[1] = u * x + w * y, w * x - u * y - distance * circle.spin[2]
    point.force = pair.stiffness * (distance - pair.reach) + _damping(pair) * point.rate[0]


@inlined
def _set_weights(point, length):
    """Shape functions of the element there."""
    x = point.xi
    point.weights[0] = 1.0 - x * x * (3.0 - 2.0 * x)
    point.weights[1] = length * x * (1.0 - x) * (1.0 - x)
    point.weights[2] = x * x * (3.0 - 2.0 * x)
    point.weights[3] = length * x * x * (x - 1.0)


@inlined
def _pull(pair, point, circle, normal, along, force):
    """A force on the cable's shape functions and on the circle."""
    n, wrench = point.normal, pair.wrench
    x, y = normal * n[0] - along * n[1], normal * n[1] + along * n[0]
    for k in range(4):
        at = pair.nodes[k // 2] + 2 * (k % 2)
        force[at] -= point.weights[k] * x
        force[at + 1] -= point.weights[k] * y
    wrench[0], wrench[1], wrench[5] = x, y, pair.radius * along
    add_wrench(circle, wrench, 1.0, force)


@inlined
def _acceleration(pair, point, a, axis):
    """B a along n or t."""
    u, w = combine(pair.nodes, point.weights, a, 0), combine(pair.nodes, point.weights, a, 1)
    n = point.normal
    return u * n[0] + w * n[1] if axis == 0 else w * n[0] - u * n[1]


@inlined
def _mass(share, pair, point, axis):
    """W along n or t [kg]."""
    return share * pair.lag * point.weight * (_damping(pair) if axis == 0 else max(point.resistance, 0.0))


@inlined
def _add_part(part, pair, circle, share, force):
    """That share of its forces, with what implicit damping takes off them."""
    for i in range(POINTS):
        point = part.points[i]
        normal = point.weight * point.force - 0.5 * _mass(1.0, pair, point, 0) * point.before[0]
        along = point.weight * point.resistance * point.rate[1]
        along -= 0.5 * _mass(1.0, pair, point, 1) * point.before[1]
        _pull(pair, point, circle, share * normal, share * along, force)


@inlined
def _set_part(part, pair, circle, element, segment, one, other, begin, end, a):
    """Where a part is pressed, and by what.   segment: its number."""
    total = fastest = 0.0
    for i in range(POINTS):
        point, share = part.points[i], begin + 0.5 * i * (end - begin)
        if i == POINTS - 1:
            share = end  # so that the next part begins with the same number
        _place_point(point, pair, circle, one, other, share)
        point.xi = (segment + share) / element.segments
        total += point.force
        fastest = max(fastest, abs(point.rate[1]))
    part.share = 1.0 if total < 0.0 else 0.0
    part.tried[0] = part.tried[1] = part.rubs = 0
    part.is_fast = fastest >= pair.zone
    length = (end - begin) * element.length / element.segments
    for i in range(POINTS):
        point = part.points[i]
        _set_weights(point, element.length)
        point.weight = length * (4.0 if i == 1 else 1.0) / 6.0
        point.pressing = point.force
        point.before[0] = point.before[1] = 0.0
        if pair.lag > 0.0:
            point.before[0] = _acceleration(pair, point, a, 0)
            point.before[1] = _acceleration(pair, point, a, 1)
    _rub(part, pair, 0.0)


@inlined
def _rub(part, pair, less):
    """Let friction follow from what presses.   less: by which that is less."""
    for i in range(POINTS):
        point = part.points[i]
        point.rubbing = point.pressing - less
        point.resistance = -point.rubbing * pair.viscosity
        if part.is_fast and point.rate[1] != 0.0:
            point.resistance *= pair.zone / abs(point.rate[1])


@inlined
def _touch(contacts, c, circle, element, ends, a, force):
    """Forces between an element and a circle."""
    pair, number = contacts.records[c], contacts.number
    for s in range(element.segments):
        one, other = ends[s], ends[s + 1]
        begin, end = _part_within(pair, circle, one, other)
        if end > begin:
            part = contacts.parts[number[0]]
            number[0] += 1
            part.pair = c
            _set_part(part, pair, circle, element, s, one, other, begin, end, a)
            if part.share > 0.0:
                _add_part(part, pair, circle, 1.0, force)


@implements(add_contacts, GeneralContacts)
def add_general_contacts(contacts, q, v, a, settles, force):
    contacts.number[0], points = 0, contacts.points
    for e in range(len(contacts.elements)):
        element, moves = contacts.elements[e], False
        ends = contacts.ends[element.first : element.first + element.segments + 1]
        _place_ends(element, ends, q)
        for c in range(element.pairs[0], element.pairs[1]):
            circle = points[contacts.records[c].circle]
            if _is_near(element, contacts.records[c], circle):
                if not moves:
                    _move_ends(element, ends, v)
                    moves = True
                _touch(contacts, c, circle, element, ends, a, force)


@inlined
def _weigh(part):
    """What share of its forces lets their mean be zero.

    v_n is v_0 without them and v_1 with all of them: the mass that moves is -h f_1 / (v_1 - v_0).
    """
    missing, excess = -part.sums[0], part.sums[1]
    length = part.points[0].weight + part.points[1].weight + part.points[2].weight
    force = part.force - length * excess / POINTS  # at that velocity
    return min(max(part.force / force, 0.0) * missing / (missing + excess), 1.0) if force < 0.0 else 0.0


@inlined
def _is_wrong(part, pair, a):
    """Whether a part pulls at the velocities to come though it acts, or would press though it does not."""
    total = force = 0.0
    now = 1 if part.share > 0.0 else 0
    for i in range(POINTS):
        point = part.points[i]
        more = _acceleration(pair, point, a, 0) - 0.5 * point.before[0]
        to_come = point.force + pair.lag * _damping(pair) * more
        total += to_come
        force += point.weight * to_come
        if now == 1:
            point.pressing = to_come
    part.sums[now], part.tried[now] = total, 1
    if now == 1:
        part.force = force
    return total >= 0.0 if now == 1 else total < 0.0


@inlined
def _rubs_wrong(part, pair):
    """Whether friction is that of another force than presses."""
    if part.rubs or not part.share > 0.0 or pair.viscosity == 0.0:
        return False
    force = 0.0
    for i in range(POINTS):
        force += part.points[i].weight * part.points[i].rubbing
    return abs(force - part.force) > OFF * abs(part.force)


@inlined
def _reconsider_part(part, pair, circle, a, force):
    """Whether another share of a part acts than did, or friction is another one."""
    if part.tried[0] + part.tried[1] == 2:
        return False
    before, is_wrong = part.share, _is_wrong(part, pair, a)
    if not is_wrong and not _rubs_wrong(part, pair):
        return False
    _add_part(part, pair, circle, -before, force)
    if is_wrong:
        part.share = _weigh(part) if part.tried[0] + part.tried[1] == 2 else 1.0 - before
    if part.tried[1]:
        part.rubs = 1
        _rub(part, pair, max(part.sums[1], 0.0) / POINTS)
    _add_part(part, pair, circle, part.share, force)
    return True


@implements(reconsider_contacts, GeneralContacts)
def reconsider_general_contacts(contacts, a, force):
    changed, points = 0.0, contacts.points
    for k in range(contacts.number[0]):
        part = contacts.parts[k]
        pair = contacts.records[part.pair]
        if pair.lag > 0.0 and _reconsider_part(part, pair, points[pair.circle], a, force):
            changed = 1.0
    return changed


@implements(complete_contacts, GeneralContacts)
def complete_general_contacts(contacts, a, force):
    points = contacts.points
    for k in range(contacts.number[0]):
        part = contacts.parts[k]
        pair = contacts.records[part.pair]
        if part.share > 0.0 and pair.lag > 0.0:
            for i in range(POINTS):
                point = part.points[i]
                normal = _mass(part.share, pair, point, 0) * _acceleration(pair, point, a, 0)
                along = _mass(part.share, pair, point, 1) * _acceleration(pair, point, a, 1)
                _pull(pair, point, points[pair.circle], normal, along, force)


@implements(press, GeneralContacts)
def press_by_general_contacts(contacts, again):
    cables = contacts.cables
    for k in range(len(cables.functions)):
        if provides(cables, k, CONTACT):
            _press_chain(one_chain(cables, k), contacts, cables.dofs[k], cables.dofs[k + 1], again)


@inlined
def _press_chain(chain, contacts, begin, end, again):
    """begin, end: coordinates of the chain. Where parts meet, their masses are added."""
    row, parts, number = local_array(1, 8), contacts.parts, contacts.number[0]
    add_contact(chain, AGAIN if again else NOTHING, 0.0, row[0])
    across = along = 0.0
    for k in range(number):
        part = parts[k]
        pair = contacts.records[part.pair]
        if part.share > 0.0 and pair.lag > 0.0 and begin <= pair.nodes[0] < end:
            goes_on = k + 1 < number and parts[k + 1].share > 0.0 and parts[k + 1].pair == part.pair
            goes_on = goes_on and parts[k + 1].points[0].xi == part.points[POINTS - 1].xi
            for i in range(POINTS):
                point = part.points[i]
                across += _mass(part.share, pair, point, 0)
                along += _mass(part.share, pair, point, 1)
                if i < POINTS - 1 or not goes_on:
                    _press_point(chain, (pair.nodes[0] - begin) // 4, point, across, along, row)
                    across = along = 0.0


@inlined
def _press_point(chain, element, point, across, along, row):
    """Masses along n and t [kg].   row: (1, 8) memory."""
    for axis in range(2):
        mass = across if axis == 0 else along
        if mass > 0.0:
            x = point.normal[0] if axis == 0 else -point.normal[1]
            y = point.normal[1] if axis == 0 else point.normal[0]
            for k in range(4):
                row[0, 2 * k] = point.weights[k] * x
                row[0, 2 * k + 1] = point.weights[k] * y
            add_contact(chain, element, mass, row[0])
