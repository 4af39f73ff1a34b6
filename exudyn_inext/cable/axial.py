"""Axial stiffness, implicit: forces, effective mass and corrections of steps that do not depend on EA.

With strains c at nodes and in elements, see `element.axial_strain`, their Jacobian J and energy D c^2 / 2, a
step has mean axial forces mu_n = D (c_n + c_(n+1)) / 2 + d (c_(n+1) - c_n) / h:

    v_(n+1/2) = v_(n-1/2) + h a_n,  M a_n = F_n - J_n^T (mu_(n-1) + mu_n) / 2,  q_(n+1) = q_n + h v_(n+1/2).

It is the method of the discrete Lagrangian h (v M v / 2 - (U + U') / 2 - D ((c + c') / 2)^2 / 2): symmetric,
symplectic, of order 2, and the trapezoidal rule for axial vibrations; D -> infinity gives RATTLE's positions.
With what is not linear in the step, rho = c(q_(n+1)) - c(q_n) - J_n (q_(n+1) - q_n), it is

    (M + h^2/2 J^T E J) a = F - J^T f,  f = (mu_(n-1) + D c + E (h J v_(n-1/2) + rho)) / 2,  E = D/2 + d/h,

a matrix of the same bandwidth as that of the constraints, and positive definite. rho is found by fixed-point
iteration.

The bending energy is EI/2 int |r_x x r_xx|^2 / |r_x|^4 dx = EI/2 int (|r_xx|^2 - (|r_x|_x)^2) / |r_x|^2 dx,
as of native cables, with the mean |r_x| of an element and |r_x|_x from its strains.

J. E. Marsden, M. West, Discrete mechanics and variational integrators, Acta Numerica 10 (2001) 357-514.
"""

import numpy as np

from ..compiled import clear, inlined, optional
from ..element.axial_strain import middle_strain, norm, rise_by_left
from ..element.inextensibility import contract, length_gradient
from ..lowered import local_array, subtract_multiple
from .assembly import (
    ACCELERATION,
    CORRECTION,
    GAMMA,
    VALUE,
    add_bending,
    add_element_force,
    assemble,
    differences,
    elastic_energy,
    leave_targets,
    set_gradient,
    set_violations,
)
from .axial_damping import damping_rows
from .axial_stiffness import (
    ADDED_MASS,
    DAMPING,
    FIRST_DAMPING,
    FORCE,
    FREE_STRAIN,
    FROZEN,
    IMPLICIT,
    MEAN_FORCE,
    PLACE,
    REST_BEFORE,
    STEP,
    STIFFNESS,
    STRAIN,
)
from .contact_mass import add_contact_mass, couple_by_contact
from .factorisation import eliminate_node, factorise
from .saddle_point import solve_column

HUGE = 1e30  # 1/s
SHORTEST = 0.2  # |r_x| of a compressed cable, below which it is about to turn inside out


@inlined
def _along_node(axes, node, x):
    """J x of a node.   x: (2, dim)."""
    value = 0.0
    for i in range(len(axes)):
        value += node.slope[i] * x[1, i]
    return value


@inlined
def _along_element(axes, element, left, right):
    """J x of an element.   left, right: (2, dim) x of its nodes."""
    value = 0.0
    for i in range(len(axes)):
        value += element.gradient[0, i] * left[0, i] + element.gradient[1, i] * left[1, i]
        value += element.gradient[2, i] * right[0, i] + element.gradient[3, i] * right[1, i]
    return value


@inlined
def mean_stretch(element, square):
    """m = (int |r_x|^2 dx / l)^(1/2) [-]; 1 between two cables.   square: the integral [m]."""
    return np.sqrt(square * element.per_length) if element.per_length > 0.0 else 1.0


@inlined
def _set_force(record, strain, rate, bend, place, duration):
    """f of a record; at the start of a run, from the motion before and after it that is symmetric.

    It has no branch, so that both cases leave the same bits in all but the force.

    strain: c.   rate: J v [1/s].   bend: v c_qq v [1/s^2].   place: J q.
    duration: 0 at the start of a run, when v is the velocity of the state.
    """
    axial = record.axial
    h = axial[STEP]
    of_steps = min(1.0, HUGE * duration)
    foreseen = record.drift_correction + of_steps * (record.drift_correction - axial[REST_BEFORE])
    axial[REST_BEFORE] += of_steps * (record.drift_correction - axial[REST_BEFORE])
    record.drift_correction = foreseen
    lead = axial[IMPLICIT] * (h * rate + foreseen)
    starting = axial[STIFFNESS] * (strain + 0.25 * h * h * bend) + axial[DAMPING] * rate + axial[FROZEN]
    going = 0.5 * (axial[MEAN_FORCE] + axial[STIFFNESS] * strain + lead)
    force = of_steps * going + (1.0 - of_steps) * starting
    axial[STRAIN] = strain
    axial[PLACE] = place
    axial[FORCE] = force
    axial[FIRST_DAMPING] = 0.5 * h * (1.0 - of_steps) * axial[DAMPING]
    record.target[ACCELERATION] = force
    record.target[CORRECTION] = 0.0


