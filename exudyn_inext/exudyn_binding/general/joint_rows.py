"""The joints of an mbs as rows of one constraint on the parts of a coupled system."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ...arrays import Array
from ...coupling.coupled_system import Part
from ...coupling.joints import JointBlock, JointTerms
from .bodies import Quaternion
from .coordinates import CoordinateMap
from .joint_items import JointItem

STEP = 1e-4  # of differences along the motion [m, -, s]


class JointRows:
    """Values c(q, t) from Exudyn for all algebraic equations at once, Jacobians joint by joint.

    names: (m,) of the rows.   blocks: Jacobian by parts, overwritten at each evaluation.
    """

    def __init__(
        self,
        joints: Sequence[JointItem],
        quaternions: Sequence[Quaternion],
        parts: Sequence[Part],
        coordinates: CoordinateMap,
    ) -> None:
        self.names = [f"{j.name}, equation {k}," for j in joints for k in j.active]
        self.names += [f"the unit quaternion of node {quaternion.node}" for quaternion in quaternions]
        of_joints = [joint.rows for joint in joints]
        of_nodes = [np.array([quaternion.row]) for quaternion in quaternions]
        self._equations = np.concatenate([np.zeros(0, int), *of_joints, *of_nodes])
        self.follows_time = any(joint.follows_time for joint in joints)
        ends = np.cumsum([0, *(len(rows) for rows in [*of_joints, *of_nodes])])
        own = [np.arange(a, b) for a, b in pairwise(ends)]
        touched = [joint.coordinates for joint in joints] + [q.coordinates for q in quaternions]
        places = [coordinates.places(c) for c in touched]
        self.blocks: list[JointBlock] = []
        position: dict[int, tuple[JointBlock, np.ndarray]] = {}
        for number, part in enumerate(parts):
            rows = [own[k] for k, met in enumerate(places) if any(p == number for p, _, _ in met)]
            if rows:
                everything = np.concatenate(rows)
                block = JointBlock(part.system, part.dofs, everything)
                self.blocks.append(block)
                position[number] = (block, everything)
        self._targets = [
            [
                (position[part][0].jacobian, np.ix_(np.searchsorted(position[part][1], own[k]), at), columns)
                for part, columns, at in met
            ]
            for k, met in enumerate(places)
        ]
        self._joints = joints
        self._quaternions = [
            (
                np.array([np.flatnonzero(coordinates.indices == c)[0] for c in quaternion.coordinates]),
                quaternion,
            )
            for quaternion in quaternions
        ]

    @property
    def number(self) -> int:
        return len(self.names)

    def values(self, equations: Array) -> Array:
        """(m,) from the values of all algebraic equations."""
        return equations[self._equations]

    def equations(self, rows: Array, size: int) -> Array:
        """(size,) for all algebraic equations, from those of the rows (m,)."""
        result = np.zeros(size)
        result[self._equations] = rows
        return result

    def update_jacobian(self, mbs: Any, q: Array) -> None:
        """`blocks` in the current configuration of mbs, which is q (n,)."""
        for joint, targets in zip(self._joints, self._targets, strict=False):
            jacobian = joint.jacobian(mbs)
            for block, places, columns in targets:
                block[places] = jacobian[:, columns]
        for (at, quaternion), targets in zip(
            self._quaternions, self._targets[len(self._joints) :], strict=True
        ):
            normal = 2.0 * (q[at] + quaternion.reference)
            for block, places, columns in targets:
                block[places] = normal[columns]

    def _moved(self, q: Array, v: Array, duration: float) -> Array:
        """q + duration v, on curves that keep the norm of quaternions.

        Exudyn's Jacobians are those of rotations: they do not see a change of that norm.
        """
        moved = q + duration * v
        for at, quaternion in self._quaternions:
            norm = np.linalg.norm(q[at] + quaternion.reference)
            p = moved[at] + quaternion.reference
            moved[at] = p * (norm / np.linalg.norm(p)) - quaternion.reference
        return moved

    def terms(self, value_at: Callable[[float, Array], Array], t: float, q: Array, v: Array) -> JointTerms:
        """The joints at (t, q, v); the Jacobian is up to date.

        Args:
            value_at: (t, q) -> c (m,); its second difference along the motion is -gamma, Eq. (27).
        """
        value = value_at(t, q)
        if not (self.follows_time or v.any()):
            return JointTerms(value, np.zeros(self.number), np.zeros(self.number))
        step = STEP / max(1.0, float(np.abs(v).max()))
        after, before = (value_at(t + s, self._moved(q, v, s)) for s in (step, -step))
        gamma = (2.0 * value - after - before) / step**2
        gamma[len(self.names) - len(self._quaternions) :] = [
            -2.0 * np.dot(v[at], v[at]) for at, _ in self._quaternions
        ]
        drift = np.zeros(self.number)
        if self.follows_time:
            drift = (value_at(t + STEP, q) - value_at(t - STEP, q)) / (2.0 * STEP)
        return JointTerms(value, drift, gamma)
