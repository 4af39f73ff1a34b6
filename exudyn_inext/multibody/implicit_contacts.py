"""Damping of contact that is implicit in the accelerations of the cable.

Along n and t of a segment that touches, with the damping d and B x its motion by the cable's coordinates,

    (M + W B^T B) a = F - B^T (f - W B a_before),   W = (1/2 + 1/16) h d,

f being the force at the velocities that a_before predicts. The segment feels f + W B (a - a_before), and so
does the circle. Of W, h d / 2 is the trapezoidal rule, of order 2; that alone would let velocities that steps
do not resolve change their sign each time. The rest is of order 2, too, and takes two thirds off them each
time, most that it can: with z = h d / m and w = W / m, steps of a mass are

    (1 + w) x_(n+1) = (1 + 2 w - 3/2 z) x_n - (w - z/2) x_(n-1),  z -> infinity: x_n ~ (-1/3)^n.

What slides has d = |f_t| / |v_t| along t, at most its viscosity. The circle's own motion is not in W: its
part of the damping remains explicit, and bounds the step.
"""

from functools import singledispatch
from typing import Any

from ..cable.contact_mass import add_contact_row, clear_contact_mass
from ..cable.index_reduction import CableSystem
from ..cable.linked_cable import LinkedCableSystem
from ..compiled import dispatched, inlined, optional
from ..lowered import local_array
from ..system import implements
from .cables import Alike, NoCables, TwoKinds, each_chain
from .circle_contacts import NOW, Contacts, NoContacts, add_end, pull_by_masses

SHARE = 0.5 + 0.0625  # of h d


def mark_implicit(cables: Any, records: Any) -> None:
    """Set which contacts have damping that may be implicit: those of planar cables that stretch.

    Args:
        cables: system of all.   records: of the contacts, in place.
    """
    for offset, _, system in each_chain(cables):
        of_these = records["nodes"][:, 0] >= offset
        records["implicit"][of_these] = system.chain.elements["contact"].size > 0


@dispatched
@singledispatch
def press(contacts, cables):
    """Set the masses of contact beside those of the cables, after `add_contacts`.

    Raises:
        NotImplementedError: no such contacts.
    """
    raise NotImplementedError(f"no contacts of type {type(contacts).__name__}")


@dispatched
@singledispatch
def _press_cables(cables, contacts, offset):
    """offset: first coordinate of the cables."""
    raise NotImplementedError(f"no contact with cables of type {type(cables).__name__}")


@dispatched
@singledispatch
def complete_contacts(contacts, points, a, force):
    """Add to force (n,) what the accelerations a (n,) of the cables do to implicit contact.

    Raises:
        NotImplementedError: no such contacts.
    """
    raise NotImplementedError(f"no contacts of type {type(contacts).__name__}")


@implements(press, NoContacts)
def press_nothing(contacts, cables):
    """Nothing touches."""


@implements(complete_contacts, NoContacts)
def complete_no_contacts(contacts, points, a, force):
    """There are no forces."""


@implements(press, Contacts)
def press_cables(contacts, cables):
    """Arguments: see `press`."""
    _press_cables(cables, contacts, 0)


@implements(_press_cables, NoCables)
def press_no_cables(cables, contacts, offset):
    """There are none."""


@implements(_press_cables, CableSystem)
def press_chain(cables, contacts, offset):
    """Arguments: see `_press_cables`."""
    _press(cables.chain.axes, cables.chain.nodes, cables.chain.elements, contacts, offset)


@implements(_press_cables, LinkedCableSystem)
def press_linked_chain(cables, contacts, offset):
    """Arguments: see `_press_cables`."""
    _press(cables.chain.axes, cables.chain.nodes, cables.chain.elements, contacts, offset)


@implements(_press_cables, TwoKinds)
def press_two_kinds(cables, contacts, offset):
    """Arguments: see `_press_cables`."""
    _press_cables(cables.first, contacts, offset)
    _press_cables(cables.second, contacts, offset + cables.dofs)


@implements(_press_cables, Alike)
def press_alike(cables, contacts, offset):
    """Arguments: see `_press_cables`."""
    for k in range(len(cables.systems)):
        _press_cables(cables.systems[k], contacts, offset + cables.dofs[k])


@optional("contact")
def _press(axes, nodes, elements, contacts, offset):
    clear_contact_mass(axes, nodes, elements)
    for c in range(len(contacts.records)):
        contact = contacts.records[c]
        place = contact.nodes[0] - offset
        if contact.lag > 0.0 and 0 <= place < 4 * len(elements):
            _press_element(nodes, elements[place // 4], place // 4, contacts, contact, contact.first + c)


@inlined
def _press_element(nodes, element, k, contacts, contact, end):
    """All segments of element k.   end: first of its ends."""
    row = local_array(1, 8)
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
                    add_contact_row(nodes, element, k, segment.mass[axis], row)


@implements(complete_contacts, Contacts)
def complete_circle_contacts(contacts, points, a, force):
    """Arguments: see `complete_contacts`."""
    for c in range(len(contacts.records)):
        contact = contacts.records[c]
        if contact.lag > 0.0:
            first, number = contact.first, contact.segments
            segments, ends = contacts.segments[first : first + number], contacts.ends[first + c :]
            circle = points[contact.circle]
            pull_by_masses(contact, circle, ends[: number + 1], segments, contacts.data, a, force)
