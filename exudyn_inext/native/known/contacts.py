"""Contact of cables with circles as records."""

from collections.abc import Sequence
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...element.shape_functions import first_derivatives, shape_functions
from ...items.arguments import described
from ...multibody.circle_contacts import CONTACT, END, SEGMENT, Contacts, NoContacts
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


class ContactReader:
    """Makes records of contacts, one after the other.

    Args:
        mbs: assembled.   reader: of markers.   checked: numbers of the objects whose friction is looked at.
    """

    def __init__(self, mbs: Any, reader: PointReader, checked: Sequence[int]) -> None:
        self._mbs = mbs
        self._reader = reader
        self._row_of = {number: row for row, number in enumerate(checked)}
        self._segments = 0
        self._records: list[Any] = []
        self._weights: list[Array] = []

    def adds(self, number: int) -> bool:
        """Whether the object is a contact that acts; UnknownItemError if that has no compiled form."""
        data = self._mbs.GetObject(number)
        if data["objectType"] not in WITH_CIRCLES or not data["activeConnector"]:
            return False
        self._add(data, number)
        return True

    def _add(self, data: dict[str, Any], number: int) -> None:
        name, record = described(data, number), np.zeros(1, CONTACT)[0]
        circle, shape = data["markerNumbers"]
        marker, place = self._mbs.GetMarker(shape), self._reader.marker(circle)
        record.has_friction = "Friction" in data["objectType"]
        if record.has_friction and not (place.has_frame and np.array_equal(place.turn, np.eye(3))):
            raise UnknownItemError(f"{name}, whose circle has no frame of its own")
        record.circle = place.point
        record.nodes[:] = self._reader.nodes_of_element(marker["bodyNumber"])
        record.segments = segments = int(data["numberOfContactSegments"])
        record.first = self._segments
        self._segments += segments
        record.place = self._mbs.systemData.GetObjectLTGData(number)[0]
        record.pointwise = not data.get("useSegmentNormals", True)
        record.checked = self._row_of.get(number, -1)
        for field, parameter in _NAMES.items():
            setattr(record, field, data.get(parameter, 0.0))
        length = float(self._mbs.GetObject(marker["bodyNumber"])["length"])
        record.length, record.height = length / segments, marker["verticalOffset"]
        self._records.append(record)
        xi = np.linspace(0.0, 1.0, segments + 1)
        self._weights.append(np.stack([shape_functions(xi, length), first_derivatives(xi, length)]).T)

    def contacts(self, sums: Array) -> Any:
        """All of them, as they are at the start of a run.   sums: (checked, 4) memory, see `Contacts`."""
        if not self._records:
            return NoContacts()
        ends = np.zeros(sum(map(len, self._weights)), END)
        ends["weights"] = np.concatenate(self._weights).transpose(0, 2, 1)
        segments = np.zeros(self._segments, SEGMENT)
        data = np.array([self._mbs.systemData.GetDataCoordinates(exudyn.ConfigurationType.Initial)] * 2)
        records = np.array(self._records, CONTACT)
        return Contacts(records, ends, segments, data, data[:1].copy(), sums, np.zeros(1, np.int64))


def disturb(contacts: Any, random: np.random.Generator) -> None:
    """Let data be those of random contacts, each with a segment that touches, wherever it is."""
    for record in contacts.records:
        gaps = slice(record.place, record.place + record.segments)
        contacts.data[:, gaps] = random.uniform(-1.0, 0.5, record.segments)
        contacts.data[:, record.place] = -1.0
        if record.has_friction:
            states, places = (
                slice(gaps.stop + k * record.segments, gaps.stop + (k + 1) * record.segments) for k in (0, 1)
            )
            contacts.data[:, states] = random.integers(-2, 2, record.segments)
            contacts.data[:, places] = record.radius * random.uniform(-1.0, 1.0, record.segments)
