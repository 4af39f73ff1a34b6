"""What Exudyn's items do to a scene at rest, for the search for its equilibrium."""

from collections import defaultdict
from collections.abc import Iterable
from itertools import pairwise
from typing import Any
from warnings import warn

import exudyn
import numpy as np
import scipy

from ..arrays import Array, SparseArray
from ..errors import SceneError
from ..items.arguments import described
from ..items.attach.inert import is_inert_cable
from ..items.functions_of_time import is_of_time_alone
from .bodies import read_quaternions
from .circles_in_the_way import CirclesInTheWay
from .evaluated_scene import SceneOfExudyn
from .sliding_joints import SlidingJoint

_ROTATIONS = {"RigidBody2D": 2, "Point2DSlope1": 2, "PointSlope1": 3, "PointSlope12": 3, "PointSlope23": 3}
"""Where the rotations, or slopes, of a node begin."""


class StaticScene:
    """All that a scene has besides its cables, as Exudyn evaluates it; coordinates are those of the scene.

    Args:
        scene: evaluated by Exudyn.   t: at which loads and joints are taken [s].

    mass: (b, b) of the bodies, whose coordinates come last.
    varying: coordinates that forces or Jacobians depend on, item by item; of what slides near the last
        state of `turn_with`.
    quaternions: (Q, 4) places of Euler parameters.   references: (Q, 4) added to these.
    turning: (k,) places of coordinates that turn bodies.
    """

    def __init__(self, scene: SceneOfExudyn, t: float) -> None:
        self._scene, self._time = scene, t
        self._rest = np.zeros(scene.size)
        mbs = scene.mbs
        if mbs.systemData.ODE1Size():
            raise SceneError("mbs has states of first order, whose rest is not searched for: remove them.")
        for joint in scene.joints:
            if joint.is_rolling:
                raise SceneError(
                    f"{joint.name} rolls, and where it would come to rest depends on the way there: for the "
                    "search, set its activeConnector to False and hold the body by a joint, as by "
                    "CreateGenericJoint."
                )
        scene.native_items.settles = True
        self.force(scene.initial_state[0])
        self.mass = scene.body_system.mass
        scene.native_items.weighs = False
        bodies = scene.map.slices[-1]
        self._sliding = [joint for joint in scene.joints if isinstance(joint, SlidingJoint)]
        self._varying = self.varying = _varying(scene)
        quaternions = read_quaternions(mbs)
        self.quaternions = scene.map.all_places(quaternions.coordinates)
        self.references = quaternions.references
        self.turning = _turning(scene, bodies.start)
        self._circles = CirclesInTheWay(mbs)

    @property
    def slides(self) -> bool:
        return len(self._sliding) > 0

    def turn_with(self, q: Array) -> None:
        """Sliding joints meet the elements on which they are at q, and their frames do not twist there."""
        scene = self._scene
        scene.native_items.set_state(self._time, q, self._rest)
        for joint in self._sliding:
            joint.turn_with(scene.mbs)
        self.varying = self._varying + [_places(scene, joint.near(scene.mbs)) for joint in self._sliding]

    def force(self, q: Array) -> Array:
        """F (n,) of all items but the cables, and of these items on the cables, at rest."""
        self._scene.native_items.act(self._time, q, self._rest)
        return self._scene.native_items.native_forces.copy()

    def is_blocked(self, q: Array, trial: Array) -> bool:
        """Whether a cable would jump over a circle that it touches, or through it."""
        return len(self._circles) > 0 and self._circles.are_between(self._ends(q), self._ends(trial))

    def _ends(self, q: Array) -> Array:
        """Of segments in contact with circles, see `CirclesInTheWay`."""
        self._scene.native_items.set_state(self._time, q, self._rest)
        return self._circles.present()

    def values(self, q: Array) -> Array:
        """c (m,) of the joints."""
        if not self._scene.joints:
            return np.zeros(0)
        native_items = self._scene.native_items
        values = native_items.violations(self._time, q)
        if native_items.has_sliding_joints:  # what no change of c makes up for
            values = values + np.copysign(native_items.beyond(), values)
        return values

    def jacobian(self, q: Array) -> SparseArray:
        """J (m, n)."""
        native_items, size = self._scene.native_items, (len(self._scene.native_items.joints), len(q))
        rows, columns, values = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)]
        for block in native_items.jacobian(self._time, q) if self._scene.joints else ():
            at = np.nonzero(block.jacobian)
            rows.append(block.rows[at[0]])
            columns.append(block.dofs.start + at[1])
            values.append(block.jacobian[at])
        places = np.concatenate(rows), np.concatenate(columns)
        return scipy.sparse.csr_array((np.concatenate(values), places), size)

    def pulls(self, q: Array, nu: Array) -> Array:
        """J^T nu (n,)."""
        result = np.zeros(len(q))
        for block in self._scene.native_items.jacobian(self._time, q) if self._scene.joints else ():
            result[block.dofs] += block.jacobian.T @ nu[block.rows]
        return result

    def reactions(self, q: Array, nu: Array) -> Array:
        """Of all algebraic equations in Exudyn's order.   nu: (m,) of the joints."""
        self.force(q)
        return self._scene.native_items.all_multipliers(nu, self._rest)

    def data(self, q: Array) -> Array:
        """(D,) what contacts remember once they have settled, and the places of sliding joints."""
        self.force(q)
        return self._scene.native_items.present_places()


