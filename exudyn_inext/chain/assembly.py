"""Forces and constraint terms of the whole chain, element by element."""

from ..compiled import inlined, kernel, local_array
from ..element.bending import add_bending_force
from ..element.inextensibility import (
    contract,
    length_gradient,
    nodal_constraint,
    nodal_gamma,
    nodal_rate,
)


@inlined
def differences(axes, q, k, e):
    """e = (d, s_left, s_right) of element k.   q: (n, 2, dim); e: (3, dim) output."""
    for i in range(len(axes)):
        e[0, i] = q[k + 1, 0, i] - q[k, 0, i]
        e[1, i] = q[k, 1, i]
        e[2, i] = q[k + 1, 1, i]


@inlined
def add_element_force(axes, k, element_force, force):
    """Add the force on (d, s_left, s_right) of element k to the nodal forces (n, 2, dim)."""
    for i in range(len(axes)):
        force[k, 0, i] -= element_force[0, i]
        force[k + 1, 0, i] += element_force[0, i]
        force[k, 1, i] += element_force[1, i]
        force[k + 1, 1, i] += element_force[2, i]


@inlined
def clear(e):
    """All entries of a (3, 3) local array to zero."""
    for a in range(3):
        for i in range(3):
            e[a, i] = 0.0


@inlined
def _set_nodal_gradient(axes, free, k, gradient, nodal):
    """Gradient on (d, s_left, s_right) to (r_left, s_left, r_right, s_right), supports taken out."""
    for i in range(len(axes)):
        nodal[k, 0, i] = -free[k, 0] * gradient[0, i]
        nodal[k, 1, i] = free[k, 1] * gradient[1, i]
        nodal[k, 2, i] = free[k + 1, 0] * gradient[0, i]
        nodal[k, 3, i] = free[k + 1, 1] * gradient[2, i]


@kernel
def add_elastic_force(chain, q, force):
    """force += Q_el(q), the bending forces of all elements.

    Args:
        chain: coefficients.
        q: (n, 2, dim) positions [m] and slopes [-].
        force: (n, 2, dim) [N, Nm].
    """
    e, element_force = local_array(3, 3), local_array(3, 3)
    for k in range(len(chain.stiffness)):
        differences(chain.axes, q, k, e)
        clear(element_force)
        add_bending_force(chain.axes, chain.stiffness, chain.tensor, k, e, element_force)
        add_element_force(chain.axes, k, element_force, force)


@kernel
def assemble(chain, q, v, force, nodal, length, gradient):
    """All that the index-reduced equations need at (q, v): forces, constraints, Jacobian.

    Args:
        chain: coefficients.
        q, v: (n, 2, dim) coordinates and velocities.
        force: (n, 2, dim) [N, Nm]; elastic forces are added.
        nodal: (n, 3) value [-], rate [1/s] and gamma [1/s^2] of the nodal constraints (18), (27).
        length: (N, 3) the same of the length constraints (19), each element's share [m, ...].
        gradient: (N, 4, dim) Jacobian of the length constraints on r_left, s_left, r_right, s_right.
    """
    axes = chain.axes
    for k in range(len(q)):
        nodal[k, 0] = nodal_constraint(axes, q[k, 1])
        nodal[k, 1] = nodal_rate(axes, q[k, 1], v[k, 1])
        nodal[k, 2] = nodal_gamma(axes, v[k, 1])
    e, e_t = local_array(3, 3), local_array(3, 3)
    result = local_array(3, 3)
    for k in range(len(chain.stiffness)):
        differences(axes, q, k, e)
        differences(axes, v, k, e_t)
        clear(result)
        add_bending_force(axes, chain.stiffness, chain.tensor, k, e, result)
        add_element_force(axes, k, result, force)
        length_gradient(axes, chain.slope_gram, k, e_t, result)
        length[k, 2] = -contract(axes, e_t, result)
        length_gradient(axes, chain.slope_gram, k, e, result)
        length[k, 0] = 0.5 * contract(axes, e, result) - chain.reference_length[k]
        length[k, 1] = contract(axes, e_t, result)
        _set_nodal_gradient(axes, chain.free, k, result, gradient)
