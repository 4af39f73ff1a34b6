"""Forces and constraint terms of the whole chain, element by element."""

from ..compiled import clear, inlined, inlined_kernel, optional
from ..element.bending import add_bending_force
from ..element.bending_damping import add_curvature_force, add_damping_force, add_stretched_damping_force
from ..element.drag import add_drag_force
from ..element.inextensibility import contract, length_gradient, nodal_constraint, nodal_gamma, nodal_rate
from ..element.natural_curvature import add_natural_curvature_force
from ..lowered import local_array
from .factorisation import set_frame

ACCELERATION, CORRECTION = 0, 1  # columns of Eq. (29): v' with lam, and q' - v with mu
VALUE, RATE, GAMMA = 0, 1, 2  # entries of the `constraint` of a record


@inlined
def leave_targets(parameter, record):
    """For whoever needs no targets."""


@inlined
def differences(axes, q, k, e):
    """e = (d, s_left, s_right) of element k.   q: (n, 2, dim); e: (3, dim) output."""
    for i in range(len(axes)):
        e[0, i] = q[k + 1, 0, i] - q[k, 0, i]
        e[1, i] = q[k, 1, i]
        e[2, i] = q[k + 1, 1, i]


@inlined
def add_element_force(axes, element_force, left, right):
    """Add the force on (d, s_left, s_right) to the forces (2, dim) of the two nodes."""
    for i in range(len(axes)):
        left[0, i] -= element_force[0, i]
        right[0, i] += element_force[0, i]
        left[1, i] += element_force[1, i]
        right[1, i] += element_force[2, i]


@inlined
def set_gradient(axes, left_free, right_free, gradient, nodal):
    """Gradient on (d, s_left, s_right) to (r_left, s_left, r_right, s_right), supports taken out."""
    for i in range(len(axes)):
        nodal[0, i] = -left_free[0] * gradient[0, i]
        nodal[1, i] = left_free[1] * gradient[1, i]
        nodal[2, i] = right_free[0] * gradient[0, i]
        nodal[3, i] = right_free[1] * gradient[2, i]


@inlined
def add_bending(axes, element, e, force):
    """Bending force of an element, with its natural curvature.   e: (3, dim); force: (3, dim), added to."""
    add_bending_force(axes, element.stiffness, element.tensor, e, force)
    if element.curved:
        add_natural_curvature_force(element.natural, e, force)


@inlined_kernel
def add_elastic_force(chain, q, force):
    """force += Q_el(q), the bending forces of all elements.

    Args:
        chain: coefficients.
        q: (n, 2, dim) positions [m] and slopes [-].
        force: (n, 2, dim) [N, Nm].
    """
    e, element_force = local_array(3, 3), local_array(3, 3)
    for k in range(len(chain.elements)):
        element = chain.elements[k]
        differences(chain.axes, q, k, e)
        clear(element_force)
        add_bending(chain.axes, element, e, element_force)
        add_element_force(chain.axes, element_force, force[k], force[k + 1])


@inlined_kernel
def elastic_energy(chain, q):
    """Bending energy at q (n, 2, dim) less that of all nodes in one point [J].

    The force along the ray from there is linear, or a polynomial of degree three (`product`): Simpson's rule
    is exact. Element by element in differences, so that the energy of a fine mesh is not lost in round-off.
    """
    axes = chain.axes
    e, half, force = local_array(3, 3), local_array(3, 3), local_array(3, 3)
    energy = 0.0
    for k in range(len(chain.elements)):
        element = chain.elements[k]
        differences(axes, q, k, e)
        clear(force)
        add_bending(axes, element, e, force)
        if element.tensor.shape[0] == 0:
            energy -= 0.5 * contract(axes, e, force)
            continue
        for a in range(3):
            for i in range(len(axes)):
                half[a, i] = 0.5 * e[a, i]
        for _ in range(4):
            add_bending(axes, element, half, force)
        energy -= contract(axes, e, force) / 6.0
    return energy


@inlined
def set_violations(axes, nodes, elements, q, set_targets, parameter):
    """Values of all constraints at q into the records; returns the largest, lengths relative.

    set_targets, parameter: see `assemble`.
    """
    worst = 0.0
    for k in range(len(nodes)):
        value = nodes[k].free[1] * nodal_constraint(axes, q[k, 1])
        nodes[k].constraint[VALUE] = value
        set_targets(parameter, nodes[k])
        worst = max(worst, abs(value))
    e, gradient = local_array(3, 3), local_array(3, 3)
    of_group = 0.0
    for k in range(len(elements)):
        element = elements[k]
        differences(axes, q, k, e)
        length_gradient(axes, element.slope_gram, e, gradient)
        value = 0.5 * contract(axes, e, gradient) - element.reference_length
        element.constraint[VALUE] = value
        set_targets(parameter, element)
        of_group += value * element.per_length
        if nodes[k + 1].ends_group:
            worst = max(worst, abs(of_group))
            of_group = 0.0
    return worst