@optional("axial")
def take_back(axes, nodes, elements):
    """What the last assembly of a step has foreseen: the same state will be assembled again."""
    for k in range(len(nodes)):
        _take_back(nodes[k])
    for k in range(len(elements)):
        _take_back(elements[k])


@inlined
def _take_back(record):
    foreseen = record.drift_correction
    record.drift_correction = record.axial[REST_BEFORE]
    record.axial[REST_BEFORE] += record.drift_correction - foreseen


@inlined
def _assemble_node(axes, node, q, v, duration):
    """Strain terms of a node, and the direction of its slope.   q, v: (2, dim)."""
    stretch = norm(axes, q[1])
    square, inverse = 0.0, 1.0 / stretch
    for i in range(len(axes)):
        node.slope[i] = node.free[1] * inverse * q[1, i]
        square += v[1, i] * v[1, i]
    rate = _along_node(axes, node, v)
    node.constraint[VALUE] = stretch - 1.0
    node.constraint[GAMMA] = (square - rate * rate) * inverse
    strain = stretch - 1.0 - node.axial[FREE_STRAIN]
    _set_force(node, strain, rate, node.constraint[GAMMA], _along_node(axes, node, q), duration)


@inlined
def _add_bending(axes, element, left, right, e, per_stretch):
    """Bending force of an element, onto the forces of its nodes and the targets of its strains.

    left, right: the nodes.   e: (3, dim) differences of q.   per_stretch: 1 / m.
    """
    result = local_array(3, 3)
    clear(result)
    add_bending(axes, element, e, result)
    work = contract(axes, e, result)
    middle = element.axial[STRAIN] + element.axial[FREE_STRAIN]
    before, after = left.constraint[VALUE] - middle, right.constraint[VALUE] - middle
    per_square = per_stretch * per_stretch
    for a in range(3):
        for i in range(len(axes)):
            result[a, i] *= per_square
    add_element_force(axes, result, left.force[ACCELERATION], right.force[ACCELERATION])
    factor = element.bending[0] * per_square
    on_left, on_right = factor * rise_by_left(before, after), factor * rise_by_left(after, before)
    on_mean = (work * per_square + before * on_left + after * on_right) * per_stretch / 6.0
    left.target[ACCELERATION] += on_mean - on_left
    element.target[ACCELERATION] += 4.0 * on_mean + on_left + on_right
    right.target[ACCELERATION] += on_mean - on_right


@inlined
def _set_strain_gradient(axes, element, left, right, factor, gradient):
    """J of an element on its nodes' coordinates.

    gradient: (3, dim) of int |r_x|^2 dx, destroyed; factor times it is that of m.
    """
    for a in range(3):
        for i in range(len(axes)):
            gradient[a, i] *= 1.5 * factor
    set_gradient(axes, left.free, right.free, gradient, element.gradient)
    if element.per_length > 0.0:
        for i in range(len(axes)):
            element.gradient[1, i] -= 0.25 * left.slope[i]
            element.gradient[3, i] -= 0.25 * right.slope[i]


@inlined
def _mean_bend(axes, element, v, k, gradient, per_stretch):
    """v m_qq v [1/s^2].   v: (n, 2, dim).   gradient: (3, dim) of int |r_x|^2 dx."""
    e_t, of_rates = local_array(3, 3), local_array(3, 3)
    differences(axes, v, k, e_t)
    length_gradient(axes, element.slope_gram, e_t, of_rates)
    rate = 0.5 * element.per_length * per_stretch * contract(axes, e_t, gradient)
    return (0.5 * element.per_length * contract(axes, e_t, of_rates) - rate * rate) * per_stretch


