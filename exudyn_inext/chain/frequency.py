"""The largest natural frequency of the constrained chain, which bounds every explicit step."""

import numpy as np
from scipy.linalg import eigvalsh_tridiagonal

from ..compiled import inlined, kernel, local_array
from ..element.inextensibility import length_gradient
from ..element.shape_functions import Array
from ..system import index_reduced_rates
from .assembly import add_elastic_force, add_element_force, differences
from .index_reduction import CableSystem
from .saddle_point import apply_mass, nodal_multipliers, solve

LANCZOS_STEPS = 40


@inlined
def _apply_elastic_tangent(chain, q, x, trial, force, y):
    """y = -(dQ_el/dq) x, exact: Q_el is cubic in q, so that two central differences suffice."""
    y[:] = 0.0
    for step, weight in ((1.0, -8.0 / 12.0), (2.0, 1.0 / 12.0)):
        for sign in (1.0, -1.0):
            trial[:] = q + sign * step * x
            force[:] = 0.0
            add_elastic_force(chain, trial, force)
            y += sign * weight * force


@inlined
def _add_geometric_stiffness(chain, nodal, length, x, y):
    """y += sum lam d2c/dq2 x: the stiffness that the tension gives.   nodal: (n,); length: (N,)."""
    for k in range(len(nodal)):
        for i in range(len(chain.axes)):
            y[k, 1, i] += 2.0 * nodal[k] * x[k, 1, i]
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(length)):
        differences(chain.axes, x, k, e)
        length_gradient(chain.axes, chain.elements[k].slope_gram, e, gradient)
        for a in range(3):
            for i in range(len(chain.axes)):
                gradient[a, i] *= length[k]
        add_element_force(chain.axes, gradient, y[k], y[k + 1])


@inlined
def _project(chain, force, x):
    """x = constrained M^-1 force."""
    for k in range(len(chain.nodes)):
        chain.nodes[k].target[0] = 0.0
        for i in range(len(chain.axes)):
            chain.nodes[k].force[0, 0, i] = force[k, 0, i]
            chain.nodes[k].force[0, 1, i] = force[k, 1, i]
    for k in range(len(chain.elements)):
        chain.elements[k].target[0] = 0.0
    solve(chain, x)


@kernel
def _lanczos(system, external, q, start, diagonal, off_diagonal):
    """Lanczos recursion of x -> constrained M^-1 H x in the mass inner product.

    H is the elastic and the geometric stiffness, the latter with the tension at rest under `external`.
    Returns the number of rows of the tridiagonal matrix that were found before breakdown.
    """
    chain = system.chain
    current, previous, image = np.zeros_like(q), np.zeros_like(q), np.zeros_like(q)
    trial, force, momentum = np.zeros_like(q), np.zeros_like(q), np.zeros_like(q)
    nodal, length = np.zeros(len(q)), np.zeros(len(q) - 1)
    index_reduced_rates(
        system, external.ravel(), q.ravel(), current.ravel(), image.ravel(), force.ravel()
    )
    nodal_multipliers(chain, image, momentum, nodal)
    for k in range(len(length)):
        length[k] = chain.elements[k].multiplier[0]
    _project(chain, start, current)
    apply_mass(chain, current, momentum)
    current /= np.sqrt(np.sum(current * momentum))
    norm = 0.0
    for row in range(len(diagonal)):
        _apply_elastic_tangent(chain, q, current, trial, force, image)
        _add_geometric_stiffness(chain, nodal, length, current, image)
        diagonal[row] = np.sum(current * image)
        force[:] = image
        _project(chain, force, image)
        image -= diagonal[row] * current + norm * previous
        apply_mass(chain, image, momentum)
        norm = np.sqrt(max(np.sum(image * momentum), 0.0))
        off_diagonal[row] = norm
        if not norm > 1e-10 * abs(diagonal[row]):
            return row + 1
        previous[:] = current
        current[:] = image / norm
    return len(diagonal)


def largest_frequency(system: CableSystem, external: Array, q: Array) -> float:
    """w_max of small vibrations about q, constraints and tension included.

    Lanczos iteration with the structured solve: O(N), no matrix is formed.

    Args:
        system: the cable's system; its memory is used.
        external: (n, 2, dim) external force, which sets the tension [N, Nm].
        q: (n, 2, dim) configuration.

    Returns:
        Largest natural frequency [rad/s]; 0 if nothing can move.
    """
    start = np.random.default_rng(1).standard_normal(q.shape)
    rows = min(LANCZOS_STEPS, q.size)
    diagonal, off_diagonal = np.zeros(rows), np.zeros(rows)
    arguments = (np.ascontiguousarray(array) for array in (external, q, start))
    found = _lanczos(system, *arguments, diagonal, off_diagonal)
    if not np.isfinite(diagonal[:found]).all():
        return 0.0
    top = eigvalsh_tridiagonal(diagonal[:found], off_diagonal[: found - 1])[-1]
    return float(np.sqrt(max(top, 0.0)))
