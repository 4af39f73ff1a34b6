"""Kinetic energy of a cable, and the power of what is no energy of it: damping, drag, moving links."""

from ..compiled import inlined
from ..element.bending_damping import curvature_power
from ..lowered import local_array
from .assembly import add_damping, add_drag, differences, lag_of, lags

LOSS = 1  # column of the nodes' forces that is zero between two evaluations, and has to be


@inlined
def kinetic_energy(axes, nodes, elements, v):
    """v . M v / 2 with the mass of the chain, scaled or not [J].   v: (n, 2, dim) [m/s, 1/s]."""
    twice = 0.0
    for k in range(len(nodes)):
        m = nodes[k].mass
        for i in range(len(axes)):
            r, s = v[k, 0, i], v[k, 1, i]
            twice += m[0] * r * r + 2.0 * m[1] * r * s + m[2] * s * s
    for k in range(len(elements)):
        m = elements[k].mass
        for i in range(len(axes)):
            r, s = v[k, 0, i], v[k, 1, i]
            r_next, s_next = v[k + 1, 0, i], v[k + 1, 1, i]
            twice += 2.0 * (r * (m[0] * r_next + m[1] * s_next) + s * (m[2] * r_next + m[3] * s_next))
    return 0.5 * twice


@inlined
def lagging_energy(axes, elements, v):
    """What the implicit damping in the mass adds to `kinetic_energy`, and is none: v . lag D_c v / 2 [J]."""
    if not lags(elements):
        return 0.0
    twice = 0.0
    e_t, memory = local_array(3, 3), local_array(7, 3)
    for k in range(len(elements)):
        differences(axes, v, k, e_t)
        twice += curvature_power(axes, elements[k].damping, e_t, memory)
    return 0.5 * lag_of(elements) * twice


@inlined
def dissipative_power(axes, nodes, elements, q, v):
    """Power of bending damping and drag [W]; flowing air may do work.   q, v: (n, 2, dim)."""
    if not (elements[0].damped or elements[0].dragged):
        return 0.0
    add_damping(axes, nodes, elements, q, v, 0.0, v, LOSS)
    add_drag(axes, nodes, elements, q, v, 0.0, v, LOSS)
    power = 0.0
    for k in range(len(nodes)):
        for i in range(len(axes)):
            power += nodes[k].force[LOSS, 0, i] * v[k, 0, i] + nodes[k].force[LOSS, 1, i] * v[k, 1, i]
            nodes[k].force[LOSS, 0, i] = 0.0
            nodes[k].force[LOSS, 1, i] = 0.0
    return power


@inlined
def power_of_motions(axes, links, motions):
    """lam c_t of links whose anchors move [W].   motions: (M, 3, dim) p, p_t, p_tt."""
    power = 0.0
    for r in range(len(links)):
        link = links[r]
        for i in range(len(axes)):
            direction = link.normal[i] + link.offset[i] * link.inverse_length
            power -= link.multiplier[0] * direction * motions[link.motion, 1, i]
    return power