@inlined
def assemble(axes, nodes, elements, external, q, v, set_targets, parameter):
    """All that the index-reduced equations need at (q, v), into the records of the chain.

    Nodes: external and elastic forces, constraint terms (18), (27) and the frame.
    Elements: constraint terms (19), (27) and the Jacobian.

    Args:
        axes, nodes, elements: of the chain.
        external: (n, 2, dim) [N, Nm].
        q, v: (n, 2, dim) coordinates and velocities.
        set_targets: (parameter, record): sets the targets of a record's constraint from its terms.
    """
    for k in range(len(nodes)):
        for i in range(len(axes)):
            nodes[k].force[ACCELERATION, 0, i] = external[k, 0, i]
            nodes[k].force[ACCELERATION, 1, i] = external[k, 1, i]
        set_frame(axes, nodes[k], q[k, 1])
        terms = nodes[k].constraint
        terms[VALUE] = nodal_constraint(axes, q[k, 1])
        terms[RATE] = nodal_rate(axes, q[k, 1], v[k, 1])
        terms[GAMMA] = nodal_gamma(axes, v[k, 1])
        set_targets(parameter, nodes[k])
    e, e_t, result = local_array(3, 3), local_array(3, 3), local_array(3, 3)
    for k in range(len(elements)):
        element = elements[k]
        differences(axes, q, k, e)
        differences(axes, v, k, e_t)
        clear(result)
        add_bending(axes, element, e, result)
        add_element_force(axes, result, nodes[k].force[ACCELERATION], nodes[k + 1].force[ACCELERATION])
        length_gradient(axes, element.slope_gram, e_t, result)
        element.constraint[GAMMA] = -contract(axes, e_t, result)
        length_gradient(axes, element.slope_gram, e, result)
        element.constraint[VALUE] = 0.5 * contract(axes, e, result) - element.reference_length
        element.constraint[RATE] = contract(axes, e_t, result)
        set_targets(parameter, element)
        set_gradient(axes, nodes[k].free, nodes[k + 1].free, result, element.gradient)


@inlined
def _damp_constrained(axes, nodes, elements, k, e, e_t, memory, force):
    add_damping_force(axes, elements[k].damping, e, e_t, memory, force)


@optional("axial", otherwise=_damp_constrained)
def damp_element(axes, nodes, elements, k, e, e_t, memory, force):
    """Damping force of element k; other arguments: see `add_damping_force`."""
    add_stretched_damping_force(axes, elements[k].damping, e, e_t, memory, force)


@inlined
def add_damping(axes, nodes, elements, q, v, lead, a, column):
    """Damping forces at the velocities v + lead a, added to column `column` of the nodes' `force`.

    lead: [s]; a: (n, 2, dim) accelerations that v still lacks. Nothing happens without damping.
    """
    if not elements[0].damped:
        return
    e, e_t, lacking, result = local_array(3, 3), local_array(3, 3), local_array(3, 3), local_array(3, 3)
    memory = local_array(7, 3)
    for k in range(len(elements)):
        differences(axes, q, k, e)
        differences(axes, v, k, e_t)
        differences(axes, a, k, lacking)
        for row in range(3):
            for i in range(len(axes)):
                e_t[row, i] += lead * lacking[row, i]
        clear(result)
        damp_element(axes, nodes, elements, k, e, e_t, memory, result)
        add_element_force(axes, result, nodes[k].force[column], nodes[k + 1].force[column])


@inlined
def lag_of(elements):
    """h/2 [s] if the damping is implicit, see `implicit_bending`; 0 without damping."""
    return elements[0].lag


@inlined
def lags(elements):
    """Whether a constant matrix takes more on the left than the damping is; see `axial_damping`."""
    return lag_of(elements) > 0.0 and elements[0].axial.shape[0] == 0


@inlined
def improves_alone(elements):
    """Whether the cable takes that off by a second solve; under joints, the whole scene does."""
    return lags(elements) and not elements[0].joined


@inlined
def add_lagging_damping(axes, nodes, elements, q, a):
    """lag (D_c - D) a, by which the matrix D_c on the left differs from the damping D, to the `force`.

    a: (n, 2, dim) accelerations.   Other arguments: see `add_damping`.
    """
    e, e_tt, all_of_it, damped = local_array(3, 3), local_array(3, 3), local_array(3, 3), local_array(3, 3)
    memory = local_array(7, 3)
    for k in range(len(elements)):
        differences(axes, q, k, e)
        differences(axes, a, k, e_tt)
        clear(all_of_it)
        clear(damped)
        add_curvature_force(axes, elements[k].damping, e_tt, memory, all_of_it)
        damp_element(axes, nodes, elements, k, e, e_tt, memory, damped)
        for row in range(3):
            for i in range(len(axes)):
                damped[row, i] = elements[k].lag * (damped[row, i] - all_of_it[row, i])
        add_element_force(axes, damped, nodes[k].force[ACCELERATION], nodes[k + 1].force[ACCELERATION])


@inlined
def add_drag(axes, nodes, elements, q, v, lead, a, column):
    """Drag at the velocities v + lead a; arguments as for `add_damping`. Nothing happens without drag."""
    if not elements[0].dragged:
        return
    e, rates, result, memory = local_array(3, 3), local_array(4, 3), local_array(4, 3), local_array(2, 3)
    for k in range(len(elements)):
        differences(axes, q, k, e)
        for row in range(4):
            for i in range(len(axes)):
                node, kind = k + row // 2, row % 2
                rates[row, i] = v[node, kind, i] + lead * a[node, kind, i]
                result[row, i] = 0.0
        add_drag_force(axes, elements[k].drag, elements[k].drag_law, e, rates, memory, result)
        for row in range(4):
            for i in range(len(axes)):
                nodes[k + row // 2].force[column, row % 2, i] += result[row, i]