@inlined
def _assemble_element(axes, nodes, element, q, v, k, duration):
    """Strain and bending of element k, after the strains of its nodes.

    q, v: (n, 2, dim).   duration: see `_set_force`.
    """
    e, gradient = local_array(3, 3), local_array(3, 3)
    left, right = nodes[k], nodes[k + 1]
    differences(axes, q, k, e)
    length_gradient(axes, element.slope_gram, e, gradient)
    stretch = mean_stretch(element, 0.5 * contract(axes, e, gradient))
    per_stretch = 1.0 / stretch
    bend = 0.0
    if duration == 0.0:  # the start of a run needs it
        bend = _mean_bend(axes, element, v, k, gradient, per_stretch)
    _set_strain_gradient(axes, element, left, right, 0.5 * element.per_length * per_stretch, gradient)
    _set_force(
        element,
        middle_strain(stretch - 1.0, left.constraint[VALUE], right.constraint[VALUE])
        - element.axial[FREE_STRAIN],
        _along_element(axes, element, v[k], v[k + 1]),
        middle_strain(bend, left.constraint[GAMMA], right.constraint[GAMMA]),
        _along_element(axes, element, q[k], q[k + 1]),
        duration,
    )
    _add_bending(axes, element, left, right, e, per_stretch)


@inlined
def _assemble_constrained(axes, nodes, elements, external, q, v, lead, set_targets, parameter):
    """See `assembly.assemble`."""
    assemble(axes, nodes, elements, external, q, v, set_targets, parameter)


@optional("axial", otherwise=_assemble_constrained)
def assemble_chain(axes, nodes, elements, external, q, v, lead, set_targets, parameter):
    """Forces, strains and their Jacobian; arguments: see `assembly.assemble`.

    lead: 0 at the start of a run, see `_set_force`.
    """
    for k in range(len(nodes)):
        for i in range(len(axes)):
            nodes[k].force[ACCELERATION, 0, i] = external[k, 0, i]
            nodes[k].force[ACCELERATION, 1, i] = external[k, 1, i]
        _assemble_node(axes, nodes[k], q[k], v[k], lead)
    for k in range(len(elements)):
        _assemble_element(axes, nodes, elements[k], q, v, k, lead)


@inlined
def add_forces_of(axes, nodes, elements, a):
    """Add what accelerations a (n, 2, dim) do to the axial forces of the last assembly, see `axial`."""
    for k in range(len(nodes)):
        _add_force_of(nodes[k], _along_node(axes, nodes[k], a[k]))
    for k in range(len(elements)):
        _add_force_of(elements[k], _along_element(axes, elements[k], a[k], a[k + 1]))


@inlined
def _add_force_of(record, acceleration):
    added = record.axial[ADDED_MASS] * acceleration
    record.axial[FORCE] += added
    record.target[ACCELERATION] += added


@inlined
def _add_of_node(axes, node, block):
    """block += mass of the node with itself, axial stiffness included; lower triangle."""
    dim, weight = len(axes), node.axial[ADDED_MASS]
    for i in range(dim):
        block[i, i] += node.mass[0]
        block[dim + i, i] += node.mass[1]
        block[dim + i, dim + i] += node.mass[2]
        for j in range(i + 1):
            block[dim + i, dim + j] += weight * node.slope[i] * node.slope[j]


@inlined
def _set_sides(axes, element, sides):
    """Gradient of an element on its left node, and on its right one.   sides: (2, 2 dim) output."""
    dim = len(axes)
    for side in range(2):
        for i in range(dim):
            sides[side, i] = element.gradient[2 * side, i]
            sides[side, dim + i] = element.gradient[2 * side + 1, i]


@inlined
def _add_product(axes, weight, left, right, block):
    """block += weight left right^T.   left, right: (2 dim,) on position and slope of a node."""
    unknowns = axes + axes
    for i in range(len(unknowns)):
        subtract_multiple(unknowns, block[i], -weight * left[i], right)


@inlined
def _set_coupling(axes, element, w):
    """w = mass between the two nodes of an element."""
    dim = len(axes)
    clear(w)
    for a in range(2):
        for i in range(dim):
            for b in range(2):
                w[a * dim + i, b * dim + i] = element.mass[2 * a + b]


@inlined
def _factorise_constrained(axes, nodes, elements, q):
    factorise(axes, nodes, elements)


