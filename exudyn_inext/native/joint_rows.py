"""The joints of an mbs as rows of one constraint on the parts of a coupled system."""

from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from ..arrays import Array, as_slice
from ..compiled import kernel
from ..constraints.motion import AHEAD, differences_and_side
from ..constraints.motion import STEP as STEP_OF_TIME
from ..scene.coupled_system import Part
from ..scene.joints import JointBlock, JointTerms
from .bodies import Quaternions
from .coordinates import CoordinateMap
from .joint_item import JointItem
from .sliding_joints import SlidingJoint

STEP = 1e-4  # of differences along the motion [m, -, s], where coordinates are 1 at most
# places, in steps, and weights of second differences: between two; between four, for functions of time, which
# may be fast; or of one side. The last two are exact up to the fifth power.
_BETWEEN = np.array([1.0, -1.0]), np.ones(2)
_AROUND = np.array([1.0, -1.0, 2.0, -2.0]), np.array([16.0, 16.0, -1.0, -1.0]) / 12.0
_BESIDE = np.arange(1.0, AHEAD.shape[1]), STEP_OF_TIME**2 * AHEAD[1, 1:]


class JointRows:
    """Values c(q, t) from Exudyn for all algebraic equations at once, Jacobians joint by joint.

    names: (m,) of the rows.   blocks: Jacobian by parts, overwritten at each evaluation.
    on_held: (k, m) its transpose for coordinates that lie in no part.
    sliding: rows of sliding joints, and these.
    quaternions: (Q, 4) places of those of bodies.   references: (Q, 4) what separates them from Exudyn's.

    Args:
        held: (k,) places of these in the system vector.
    """

    def __init__(
        self,
        joints: Sequence[JointItem],
        quaternions: Quaternions,
        parts: Sequence[Part],
        coordinates: CoordinateMap,
        held: np.ndarray,
    ) -> None:
        self.names = [f"{joint.name}, equation {k}," for joint in joints for k in joint.active]
        self.follows_time = any(joint.follows_time for joint in joints)
        self._joints = joints
        self._places = len(coordinates.indices)
        self._are_linear = all(joint.is_linear for joint in joints)
        self._is_set = False  # the Jacobian of linear joints
        self._equations = np.concatenate([np.zeros(0, int), *(joint.rows for joint in joints)])
        sizes = [len(joint.rows) for joint in joints]
        rows = [np.arange(a, b) for a, b in pairwise([0, *accumulate(sizes)])]
        periods = np.repeat([joint.period for joint in joints], sizes)
        self._angles = np.flatnonzero(np.isfinite(periods))
        self._periods = periods[self._angles]
        pairs = zip(rows, joints, strict=True)
        self.sliding = [(own, joint) for own, joint in pairs if isinstance(joint, SlidingJoint)]
        self.shortest = min((joint.scale for joint in joints), default=1.0)
        self._step = STEP * min(1.0, self.shortest) ** 0.5  # c of short rods and elements bends within STEP
        places = [coordinates.places(joint.coordinates) for joint in joints]
        of_parts = _blocks(parts, rows, places)
        self.blocks = list(of_parts.values())
        self._of_rates = [
            (own, joint, coordinates.all_places(joint.coordinates))
            for own, joint in zip(rows, joints, strict=True)
            if joint.is_angular or joint.is_rolling
        ]
        self._rolling = np.flatnonzero(np.repeat([joint.is_rolling for joint in joints], sizes))
        self._targets = [
            [
                (of_parts[part], _places(of_parts[part].rows, own, at), as_slice(columns))
                for part, columns, at in met
            ]
            for own, met in zip(rows, places, strict=True)
        ]
        self.on_held: Array = np.zeros((len(held), len(self.names)))
        self._held = [
            (own, *_common(joint.coordinates, held)) for own, joint in zip(rows, joints, strict=True)
        ]
        self.quaternions = coordinates.all_places(quaternions.coordinates)
        self.references = quaternions.references

    def values(self, mbs: Any, equations: Array) -> Array:
        """(m,) in the current configuration of mbs, from the values of all algebraic equations there."""
        result = equations[self._equations]
        if len(self._angles):
            result[self._angles] -= self._periods * np.round(result[self._angles] / self._periods)
        if len(self._rolling):
            result[self._rolling] = 0.0
        for own, joint in self.sliding:
            result[own] = joint.foot(mbs).distances
        return result

    def multipliers(self, mbs: Any, rows: Array, size: int) -> Array:
        """(size,) of all algebraic equations, from those of the rows (m,) in mbs's configuration."""
        result = np.zeros(size)
        result[self._equations] = rows
        for own, joint in self.sliding:
            result[joint.equations] = joint.multipliers(mbs, rows[own])
        return result

    def beyond(self, mbs: Any) -> Array:
        """(m,) how far what slides is beyond the ends of its cable [m]."""
        result = np.zeros(len(self.names))
        for own, joint in self.sliding:
            result[own[0]] = joint.beyond(mbs)
        return result

    def put_places(self, mbs: Any, data: Array) -> Array:
        """Data (D,) of mbs with the places of what slides; OffCableError if one has left its cable."""
        for _, joint in self.sliding:
            joint.put_place(mbs, data)
        return data

    def forget(self) -> None:
        """Joints or their markers may have been changed."""
        self._is_set = False

    def update_jacobian(self, mbs: Any, q: Array) -> None:
        """`blocks` in the current configuration of mbs, which is q (n,)."""
        for joint, targets, (own, columns_held, held) in zip(
            self._joints, self._targets, self._held, strict=True
        ):
            if joint.is_linear and self._is_set:
                continue
            jacobian = joint.jacobian(mbs)
            for block, places, columns in targets:
                block.jacobian[places] = jacobian[:, columns]
            if len(held):
                self.on_held[held[:, None], own] = jacobian[:, columns_held].T
        self._is_set = True

    def _moved(self, q: Array, v: Array, duration: float) -> Array:
        """q + duration v, on curves that keep the norm of quaternions.

        Exudyn's Jacobians are those of rotations: they do not see a change of that norm.
        """
        moved = q + duration * v
        if len(self.quaternions):
            _keep_norms(self.quaternions, self.references, q, moved)
        return moved

    def terms(
        self, mbs: Any, value_at: Callable[[float, Array], Array], t: float, q: Array, v: Array
    ) -> JointTerms:
        """The joints at (t, q, v); the Jacobian is up to date.

        Args:
            value_at: (t, q) -> c (m,), which brings mbs there; its second difference along the motion is
                -gamma, Eq. (27), or the difference of its rate where velocities are constrained;
                of one side where functions of time begin or end, and exact there up to the fourth power.
        """
        if self.follows_time:
            (value, drift, change), side = differences_and_side(lambda s: value_at(s, q), t)
        else:
            (drift, change), value, side = np.zeros((2, len(self.names))), value_at(t, q), 0
            if self._are_linear or not v.any():
                return JointTerms(value, drift, change)
        rates = v[: self._places]  # those of first-order states behind them have other units
        size, speed = (max(1.0, float(np.abs(x).max())) for x in (q[: self._places], rates))
        step = self._step * size**0.5 / speed  # large coordinates have larger round-off
        if self.follows_time:
            step = min(step, STEP_OF_TIME)
        places, weights = _BESIDE if side else _AROUND if self.follows_time else _BETWEEN
        times = step * (side or 1.0) * places
        along = [(value_at(t + s, self._moved(q, v, s)), self._rates(mbs, v)) for s in times.tolist()]
        gamma = weights @ [value - beside for beside, _ in along] / step**2
        for k, (own, _, _) in enumerate(self._of_rates):
            gamma[own] = (along[0][1][k] - along[1][1][k]) / (times[1] - times[0]) - change[own]
        return JointTerms(value, drift, gamma)

    def _rates(self, mbs: Any, v: Array) -> list[Array]:
        """Rates of c of those joints that constrain velocities, where mbs is."""
        return [
            joint.jacobian(mbs)[:, places >= 0] @ v[places[places >= 0]]
            for _, joint, places in self._of_rates
        ]


