"""Contact whose dampers and springs are implicit in the accelerations of the cable.

Along n and t of a segment that touches, with the damping d and B x its motion by the cable's coordinates,

    (M + W B^T B) a = F - B^T (f - W B a_before),   W = (1/2 + 1/16) h d,

f being the force at the velocities that a_before predicts. The segment feels f + W B (a - a_before), and so
does the circle. Of W, h d / 2 is the trapezoidal rule, of order 2; that alone would let velocities that steps
do not resolve change their sign each time. The rest is of order 2, too, and takes two thirds off them each
time, most that it can: with z = h d / m and w = W / m, steps of a mass are

    (1 + w) x_(n+1) = (1 + 2 w - 3/2 z) x_n - (w - z/2) x_(n-1),  z -> infinity: x_n ~ (-1/3)^n.

What slides has d = |f_t| / |v_t| along t, at most its viscosity. What joints change of a is in W B a, too:
the circle is told of it afterwards, see `scene`.

Springs add h^2 k (1/2 + 1/16) to W, which acts on a alone: central differences with M + h^2 k / 4 are the
trapezoidal rule, and no step is too long for more. With half of it, what is pressed for two steps leaves as
fast as it came, however stiff that is; with a quarter, up to three times as fast. Steps are still to resolve
what bounces, since it has less than the critical damping, and pressure under which cables rub.

The circle's own motion is not in W: where cables are much heavier than a circle, steps that friction turns
round gain energy, and the watch of the run takes shorter ones. Cables that do not stretch move along it as
one, so that W makes friction on a circle that turns no softer; slip has errors that grow with h r, r the rate
at which friction takes the circle along, and steps resolve that.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..cable.axial import take_back
from ..cable.contact_mass import add_contact_row, clear_contact_mass
from ..cable.index_reduction import CableSystem
from ..cable.linked_cable import LinkedCableSystem
from ..called_system import called_by_address, implements, of_parts
from ..checks import SMALLEST
from ..compiled import inlined, optional, protocol
from ..lowered import COUNT, REAL, VECTOR, local_array
from .cables import Cables, one_chain, provides
from .circle_contacts import CONTACT as CONTACT_WITH_CIRCLE
from .circle_contacts import NOW, Contacts, add_end, pull_by_masses
from .points import ON_BODY

NOTHING, AGAIN = -1, -2
ABOUT_Z = 5  # row of a body's mass
OF_DRAG = 0.05  # of the rate at which a circle is taken along: slip is then within 1 % of small steps
_STIFFNESSES = "stiffness", "friction_stiffness"


def mark_implicit(cables: Cables, chains: Sequence[Any], records: Any) -> bool:
    """Set which contacts may be implicit: those of planar cables.

    Args:
        cables, chains: systems of all.   records: of the contacts, in place.

    Returns:
        Whether there are any.
    """
    of_circles = records.dtype == CONTACT_WITH_CIRCLE
    for offset, system in zip(cables.dofs.tolist(), chains, strict=False):
        of_these, elements = records["nodes"][:, 0] >= offset, system.chain.elements
        stretches = elements["axial"].size > 0
        records["implicit"][of_these] = elements["contact"].size > 0
        if of_circles:
            records["stretches"][of_these] = stretches
    return bool(records["implicit"].any())


def implicit_parameters(records: Any) -> tuple[str, ...]:
    """Fields of what is implicit in contacts that are; the springs of a GeneralContact bound steps."""
    return "damping", "viscosity", *(_STIFFNESSES if records.dtype == CONTACT_WITH_CIRCLE else ())


def contact_rates(records: Any) -> dict[int, float]:
    """At which the pressure of implicit contacts with circles changes, by the place of their data [1/s].

    That is sqrt(k / m), m the mass of a segment, or the slower one of both roots of m x'' + d x' + k x = 0;
    the faster one is left to implicit damping. 0: it need not be known, of what neither bounces nor rubs.
    """
    own = _implicit(records)
    rates, bounces = _rates(own)
    return dict(zip(own["place"].tolist(), (rates * (bounces | _rubs(own))).tolist(), strict=True))


def fastest_rubbing_contact(contacts: Any, bodies: Any) -> float:
    """Rate of those that rub [1/s], since friction follows the pressure; 0: none does.

    Or a share of that at which cables that do not stretch take a circle along.

    contacts: see `Contacts`.   bodies: of the scene.
    """
    own = _implicit(contacts.records)
    turning = [_rate_of_circle(own, number, contacts.points, bodies) for number in np.unique(own["circle"])]
    return float(max((_rates(own)[0] * _rubs(own)).max(initial=0.0), *turning, 0.0))


def _rate_of_circle(records: Any, number: int, points: Any, bodies: Any) -> float:
    """See `fastest_rubbing_contact`: of a body that turns, by one turn of the cables around it at most."""
    own = records[(records["circle"] == number) & ~records["stretches"] & (records["friction"] > 0.0)]
    if not len(own):
        return 0.0
    radius, length = own["radius"].max(), (own["length"] * own["segments"]).sum()
    viscosity = (own["viscosity"] * own["segments"]).sum() * min(1.0, 2.0 * np.pi * radius / length)
    return OF_DRAG * float(viscosity * radius**2 * ease_of_turning(points[number], bodies))


def ease_of_turning(point: Any, bodies: Any) -> float:
    """Inverse moment of inertia about z of the body that a point is on [1/(kg m^2)]; 0: it does not turn."""
    if point["kind"] != ON_BODY or not bodies[point["body"]]["rotations"]:
        return 0.0
    return float(bodies[point["body"]]["inverse"][ABOUT_Z, ABOUT_Z])


def _rates(records: Any) -> tuple[Any, Any]:
    """See `contact_rates`; and which bounce, with less than the critical damping."""
    frequencies = np.sqrt(records["stiffness"] / records["mass"])
    ratios = 0.5 * records["damping"] / np.maximum(frequencies * records["mass"], SMALLEST)
    beyond = np.sqrt(np.maximum(ratios**2 - 1.0, 0.0))
    return frequencies / (np.maximum(ratios, 1.0) + beyond), ratios < 1.0


def _rubs(records: Any) -> Any:
    return records["friction"] * (records["viscosity"] + records["friction_stiffness"]) > 0.0


def _implicit(records: Any) -> Any:
    """Those with circles that are."""
    of_circles = records.dtype == CONTACT_WITH_CIRCLE
    return records[records["implicit"]] if of_circles else np.zeros(0, CONTACT_WITH_CIRCLE)


@protocol
def add_contact(system, element, mass, row):
    """mass b b^T beside the mass of an element of a chain.

    Args:
        system: of the chain.   element: its number; NOTHING: nothing touches the chain any more; AGAIN: nor
            does it, and the state that was evaluated last will be evaluated again.
        mass: [kg].   row: (8,) b, destroyed.
    """


CONTACT = called_by_address(add_contact, COUNT, REAL, VECTOR)


@optional("contact")
def _add_contact(axes, nodes, elements, element, mass, row):
    if element < 0:
        clear_contact_mass(axes, nodes, elements)
        if element == AGAIN:
            take_back(axes, nodes, elements)
    else:
        add_contact_row(nodes, elements[element], element, mass, row.reshape((1, 8)))


@implements(add_contact, CableSystem, LinkedCableSystem)
def add_contact_of_cable(system, element, mass, row):
    _add_contact(system.chain.axes, system.chain.nodes, system.chain.elements, element, mass, row)


@protocol
def press(contacts, again):
    """Set the masses of contact beside those of the cables, after `add_contacts`.

    again: 1 if the cables have been accelerated in this state before, by other contacts, in a step; or 0.
    """


@protocol
def complete_contacts(contacts, a, force):
    """Add to force (n,) what the accelerations a (n,) of the cables do to implicit contact."""


@protocol
def reconsider_contacts(contacts, a, force):
    """1 if other contacts act at the velocities to come, or 0; then force (n,) is theirs, and `press` is due.

    Circles have none: they act as long as they touch, whether they press or pull.

    a: (n,) accelerations of the cables, by those that act at present.
    """


of_parts(press, COUNT)
of_parts(complete_contacts, VECTOR, VECTOR)
RECONSIDERING = of_parts(reconsider_contacts, VECTOR, VECTOR)


@implements(press, Contacts)
def press_cables(contacts, again):
    cables = contacts.cables
    for k in range(len(cables.functions)):
        if provides(cables, k, CONTACT):
            _press_chain(one_chain(cables, k), contacts, cables.dofs[k], cables.dofs[k + 1])


@inlined
def _press_chain(chain, contacts, begin, end):
    """begin, end: coordinates of the chain."""
    row = local_array(1, 8)
    add_contact(chain, NOTHING, 0.0, row[0])
    for c in range(len(contacts.records)):
        contact = contacts.records[c]
        if contact.lag > 0.0 and begin <= contact.nodes[0] < end:
            _press_element(chain, (contact.nodes[0] - begin) // 4, contacts, contact, contact.first + c, row)


@inlined
def _press_element(chain, element, contacts, contact, end, row):
    """All segments of an element.   end: first of its ends.   row: (1, 8) memory."""
    for s in range(contact.segments):
        if contacts.data[NOW, contact.place + s] <= 0.0:
            segment = contacts.segments[contact.first + s]
            one, other, n = contacts.ends[end + s], contacts.ends[end + s + 1], segment.normal
            for axis in range(2):
                if segment.mass[axis] > 0.0:
                    x, y = (n[0], n[1]) if axis == 0 else (-n[1], n[0])
                    for i in range(8):
                        row[0, i] = 0.0
                    add_end(contact, one, (1.0 - segment.share) * x, (1.0 - segment.share) * y, row)
                    add_end(contact, other, segment.share * x, segment.share * y, row)
                    add_contact(chain, element, segment.mass[axis], row[0])


@implements(complete_contacts, Contacts)
def complete_circle_contacts(contacts, a, force):
    for c in range(len(contacts.records)):
        contact = contacts.records[c]
        if contact.lag > 0.0:
            first, number = contact.first, contact.segments
            segments, ends = contacts.segments[first : first + number], contacts.ends[first + c :]
            circle = contacts.points[contact.circle]
            pull_by_masses(contact, circle, ends[: number + 1], segments, contacts.data, a, force)
