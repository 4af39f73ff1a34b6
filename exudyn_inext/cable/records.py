"""Memory layout of a chain: one record a node, one record an element.

A record holds the constant coefficients of a node or element and the memory for its share of a solve,
side by side in memory. All shapes are part of the type, hence known when compiling.
"""

from functools import lru_cache

import numpy as np

from ..arrays import record_type

NUMBER = np.float64
AXIAL_SIZE = 13  # coefficients of `axial_stiffness`


@lru_cache
def node_type(dim: int, axial: bool = False) -> np.dtype:
    """Record of a node in `dim` dimensions.

    mass: r-r, r-s, s-s mass of the node with itself; supports replaced by unity [kg, kg m, kg m^2].
    free: 1.0 where position or slope moves, 0.0 where a support holds it.
    ends_group: whether a length constraint ends at this node.
    slope: r_x of the configuration [-].
    basis: orthonormal vectors transverse to the slope, as columns; all directions with axial stiffness.
    axial: axial stiffness and force, see `axial`, empty without them.
    force: right-hand sides on position and slope [N, Nm], one for each column of Eq. (29).
    constraint: value [-], rate [1/s], gamma [1/s^2] of the nodal constraint (18).
    target: right-hand sides of the nodal constraint, one for each column.
    drift_correction: what the constraint's acceleration lacked in the last step of a position-level scheme.
    along: known increments along the slope, one for each column.
    lower, inverse_pivot: unit lower L, row by row, and inverse of D of the node's diagonal block L D L^T.
    coupling: D^-1 L^-1 E, where E couples the node with the next one.
    solution: reduced right-hand sides, then their solutions.
    """
    size = 2 * dim
    return record_type(
        [
            ("mass", NUMBER, (3,)),
            ("free", NUMBER, (2,)),
            ("ends_group", np.bool_),
            ("slope", NUMBER, (dim,)),
            ("basis", NUMBER, (dim, dim if axial else dim - 1)),
            ("axial", NUMBER, (AXIAL_SIZE if axial else 0,)),
            ("force", NUMBER, (2, 2, dim)),
            ("constraint", NUMBER, (3,)),
            ("target", NUMBER, (2,)),
            ("drift_correction", NUMBER),
            ("along", NUMBER, (2,)),
            ("lower", NUMBER, (size * (size - 1) // 2,)),
            ("inverse_pivot", NUMBER, (size,)),
            ("coupling", NUMBER, (size, size)),
            ("solution", NUMBER, (2, size)),
        ]
    )


@lru_cache
def element_type(dim: int, product: bool, axial: bool = False, pressed: bool = False) -> np.dtype:
    """Record of an element in `dim` dimensions.

    mass: r-r, r-s, s-r, s-s mass of the left with the right node [kg, kg m, kg m, kg m^2].
    stiffness: EI times the stiffness matrix, in difference coordinates, empty for `product`.
    tensor: EI times the stiffness tensor over pairs, empty for `secondDerivative`.
    curved, damped, dragged: whether there is natural curvature, bending damping, drag; zeros without it.
    natural: EI kappa_0 times the turning matrix in difference coordinates, empty in space.
    damping: table of the damping force.
    lag: h/2 [s] where damping is implicit, see `implicit_bending`; else 0.
    joined: whether joints act on the cable, see `linear_response.improve_damping`.
    drag: table of the drag.   drag_law: its coefficients and the flow.
    axial: as for nodes.   bending: EI / (3 l) [N m], empty without axial stiffness.
    contact: beside the mass of both nodes, see `contact_mass`; empty in space, and of what neither stretches
        nor is pressed.
    touches: whether it is not zero.
    slope_gram: slope Gram matrix in difference coordinates; zero without length constraint.
    reference_length: int |r_x|^2 dx in the reference configuration [m].
    per_length: its inverse [1/m]; 0 between two cables.
    gradient: length constraint Jacobian on r_left, s_left, r_right, s_right, supports taken out.
    constraint: value [m], rate [m/s], gamma [m/s^2] of the element's share of (19).
    target: right-hand sides of the length constraint, one for each column of Eq. (29).
    drift_correction: as for nodes.
    multiplier: of the length constraint that the element belongs to, one for each column.
    """
    return record_type(
        [
            ("mass", NUMBER, (4,)),
            ("stiffness", NUMBER, (0, 0) if product else (3, 3)),
            ("tensor", NUMBER, (6, 6) if product else (0, 0)),
            ("curved", np.bool_),
            ("damped", np.bool_),
            ("dragged", np.bool_),
            ("joined", np.bool_),
            ("touches", np.bool_),
            ("lag", NUMBER),
            ("axial", NUMBER, (AXIAL_SIZE if axial else 0,)),
            ("bending", NUMBER, (1 if axial else 0,)),
            ("contact", NUMBER, (8 if (axial or pressed) and dim == 2 else 0, 8)),
            ("slope_gram", NUMBER, (3, 3)),
            ("reference_length", NUMBER),
            ("per_length", NUMBER),
            ("gradient", NUMBER, (4, dim)),
            ("constraint", NUMBER, (3,)),
            ("target", NUMBER, (2,)),
            ("drift_correction", NUMBER),
            ("multiplier", NUMBER, (2,)),
            ("natural", NUMBER, (3, 3) if dim == 2 else (0, 0)),
            ("damping", NUMBER, (4, 7)),
            ("drag", NUMBER, (4, 8)),
            ("drag_law", NUMBER, (2, 3)),
        ]
    )


@lru_cache
def link_type(dim: int) -> np.dtype:
    """Record of a link, see `link.Link`, between two nodes, or on one that stands twice.

    node: indices.   weight: of position and slope of each node in u [-, m].
    normal: n [-]; inverse_length: 1/L [1/m], 0 for linear links; length: L [m], 0 for linear links.
    follows: column of the basis at the first node that n follows, or -1.
    motion: index of the anchor's motion.   scale: 1/m, makes the violation a number.
    offset: u [m].
    gradient: of c on position and slope of each node, supports taken out.
    constraint: value [m], rate [m/s], gamma [m/s^2].
    target, drift_correction, multiplier: as for elements.
    """
    return record_type(
        [
            ("node", np.int64, (2,)),
            ("weight", NUMBER, (2, 2)),
            ("normal", NUMBER, (dim,)),
            ("inverse_length", NUMBER),
            ("length", NUMBER),
            ("follows", np.int64),
            ("motion", np.int64),
            ("scale", NUMBER),
            ("offset", NUMBER, (dim,)),
            ("gradient", NUMBER, (2, 2, dim)),
            ("constraint", NUMBER, (3,)),
            ("target", NUMBER, (2,)),
            ("drift_correction", NUMBER),
            ("multiplier", NUMBER, (2,)),
        ]
    )
