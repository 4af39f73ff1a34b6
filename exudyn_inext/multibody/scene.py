"""Cables, bodies, springs, joints and loads as one compiled `system` of the integrators, as `CoupledSystem`.

The external force is followed by functions of time: (n_cables + F,) numbers, those of the cables as their
own system takes them.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import (
    Called,
    accelerates,
    called_by_address,
    implements,
    of_parts,
)
from ..compiled import called_kernel, inlined, inlined_kernel, kernel, protocol
from ..integrators.integrator import LoadHistory, advance, external_force
from ..lowered import COUNT, VECTOR
from ..scene.path_work import compare_added, follow
from ..system import (
    ACCELERATION_ENERGY,
    ELASTIC,
    KINETIC,
    POWER,
    RESOLVED,
    VIOLATION,
    accelerate_and_project,
    correct_position,
    report_energy,
)
from .bodies import (
    accelerate_body,
    add_lever,
    aim_at_acceleration,
    aim_at_place,
    aim_at_velocity,
    move_body,
    place_body,
    respond_body,
    set_normal,
    subtract_inertia,
    twice_energy,
)
from .cables import (
    Cables,
    accelerate_cables,
    correct_cables,
    improve_cables,
    one_chain,
    respond_with_cables,
)
from .circle_contacts import ADDING, NOW, START, add_contacts, check_friction
from .connectors import add_connectors
from .dashpots import added_energy, aim_dashpots
from .implicit_contacts import RECONSIDERING, complete_contacts, press, reconsider_contacts
from .joints import (
    Joints,
    apply_joints,
    factorise_joints,
    foresee_forces,
    keep_multipliers,
    largest_value,
    power_of_offsets,
    predict_rates_of_dashpots,
    respond_with_bodies,
    set_jacobian,
    set_rates,
    set_values,
    subtract_forces,
    subtract_forces_of_dashpots,
    take_back_foreseen,
)
from .linear_forces import add_linear_forces
from .loads import add_loads
from .points import move_points, move_rare_points, place_points, place_rare_points
from .ramps import Ramps, follow_ramps
from .rows import move_rows

NOT_COUNTED, EACH, ALL_BUT_FIRST = range(3)  # evaluations whose work is counted
SETTLING, AS_PRESSED = 3, 4  # contact settles, or stays in the cables' matrices as it is
MODE, EVALUATION, STEP = range(3)
TURNED = 300.0  # angle in a run up to which all of a spin counts [rad]
STEPS_BETWEEN = 16  # two looks at friction that lasts
TRIALS = 4  # solves in one evaluation, until those contacts act that press


class Items(NamedTuple):
    """All but the cables: records, and memory.

    bodies, points, connectors, linear_forces, loads: records.
    trees, sliders, springs, contacts: what many scenes do not have, called by address; springs: connectors.
    data: (2, D) what contacts and connectors remember, NOW and from the START of the step.
    history: (intervals, D) output: data at the ends of intervals.
    ramps, joints: see `Ramps`, `Joints`.
    force: (n,) what connectors, contacts and loads do to all coordinates [N, Nm].
    given: (n,) what others do.   predicted: (n,) velocities at which they act.
    path: memory of their work, see `scene.path_work`.   counting: (3,) MODE, EVALUATION and STEP: in which
        evaluations it is counted, and the numbers of the present one in its step, and of that.
    """

    bodies: Any
    trees: Called
    points: Any
    sliders: Called
    connectors: Any
    linear_forces: Any
    loads: Any
    springs: Called
    contacts: Called
    data: Array
    history: Array
    ramps: Ramps
    joints: Joints
    force: Array
    given: Array
    predicted: Array
    path: Array
    counting: np.ndarray


class SceneSystem(NamedTuple):
    """cables: systems of the cables, called by address.   cable_dofs: their number of coordinates.

    cable_force: (n_cables,) memory.   cable_places: (cable_dofs,) where in it the force on a coordinate is.
    unjoined, left: (n,) memory: accelerations without joints, and forces that these leave out.
    zeta: stabilisation rate of the joints [1/s].
    """

    cables: Cables
    cable_dofs: int
    cable_force: Array
    cable_places: np.ndarray
    unjoined: Array
    left: Array
    items: Items
    zeta: float


@inlined
def _count_work(items, q):
    counting = items.counting
    is_first = counting[EVALUATION] == 0
    counting[EVALUATION] += 1
    if counting[MODE] == EACH or (counting[MODE] == ALL_BUT_FIRST and not is_first):
        follow(items.path, q, items.force)


@inlined
def _place_points(items, q):
    place_points(items.points, items.bodies, q)
    place_rare_points(items.trees, q)
    place_rare_points(items.sliders, q)


@inlined
def _move_points(items, q, v):
    move_points(items.points, items.bodies, q, v)
    move_rare_points(items.trees, q, v)
    move_rare_points(items.sliders, q, v)


@inlined
def _place(items, q, v):
    for b in range(len(items.bodies)):
        body = items.bodies[b]
        place_body(body, q)
        set_normal(body)
        move_body(body, q, v)
    _place_points(items, q)
    _move_points(items, q, v)


@called_kernel
def act(items, functions, q, v, a):
    """Place all items at q (n,); forces at the velocities v (n,).   functions: (F,) of time.

    a: see `add_contacts`.

    Where a step has one evaluation, at its end, contact settles there: what closes within a step acts in it.
    """
    follow_ramps(items.ramps, functions)
    _place(items, q, v)
    for i in range(len(items.force)):
        items.force[i] = items.given[i]
    settles = items.counting[MODE] == EACH or items.counting[MODE] == SETTLING
    add_connectors(items.springs, 1 if settles else 0, items.force)
    add_linear_forces(items.linear_forces, q, v, items.force)
    add_contacts(items.contacts, q, v, a, 1 if settles else 0, items.force)
    add_loads(items.loads, items.points, functions, items.force)
    move_rows(items.joints.rows, functions)


@protocol
def settle_contacts(system, q, v):
    """Bring the data of contacts and connectors up to date with a state (q, v) at the end of a step."""


of_parts(settle_contacts, VECTOR, VECTOR)


@implements(settle_contacts, SceneSystem)
def settle_scene(system, q, v):
    items = system.items
    if items.counting[MODE] == ALL_BUT_FIRST:
        _place(items, q, v)
        add_connectors(items.springs, 1, items.predicted)
        add_contacts(items.contacts, q, v, v, 1, items.predicted)


@kernel
def measure_connectors(system, q, v):
    """Stretch and rate of all springs at (q, v), (n,) each.   system: `placed`."""
    items = system.items
    _place(items, q, v)
    add_connectors(items.springs, 0, items.predicted)


@called_kernel
def hold(items, q, v):
    """Jacobian and gamma of the joints at (q, v), after `act`, and the responses of bodies."""
    for b in range(len(items.bodies)):
        move_body(items.bodies[b], q, v)
    _move_points(items, q, v)
    set_values(items.joints, items.points)
    aim_dashpots(items.joints, items.connectors, items.points)
    set_jacobian(items.joints, items.points)
    respond_with_bodies(items.joints, items.bodies)


@inlined
def _set_cable_force(system, external):
    """What the cables' own system takes."""
    force = system.cable_force
    for i in range(len(force)):
        force[i] = external[i]
    for i in range(system.cable_dofs):
        force[system.cable_places[i]] += system.items.force[i]


