"""Circles that lie between two states of cables in contact with them."""

from collections.abc import Iterator
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..element.shape_functions import shape_functions
from .contact_rates import WITH_CIRCLES

SHARE = 0.5  # of its radius: how far from the middle of a circle a segment stays in one step
MOST_STRIDES = 1000  # of one step, each shorter than that


class CirclesInTheWay:
    """Of all contacts that are active; `mbs` is brought to a state before it is looked at.

    Args:
        mbs: assembled system.
    """

    def __init__(self, mbs: Any) -> None:
        self._mbs, self._markers = mbs, []
        weights, elements, segments, radii = [np.zeros((0, 4))], [np.zeros((0, 8), int)], [0], []
        for circle, element, number, radius in _pairs(mbs):
            ends = np.linspace(0.0, 1.0, number + 1)
            weights.append(shape_functions(ends, float(mbs.GetObject(element)["length"])).T)
            elements.append(np.tile(mbs.systemData.GetObjectLTGODE2(element), (len(ends), 1)))
            segments.append(len(ends))
            radii += [radius] * number
            self._markers.append(circle)
        self._weights, self._elements = np.concatenate(weights), np.concatenate(elements).reshape(-1, 4, 2)
        self._contact_of_end = np.repeat(np.arange(len(self._markers)), segments[1:])
        self._first = np.flatnonzero(np.diff(self._contact_of_end) == 0)  # end of each segment
        self._radii = np.array(radii)

    def __len__(self) -> int:
        return len(self._radii)

    def present(self) -> Array:
        """(ends, 2) of all segments, from the middles of their circles [m]."""
        data, kind = self._mbs.systemData, exudyn.OutputVariableType.Position
        places = np.array([self._mbs.GetMarkerOutput(marker, kind)[:2] for marker in self._markers])
        q = np.add(data.GetODE2Coordinates(), data.GetODE2Coordinates(exudyn.ConfigurationType.Reference))
        ends: Array = np.einsum("ef,efi->ei", self._weights, q[self._elements])
        return ends - places[self._contact_of_end]

    def are_between(self, before: Array, after: Array) -> bool:
        """Whether a segment would pass the middle of its circle, or nearly so, or goes very far.

        Arguments: see `present`.
        """
        allowed = SHARE * np.minimum(self._distances(before), self._radii)
        furthest = float(np.linalg.norm(after - before, axis=1).max())
        strides = 1 + int(min(furthest / (SHARE * self._radii.min()), MOST_STRIDES))
        if strides > MOST_STRIDES:
            return True
        ways = (before + share * (after - before) for share in np.linspace(0.0, 1.0, strides + 1)[1:])
        return any((self._distances(way) < allowed).any() for way in ways)

    def _distances(self, ends: Array) -> Array:
        """(segments,) of their nearest points from the middles of the circles [m]."""
        start, along = ends[self._first], ends[self._first + 1] - ends[self._first]
        squares = np.maximum((along**2).sum(axis=1), 1e-300)
        nearest = np.clip(-(start * along).sum(axis=1) / squares, 0.0, 1.0)
        return np.linalg.norm(start + nearest[:, np.newaxis] * along, axis=1)


def _pairs(mbs: Any) -> Iterator[tuple[int, int, int, float]]:
    """Marker of a circle, an element that may touch it, segments of that element, and the radius [m].

    Of a GeneralContact only where it has all planar elements: Exudyn does not say which ones it has.
    """
    elements = []
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        if data["objectType"] == "ANCFCable2D":
            elements.append(number)
        if data["objectType"] in WITH_CIRCLES and data["activeConnector"]:
            circle, shape = data["markerNumbers"]
            element, segments = mbs.GetMarker(shape)["bodyNumber"], data["numberOfContactSegments"]
            yield int(circle), int(element), int(segments), float(data["circleRadius"])
    for number in range(mbs.NumberOfGeneralContacts()):
        contact = mbs.GetGeneralContact(number)
        sizes = contact.GetPythonObject()
        if sizes["numberOfANCFCable2D"] != len(elements):
            continue
        for k in range(sizes["numberOfSpheresMarkerBased"]):
            sphere = contact.GetSphereMarkerBased(k, addData=True)
            for element in elements:
                segments = contact.ancfCableNumberOfContactSegments
                yield int(sphere["markerIndex"]), element, int(segments), float(sphere["radius"])
