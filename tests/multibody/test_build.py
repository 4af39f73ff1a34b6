"""Parts of scenes that are called by address: without records nothing is, and copies are of one scene."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from exudyn_inext.called_system import behind, called_part
from exudyn_inext.multibody.build import copied
from exudyn_inext.multibody.circle_contacts import add_contacts

from .test_circle_contacts import PUSH, along, on_top

pytestmark = pytest.mark.kernel


class Scene(NamedTuple):
    contacts: Any
    points: np.ndarray
    data: np.ndarray


def push_of(contacts, q):
    """On the cable [N]."""
    force = np.zeros(8)
    add_contacts(contacts, q, along(0.0), along(0.0), 1, force)
    return force[1::4].sum()


def test_a_part_without_records_does_nothing():
    contacts, q = on_top()
    nothing = contacts._replace(records=contacts.records[:0])
    assert push_of(called_part(contacts, add_contacts), q) == pytest.approx(PUSH)
    assert push_of(called_part(nothing, add_contacts), q) == 0.0


def test_a_copied_part_shares_the_copies_of_its_scene():
    contacts, q = on_top()
    scene = Scene(called_part(contacts, add_contacts), contacts.points, contacts.data)
    other = copied(scene, {})
    other.points["x"][:, 0, 1] -= 1.0  # the circle goes down
    assert push_of(other.contacts, q) == 0.0 and other.data[0, 0] > 0.9
    assert push_of(scene.contacts, q) == pytest.approx(PUSH) and scene.data[0, 0] < 0.0
    assert behind(other.contacts).points is other.points


def test_what_takes_the_place_of_an_array_is_no_copy():
    contacts, q = on_top()
    scene = Scene(called_part(contacts, add_contacts), contacts.points, contacts.data)
    shared = copied(scene, {id(contacts.points): contacts.points})
    contacts.points["x"][:, 0, 1] -= 1.0
    assert push_of(shared.contacts, q) == 0.0