@called_kernel
def accelerate_bodies(items, v, zeta, acceleration):
    """Those of the bodies, after `act`, without joints.   v, acceleration: (n,)."""
    for b in range(len(items.bodies)):
        body = items.bodies[b]
        aim_at_acceleration(body, v[body.first :], zeta)
        accelerate_body(body, items.force[body.first :], acceleration[body.first :])


@called_kernel
def _project_bodies(items, v, zeta, x):
    """x += what leads the rates v of quaternions to the manifold.   v, x: (n,)."""
    for b in range(len(items.bodies)):
        body = items.bodies[b]
        aim_at_velocity(body, v[body.first :], zeta)
        add_lever(body, x[body.first :])


@called_kernel
def _join_accelerations(joints, zeta, learned, v, predicted, duration, acceleration):
    """Factorised: J a = gamma - zeta J v, and that share of what earlier steps taught.   v: (n,).

    predicted: (n,) velocities at the end of the duration [s], by the accelerations before.
    """
    factorise_joints(joints)
    set_rates(joints, v)
    predict_rates_of_dashpots(joints, predicted)
    for r in range(joints.holding):
        joints.target[r] = joints.gamma[r] + learned * joints.drift_correction[r] - zeta * joints.rate[r]
    for r in range(joints.holding, len(joints.rows)):
        row = joints.rows[r]
        of_springs = joints.rate[r] - duration * row.bend
        joints.gamma[r] += row.springiness * (of_springs - joints.gamma[r])
        change = joints.gamma[r] - joints.rate[r]
        joints.target[r] = change / duration if duration > 0.0 else -row.springiness * row.bend
    apply_joints(joints, acceleration, True)
    keep_multipliers(joints)


