"""What contacts of cables with circles would do if all of them closed: nobody feels them while they are open.

Springs and dashpots between the middle of each open segment and the circle: those of contact across the
cable, those of friction along it, as on a cable that lies on the circle. The ends of a segment meet the
circle at an angle, by which each acts a little in the other direction, too. A circle feels at most one turn
of the cable at once. Of implicit ones, see `multibody.implicit_contacts`, the pressure counts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
import scipy

from ..arrays import Array
from ..element.shape_functions import first_derivatives, shape_functions
from ..errors import SceneError
from ..scene.open_contacts import OpenContacts
from .coordinates import CoordinateMap
from .native_items import state_kept

STIFFNESSES = ("contactStiffness", "frictionStiffness")  # across and along the cable
DAMPINGS = ("contactDamping", "frictionVelocityPenalty")
WITH_CIRCLES = {"ContactFrictionCircleCable2D", "ContactCircleCable2D"}
_WITH_FRAME = {"BodyRigid", "NodeRigid"}


@dataclass(frozen=True, eq=False)
class _OpenContact:
    """An object with segments that do not touch, or that is implicit.

    number: of the object.   data: of it.   element: (8,) system coordinates of its cable.
    segments: number of those that count.   length: of them together [m].   rate: see `OpenContacts`.
    middles, slopes: (segments, 4) shape functions and their derivatives [1/m] in the middle of each.
    """

    number: int
    data: dict[str, Any]
    element: np.ndarray
    segments: int
    length: float
    rate: float
    middles: Array
    slopes: Array

    @property
    def marker(self) -> int:
        """On the circle."""
        return int(self.data["markerNumbers"][0])

    @property
    def radius(self) -> float:
        return float(self.data["circleRadius"])

    def strengths(self, names: Sequence[str]) -> tuple[float, float]:
        """Of a segment across and along the cable, of the parameters of these names."""
        across, along = (float(self.data.get(name, 0.0)) for name in names)
        angle = min(0.5 * self.length / self.segments / max(self.radius, 1e-300), 1.0)
        return across + angle**2 * along, along + angle**2 * across

    def __str__(self) -> str:
        return _named(self.number, self.data)


def _named(number: int, data: Mapping[str, Any]) -> str:
    names = [name for name in (*STIFFNESSES, *DAMPINGS) if data.get(name)]
    given = ", ".join(f"{name} = {data[name]:g}" for name in names)
    return f"object {number} '{data['name']}' ({data['objectType']}: {given})"


def open_contacts(
    mbs: Any, coordinates: CoordinateMap, size: int, implicit: Mapping[int, float]
) -> OpenContacts | None:
    """Contacts of cables with circles that do not act in the current state of mbs; None: there is none.

    Args:
        mbs: assembled.   coordinates: of the coupled parts.   size: number of coordinates of all parts.
        implicit: see `SceneOfExudyn.open_contacts`.
    """
    data = mbs.systemData
    gaps = np.array(data.GetDataCoordinates())
    numbers = range(data.NumberOfObjects() if len(gaps) else 0)
    contacts = [_read(mbs, number, gaps, implicit) for number in numbers]
    found = [contact for contact in contacts if contact is not None]
    if not found:
        return None
    springs = _springs(mbs, [contact for contact in found if not contact.rate], coordinates, size)
    rate = max(contact.rate for contact in found)
    return OpenContacts(*springs, rate, _name(found), STIFFNESSES, DAMPINGS)


def has_circles(mbs: Any) -> bool:
    """Whether there are circles that may touch cables, now or after they have been switched on."""
    remembers = len(mbs.systemData.GetDataCoordinates()) > 0
    numbers = range(mbs.systemData.NumberOfObjects() if remembers else 0)
    return any(mbs.GetObject(number)["objectType"] in WITH_CIRCLES for number in numbers)


def _springs(
    mbs: Any, contacts: Sequence[_OpenContact], coordinates: CoordinateMap, size: int
) -> tuple[Any, Array, Array]:
    """Motions, stiffness and damping of all segments of these contacts, see `OpenContacts`."""
    if not contacts:
        return scipy.sparse.csr_array((0, size)), np.zeros(0), np.zeros(0)
    q = np.add(
        mbs.systemData.GetODE2Coordinates(),
        mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Reference),
    )
    lengths: dict[int, float] = {}
    for contact in contacts:
        lengths[contact.marker] = lengths.get(contact.marker, 0.0) + contact.length
    circles = {marker: _Circle(mbs, marker) for marker in lengths}
    blocks = []
    for contact in contacts:
        turn = 2.0 * np.pi * contact.radius
        share = float(np.sqrt(min(1.0, turn / lengths[contact.marker])))
        blocks.append(_motion(q, contact, circles[contact.marker], share, coordinates))
    stiffness, damping = (
        np.concatenate([np.tile(contact.strengths(names), contact.segments) for contact in contacts])
        for names in (STIFFNESSES, DAMPINGS)
    )
    return _below_each_other(blocks, size), stiffness, damping


def _require_finite(number: int, data: Mapping[str, Any]) -> None:
    """Raise SceneError unless springs and dashpots are numbers."""
    if not np.isfinite([data.get(name, 0.0) for name in (*STIFFNESSES, *DAMPINGS)]).all():
        raise SceneError(
            f"{_named(number, data)} has a stiffness or a damping that is not finite, so that no step is "
            "known to be stable: give finite numbers."
        )


def _read(mbs: Any, number: int, gaps: Array, implicit: Mapping[int, float]) -> _OpenContact | None:
    """The contact that this object is, or None if it is none that counts.

    gaps: data coordinates of mbs.   Other arguments: see `open_contacts`.
    """
    data = mbs.GetObject(number)
    if data["objectType"] not in WITH_CIRCLES or not data["activeConnector"]:
        return None
    cable = mbs.GetMarker(data["markerNumbers"][1])["bodyNumber"]
    body = mbs.GetObject(cable)
    if body["objectType"] != "ANCFCable2D":
        return None
    _require_finite(number, data)
    segments, length = int(data["numberOfContactSegments"]), float(body["length"])
    places = mbs.systemData.GetObjectLTGData(number)[:segments]
    rate = implicit.get(int(places[0]))
    counts = gaps[places] > 0.0 if rate is None else np.full(segments, rate > 0.0)
    xi = (np.flatnonzero(counts) + 0.5) / segments
    if not len(xi):
        return None
    element = np.array(mbs.systemData.GetObjectLTGODE2(cable), dtype=int)
    middles, slopes = shape_functions(xi, length).T, first_derivatives(xi, length).T
    of_all = length * len(xi) / segments
    return _OpenContact(number, data, element, len(xi), of_all, rate or 0.0, middles, slopes)


class _Circle:
    """The body that a marker lies on.

    centre: (2,) [m].   rates: (k, 3) velocity of the marker [m/s] and angular velocity [1/s] in the plane
    for a unit velocity of each coordinate of the body; none about a point, where nothing rubs.
    """

    def __init__(self, mbs: Any, marker: int) -> None:
        what = exudyn.OutputVariableType
        self.centre = np.array(mbs.GetMarkerOutput(marker, what.Position))[:2]
        data = mbs.GetMarker(marker)
        turns = data["markerType"] in _WITH_FRAME
        body = data.get("bodyNumber")
        system = mbs.systemData
        columns = system.GetNodeLTGODE2(data["nodeNumber"]) if body is None else system.GetObjectLTGODE2(body)
        rates = []
        with state_kept(mbs):
            for column in columns:
                unit = np.zeros(system.ODE2Size())
                unit[column] = 1.0
                system.SetODE2Coordinates_t(unit.tolist())
                velocity = mbs.GetMarkerOutput(marker, what.Velocity)[:2]
                turning = mbs.GetMarkerOutput(marker, what.AngularVelocity)[2] if turns else 0.0
                rates.append([*velocity, turning])
        self.columns = np.array(columns, dtype=int)
        self.rates = np.reshape(rates, (-1, 3))


def _motion(
    q: Array, contact: _OpenContact, circle: _Circle, share: float, coordinates: CoordinateMap
) -> tuple[Array, np.ndarray]:
    """(2 segments, k) relative velocities of the segments' middles and the circle, and the k coordinates.

    Of each segment across and along the cable.   q: of the system.   share: of the circle's velocity that
    counts [-].
    """
    nodal = q[contact.element].reshape(4, 2)
    axes = _across_and_along(contact.slopes @ nodal)
    away = contact.middles @ nodal - circle.centre
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
    around = contact.radius * np.stack([-away[:, 1], away[:, 0]], axis=1)
    of_cable = np.einsum("sf,sai->safi", contact.middles, axes)
    turning = np.einsum("si,k->sik", around, circle.rates[:, 2])
    of_circle = np.einsum("sik,sai->sak", circle.rates[:, :2].T + turning, axes)
    count = 2 * contact.segments
    block = np.hstack([of_cable.reshape(count, -1), -share * of_circle.reshape(count, -1)])
    places = coordinates.all_places([*contact.element, *circle.columns])
    return block[:, places >= 0], places[places >= 0]  # others are held


def _below_each_other(blocks: Sequence[tuple[Array, np.ndarray]], size: int) -> Any:
    """(m, size) rows of blocks that have these columns, sparse."""
    ends = np.cumsum([len(block) for block, _ in blocks])
    rows = [
        np.repeat(np.arange(end - len(b), end), b.shape[1]) for end, (b, _) in zip(ends, blocks, strict=True)
    ]
    columns = np.concatenate([np.tile(places, len(block)) for block, places in blocks])
    values = np.concatenate([block.ravel() for block, _ in blocks])
    return scipy.sparse.csr_array((values, (np.concatenate(rows), columns)), shape=(int(ends[-1]), size))


def _across_and_along(tangents: Array) -> Array:
    """(s, 2, 2) unit normals and tangents.   tangents: (s, 2)."""
    along = tangents / np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-12)
    return np.stack([np.stack([-along[:, 1], along[:, 0]], axis=1), along], axis=1)


def _name(found: Sequence[_OpenContact]) -> str:
    """The strongest one, and how many there are besides."""
    strongest = max(found, key=lambda contact: contact.strengths(STIFFNESSES))
    others = f" and {len(found) - 1} more like it" if len(found) > 1 else ""
    return f"{strongest}{others}"
