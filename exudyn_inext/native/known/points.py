"""Markers as points: of the ground, of bodies, of cables."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, collected, copies_of
from ...element.shape_functions import first_derivatives, shape_functions
from ...items.arguments import described
from ...items.attach.inert import is_inert_cable
from ...items.mass_points import node_of_mass_point
from ...multibody.points import (
    ANGLE,
    COORDINATE,
    FIXED,
    FRAME_OF_CABLE,
    ON_BODY,
    ON_CABLE,
    ON_LINK,
    POINT,
)
from ..coordinates import CoordinateMap
from .unknown import UnknownItemError


class Place(NamedTuple):
    """A marker.   point: its number.   turn: (3, 3) its frame in that of the point.

    has_frame: whether it has an orientation.
    """

    point: int
    turn: Array
    has_frame: bool = False


_WITH_DATA = {"ConnectorTorsionalSpringDamper", "ConnectorCoordinateSpringDamperExt"}
_ALONG = np.eye(3)
_POINT = np.zeros(1, POINT)[0]
_POINT["orientation"] = _ALONG
_new_point = copies_of(_POINT)


class PointReader:
    """Makes one record for each marker that is asked for.

    Args:
        mbs: assembled.   coordinates: of the scene.   on_cables: how many lie on cables, the first ones.
        bodies: records.   of_bodies: number of the record by that of the object.
        links: records of those of trees.   of_trees: as of_bodies.
    """

    def __init__(
        self,
        mbs: Any,
        coordinates: CoordinateMap,
        on_cables: int,
        bodies: Any,
        of_bodies: dict[int, int],
        links: Any,
        of_trees: dict[int, int],
    ) -> None:
        self._mbs = mbs
        self._coordinates = coordinates
        self._on_cables = on_cables
        self.bodies = bodies
        self._links, self._of_trees = links, of_trees
        self._of_bodies = of_bodies
        self._of_nodes = {int(body["first"]): number for number, body in enumerate(bodies)}
        self._points: list[Any] = []
        self._known: dict[int, Place] = {}
        self._centres: dict[int, list[int]] = {}  # points at the centre of mass of a body
        self._nodes: dict[int, tuple[list[int], dict[str, Any]]] = {}

    @property
    def records(self) -> Any:
        """(P,)"""
        return collected(POINT, self._points)

    @property
    def number_of_points(self) -> int:
        return len(self._points)

    def marker(self, number: int) -> Place:
        """The place of a marker; UnknownItemError if it has no compiled form."""
        key = int(number)
        if key not in self._known:
            self._known[key] = self._read(key)
        return self._known[key]

    def _read(self, number: int) -> Place:
        data = self._mbs.GetMarker(number)
        kind = data["markerType"]
        if kind in ("BodyPosition", "BodyRigid"):
            turn = np.array(data["localHT"])[:3, :3] if "localHT" in data else _ALONG
            local = np.asarray(data["localPosition"], dtype=float)
            return self._on_object(int(data["bodyNumber"]), local, kind == "BodyRigid", turn)
        if kind in ("NodePosition", "NodeRigid"):
            return self.on_node(int(data["nodeNumber"]), kind == "NodeRigid")
        if kind == "NodeCoordinate":
            return self.coordinate(int(data["nodeNumber"]), int(data["coordinate"]))
        if kind == "NodeRotationCoordinate":
            return self.angle(int(data["nodeNumber"]), int(data["rotationCoordinate"]))
        if kind == "KinematicTreeRigid" and int(data["objectNumber"]) in self._of_trees:
            return self._on_link(data)
        if kind == "BodyMass":
            return self.centre_of_mass(int(data["bodyNumber"]))
        raise UnknownItemError(f"marker {number} '{data['name']}' ({kind})")

    def node_of_coordinates(self, number: int) -> int:
        """The node whose coordinates a marker gives; UnknownItemError of others."""
        data = self._mbs.GetMarker(number)
        if data["markerType"] != "NodeCoordinates":
            raise UnknownItemError(f"marker {number} '{data['name']}' ({data['markerType']})")
        return int(data["nodeNumber"])

    def _add(self, point: Any, turn: Array = _ALONG, has_frame: bool = False) -> Place:
        self._points.append(point)
        return Place(len(self._points) - 1, turn, has_frame)

    def fixed(self, position: Array, orientation: Array = _ALONG, has_frame: bool = True) -> Place:
        """A point of the ground."""
        point = _new(FIXED)
        point["x"][0], point["orientation"][:] = position, orientation
        return self._add(point, has_frame=has_frame)

    def place_of_data(self, data: dict[str, Any], number: int) -> int:
        """Of what springs with turns, friction or stops remember; -1: it has no node, nor have others.

        Raises:
            UnknownItemError: another object has a node of its own.
        """
        if int(data.get("nodeNumber", -1)) < 0:
            return -1
        if data["objectType"] not in _WITH_DATA:
            raise UnknownItemError(f"{described(data, number)} with a node of its own")
        return int(self._mbs.systemData.GetObjectLTGData(number)[0])

    def is_placeable(self, number: int) -> bool:
        """Whether `place_again` may be asked for a marker, or nothing depends on it."""
        known = self._known.get(number)
        return known is None or self._points[known.point]["kind"] in (FIXED, ON_BODY)

    def place_of(self, number: int) -> Place | None:
        """Of a marker; None if nothing depends on it."""
        return self._known.get(number)

    def place_again(self, number: int, memories: Sequence[Any]) -> None:
        """A marker on the ground or a body has another place.   memories: records that systems hold now."""
        if number not in self._known:
            return
        place, mbs = self._known[number].point, self._mbs
        marker = mbs.GetMarker(number)
        if self._points[place]["kind"] == ON_BODY:
            for points in memories:
                points["local"][place] = marker["localPosition"]
            return
        if marker["markerType"].startswith("Node"):
            x, rotation = mbs.GetNodeParameter(marker["nodeNumber"], "referenceCoordinates"), _ALONG
        else:
            position, rotation = (
                mbs.GetObjectParameter(marker["bodyNumber"], name)
                for name in ("referencePosition", "referenceRotation")
            )
            x = _place_on_ground(position, rotation, marker["localPosition"])
        for points in memories:
            points["x"][place, 0], points["orientation"][place] = x, rotation

    def _on_object(self, number: int, local: Array, has_frame: bool, turn: Array) -> Place:
        data = self._mbs.GetObject(number)
        if data["objectType"] == "Ground":
            orientation = np.asarray(data["referenceRotation"], dtype=float)
            x = _place_on_ground(data["referencePosition"], orientation, local)
            return self.fixed(x, orientation, has_frame)._replace(turn=turn)
        if number in self._of_bodies:
            return self.on_body(self._of_bodies[number], local, has_frame)._replace(turn=turn)
        if self.is_on_other_node(data):
            return self.on_node(node_of_mass_point(data), has_frame)
        if is_inert_cable(data) and not local[2]:
            return self._on_element(data, local, has_frame)._replace(turn=turn)
        raise UnknownItemError(f"a marker on {described(data, number)}")

    def on_body(self, body: int, local: Array, has_frame: bool = True) -> Place:
        """A point of a body.   body: number of its record.   local: (3,) in its frame.

        Raises:
            UnknownItemError: a mass point has no frame; where a point of a body of one coordinate, or of
                matrices, lies, its record does not say.
        """
        record = self.bodies[body]
        translations, rotations = int(record["translations"]), int(record["rotations"])
        if translations not in (2, 3):
            raise UnknownItemError(f"a marker on a body with {translations} coordinate(s)")
        if has_frame and not rotations:
            raise UnknownItemError("a marker with a frame on a mass point")
        point = _new(ON_BODY, int(record["first"]), translations + rotations)
        point["body"] = body
        point["local"][:] = local
        point["along"][:, :translations] = _ALONG[:, :translations]
        return self._add(point, has_frame=has_frame)

    def centre_of_link(self, tree: int, which: int) -> Place:
        """That of the mass of a link.   tree: number of the object."""
        number = int(np.flatnonzero(self._links["body"] == self._of_trees[tree])[which])
        point = _new(ON_LINK, int(self._links["first"][number]), int(self._links["width"][number]))
        point["body"] = number
        return self._add(point, has_frame=True)

    def _on_link(self, data: dict[str, Any]) -> Place:
        place = self.centre_of_link(int(data["objectNumber"]), int(data["linkNumber"]))
        point = self._points[place.point]
        point["local"] = data["localPosition"] - self._links["centre"][point["body"]]
        return place

    def centre_of_mass(self, number: int) -> Place:
        """That of a body, from its mass matrix, or of a mass point; UnknownItemError of other objects."""
        if number not in self._of_bodies:
            if self.is_on_other_node(data := self._mbs.GetObject(number)):
                return self.on_node(node_of_mass_point(data), has_frame=False)
            raise UnknownItemError(f"a marker on the mass of object {number}")
        place = self.on_body(self._of_bodies[number], _centre(self.bodies[self._of_bodies[number]]), False)
        self._centres.setdefault(number, []).append(place.point)
        return place

    def has_lever(self, number: int) -> bool:
        """Whether the centre of mass of a body was beside its node when it was read."""
        return bool(_centre(self.bodies[self._of_bodies[number]]).any())

    def centre_again(self, number: int, points: Any, body: Any) -> None:
        """A body has another mass.   points: records that a system holds now.   body: record of it there."""
        for point in self._centres.get(number, ()):
            points["local"][point] = _centre(body)

    def is_on_cable(self, number: int) -> bool:
        """Whether a marker lies on a companion of a cable."""
        marker = self._mbs.GetMarker(number)
        return "bodyNumber" in marker and is_inert_cable(self._mbs.GetObject(int(marker["bodyNumber"])))

    def mass(self, number: int) -> float:
        """Of a body or mass point [kg]."""
        if number not in self._of_bodies:
            return float(self._mbs.GetObjectParameter(number, "mass"))
        return float(self.bodies[self._of_bodies[number]].mass[0, 0])

    def _of_node(self, number: int) -> tuple[list[int], dict[str, Any]]:
        if number not in self._nodes:
            self._nodes[number] = self._mbs.systemData.GetNodeLTGODE2(number), self._mbs.GetNode(number)
        return self._nodes[number]

    def on_node(self, number: int, has_frame: bool) -> Place:
        """A point of a cable, or the body on a node, with a frame or without; UnknownItemError on others."""
        places, node = self._of_node(number)
        if not len(places):
            return self.fixed(np.asarray(node["referenceCoordinates"], dtype=float), has_frame=has_frame)
        first = self._coordinates.place(places[0])
        if first in self._of_nodes:
            return self.on_body(self._of_nodes[first], np.zeros(3), has_frame)
        if not 0 <= first < self._on_cables:
            raise UnknownItemError(f"a marker on node {number} '{node['name']}' ({node['nodeType']})")
        dim = len(places) // 2
        if not has_frame:
            return self._weighted(first, dim, [1.0])
        if dim == 3:
            raise UnknownItemError(f"a marker with a frame on node {number} '{node['name']}'")
        return self._frame(first, np.eye(4)[0, :2], np.eye(4)[1, :2])

    def is_on_other_node(self, data: dict[str, Any]) -> bool:
        """Whether an object is a mass point on a node of a cable or of the ground."""
        if (node := node_of_mass_point(data)) < 0:
            return False
        places, _ = self._of_node(node)
        return not len(places) or 0 <= self._coordinates.place(places[0]) < self._on_cables

    def slope(self, number: int) -> Place:
        """The slope of a cable's node; UnknownItemError on another one."""
        places, node = self._of_node(number)
        first = self._coordinates.place(places[0])
        if not 0 <= first < self._on_cables:
            raise UnknownItemError(f"the slope of node {number} '{node['name']}'")
        dim = len(places) // 2
        return self._weighted(first + dim, dim, [1.0])

    def nodes_of_element(self, number: int, dimension: int = 2) -> tuple[int, int]:
        """First coordinates of both nodes of a cable's companion; UnknownItemError if it is none."""
        data = self._mbs.GetObject(number)
        first, last, dim = self._span(data) if is_inert_cable(data) else (-1, -1, 0)
        if not (dim == dimension and 0 <= min(first, last) <= max(first, last) < self._on_cables):
            raise UnknownItemError(f"what touches, or slides along, {described(data, number)}")
        return first, last

    def on_chain(self, first: int, elements: int, dimension: int) -> Place:
        """A point that slides along elements of a cable, see `multibody.sliding`.

        It has all of their coordinates, the first one being `first`, until it is placed.
        """
        point = _new(ON_CABLE, first, 2 * dimension * (elements + 1))
        point["dimension"] = dimension
        return self._add(point, has_frame=True)

    def _span(self, data: dict[str, Any]) -> tuple[int, int, int]:
        """First coordinates of both nodes of an element, and its dimension."""
        (left, _), (right, _) = (self._of_node(int(node)) for node in data["nodeNumbers"])
        return self._coordinates.place(left[0]), self._coordinates.place(right[0]), len(left) // 2

    def _on_element(self, data: dict[str, Any], local: Array, has_frame: bool) -> Place:
        first, last, dim = self._span(data)
        if last != first + 2 * dim or not 0 <= first < self._on_cables:
            raise UnknownItemError(f"a marker on the last element of a closed cable ('{data['name']}')")
        length, x, off = float(data["length"]), float(local[0]), float(local[1])
        weights = shape_functions(x / length, length)
        if not (off or has_frame):
            return self._weighted(first, dim, weights.tolist())
        if dim == 3:
            raise UnknownItemError(f"a marker beside the axis of '{data['name']}'")
        return self._frame(first, weights, first_derivatives(x / length, length), off)

    def _frame(self, first: int, weights: Array, slope_weights: Array, off: float = 0.0) -> Place:
        """Of a planar cable, on its axis or beside it."""
        point = _new(FRAME_OF_CABLE, first, 2 * len(weights))
        point.dimension, point.local[1] = 2, off
        point.weights[: len(weights)], point.slope_weights[: len(weights)] = weights, slope_weights
        return self._add(point, has_frame=True)

    def _weighted(self, first: int, dim: int, weights: list[float]) -> Place:
        point = _points_on_axis(dim, *weights)()
        point["first"] = first
        return self._add(point)

    def coordinate(self, number: int, which: int) -> Place:
        """A coordinate of a node, without its reference value; UnknownItemError if it is held."""
        return self.combination(number, np.eye(1, which + 1, which)[0], has_reference=False)

    def combination(self, number: int, weights: Array, has_reference: bool = True) -> Place:
        """A weighted sum of the first coordinates of a node, with or without their reference values.

        Raises:
            UnknownItemError: one of them is held, or they belong to several bodies.
        """
        system, node = self._of_node(number)
        which = np.flatnonzero(weights)
        if not len(system) or not len(which):
            return self.fixed(np.zeros(3), has_frame=False)
        own = slice(which[0], which[-1] + 1)
        places = self._coordinates.all_places(system[own]).tolist()
        if min(places) < 0 or not self._are_together(places):
            raise UnknownItemError(
                f"coordinate {which[0]} of node {number} '{node['name']}', which is held, or in another body "
                "than the next ones"
            )
        point = _new(COORDINATE, places[0], len(places))
        reference = has_reference * np.asarray(node["referenceCoordinates"])[own]
        point["local"][0] = weights[own] @ (reference - self._coordinates.reference[places])
        point["along"][0, : len(places)] = weights[own]
        return self._add(point)

    def _are_together(self, places: list[int]) -> bool:
        """Whether coordinates of one node belong to a cable, or to one body."""
        first, bodies = places[0], self.bodies
        width = bodies["translations"] + bodies["rotations"]
        in_body = (bodies["first"] <= first) & (places[-1] < bodies["first"] + width)
        return first < self._on_cables or bool(in_body.any())

    def angle(self, number: int, axis: int) -> Place:
        """An angle of the body on a node; UnknownItemError if there is none."""
        places, node = self._of_node(number)
        first = self._coordinates.place(places[0])
        if first not in self._of_nodes:
            raise UnknownItemError(f"an angle of node {number} '{node['name']}' ({node['nodeType']})")
        body = self._of_nodes[first]
        record = self.bodies[body]
        point = _new(ANGLE, first + int(record["translations"]), int(record["rotations"]))
        point["body"], point["axis"] = body, axis
        return self._add(point)


def _place_on_ground(position: Any, rotation: Any, local: Any) -> Array:
    """(3,) of a point `local` (3,) in the frame of an object."""
    return position + np.asarray(rotation) @ local


def _centre(body: Any) -> Array:
    """(3,) of the mass of a record, in its frame [m]."""
    mass = body["mass"]
    return np.array([mass[1, 5], -mass[0, 5], mass[0, 4]]) / mass[0, 0]


def _new(kind: int, first: int = 0, width: int = 0) -> Any:
    point = _new_point()
    point["kind"], point["first"], point["width"] = kind, first, width
    return point


@lru_cache(maxsize=64)
def _points_on_axis(dim: int, *weights: float) -> Callable[[], Any]:
    """Makes points on the axis of a cable, by these weights of its coordinates; the first one is not set."""
    point = _new(ON_CABLE, width=len(weights) * dim)
    point["dimension"] = dim
    point["weights"][: len(weights)] = weights
    for k, weight in enumerate(weights):
        point["along"][:dim, k * dim : (k + 1) * dim] = weight * _ALONG[:dim, :dim]
    return copies_of(point)