@inlined
def _join(joints, share, moving, x, refines):
    """J x = -share c + moving o_t; see `apply_joints`. What moves has the rates of dashpots as predicted."""
    for r in range(joints.holding):
        joints.target[r] = -share * joints.value[r] + moving * joints.rows[r].drift
    for r in range(joints.holding, len(joints.rows)):
        joints.target[r] = moving * joints.gamma[r]
    apply_joints(joints, x, refines)


@inlined
def _add_joined(joints, added, duration, acceleration, end_velocity):
    """Add accelerations, (n,) of the parts without joints; `added` is what they do with joints then."""
    _join(joints, 0.0, 0.0, added, True)
    for i in range(len(added)):
        acceleration[i] += added[i]
        end_velocity[i] += duration * added[i]
    for r in range(len(joints.multipliers)):
        joints.multipliers[r] += joints.solved[r]


@inlined
def _accelerate_joined(system, q, v, zeta, learned, acceleration, duration, end_velocity):
    """Those of all parts, from those without joints; see `_join_accelerations` and `improve_damping`."""
    joints, added = system.items.joints, system.items.predicted
    hold(system.items, q, v)
    respond_with_cables(system.cables, joints)
    _join_accelerations(joints, zeta, learned, v, added, duration, acceleration)
    for i in range(len(q)):
        added[i] = acceleration[i] if i < system.cable_dofs else 0.0
    if improve_cables(system.cables, q, added):
        _add_joined(joints, added, duration, acceleration, end_velocity)


@inlined
def _press_as_joined(system, acceleration, duration, end_velocity):
    """Let circles feel what joints do to cables by implicit contact, see `complete_contacts`.

    They feel what the cables do without joints before; the arguments are those of `_join_step`.
    """
    items, left, added = system.items, system.left, system.items.predicted
    for i in range(len(left)):
        added[i] = acceleration[i] - system.unjoined[i]
        left[i] = 0.0
    complete_contacts(items.contacts, added, left)
    largest = 0.0
    for i in range(len(left)):
        largest = max(largest, abs(left[i]))
        items.force[i] += left[i]
        added[i] = 0.0
    if largest == 0.0:  # no joint holds a cable that touches, or contact is explicit
        return
    for b in range(len(items.bodies)):
        first = items.bodies[b].first
        respond_body(items.bodies[b], left[first:], added[first:])
    _add_joined(items.joints, added, duration, acceleration, end_velocity)


