"""Contact of cables with circles as records."""

from collections.abc import Sequence
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...cable.cable import Section
from ...element.shape_functions import first_derivatives, shape_functions
from ...items.arguments import described
from ...multibody.circle_contacts import CONTACT, END, SEGMENT, Contacts
from ...multibody.connectors import RUBBING
from ...multibody.rubbing_springs import DATA
from ..contact_rates import WITH_CIRCLES
from .points import PointReader
from .unknown import UnknownItemError

_NAMES = {
    "radius": "circleRadius",
    "offset": "offset",
    "stiffness": "contactStiffness",
    "damping": "contactDamping",
    "friction": "frictionCoefficient",
    "friction_stiffness": "frictionStiffness",
    "viscosity": "frictionVelocityPenalty",
}
TURNED = 20.0  # angle of springs at random, at most [rad]


class ContactReader:
    """Makes records of contacts, one after the other.

    Args:
        mbs: assembled.   reader: of markers.   checked: numbers of the objects whose friction is looked at.
        sections: of the cables, by the end of their coordinates.
    """

    def __init__(
        self, mbs: Any, reader: PointReader, checked: Sequence[int], sections: Sequence[tuple[int, Section]]
    ) -> None:
        self._mbs = mbs
        self._reader = reader
        self._sections = sections
        self._row_of = {number: row for row, number in enumerate(checked)}
        self._segments = 0
        self._records: list[dict[str, Any]] = []
        self._weights: list[Array] = []
        self._weights_of: dict[tuple[int, float], Array] = {}  # of so many segments, of an element so long

    def adds(self, number: int) -> bool:
        """Whether the object is a contact that acts; UnknownItemError if that has no compiled form."""
        data = self._mbs.GetObject(number)
        if data["objectType"] not in WITH_CIRCLES or not data["activeConnector"]:
            return False
        self._add(data, number)
        return True

    def _add(self, data: dict[str, Any], number: int) -> None:
        circle, shape = data["markerNumbers"]
        marker, place = self._mbs.GetMarker(shape), self._reader.marker(circle)
        has_friction = "Friction" in data["objectType"]
        if has_friction and not (place.has_frame and np.array_equal(place.turn, np.eye(3))):
            raise UnknownItemError(f"{described(data, number)}, whose circle has no frame of its own")
        segments = int(data["numberOfContactSegments"])
        length = float(self._mbs.GetObject(marker["bodyNumber"])["length"])
        nodes = self._reader.nodes_of_element(marker["bodyNumber"])
        section = next(section for end, section in self._sections if nodes[0] < end)
        fields = {
            "circle": place.point,
            "nodes": nodes,
            "mass": section.mass_per_length * length / segments,
            "segments": segments,
            "first": self._segments,
            "place": self._mbs.systemData.GetObjectLTGData(number)[0],
            "has_friction": has_friction,
            "pointwise": not data.get("useSegmentNormals", True),
            "checked": self._row_of.get(number, -1),
            "length": length / segments,
            "height": marker["verticalOffset"],
        }
        parameters = {field: data.get(parameter, 0.0) for field, parameter in _NAMES.items()}
        self._records.append(fields | parameters)
        self._segments += segments
        if (segments, length) not in self._weights_of:
            self._weights_of[segments, length] = _weights(segments, length)
        self._weights.append(self._weights_of[segments, length])

    def data(self, others: bool) -> Array:
        """(2, D) see `Items`, at the start of a run.   others: whether connectors have some."""
        if not (self._records or others):
            return np.zeros((2, 0))
        return np.array([self._mbs.systemData.GetDataCoordinates(exudyn.ConfigurationType.Initial)] * 2)

    def contacts(self, sums: Array, data: Array) -> Contacts:
        """All of them.   sums: (checked, 4) memory, data: see `Contacts`."""
        ends = np.zeros(sum(map(len, self._weights)), END)
        if self._records:
            ends["weights"] = np.concatenate(self._weights).transpose(0, 2, 1)
        segments = np.zeros(self._segments, SEGMENT)
        records = np.zeros(len(self._records), CONTACT)
        for field in self._records[0] if self._records else ():
            records[field] = [one[field] for one in self._records]
        return Contacts(records, ends, segments, data, sums)


def _weights(segments: int, length: float) -> Array:
    """(segments + 1, 4, 2) shape functions and their derivatives at the ends of the segments."""
    xi = np.linspace(0.0, 1.0, segments + 1)
    return np.stack([shape_functions(xi, length), first_derivatives(xi, length)]).T


def disturb(data: Array, records: Any, connectors: Any, random: np.random.Generator) -> None:
    """Let data be those of random contacts, each with a segment that touches, wherever it is, and turns.

    Springs that rub stick or slide, at random; stops act or do not.

    data: see `Items`.   records: of contacts.
    """
    for spring in connectors[connectors["place"] >= 0]:
        place = spring["place"]
        if spring["kind"] == RUBBING:
            sticks = float(spring["sticking_stiffness"] > 0.0)  # or slides; otherwise it does neither
            below, above = np.isfinite(spring["stops"]).astype(float)  # infinite stops never act
            least, most = [-sticks, -sticks, -below], [sticks, sticks, above]
            data[:, place : place + DATA] = random.integers(-1, 2, DATA).clip(least, most)
        else:
            data[:, place] = random.uniform(-TURNED, TURNED)
    names = ("place", "segments", "has_friction", "radius")
    for place, segments, has_friction, radius in zip(
        *(records[name].tolist() for name in names), strict=True
    ):
        gaps, states, places = (slice(place + k * segments, place + (k + 1) * segments) for k in range(3))
        data[:, gaps] = random.uniform(-1.0, 0.5, segments)
        data[:, place] = -1.0
        if has_friction:
            data[:, states] = random.integers(-2, 2, segments)
            data[:, places] = radius * random.uniform(-1.0, 1.0, segments)