@optional("axial", otherwise=_factorise_constrained)
def factorise_chain(axes, nodes, elements, q):
    """L D L^T of the effective mass, node by node; the chain is assembled.   q: (n, 2, dim)."""
    block, w, following = local_array(6, 6), local_array(6, 6), local_array(6, 6)
    sides, rows, number = local_array(2, 6), local_array(24, 6), 0  # see `damping_rows`
    clear(block)
    clear(w)
    for k in range(len(nodes)):
        _add_of_node(axes, nodes[k], block)
        if k > 0:
            _add_product(axes, elements[k - 1].axial[ADDED_MASS], sides[1], sides[1], block)
            for r in range(number):
                _add_product(axes, 1.0, rows[2 * r + 1], rows[2 * r + 1], block)
            add_contact_mass(axes, nodes, elements, k - 1, 1, block)
        if k < len(elements):
            weight = elements[k].axial[ADDED_MASS]
            _set_sides(axes, elements[k], sides)
            _add_product(axes, weight, sides[0], sides[0], block)
            _set_coupling(axes, elements[k], w)
            _add_product(axes, weight, sides[0], sides[1], w)
            number = damping_rows(axes, nodes, elements, q, k, rows)
            for r in range(number):
                _add_product(axes, 1.0, rows[2 * r], rows[2 * r], block)
                _add_product(axes, 1.0, rows[2 * r], rows[2 * r + 1], w)
            add_contact_mass(axes, nodes, elements, k, 0, block)
            couple_by_contact(axes, nodes, elements, k, w)
        eliminate_node(axes, nodes[k], block, w, following)


@inlined
def _aim_at_strain(record, strain, place):
    """Target of a correction from c and J q of a trial, mean force so far; returns what rho lacked."""
    axial = record.axial
    moved = place - axial[PLACE]
    rest = strain - axial[STRAIN] - moved
    lacking = rest - record.drift_correction
    axial[MEAN_FORCE] = axial[STIFFNESS] * axial[STRAIN] + axial[IMPLICIT] * (moved + record.drift_correction)
    record.target[CORRECTION] = record.axial[ADDED_MASS] * lacking
    record.drift_correction = rest
    return abs(lacking)


@optional("axial", otherwise=set_violations)
def aim_at_positions(axes, nodes, elements, q, set_targets, parameter):
    """Targets of a correction at a trial q (n, 2, dim); returns the largest rest that was not foreseen [-].

    Other arguments: see `assembly.set_violations`.
    """
    worst = 0.0
    for k in range(len(nodes)):
        node = nodes[k]
        raw = norm(axes, q[k, 1]) - 1.0
        node.constraint[VALUE] = raw
        rest = node.free[1] * _aim_at_strain(
            node, raw - node.axial[FREE_STRAIN], _along_node(axes, node, q[k])
        )
        worst = max(worst, rest)
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(elements)):
        element = elements[k]
        differences(axes, q, k, e)
        length_gradient(axes, element.slope_gram, e, gradient)
        mean = mean_stretch(element, 0.5 * contract(axes, e, gradient)) - 1.0
        strain = middle_strain(mean, nodes[k].constraint[VALUE], nodes[k + 1].constraint[VALUE])
        place = _along_element(axes, element, q[k], q[k + 1])
        worst = max(worst, _aim_at_strain(element, strain - element.axial[FREE_STRAIN], place))
    return worst


@inlined
def _violation(axes, nodes, elements, q):
    return set_violations(axes, nodes, elements, q, leave_targets, 0.0)


@optional("axial", otherwise=_violation)
def largest_violation(axes, nodes, elements, q):
    """Of the constraints (18), (19) at q [-]; in their place, how far |r_x| is below `SHORTEST`."""
    least = SHORTEST
    for k in range(len(nodes)):
        least = min(least, norm(axes, q[k, 1]))
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(elements)):
        differences(axes, q, k, e)
        length_gradient(axes, elements[k].slope_gram, e, gradient)
        least = min(least, mean_stretch(elements[k], 0.5 * contract(axes, e, gradient)))
    return SHORTEST - least


@inlined
def _bending_only(axes, nodes, elements, chain, q, v, a):
    return elastic_energy(chain, q)


@optional("axial", otherwise=_bending_only)
def stored_energy(axes, nodes, elements, chain, q, v, a):
    """Energy of bending and axial forces at q and v, evaluated last, with accelerations a (n, 2, dim) [J].

    The axial forces are those of the steps, means over a step to either side: with velocities that are such
    means, too, energies of vibrations that the step does not resolve keep their sum.
    """
    energy = 0.0
    for k in range(len(nodes)):
        node = nodes[k]
        energy += _energy_of_force(node, _along_node(axes, node, v[k]), _along_node(axes, node, a[k]))
    for k in range(len(elements)):
        rate = _along_element(axes, elements[k], v[k], v[k + 1])
        energy += _energy_of_force(elements[k], rate, _along_element(axes, elements[k], a[k], a[k + 1]))
        energy += _stretched_bending_energy(axes, elements[k], q, k)
    return energy