@inlined
def _join_step(system, q, v, duration, stabilises, acceleration, rate):
    """Those with joints, from those without; arguments: see `accelerate`."""
    items, zeta = system.items, system.zeta if stabilises else 0.0
    for i in range(len(q)):
        system.unjoined[i] = acceleration[i]
    _accelerate_joined(system, q, v, zeta, 1.0 - stabilises, acceleration, duration, rate)
    if items.counting[MODE] != NOT_COUNTED:
        compare_added(items.path, added_energy(items.joints, duration))
    if not stabilises and items.contacts.functions[ADDING] != 0:
        _press_as_joined(system, acceleration, duration, rate)
    subtract_forces_of_dashpots(items.joints, items.force)
    _join(items.joints, zeta, 1.0, rate, True)


@inlined
def _accelerate_parts(system, external, q, v, duration, stabilises, acceleration, rate):
    """Without joints, after `act`. Contacts of a step are those that act at the velocities to come."""
    items = system.items
    is_pressed = stabilises == 1 or items.counting[MODE] == AS_PRESSED
    for trial in range(TRIALS):
        _set_cable_force(system, external)
        if not is_pressed:
            press(items.contacts, 1 if trial > 0 and duration > 0.0 else 0)
        accelerate_cables(system.cables, system.cable_force, q, v, duration, stabilises, acceleration, rate)
        is_last = is_pressed or trial == TRIALS - 1
        if is_last or reconsider_contacts(items.contacts, acceleration, items.force) == 0.0:
            break
        for i in range(system.cable_dofs if duration > 0.0 else 0):
            acceleration[i] = (items.predicted[i] - v[i]) / duration
    if not stabilises:
        complete_contacts(items.contacts, acceleration, items.force)


@inlined
def _foresees(items, duration, stabilises):
    """Whether joints pull on the cables as they did in the step before, while contacts are reconsidered."""
    is_step = duration > 0.0 and stabilises == 0 and items.counting[MODE] != AS_PRESSED
    return is_step and len(items.joints.rows) > 0 and items.contacts.functions[RECONSIDERING] != 0


@accelerates(SceneSystem)
def accelerate_scene(system, external, q, v, duration, stabilises, acceleration, rate):
    """Eq. (29), or (30) if it stabilises. Arguments: see `accelerate`."""
    items, zeta = system.items, system.zeta if stabilises else 0.0
    for i in range(len(q)):
        items.predicted[i] = v[i] if stabilises else v[i] + duration * acceleration[i]
    act(items, external[len(system.cable_force) :], q, items.predicted, acceleration)
    foresees = _foresees(items, duration, stabilises)
    if foresees:
        set_values(items.joints, items.points)
        set_jacobian(items.joints, items.points)
        foresee_forces(items.joints, items.force)
    if stabilises:
        _count_work(items, q)
    _accelerate_parts(system, external, q, v, duration, stabilises, acceleration, rate)
    accelerate_bodies(items, v, zeta, acceleration)
    for i in range(system.cable_dofs, len(q)):
        rate[i] = v[i] + duration * acceleration[i]
    _project_bodies(items, rate, zeta, rate)
    if len(items.joints.rows) > 0:
        _join_step(system, q, v, duration, stabilises, acceleration, rate)
    if foresees:
        take_back_foreseen(items.joints, items.force)
    if not stabilises:
        _count_work(items, q)


@called_kernel
def _correct_items(items, functions, q, learning, correction):
    """Largest violation, which teaches the next steps; corrections of quaternions alone."""
    joints, worst = items.joints, 0.0
    for b in range(len(items.bodies)):
        body = items.bodies[b]
        place_body(body, q)
        violation = aim_at_place(body, q, learning)
        if not violation <= worst:
            worst = violation
        for i in range(body.translations + body.rotations):
            correction[body.first + i] = 0.0
        add_lever(body, correction[body.first :])
    _place_points(items, q)
    move_rows(joints.rows, functions)
    set_values(joints, items.points)
    for r in range(len(joints.value)):
        joints.drift_correction[r] -= learning * joints.value[r]
    return largest_value(joints, worst)


