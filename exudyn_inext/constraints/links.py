"""Links of one kind as a constraint: formulas of `cable.link` in plain numpy."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from ..arrays import Array
from ..cable.link import Link


@dataclass(frozen=True, eq=False)
class LinkConstraint:
    """c = n . u + (u . u - L^2) / (2 L) with u = sum of weighted nodal vectors - p(t), one row a link.

    name: what the kind is called.   links: of this kind.
    """

    name: str
    links: tuple[Link, ...]

    @property
    def number(self) -> int:
        return len(self.links)

    @staticmethod
    def _direction(link: Link, q: Array, t: float) -> tuple[Array, Array]:
        """u and dc/du, both (dim,)."""
        u = np.einsum("kw,kwi->i", link.weights, q[list(link.nodes)]) - link.anchor.at(t)[0]
        return u, link.normal + u / link.length

    @staticmethod
    def _speed(link: Link, v: Array, t: float) -> Array:
        """u_t (dim,)."""
        u_t: Array = np.einsum("kw,kwi->i", link.weights, v[list(link.nodes)]) - link.anchor.at(t)[1]
        return u_t

    def value(self, q: Array, t: float = 0.0) -> Array:
        values = []
        for link in self.links:
            u, _ = self._direction(link, q, t)
            rod = (u @ u - link.length**2) / (2 * link.length) if np.isfinite(link.length) else 0.0
            values.append(link.normal @ u + rod)
        return np.array(values)

    def rate(self, q: Array, v: Array, t: float = 0.0) -> Array:
        return np.array([self._direction(link, q, t)[1] @ self._speed(link, v, t) for link in self.links])

    def jacobian(self, q: Array, t: float = 0.0) -> csr_array:
        rows = np.zeros((self.number, *q.shape))
        for row, link in zip(rows, self.links, strict=True):
            _, direction = self._direction(link, q, t)
            row[list(link.nodes)] = np.multiply.outer(link.weights, direction)
        return csr_array(rows.reshape(self.number, q.size))

    def gamma(self, q: Array, v: Array, t: float = 0.0) -> Array:
        values = []
        for link in self.links:
            _, direction = self._direction(link, q, t)
            u_t = self._speed(link, v, t)
            values.append(direction @ link.anchor.at(t)[2] - u_t @ u_t / link.length)
        return np.array(values)

    def hessian(self, multipliers: Array, shape: tuple[int, ...]) -> csr_array:
        nodes, dim = shape[0], shape[2]
        total = csr_array((2 * nodes, 2 * nodes))
        for link, multiplier in zip(self.links, multipliers, strict=True):
            weights = np.zeros((nodes, 2))
            weights[list(link.nodes)] = link.weights
            column = csr_array(weights.reshape(-1, 1))
            total = total + multiplier / link.length * (column @ column.T)
        return csr_array(kron(total, eye_array(dim)))

    def describe(self, row: int, node_names: Sequence[Any]) -> str:
        link = self.links[row]
        nodes = " and ".join(str(node_names[node]) for node in link.nodes)
        kind = ("position", "slope")[int(np.argmax(np.abs(link.weights[0])))]
        axes = "".join("xyz"[i] for i in np.flatnonzero(link.normal)) if link.normal.any() else "distance"
        same = sum(other.nodes == link.nodes for other in self.links[:row])
        return f"{kind} {axes} of node {nodes} (row {same} there)"


def of_kind(links: tuple[Link, ...], kind: str) -> LinkConstraint:
    """The links of that kind as a constraint of its name."""
    return LinkConstraint(kind, tuple(link for link in links if link.kind == kind))