def _varying(scene: SceneOfExudyn) -> list[np.ndarray]:
    """Coordinates that forces of items, or Jacobians of joints, depend on, by items that do not slide."""
    mbs, data = scene.mbs, scene.mbs.systemData
    left_out = {part.cable.number for part in scene.cables} | scene.elsewhere
    found = _in_general_contact(scene)
    found += [_places(scene, body.coordinates) for body in scene.bodies]
    bent = [joint for joint in scene.joints if not (joint.is_linear or isinstance(joint, SlidingJoint))]
    found += [_places(scene, joint.coordinates) for joint in bent]
    left_out.update(joint.number for joint in scene.joints)
    for number in range(data.NumberOfObjects()):
        if number not in left_out and _acts(mbs.GetObject(number)):
            found.append(_places(scene, data.GetObjectLTGODE2(number)))
    for number in range(data.NumberOfLoads()):
        load = mbs.GetLoad(number)
        function = load.get("loadVectorUserFunction") or load.get("loadUserFunction")
        follows = function and not is_of_time_alone(mbs, function)
        if follows or load["loadType"] == "TorqueVector" or load.get("bodyFixed"):
            found.append(_coordinates_of_marker(scene, int(load["markerNumber"])))
    return found


def _acts(item: dict[str, Any]) -> bool:
    """Whether an object is an active connector, or has stiffness, with or without mass."""
    return bool(item.get("activeConnector")) or (
        item["objectType"] in ("GenericODE2", "ANCFCable", "ANCFCable2D") and not is_inert_cable(item)
    )


def _in_general_contact(scene: SceneOfExudyn) -> list[np.ndarray]:
    """Bodies, any two of which may touch, and each native element with all of them."""
    mbs, data = scene.mbs, scene.mbs.systemData
    if not mbs.NumberOfGeneralContacts():
        return []
    bodies = np.arange(scene.map.slices[-1].start, len(scene.map.indices))
    objects = range(data.NumberOfObjects())
    elements = [number for number in objects if mbs.GetObject(number)["objectType"] == "ANCFCable2D"]
    own = [_places(scene, data.GetObjectLTGODE2(number)) for number in elements]
    return [bodies, *(np.concatenate([places, bodies]) for places in own)]


def _places(scene: SceneOfExudyn, coordinates: Iterable[int]) -> np.ndarray:
    """Of coordinates of mbs in the scene, but of those that are held."""
    places = scene.map.all_places(list(coordinates))
    return places[places >= 0]


def _coordinates_of_marker(scene: SceneOfExudyn, number: int) -> np.ndarray:
    marker, data = scene.mbs.GetMarker(number), scene.mbs.systemData
    if "nodeNumber" in marker:  # a function may depend on others as well: then the search takes more steps
        own = data.GetNodeLTGODE2(int(marker["nodeNumber"]))
    else:
        own = data.GetObjectLTGODE2(int(marker["bodyNumber"])) if "bodyNumber" in marker else []
    return _places(scene, own)


def _turning(scene: SceneOfExudyn, first: int) -> np.ndarray:
    """Places, from `first` on, that turn bodies or their nodes."""
    data, found = scene.mbs.systemData, []
    for number in range(data.NumberOfNodes()):
        kind = scene.mbs.GetNode(number)["nodeType"]
        begin = _ROTATIONS.get(kind, 3 if kind.startswith("RigidBody") else None)
        own = data.GetNodeLTGODE2(number)[begin:] if begin is not None else []
        found += [place for place in map(scene.map.place, own) if place >= first]
    return np.array(found, dtype=int)


