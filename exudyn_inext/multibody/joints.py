"""The solve of all rows of joints among cables and bodies.

With A the saddle-point matrices of all parts, side by side, and J the Jacobian of the joints,

    [A J^T; J 0] [y; nu] = [f; b]:    S nu = J A^-1 f - b,  S = J A^-1 J^T,  y = A^-1 f - A^-1 J^T nu.

Where three or more parts meet in a knot (see `knots`), the place u of the knot is the unknown, in place of
the forces of its joints. With what a part holds split into k at knots and r in other rows, C = J A^-1 J^T of
that part, and phi the forces on its knots,

    phi = W (J_k y_0 - o - u - C_kr nu),  W = (C_kk + e I)^-1,  sum of phi over a knot = 0,

so that each part adds [-W, W C_kr; C_rk W, C_rr - C_rk W C_kr] to the matrix of (-u, nu): what the sweep of C
over k gives. o is what the joints ask of the points of a knot. C_kk of a straight cable is singular, since
its ends cannot come apart; so knots yield a little, by e. Of cables with many joints the nodes are unknowns,
too, see `nodes`.

An entry is what a row has of one cable or body: its part of J, and A^-1 J^T there. What the solve holds of
a part are entries of rows, and of knots, by one row that has the same Jacobian. Those of one part follow each
other, those of cables first, and in each part those at knots first.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import called_kernel, inlined
from ..sparse_factor import SparseFactor, eliminate_column, substitute
from .bodies import respond_body
from .nodes import (
    Nodes,
    add_nodes,
    add_rates_of_nodes,
    correct_nodes,
)
from .rows import add_row_jacobian, row_gamma, row_value

NONE = -1
PIVOT_TOLERANCE = 1e-10  # of a pivot of a row, relative to its diagonal entry
YIELD = 1e-8  # of a knot, relative to the mean of its compliances, until a second pass


class Entries(NamedTuple):
    """E entries of J.

    first, width: (E,) where an entry begins in `jacobian` and `response`, and how long it is.
    row: (E,).   dof: (E,) first coordinate of its part.   begin, stop: (E,) outside of which it is zero.
    jacobian, response: J and A^-1 J^T, one after the other; the latter where the solve holds it.
    """

    first: np.ndarray
    width: np.ndarray
    row: np.ndarray
    dof: np.ndarray
    begin: np.ndarray
    stop: np.ndarray
    jacobian: Array
    response: Array


class Holds(NamedTuple):
    """H of them, of P parts.

    entry: (H,).   sign: (H,) 1, or -1 for the opposite of the entry.   place: (H,) of its unknown, or NONE.
    member: (H,) of a knot, or NONE.   body: (H,) whose entry it is, or NONE on a cable.
    end: (P,) after the holds of each part.   at_knots: (P,) how many of them.
    square: (P,) where the part's square begins in `local` and `into`.
    local: C of each part, swept.   into: where its lower half goes in the factor, or NONE.
    rate, force: (H,) J y and phi of a solve.
    on_cables: number of holds on cables.
    """

    entry: np.ndarray
    sign: Array
    place: np.ndarray
    member: np.ndarray
    body: np.ndarray
    end: np.ndarray
    at_knots: np.ndarray
    square: np.ndarray
    local: Array
    into: np.ndarray
    rate: Array
    force: Array
    on_cables: int


class Members(NamedTuple):
    """Those of all knots, see `knots.Member`.   offset, force: o, and what a branch pulls with, then."""

    hold: np.ndarray
    row: np.ndarray
    sign: Array
    parent: np.ndarray
    offset: Array
    force: Array


class Joints(NamedTuple):
    """m rows.

    rows: (m,) records.   holding: number of those of joints, which come first; those of dashpots yield.
    place: (m,) of their multipliers among the unknowns, or NONE: of a knot.
    nodes: of cables with many rows.
    factor: of S.   is_row: (n,) whether an unknown is a multiplier.   diagonal: (n,) of S.
    value, gamma, multipliers: (m,) c, see `rows.row_gamma`, nu; gamma of dashpots: J v, as predicted, with
        accelerations zero where springs are stiff.
    foreseen: (m,) nu of the step before, by which joints pull until they are solved for.
    drift_correction: (m,) see `CoupledSystem`.
    rate, target: (m,) c_t, and memory of a solve.   unknowns, solved: (n,), (m,) memory.
    dependent: (1,) a row that is not independent of the others, or NONE.
    """

    rows: Any
    holding: int
    entries: Entries
    holds: Holds
    members: Members
    nodes: Nodes
    place: np.ndarray
    factor: SparseFactor
    is_row: np.ndarray
    diagonal: Array
    value: Array
    gamma: Array
    multipliers: Array
    foreseen: Array
    drift_correction: Array
    rate: Array
    target: Array
    unknowns: Array
    solved: Array
    dependent: np.ndarray


@inlined
def set_values(joints, points):
    """c of all rows; the points are placed."""
    rows = joints.rows
    for r in range(len(rows)):
        row = rows[r]
        joints.value[r] = row_value(row, points[row.points[0]], points[row.points[1]])


@inlined
def largest_value(joints, worst):
    """Largest |c|, or that number if it is larger; keeps a NaN."""
    for r in range(len(joints.value)):
        if not abs(joints.value[r]) <= worst:
            worst = abs(joints.value[r])
    return worst


@inlined
def set_jacobian(joints, points):
    """J and gamma of all rows, after `set_values`; the points are placed and move."""
    rows, entries = joints.rows, joints.entries
    for e in range(len(entries.first)):
        for i in range(entries.first[e] + entries.begin[e], entries.first[e] + entries.stop[e]):
            entries.jacobian[i] = 0.0
    for r in range(len(rows)):
        row = rows[r]
        joints.gamma[r] = row_gamma(row, points[row.points[0]], points[row.points[1]])
        for side in range(2):
            if row.entry[side] >= 0:
                point, entry = points[row.points[side]], row.entry[side]
                start = entries.first[entry] + point.first - entries.dof[entry]
                add_row_jacobian(row, side, point, entries.jacobian, start)


@inlined
def respond_with_bodies(joints, bodies):
    """A^-1 J^T of all that the solve holds of bodies."""
    entries, holds = joints.entries, joints.holds
    for h in range(holds.on_cables, len(holds.entry)):
        e = holds.entry[h]
        first, end = entries.first[e], entries.first[e] + entries.width[e]
        respond_body(bodies[holds.body[h]], entries.jacobian[first:end], entries.response[first:end])


@inlined
def _set_compliance(entries, holds, begin, end, local):
    """C of one part, its lower half."""
    for g in range(begin, end):
        one = holds.entry[g]
        for h in range(begin, g + 1):
            response, total = entries.first[holds.entry[h]], 0.0
            for i in range(entries.begin[one], entries.stop[one]):
                total += entries.jacobian[entries.first[one] + i] * entries.response[response + i]
            local[g - begin, h - begin] = total * holds.sign[g] * holds.sign[h]


@inlined
def _let_yield(local, knots):
    """The first unknowns yield.   local: its lower half is set; output: both."""
    mean = 0.0
    for i in range(len(local)):
        for j in range(i):
            local[j, i] = local[i, j]
    for k in range(knots):
        mean += local[k, k] / knots
    for k in range(knots):
        local[k, k] += YIELD * mean


@inlined
def _sweep(local, knots):
    """The sweep over the first unknowns.

    J. H. Goodnight, A Tutorial on the SWEEP Operator, The American Statistician 33 (1979) 149-158.
    """
    size = len(local)
    for k in range(knots):
        inverse = 1.0 / local[k, k]
        for i in range(size):
            multiple = local[i, k] * inverse
            if i != k:
                for j in range(size):
                    if j != k:
                        local[i, j] -= multiple * local[k, j]
        for i in range(size):
            local[i, k] *= inverse
            local[k, i] = local[i, k]
        local[k, k] = -inverse


@inlined
def _set_matrix(joints):
    """S, part by part."""
    holds, values, begin = joints.holds, joints.factor.values, 0
    for i in range(len(values)):
        values[i] = 0.0
    for p in range(len(holds.end)):
        size, first = holds.end[p] - begin, holds.square[p]
        local = holds.local[first : first + size * size].reshape((size, size))
        _set_compliance(joints.entries, holds, begin, holds.end[p], local)
        if holds.at_knots[p] > 0:
            _let_yield(local, holds.at_knots[p])
            _sweep(local, holds.at_knots[p])
        for i in range(size):
            for j in range(i + 1):
                into = holds.into[first + i * size + j]
                if into >= 0:
                    values[into] += local[i, j]
        begin = holds.end[p]


@inlined
def factorise_joints(joints):
    """S and its factor; the responses are set."""
    _set_matrix(joints)
    factor, dependent = joints.factor, NONE
    for j in range(len(joints.diagonal)):
        joints.diagonal[j] = factor.values[factor.start[j]]
    add_nodes(joints.nodes, joints.entries, joints.place, factor.values, joints.diagonal)
    for r in range(joints.holding, len(joints.rows)):
        place = joints.place[r]
        factor.values[factor.start[place]] += joints.rows[r].softness
        joints.diagonal[place] += joints.rows[r].softness
    for j in range(len(joints.diagonal)):
        pivot = factor.values[factor.start[j]]
        if joints.is_row[j]:
            if not pivot > PIVOT_TOLERANCE * joints.diagonal[j] and dependent == NONE:
                dependent = j
        elif not pivot < 0.0 and dependent == NONE:
            dependent = j
        if dependent != NONE:
            factor.values[factor.start[j]] = np.nan
        eliminate_column(factor, j)
    joints.dependent[0] = dependent


@inlined
def set_rates(joints, v):
    """c_t = J v - o_t of all rows.   v: (n,)."""
    for r in range(len(joints.rate)):
        joints.rate[r] = -joints.rows[r].drift
    _add_rates(joints, 0, v, joints.rate)


@inlined
def predict_rates_of_dashpots(joints, predicted):
    """J times these velocities (n,) into gamma of dashpots, where it is zero."""
    if joints.holding < len(joints.rows):
        _add_rates(joints, joints.holding, predicted, joints.gamma)


@inlined
def _add_rates(joints, begin, v, rates):
    """rates += J v of the rows from number `begin` on.   rates: (m,)."""
    entries = joints.entries
    for e in range(len(entries.first)):
        if entries.row[e] >= begin:
            first, dof = entries.first[e], entries.dof[e]
            for i in range(entries.begin[e], entries.stop[e]):
                rates[entries.row[e]] += entries.jacobian[first + i] * v[dof + i]


@inlined
def _set_held_rates(joints, x):
    """J x of all holds, less what the joints ask of the points of knots."""
    entries, holds, members = joints.entries, joints.holds, joints.members
    for m in range(len(members.row)):
        parent, row = members.parent[m], members.row[m]
        offset = members.offset[parent] if parent >= 0 else 0.0
        if row >= 0:
            offset += members.sign[m] * joints.target[row]
        members.offset[m] = offset
    for h in range(len(holds.entry)):
        e, total = holds.entry[h], 0.0
        first, dof = entries.first[e], entries.dof[e]
        for i in range(entries.begin[e], entries.stop[e]):
            total += entries.jacobian[first + i] * x[dof + i]
        holds.rate[h] = holds.sign[h] * total
        if holds.member[h] >= 0:
            holds.rate[h] -= members.offset[holds.member[h]]


@inlined
def _add_knots(holds, begin, end, local, knots, x):
    """What one part with knots adds to the right-hand side."""
    for h in range(begin, end):
        place, total = holds.place[h], 0.0
        for k in range(knots):
            total -= local[h - begin, k] * holds.rate[begin + k]
        if h - begin >= knots:
            x[place] += holds.rate[h] + total
        else:
            holds.force[h] = total
            if place >= 0:
                x[place] += total


@inlined
def _set_forces_on_knots(holds, begin, end, local, knots, x):
    """Of one part, after the solve."""
    for h in range(begin, begin + knots):
        for g in range(begin, end):
            if holds.place[g] >= 0:
                holds.force[h] -= local[h - begin, g - begin] * x[holds.place[g]]


@inlined
def _branch_forces(joints):
    """Multipliers of the joints of knots; at a root the force is what is left."""
    holds, members = joints.holds, joints.members
    for m in range(len(members.row)):
        members.force[m] = holds.force[members.hold[m]]
    for m in range(len(members.row) - 1, -1, -1):
        if members.parent[m] >= 0:
            members.force[members.parent[m]] += members.force[m]
        if members.row[m] >= 0:
            joints.solved[members.row[m]] += members.sign[m] * members.force[m]
        else:
            holds.force[members.hold[m]] -= members.force[m]


@inlined
def _set_right_hand_side(joints, x):
    """Of all unknowns, from what the solve holds of the parts.   x: (n,) without joints."""
    holds, unknowns, begin = joints.holds, joints.unknowns, 0
    for j in range(len(unknowns)):
        unknowns[j] = 0.0
    for r in range(len(joints.place)):
        if joints.place[r] >= 0:
            unknowns[joints.place[r]] = -joints.target[r] - joints.rows[r].softness * joints.solved[r]
    for p in range(len(holds.end)):
        end, knots = holds.end[p], holds.at_knots[p]
        if knots > 0:
            size, first = end - begin, holds.square[p]
            local = holds.local[first : first + size * size].reshape((size, size))
            _add_knots(holds, begin, end, local, knots, unknowns)
        else:
            for h in range(begin, end):
                unknowns[holds.place[h]] += holds.rate[h]
        begin = end
    add_rates_of_nodes(joints.nodes, joints.entries, joints.place, x, unknowns)


@inlined
def _set_forces(joints):
    """phi of all holds, and nu added to `solved`."""
    holds, unknowns, begin = joints.holds, joints.unknowns, 0
    for p in range(len(holds.end)):
        end, knots = holds.end[p], holds.at_knots[p]
        if knots > 0:
            size, first = end - begin, holds.square[p]
            local = holds.local[first : first + size * size].reshape((size, size))
            _set_forces_on_knots(holds, begin, end, local, knots, unknowns)
        for h in range(begin + knots, end):
            holds.force[h] = unknowns[holds.place[h]]
        begin = end
    for r in range(len(joints.place)):
        if joints.place[r] >= 0:
            joints.solved[r] += unknowns[joints.place[r]]
    _branch_forces(joints)


@called_kernel
def apply_joints(joints, x, refines):
    """x -= A^-1 J^T nu, such that J x is the target, or more by softness nu; nu is left in `solved`.

    Args:
        x: (n,).   refines: whether a second pass makes up for knots that yield.
    """
    entries, holds = joints.entries, joints.holds
    for r in range(len(joints.solved)):
        joints.solved[r] = 0.0
    for _ in range(2 if refines and len(joints.members.row) > 0 else 1):
        _set_held_rates(joints, x)
        _set_right_hand_side(joints, x)
        substitute(joints.factor, joints.unknowns)
        _set_forces(joints)
        for h in range(len(holds.entry)):
            e, force = holds.entry[h], holds.sign[h] * holds.force[h]
            first, dof, width = entries.first[e], entries.dof[e], entries.width[e]
            part, response = x[dof : dof + width], entries.response[first : first + width]
            for i in range(len(part)):
                part[i] -= response[i] * force
        correct_nodes(joints.nodes, joints.unknowns, x)


@inlined
def power_of_offsets(joints):
    """What joints that move do [W], by the multipliers of the last evaluation."""
    power = 0.0
    for r in range(len(joints.rows)):
        power -= joints.multipliers[r] * joints.rows[r].drift
    return power


@inlined
def keep_multipliers(joints):
    """Those of the solve just made."""
    for r in range(len(joints.multipliers)):
        joints.multipliers[r] = joints.solved[r]


@inlined
def foresee_forces(joints, x):
    """x -= J^T nu of joints as foreseen; the next solve finds what is missing.   x: (n,)."""
    _add_forces(joints, -1.0, joints.foreseen, 0, joints.holding, x)


@inlined
def take_back_foreseen(joints, x):
    """After that solve: nu are those of both, and foreseen for the next step; x is without them."""
    _add_forces(joints, 1.0, joints.foreseen, 0, joints.holding, x)
    for r in range(joints.holding):
        joints.multipliers[r] += joints.foreseen[r]
        joints.foreseen[r] = joints.multipliers[r]


@inlined
def subtract_forces(joints, x):
    """x -= J^T nu of joints.   x: (n,)."""
    _add_forces(joints, -1.0, joints.multipliers, 0, joints.holding, x)


@inlined
def subtract_forces_of_dashpots(joints, x):
    """x -= J^T nu of dashpots.   x: (n,)."""
    if joints.holding < len(joints.rows):
        _add_forces(joints, -1.0, joints.multipliers, joints.holding, len(joints.rows), x)


@inlined
def _add_forces(joints, sign, multipliers, begin, end, x):
    """x += sign J^T nu of the rows from `begin` to `end`."""
    entries = joints.entries
    for e in range(len(entries.first)):
        if begin <= entries.row[e] < end:
            force, first, dof = sign * multipliers[entries.row[e]], entries.first[e], entries.dof[e]
            for i in range(entries.begin[e], entries.stop[e]):
                x[dof + i] += entries.jacobian[first + i] * force
