"""What happens in a run, from Exudyn's outputs and textbook formulas alone."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import exudyn
import numpy as np

_OUTPUT = exudyn.OutputVariableType
_GAUSS = np.polynomial.legendre.leggauss(6)


@dataclass
class History:
    """All steps of a run.

    t: (n,).   cables: (q, v), each (n, nodes, 2, dim), of every cable.
    bodies: position (n, 3), rotation (n, 3, 3), velocity (n, 3), spin (n, 3, global) of every body.
    """

    t: list = field(default_factory=list)
    cables: list = field(default_factory=list)
    bodies: list = field(default_factory=list)

    def stacked(self):
        self.t = np.array(self.t)
        self.cables = [tuple(map(np.array, zip(*c, strict=True))) for c in zip(*self.cables, strict=True)]
        rows = [tuple(map(np.array, zip(*b, strict=True))) for b in zip(*self.bodies, strict=True)]
        names = ("position", "rotation", "velocity", "spin")
        self.bodies = [SimpleNamespace(**dict(zip(names, row, strict=True))) for row in rows]
        return self


def record(mbs, scene):
    """Assemble; returns a History that fills while mbs is solved."""
    history = History()

    def store(mbs, t):
        history.t.append(t)
        history.cables.append([cable_state(mbs, cable["nodes"]) for cable in scene["cables"]])
        history.bodies.append([body_state(mbs, body) for body in scene.get("bodies", ())])
        return True

    mbs.SetPostStepUserFunction(store)  # Exudyn calls it at the start, too
    mbs.Assemble()
    return history


def cable_state(mbs, nodes):
    """q, v (nodes, 2, dim)."""
    total = [mbs.GetNodeOutput(n, _OUTPUT.CoordinatesTotal) for n in nodes]
    rates = [mbs.GetNodeOutput(n, _OUTPUT.Coordinates_t) for n in nodes]
    return np.reshape(total, (len(nodes), 2, -1)), np.reshape(rates, (len(nodes), 2, -1))


def body_state(mbs, body):
    kinds = (_OUTPUT.Position, _OUTPUT.RotationMatrix, _OUTPUT.Velocity, _OUTPUT.AngularVelocity)
    position, rotation, velocity, spin = (
        np.array(mbs.GetObjectOutputBody(body, kind, [0, 0, 0])) for kind in kinds
    )
    return position, rotation.reshape(3, 3), velocity, spin


def hermite(length):
    """(4, p) S, S_x, S_xx and (p,) weights at Gauss points of an element with nodes r, r_x."""
    x, w = 0.5 * (1 + _GAUSS[0]), 0.5 * length * _GAUSS[1]
    one, a = np.ones_like(x), length
    s = [1 - 3 * x**2 + 2 * x**3, a * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, a * (x**3 - x**2)]
    s_xx = [(12 * x - 6) / a**2, (6 * x - 4) / a, (6 - 12 * x) / a**2, (6 * x - 2) / a]
    return np.array(s) * one, np.array(s_xx), w


def _of_elements(q):
    """(n, elements, 4, dim)."""
    return np.concatenate([q[:, :-1], q[:, 1:]], axis=2)


def cable_energy(q, v, length, section, gravity):
    """(n,) kinetic, bending and gravity energy [J] of a cable of equal elements (secondDerivative)."""
    element = length / (q.shape[1] - 1)
    s, s_xx, w = hermite(element)
    r, speed, curvature = (
        np.einsum("nekd,kp->nepd", _of_elements(x), f) for x, f in ((q, s), (v, s), (q, s_xx))
    )
    rho = section.massPerLength
    kinetic = 0.5 * rho * np.einsum("nepd,p->n", speed**2, w)
    bending = 0.5 * section.bendingStiffness * np.einsum("nepd,p->n", curvature**2, w)
    return kinetic, bending, -rho * np.einsum("nepd,d,p->n", r, np.array(gravity)[: q.shape[3]], w)


def cable_momentum(q, v, length, section, about=(0, 0, 0)):
    """(n, 3) linear and angular momentum [kg m/s, kg m^2/s]."""
    s, _, w = hermite(length / (q.shape[1] - 1))
    r, speed = (np.einsum("nekd,kp->nepd", _of_elements(x), s) for x in (q, v))
    pad = [(0, 0)] * 3 + [(0, 3 - q.shape[3])]
    r, speed = np.pad(r, pad) - np.array(about), np.pad(speed, pad)
    linear, angular = (np.einsum("nepd,p->nd", x, w) for x in (speed, np.cross(r, speed)))
    return section.massPerLength * linear, section.massPerLength * angular


def body_energy(body, inertia, gravity):
    """(n,) kinetic and gravity energy [J]; reference point in the centre of mass."""
    kinetic = 0.5 * inertia.mass * np.einsum("nd,nd->n", body.velocity, body.velocity)
    kinetic += 0.5 * np.einsum("nd,nd->n", body.spin, spin_momentum(body, inertia))
    return kinetic, -inertia.mass * body.position @ np.array(gravity, dtype=float)


def spin_momentum(body, inertia):
    """(n, 3) A J A^T w."""
    tensor = np.einsum("nij,jk,nlk->nil", body.rotation, inertia.InertiaCOM(), body.rotation)
    return np.einsum("nij,nj->ni", tensor, body.spin)


def gaps(run):
    """Largest violation [m] of each joint, knot (two nodes), and rod (anchor, node), over all steps."""
    scene, history = run
    worst = []
    for body, point, node in scene.get("joints", ()):
        state = history.bodies[scene["bodies"].index(body)]
        on_body = state.position + state.rotation @ np.array(point, dtype=float)
        on_cable = node_path(run, node)
        worst.append(np.linalg.norm(on_body[:, : on_cable.shape[1]] - on_cable, axis=1))
    for one, other in scene.get("knots", ()):
        worst.append(np.linalg.norm(node_path(run, one) - node_path(run, other), axis=1))
    for anchor, node in scene.get("rods", ()):
        length = np.linalg.norm(node_path(run, node) - anchor, axis=1)
        worst.append(np.abs(length - length[0]))
    return [gap.max() for gap in worst]


def node_path(run, node):
    """(n, dim) position of a node of a cable."""
    scene, history = run
    for cable, (q, _) in zip(scene["cables"], history.cables, strict=True):
        if node in cable["nodes"]:
            return q[:, cable["nodes"].index(node), 0]
    raise AssertionError(f"node {node} is on no cable")


def total_energy(run, cables, inertias, gravity):
    """(n,) kinetic and (n,) total energy [J].

    cables: (length, section) of each cable.   inertias: of each body.
    """
    _, history = run
    of_cables = [
        cable_energy(q, v, length, section, gravity)
        for (q, v), (length, section) in zip(history.cables, cables, strict=True)
    ]
    of_bodies = [body_energy(b, i, gravity) for b, i in zip(history.bodies, inertias, strict=True)]
    kinetic = sum(parts[0] for parts in of_cables + of_bodies)
    return kinetic, kinetic + sum(sum(parts[1:]) for parts in of_cables + of_bodies)


def integral(t, rate):
    """(n, ...) over time, by the trapezoidal rule."""
    rate = np.asarray(rate, dtype=float)
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(t).reshape(-1, *[1] * (rate.ndim - 1))
    return np.concatenate([np.zeros_like(rate[:1]), np.cumsum(steps, axis=0)])
