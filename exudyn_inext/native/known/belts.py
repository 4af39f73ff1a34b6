"""Cables in a GeneralContact, found out from what it does to them: Exudyn tells no more than their number.

One of its spheres, for a moment stiff, undamped and so large that all cables lie in it, presses each element
by forces that are linear in what is wanted. With the integrals over the length of an element

    A = int S d n dx,   B = int S n dx,   C = int S (R + y - d) d t dx,

S its shape functions, d the distance from the sphere's centre, R its radius, n and t as in
`multibody.general_contacts`, the sphere pulls it by

    k (A - (R + y) B)  at rest,    D A  more if all moves apart,    -k mu (w / z) C  more if all turns by w.

Elements share nodes: a sparse system of linear equations for each of k, y, D and mu says those of all.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import exudyn
import numpy as np
import scipy

from ...arrays import Array
from ...element.shape_functions import shape_functions
from ...items.attach.inert import is_inert_cable
from .unknown import UnknownItemError

_STIFF = 1e20  # [N/m^2], beside which that of a cable counts alone
_BEYOND = 1.5  # radius of the large sphere by the largest distance from it
_APPROACH = 100.0  # how fast all comes nearer to the centre [1/s]
_PASSES = 3  # of a solve by squares, which has twice the digits of the condition
_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0
_TOLERANCE = 1e-9  # of the forces, relative
_OF_SPHERE = ("radius", "contactStiffness", "contactDamping", "frictionMaterialIndex")


class Touching(NamedTuple):
    """An element in a contact.   number: of the object.   height: half of it [m].

    stiffness [N/m^2], damping [N s/m^2]: of its own.   material: for friction.
    """

    number: int
    height: float
    stiffness: float
    damping: float
    material: int


def elements_of(mbs: Any, contact: Any, evaluate: Callable[[], None]) -> list[Touching]:
    """The elements of cables in a contact that has spheres, in its present state; that is kept.

    evaluate: lets contact settle, and Exudyn evaluate all forces, in the present state of mbs.

    Raises:
        UnknownItemError: what the contact does is not what such elements do.
    """
    numbers = [n for n in range(mbs.systemData.NumberOfObjects()) if _is_element(mbs, n)]
    known = contact.GetPythonObject()
    probe = _Probe(mbs, contact, numbers, known["frictionPairings"], evaluate)
    with probe.large_sphere(known["numberOfSpheresMarkerBased"]):
        stiffness, pressed = probe.stiffness()
        which = np.flatnonzero(stiffness > _TOLERANCE * stiffness.max(initial=0.0))
        if len(which) != known["numberOfANCFCable2D"]:
            raise UnknownItemError(
                "GeneralContact with cables that have no compiled form, or are twice in it"
            )
        probe.keep(which)
        stiffness = stiffness[which]
        heights = probe.heights(stiffness, pressed)
        dampings = probe.dampings(pressed)
        materials = probe.materials(stiffness, heights, pressed)
    found = zip(which.tolist(), heights, stiffness, dampings, materials, strict=True)
    return [Touching(numbers[k], float(y), float(c), float(d), int(m)) for k, y, c, d, m in found]


def _is_element(mbs: Any, number: int) -> bool:
    data = mbs.GetObject(number)
    return bool(data["objectType"] == "ANCFCable2D") and is_inert_cable(data)


class _Elements(NamedTuple):
    """Elements around a place, as straight segments, with three points on each of these.

    places: (e, 8) of their coordinates.   away: (e, 4, 2) positions of their nodes from there, and slopes.
    distance: (e, p) of the points from there.   normal: (e, p, 2).   weights: (e, 4, p) of integrals by the
        shape functions [m].
    """

    places: np.ndarray
    away: Array
    distance: Array
    normal: Array
    weights: Array

    def some(self, which: np.ndarray) -> "_Elements":
        """These alone."""
        return _Elements(*(of_all[which] for of_all in self))


def _read_elements(mbs: Any, numbers: Sequence[int], segments: int, centre: Array) -> _Elements:
    """Companions of these numbers, in the present configuration.   centre: (2,) of the sphere."""
    data, shares = mbs.systemData, np.array([0.0, 0.5, 1.0])
    total = np.add(data.GetODE2Coordinates(), data.GetODE2Coordinates(exudyn.ConfigurationType.Reference))
    places = np.array([data.GetObjectLTGODE2(n) for n in numbers], dtype=int).reshape(-1, 8)
    lengths = [float(mbs.GetObject(n)["length"]) for n in numbers]
    away = total[places].reshape(-1, 4, 2) - np.outer([1.0, 0.0, 1.0, 0.0], centre)
    ends = np.linspace(0.0, 1.0, segments + 1)
    on_axis = np.array([shape_functions(ends, length).T for length in lengths])
    on_ends = np.einsum("esk,eki->esi", on_axis.reshape(-1, segments + 1, 4), away)
    along = np.diff(on_ends, axis=1)[:, :, np.newaxis]
    points = (on_ends[:, :-1, np.newaxis] + shares[:, np.newaxis] * along).reshape(-1, 3 * segments, 2)
    distance = np.linalg.norm(points, axis=2)
    normal = points / np.maximum(distance, 1e-300)[:, :, np.newaxis]
    xi, simpson = np.add.outer(ends[:-1], shares / segments).ravel(), np.tile(_SIMPSON / segments, segments)
    weights = [length * simpson * shape_functions(xi, length) for length in lengths]
    return _Elements(places, away, distance, normal, np.array(weights).reshape(-1, 4, len(xi)))


class _Probe:
    """A large sphere, and the elements in it.

    Args:
        mbs, contact, evaluate: see `elements_of`.   numbers: of the objects.
        pairings: friction coefficients of materials.
    """

    def __init__(
        self,
        mbs: Any,
        contact: Any,
        numbers: Sequence[int],
        pairings: Array,
        evaluate: Callable[[], None],
    ) -> None:
        self._mbs, self._contact, self._evaluate = mbs, contact, evaluate
        self._pairings = np.array(pairings)
        self._size = mbs.systemData.ODE2Size()
        marker = int(contact.GetSphereMarkerBased(0, addData=True)["markerIndex"])
        centre = np.array(mbs.GetMarkerOutput(marker, exudyn.OutputVariableType.Position))[:2]
        segments = int(contact.ancfCableNumberOfContactSegments)
        self._elements = _read_elements(mbs, numbers, segments, centre)
        self._furthest = float(self._elements.distance.max(initial=0.0))
        self._radius = _BEYOND * self._furthest

    @contextmanager
    def large_sphere(self, number: int) -> Iterator[None]:
        """The first one of all spheres is large, and the others are points, without friction."""
        contact, data = self._contact, self._mbs.systemData
        saved = [contact.GetSphereMarkerBased(k, addData=True) for k in range(number)]
        rates, reports = data.GetODE2Coordinates_t(), contact.computeContactForces
        try:
            contact.computeContactForces = True
            contact.SetFrictionPairings(0.0 * self._pairings)
            for k in range(number):
                contact.SetSphereMarkerBased(k, 0.0, 0.0, 0.0, 0)
            contact.SetSphereMarkerBased(0, contactStiffness=_STIFF)
            yield
        finally:
            contact.computeContactForces = reports
            contact.SetFrictionPairings(self._pairings)
            for k, sphere in enumerate(saved):
                contact.SetSphereMarkerBased(k, **{name: sphere[name] for name in _OF_SPHERE})
            data.SetODE2Coordinates_t(rates)
            self._evaluate()

    def keep(self, which: np.ndarray) -> None:
        """Go on with these elements alone."""
        self._elements = self._elements.some(which)

    def stiffness(self) -> tuple[Array, Array]:
        """(e,) of all elements [N/m^2], and (n,) what the sphere does to them at rest."""
        pressed, more = self._forces(self._radius), self._forces(2.0 * self._radius)
        return self._solve(self._radius * self._elements.normal, more - pressed), pressed

    def heights(self, stiffness: Array, pressed: Array) -> Array:
        """(e,) half of each [m]."""
        pressing = stiffness[:, np.newaxis, np.newaxis] * self._elements.normal
        depth = self._radius - self._elements.distance
        of_radius = self._integrals(depth[:, :, np.newaxis] * pressing).sum(axis=1)
        return self._solve(pressing, pressed - of_radius, float(np.abs(pressed).max()))

    def dampings(self, pressed: Array) -> Array:
        """(e,) [N s/m^2]."""
        elements = self._elements
        more = self._forces(self._radius, -_APPROACH * elements.away) - pressed
        along = _APPROACH * elements.distance[:, :, np.newaxis] * elements.normal
        return self._solve(along, more, float(np.abs(pressed).max()))

    def materials(self, stiffness: Array, heights: Array, pressed: Array) -> np.ndarray:
        """(e,) for friction."""
        number, zone = len(self._pairings), float(self._contact.frictionProportionalZone)
        if not self._pairings.any():
            return np.zeros(len(stiffness), dtype=int)
        if not zone > 0.0:
            raise UnknownItemError("GeneralContact with frictionProportionalZone = 0")
        told_apart = np.zeros((number, number))
        told_apart[0] = told_apart[:, 0] = np.arange(1.0, number + 1.0)
        self._contact.SetFrictionPairings(told_apart)
        elements, turn = self._elements, 0.5 * zone / self._furthest
        more = self._forces(self._radius, turn * _turned(elements.away)) - pressed
        depth = self._radius + heights[:, np.newaxis] - elements.distance
        pressure = depth * stiffness[:, np.newaxis] * (turn / zone) * elements.distance
        found = self._solve(-pressure[:, :, np.newaxis] * _turned(elements.normal), more)
        materials = np.rint(found).astype(int) - 1
        if not (np.abs(found - 1.0 - materials) < 1e-6).all():
            raise UnknownItemError("GeneralContact, whose friction is not known")
        return materials

    def _forces(self, radius: float, rates: Array | None = None) -> Array:
        """(n,) on all coordinates.   rates: (e, 4, 2) of the elements' nodes [m/s]; none: all is at rest."""
        v = np.zeros(self._size)
        if rates is not None:
            v[self._elements.places.ravel()] = rates.ravel()
        self._mbs.systemData.SetODE2Coordinates_t(v)
        self._contact.SetSphereMarkerBased(0, radius=radius)
        self._evaluate()
        return np.array(self._contact.GetSystemODE2RhsContactForces(copy=True))

    def _integrals(self, vectors: Array) -> Any:
        """(n, e) of vectors (e, p, 2) by the shape functions, sparse."""
        values = np.einsum("ekp,epi->eki", self._elements.weights, vectors).reshape(-1, 8)
        columns = np.repeat(np.arange(len(values)), 8)
        shape = self._size, len(values)
        return scipy.sparse.csc_array((values.ravel(), (self._elements.places.ravel(), columns)), shape=shape)

    def _solve(self, vectors: Array, forces: Array, scale: float = 0.0) -> Array:
        """(e,) factors with which the integrals of vectors (e, p, 2) are the forces (n,) on the cables.

        scale: of what cancels in these [N].   UnknownItemError if there are none.
        """
        columns, on_cables, places = self._integrals(vectors), np.zeros(self._size), self._elements.places
        on_cables[places] = forces[places]
        squares = scipy.sparse.linalg.splu(scipy.sparse.csc_array(columns.T @ columns))
        x = np.zeros(len(places))
        for _ in range(_PASSES):
            x += squares.solve(columns.T @ (on_cables - columns @ x))
        worst = float(np.abs(columns @ x - on_cables).max(initial=0.0))
        if not worst <= _TOLERANCE * max(scale, float(np.abs(on_cables).max(initial=0.0))):
            raise UnknownItemError("GeneralContact, which presses cables otherwise")
        return x


def _turned(vectors: Array) -> Array:
    """By a right angle.   vectors: (..., 2)."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)