def _places(rows: np.ndarray, own: np.ndarray, at: np.ndarray) -> Any:
    """Of the rows of a joint, which follow each other, and of columns in the block with these rows."""
    first = int(np.searchsorted(rows, own[0]))
    return slice(first, first + len(own)), as_slice(at)


def _common(coordinates: np.ndarray, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where those that are held stand in both."""
    if not len(held):
        return held, held
    _, columns, places = np.intersect1d(coordinates, held, return_indices=True)
    return columns, places


def _blocks(
    parts: Sequence[Part], rows: Sequence[np.ndarray], places: Sequence[Any]
) -> dict[int, JointBlock]:
    """Rows of the joints by the parts that they meet; places: of each joint, see `CoordinateMap.places`."""
    of_parts: dict[int, list[np.ndarray]] = {}
    for own, met in zip(rows, places, strict=True):
        for place in met:
            of_parts.setdefault(place[0], []).append(own)
    met_parts = ((number, parts[number], np.concatenate(of_parts[number])) for number in sorted(of_parts))
    return {number: JointBlock(part.system, part.dofs, own, part.whole) for number, part, own in met_parts}


@kernel
def _keep_norms(quaternions, references, q, moved):
    """Scale the quaternions of `moved` to their norms in `q`.   quaternions: (Q, 4) places."""
    for k in range(len(quaternions)):
        before, after = 0.0, 0.0
        for i in range(4):
            at = quaternions[k, i]
            before += (q[at] + references[k, i]) ** 2
            after += (moved[at] + references[k, i]) ** 2
        scale = np.sqrt(before / after)
        for i in range(4):
            at = quaternions[k, i]
            moved[at] = scale * (moved[at] + references[k, i]) - references[k, i]