@implements(correct_position, SceneSystem)
def correct_scene_position(system, external, q, tolerance, learning, correction):
    items = system.items
    own, functions = external[: len(system.cable_force)], external[len(system.cable_force) :]
    worst = _correct_items(items, functions, q, learning, correction)
    violation = correct_cables(system.cables, own, q, tolerance, learning, correction)
    if not violation <= worst:  # keeps a NaN
        worst = violation
    if len(items.joints.rows) > 0 and not worst < tolerance:
        _join(items.joints, 1.0, 0.0, correction, False)
    return worst


@implements(report_energy, SceneSystem)
def report_energy_of_scene(system, external, q, v, a, force, energy_report):
    """Violations are those of the cables alone; work of the items is counted along the way."""
    cables, bodies, trees = system.cables, system.items.bodies, system.items.trees
    elastic, power, violation = 0.0, power_of_offsets(system.items.joints), 0.0
    kinetic, of_acceleration = bodies_energy(bodies, trees, q, v), bodies_energy(bodies, trees, q, a)
    resolved = of_acceleration
    for k in range(len(cables.functions)):
        i, j = cables.dofs[k], cables.dofs[k + 1]
        given = external[cables.inputs[k] : cables.inputs[k + 1]]
        report_energy(one_chain(cables, k), given, q[i:j], v[i:j], a[i:j], force[i:j], energy_report)
        kinetic += energy_report[KINETIC]
        elastic += energy_report[ELASTIC]
        power += energy_report[POWER]
        if not energy_report[VIOLATION] <= violation:  # keeps a NaN
            violation = energy_report[VIOLATION]
        of_acceleration += energy_report[ACCELERATION_ENERGY]
        resolved += energy_report[RESOLVED]
    for i in range(system.cable_dofs, len(q)):
        force[i] = 0.0
    energy_report[KINETIC] = kinetic
    energy_report[ELASTIC] = elastic
    energy_report[POWER] = power
    energy_report[VIOLATION] = violation
    energy_report[ACCELERATION_ENERGY] = of_acceleration
    energy_report[RESOLVED] = resolved


@inlined_kernel
def bodies_energy(bodies, trees, q, v):
    """Kinetic energy [J] of velocities v (n,) at q (n,)."""
    total = 0.0
    place_rare_points(trees, q)
    for b in range(len(bodies)):
        body = bodies[b]
        place_body(body, q)
        total += twice_energy(body, v[body.first :])
    return 0.5 * total


@kernel
def set_energies_of_spins(bodies, duration, energies):
    """w^2 w . J w / 2 [J/s^2]: what a . M a / 2 of coordinates lacks where bodies turn in space.

    A spin counts the less, the more often a body turns round in a run: its angle at the end hardly matters.

    bodies: (k,) records, with the spins w of the last evaluation; in the plane, angles add up.
    duration: of the run [s].   energies: (n,) output, at the first coordinates of bodies.
    """
    for b in range(len(bodies)):
        body, squared, twice = bodies[b], 0.0, 0.0
        if body.rotations > 1:
            for i in range(3):
                squared += body.spin[i] ** 2
                for j in range(3):
                    twice += body.spin[i] * body.mass[3 + i, 3 + j] * body.spin[j]
            counted = squared / max(1.0, np.sqrt(squared) * duration / TURNED)
            energies[body.first] = 0.5 * counted * twice


def leave_out_turns(bodies, way):
    """Take whole turns off the angles of bodies in space, in place.   bodies: (k,) records.   way: (n,)."""
    for body in bodies[bodies["rotations"] == 3]:
        at = body["first"] + body["translations"]
        way[at : at + 3] = np.remainder(way[at : at + 3] + np.pi, 2.0 * np.pi) - np.pi


@kernel
def subtract_inertia_forces(bodies, trees, q, v, force):
    """Take those of all bodies that move with v (n,) at q (n,) off the forces (n,)."""
    place_rare_points(trees, q)
    move_rare_points(trees, q, v)
    for b in range(len(bodies)):
        body = bodies[b]
        place_body(body, q)
        move_body(body, q, v)
        subtract_inertia(body, force[body.first :])