def require_held(scene: SceneOfExudyn, cables_held: list[bool]) -> None:
    """Raise SceneError, which names a cable or body, if nothing connects it to the ground.

    cables_held: of each cable, whether it has supports.
    """
    mbs = scene.mbs
    if mbs.NumberOfGeneralContacts():
        return
    owners = [(cable.number, set(cable.indices.tolist())) for cable, _, _ in scene.cables]
    owners += [(body.number, set(body.coordinates.tolist())) for body in scene.bodies]
    ties = [{k, len(owners)} for k, is_held in enumerate(cables_held) if is_held]
    ties += _ties(scene, [places for _, places in owners])
    pairs = np.array([pair for tie in ties for pair in pairwise(sorted(tie))], dtype=int).reshape(-1, 2)
    size = len(owners) + 1  # the last one is the ground
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (size, size))
    _, group = scipy.sparse.csgraph.connected_components(graph, directed=False)
    for k, (number, _) in enumerate(owners):
        if group[k] != group[-1]:
            name = described(mbs.GetObject(number), number)
            raise SceneError(
                f"nothing connects {name} to the ground, so that it has no equilibrium of its own: add a "
                "support, a joint or a spring, or let SolveExplicit move it."
            )


def _ties(scene: SceneOfExudyn, owners: list[set[int]]) -> list[set[int]]:
    """Numbers of cables and bodies that hold each other; the one after the last is the ground.

    owners: their coordinates, which elements and bodies may share.
    """
    mbs, ground, owners_of = scene.mbs, len(owners), defaultdict[int, set[int]](set)
    for k, places in enumerate(owners):
        for place in places:
            owners_of[place].add(k)
    ties = [owners_of[place] | {ground} for place in scene.held.places.tolist()]
    objects = set(range(mbs.systemData.NumberOfObjects())) - {cable.number for cable, _, _ in scene.cables}
    for number in objects:
        item = mbs.GetObject(number)
        met = set[int]().union(*(owners_of[place] for place in mbs.systemData.GetObjectLTGODE2(number)))
        if item.get("activeConnector", len(met) > 1):
            ties.append(met if len(met) > 1 else met | {ground})
        if _holds_itself(item):
            ties.append(met | {ground})
    return ties


def _holds_itself(item: dict[str, Any]) -> bool:
    """Whether a body may have an equilibrium of its own: by its stiffness, its function, or its joints."""
    if item["objectType"] == "GenericODE2":
        return bool(item["forceUserFunction"]) or item["stiffnessMatrix"].Convert2DenseMatrix().any()
    return item["objectType"] == "KinematicTree"


def put_data(mbs: Any, data: Array) -> None:
    """As initial and present data (D,) of mbs."""
    for configuration in (exudyn.ConfigurationType.Initial, exudyn.ConfigurationType.Current):
        mbs.systemData.SetDataCoordinates(data.tolist(), configuration)
    for number in range(mbs.systemData.NumberOfNodes() if len(data) else 0):
        if len(places := mbs.systemData.GetNodeLTGData(number)):
            mbs.SetNodeParameter(number, "initialCoordinates", data[places].tolist())


def rest_at(mbs: Any, displacements: Array, multipliers: Array) -> None:
    """Displacements (n,) of all coordinates as initial and present state of mbs, at rest.

    multipliers: (m,) lam of M a + C_q^T lam = F; Exudyn's static solver has the other sign.
    """
    data, rest = mbs.systemData, np.zeros(len(displacements)).tolist()
    if np.any(data.GetODE2Coordinates_t(exudyn.ConfigurationType.Initial)):
        warn(
            "SolveEquilibrium has set the initial velocities of mbs to zero. To start a run with them, take "
            "v = mbs.systemData.GetODE2Coordinates_t(exu.ConfigurationType.Initial) before it, and call "
            "mbs.systemData.SetODE2Coordinates_t(v, exu.ConfigurationType.Initial) after it.",
            stacklevel=3,
        )
    for configuration in (exudyn.ConfigurationType.Initial, exudyn.ConfigurationType.Current):
        data.SetODE2Coordinates(displacements.tolist(), configuration)
        data.SetODE2Coordinates_t(rest, configuration)
        data.SetAECoordinates((-multipliers).tolist(), configuration)
    for number in range(data.NumberOfNodes()):
        places = np.array(data.GetNodeLTGODE2(number), dtype=int)
        own = displacements[places]
        values = {
            "initialCoordinates": own,
            "initialVelocities": 0.0 * own,
            "initialCoordinates_t": 0.0 * own,
        }
        for name in values.keys() & mbs.GetNode(number).keys() if len(places) else ():
            mbs.SetNodeParameter(number, name, values[name].tolist())
