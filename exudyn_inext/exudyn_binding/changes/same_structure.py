"""Whether runs can go on with a scene that has been read again, by other numbers alone."""

from dataclasses import fields
from typing import Any

import numpy as np

from ...cable.cable import Cable
from ...cable.link import Link
from ...scene.model import CableInScene, Scene

_OF_SUPPORTS = {"fixed", "links"}


def same_structure(one: Scene, other: Scene) -> bool:
    """Whether cables, their supports and links, and what is around them are of the same structure."""
    return same_cables(one, other) and sorted(one.foreign) == sorted(other.foreign)


def same_cables(one: Scene, other: Scene) -> bool:
    """Whether cables, their supports and links are of the same structure."""
    return one.own_constraints == other.own_constraints and all(map(_same_cable, one.cables, other.cables))


def _same_cable(one: CableInScene, other: CableInScene) -> bool:
    x, y = one.cable, other.cable
    if any(getattr(x, f.name) is not getattr(y, f.name) for f in fields(Cable) if f.name not in _OF_SUPPORTS):
        return False
    same_number = len(x.links) == len(y.links)
    return np.array_equal(x.fixed, y.fixed) and same_number and all(map(_same_link, x.links, y.links))


def _same_link(one: Link, other: Link) -> bool:
    anchors = one.anchor is other.anchor or (one.anchor.rests and other.anchor.rests)
    return anchors and all(
        _equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(Link) if f.name != "anchor"
    )


def _equal(x: Any, y: Any) -> bool:
    return x is y or bool(np.array_equal(x, y))