@kernel
def joint_violation(system, functions, q):
    """Largest |c| of the joints at q (n,).   system: `placed`.   functions: (F,) of time."""
    items = system.items
    move_rows(items.joints.rows, functions)
    for b in range(len(items.bodies)):
        place_body(items.bodies[b], q)
    _place_points(items, q)
    set_values(items.joints, items.points)
    return largest_value(items.joints, 0.0)


@kernel
def subtract_joint_forces(system, force):
    """force -= J^T nu (n,), with the multipliers of the last evaluation.   system: `placed`."""
    subtract_forces(system.items.joints, force)


@protocol
def finish_step(system, q, v, left, total):
    """At the end of a step, in the state (q, v); whether a joint depends on others: 1 or 0.

    left: number of intervals from the present one to the last.   total: memory of `path_work`, in one row.
    """


called_by_address(finish_step, VECTOR, VECTOR, COUNT, VECTOR)


@implements(finish_step, SceneSystem)
def finish_step_of_scene(system, q, v, left, total):
    items = system.items
    if items.counting[MODE] == ALL_BUT_FIRST:
        follow(total.reshape(items.path.shape), q, items.force)
    items.counting[EVALUATION] = 0
    items.counting[STEP] += 1
    check_friction(items.contacts, STEPS_BETWEEN if items.counting[STEP] % STEPS_BETWEEN == 0 else 0)
    row = len(items.history) - left
    for i in range(items.data.shape[1]):
        items.data[START, i] = items.history[row, i] = items.data[NOW, i]
    return 1.0 if len(items.joints.rows) > 0 and items.joints.dependent[0] >= 0 else 0.0


@kernel
def take_steps(scheme, system, loads, state, h, done, in_interval, history, total, before):
    """Steps of h [s], one for each row of the load history.

    Args:
        scheme, system, state: see `integrators.integrator.advance`; a scene, called by address.
        loads: history of all steps.
        done: number of steps since the beginning of the history.   in_interval: steps in one of it.
        history: (intervals, 3, n) output, at the ends of intervals.
        total: memory of the work of whole steps, see `scene.path_work`; counted where not each evaluation is.
        before: (2, n) output: q and a before the last step.

    It ends before them if a joint depends on others.
    """
    steps = loads.factor.shape[0]
    for step in range(steps):
        if step == steps - 1:
            for i in range(len(state.q)):
                before[0, i], before[1, i] = state.q[i], state.a[i]
        one = LoadHistory(loads.constant, loads.pattern, loads.factor[step : step + 1], loads.work)
        interval = (done + step) // in_interval
        advance(scheme, system, one, state, h, 1, history[interval : interval + 1])
        settle_contacts(system, state.q, state.v)
        if finish_step(system, state.q, state.v, len(history) - interval, total.reshape(-1)) > 0.0:
            break


@kernel
def evaluate_states(system, scene, loads, history, multipliers, forces, external, rate):
    """Accelerations and multipliers of states, neither stabilised nor with what earlier steps taught.

    Args:
        system: that has taken no steps.   scene: the same one, `placed`.   loads: history, one row a state.
        history: (k, 3, n) coordinates and velocities, and output: accelerations; that of contacts is given.
        multipliers: (k, m) output.   forces: (k, n) output, of items and joints.   external, rate: memory.
    """
    items = scene.items
    for k in range(len(history)):
        q, v, a = history[k, 0], history[k, 1], history[k, 2]
        external_force(loads, k, 0, external)
        for i in range(items.data.shape[1]):
            items.data[NOW, i] = items.history[k, i]
        accelerate_and_project(system, external, q, v, 0.0, a, rate)
        for r in range(multipliers.shape[1]):
            multipliers[k, r] = items.joints.multipliers[r]
        for i in range(forces.shape[1]):
            forces[k, i] = items.force[i]
        subtract_forces(items.joints, forces[k])
