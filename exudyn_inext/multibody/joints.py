"""The solve of all rows of joints among cables and bodies: S = J A^-1 J^T as a band, as in `scene.joints`.

An entry is what a row holds of one cable or body: its part of J, and A^-1 J^T there. Entries of one cable or
body follow each other, those of cables first.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from ..scene.joints import PIVOT_TOLERANCE
from .bodies import respond_body
from .rows import add_row_jacobian, row_gamma, row_value

NONE = -1


class Joints(NamedTuple):
    """m rows with E entries.

    rows: (m,) records.   first, width: (E,) where an entry begins in `jacobian` and `response`, and how long
        it is.   row: (E,) of an entry.   dof: (E,) its first coordinate.   begin, stop: (E,) outside of which
        its Jacobian is zero.   body: (E,) its number, or NONE on a cable.   end: after the entries of each
        cable or body.   on_cables: number of entries on cables.
    place: (m,) of the rows in the band.
    jacobian, response: J and A^-1 J^T, entry by entry.
    schur, factor: (m, width) S[place + k, place] and its Cholesky factor.
    value, gamma, multipliers: (m,) c, see `rows.row_gamma`, nu.   foresight: (m,) see `CoupledSystem`.
    rate, target, sorted: (m,) J v, and memory of a solve.
    dependent: (1,) the place of a row that is not independent of the others, or NONE.
    """

    rows: Any
    first: np.ndarray
    width: np.ndarray
    row: np.ndarray
    dof: np.ndarray
    begin: np.ndarray
    stop: np.ndarray
    body: np.ndarray
    end: np.ndarray
    on_cables: int
    place: np.ndarray
    jacobian: Array
    response: Array
    schur: Array
    factor: Array
    value: Array
    gamma: Array
    multipliers: Array
    foresight: Array
    rate: Array
    target: Array
    sorted: Array
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
    rows = joints.rows
    for e in range(len(joints.first)):
        for i in range(joints.first[e] + joints.begin[e], joints.first[e] + joints.stop[e]):
            joints.jacobian[i] = 0.0
    for r in range(len(rows)):
        row = rows[r]
        joints.gamma[r] = row_gamma(row, points[row.points[0]], points[row.points[1]])
        for side in range(2):
            if row.entry[side] >= 0:
                point, entry = points[row.points[side]], row.entry[side]
                start = joints.first[entry] + point.first - joints.dof[entry]
                add_row_jacobian(row, side, point, joints.jacobian, start)


@inlined
def respond_with_bodies(joints, bodies):
    """A^-1 J^T of all entries on bodies."""
    for e in range(joints.on_cables, len(joints.first)):
        first = joints.first[e]
        end = first + joints.width[e]
        respond_body(bodies[joints.body[e]], joints.jacobian[first:end], joints.response[first:end])


@inlined
def factorise_joints(joints):
    """S and its factor; the responses are set."""
    _set_schur(joints)
    schur, factor = joints.schur, joints.factor
    size, width = schur.shape
    joints.dependent[0] = NONE
    for j in range(size):
        most = min(width, size - j)
        for d in range(most):
            factor[j, d] = schur[j, d]
        for k in range(max(0, j - width + 1), j):
            share = factor[k, j - k]
            for d in range(min(width - (j - k), size - j)):
                factor[j, d] -= share * factor[k, j - k + d]
        if not factor[j, 0] > PIVOT_TOLERANCE * schur[j, 0]:
            if joints.dependent[0] == NONE:
                joints.dependent[0] = j
            factor[j, 0] = np.nan
        pivot = np.sqrt(factor[j, 0])
        factor[j, 0] = pivot
        for d in range(1, most):
            factor[j, d] /= pivot


@inlined
def _set_schur(joints):
    schur, start = joints.schur, 0
    for j in range(schur.shape[0]):
        for d in range(schur.shape[1]):
            schur[j, d] = 0.0
    for end in joints.end:
        for e in range(start, end):
            place = joints.place[joints.row[e]]
            for f in range(start, end):
                other = joints.place[joints.row[f]]
                if other <= place:
                    total = 0.0
                    for i in range(joints.begin[e], joints.stop[e]):
                        total += joints.jacobian[joints.first[e] + i] * joints.response[joints.first[f] + i]
                    schur[other, place - other] += total
        start = end


@inlined
def set_rates(joints, v):
    """J v of all rows.   v: (n,)."""
    for r in range(len(joints.rate)):
        joints.rate[r] = 0.0
    for e in range(len(joints.first)):
        first, dof = joints.first[e], joints.dof[e]
        for i in range(joints.begin[e], joints.stop[e]):
            joints.rate[joints.row[e]] += joints.jacobian[first + i] * v[dof + i]


@inlined
def apply_joints(joints, x):
    """x -= A^-1 J^T nu, such that J x is the target; nu is left in `sorted`.   x: (n,)."""
    nu = joints.sorted
    for r in range(len(nu)):
        nu[joints.place[r]] = -joints.target[r]
    for e in range(len(joints.first)):
        total, first, dof = 0.0, joints.first[e], joints.dof[e]
        for i in range(joints.begin[e], joints.stop[e]):
            total += joints.jacobian[first + i] * x[dof + i]
        nu[joints.place[joints.row[e]]] += total
    _substitute(joints.factor, nu)
    for e in range(len(joints.first)):
        force, first, dof = nu[joints.place[joints.row[e]]], joints.first[e], joints.dof[e]
        for i in range(joints.width[e]):
            x[dof + i] -= joints.response[first + i] * force


@inlined
def keep_multipliers(joints):
    """Those of the solve just made."""
    for r in range(len(joints.multipliers)):
        joints.multipliers[r] = joints.sorted[joints.place[r]]


@inlined
def subtract_forces(joints, x):
    """x -= J^T nu.   x: (n,)."""
    for e in range(len(joints.first)):
        force, first, dof = joints.multipliers[joints.row[e]], joints.first[e], joints.dof[e]
        for i in range(joints.begin[e], joints.stop[e]):
            x[dof + i] -= joints.jacobian[first + i] * force


def effect_of_joints(joints: Joints, size: int) -> Array:
    """(size,) what joints took off the accelerations at the last evaluation."""
    result = np.zeros(size)
    for e, (first, width, dof) in enumerate(zip(joints.first, joints.width, joints.dof, strict=True)):
        nu = joints.multipliers[joints.row[e]]
        result[dof : dof + width] += joints.response[first : first + width] * nu
    return result


@inlined
def _substitute(factor, x):
    """x = S^-1 x, in the order of the band."""
    size, width = factor.shape
    for j in range(size):
        x[j] /= factor[j, 0]
        for d in range(1, min(width, size - j)):
            x[j + d] -= factor[j, d] * x[j]
    for j in range(size - 1, -1, -1):
        for d in range(1, min(width, size - j)):
            x[j] -= factor[j, d] * x[j + d]
        x[j] /= factor[j, 0]