@inlined
def _energy_of_force(record, rate, acceleration):
    """(f + h^2/2 E J a - damping)^2 / (2 D) [J].   rate, acceleration: J v, J a.

    At the start of a run, v is the velocity before its first half step, and damping acts behind that.
    """
    axial = record.axial
    force = axial[FORCE] + (axial[ADDED_MASS] - axial[FIRST_DAMPING]) * acceleration
    force -= _damping_force(record, rate)
    return 0.5 * force * force / axial[STIFFNESS] if axial[STIFFNESS] > 0.0 else 0.0


@inlined
def _damping_force(record, rate):
    """d J v, with what the rest of the next step, as foreseen, is more than that of the last one [N m].

    Strong damping makes a large force of what foresight lacks, as after the first step, or a change of h.

    rate: J v.
    """
    axial = record.axial
    of_rest = 0.5 * (axial[IMPLICIT] - 0.5 * axial[STIFFNESS])  # d / (2 h)
    return axial[DAMPING] * rate + of_rest * (record.drift_correction - axial[REST_BEFORE])


@inlined
def _power_of_damping(record, rate):
    """Negative [W].   rate: J v."""
    damping = record.axial[DAMPING]
    return -(_damping_force(record, rate) ** 2) / damping if damping > 0.0 else 0.0


@inlined
def _stretched_bending_energy(axes, element, q, k):
    """Bending energy of element k at q (n, 2, dim), less that of all nodes in one point [J]."""
    e, gradient, force = local_array(3, 3), local_array(3, 3), local_array(3, 3)
    differences(axes, q, k, e)
    length_gradient(axes, element.slope_gram, e, gradient)
    stretch = mean_stretch(element, 0.5 * contract(axes, e, gradient))
    clear(force)
    add_bending(axes, element, e, force)
    left, right = norm(axes, q[k, 1]) - 1.0, norm(axes, q[k + 1, 1]) - 1.0
    middle = middle_strain(stretch - 1.0, left, right)
    left -= middle
    right -= middle
    rise = left * rise_by_left(left, right) + right * rise_by_left(right, left)
    return -0.5 * (contract(axes, e, force) + element.bending[0] * rise) / (stretch * stretch)


@inlined
def _all_of_it(axes, nodes, elements, a, resolved):
    for k in range(len(nodes)):
        for i in range(len(axes)):
            resolved[k, 0, i] = a[k, 0, i]
            resolved[k, 1, i] = a[k, 1, i]


@optional("axial", otherwise=_all_of_it)
def resolved_acceleration(axes, nodes, elements, a, resolved):
    """(M + h^2/2 J^T E J)^-1 M a: a (n, 2, dim) without axial vibrations that the step does not resolve.

    One of the frequency w is left with the share 1 / (1 + (h w / 2)^2).   resolved: (n, 2, dim) output.
    """
    for k in range(len(nodes)):
        nodes[k].target[CORRECTION] = nodes[k].axial[ADDED_MASS] * _along_node(axes, nodes[k], a[k])
    for k in range(len(elements)):
        along = _along_element(axes, elements[k], a[k], a[k + 1])
        elements[k].target[CORRECTION] = elements[k].axial[ADDED_MASS] * along
    solve_column(axes, nodes, elements, CORRECTION, resolved)
    for k in range(len(nodes)):
        for i in range(len(axes)):
            resolved[k, 0, i] += a[k, 0, i]
            resolved[k, 1, i] += a[k, 1, i]


@inlined
def _no_power(axes, nodes, elements, v):
    return 0.0


@optional("axial", otherwise=_no_power)
def axial_power(axes, nodes, elements, v):
    """Power of axial damping at v (n, 2, dim), J evaluated last [W]."""
    power = 0.0
    for k in range(len(nodes)):
        power += _power_of_damping(nodes[k], _along_node(axes, nodes[k], v[k]))
    for k in range(len(elements)):
        power += _power_of_damping(elements[k], _along_element(axes, elements[k], v[k], v[k + 1]))
    return power
