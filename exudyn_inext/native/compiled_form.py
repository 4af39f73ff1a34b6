"""The compiled form of a scene, compared with what Exudyn says of it."""

from functools import lru_cache, partial
from typing import Any

import numpy as np

from ..arrays import Array
from ..items.functions_of_time import step_functions
from ..multibody.build import build_scene, held_coordinates
from ..multibody.scene import subtract_inertia_forces
from ..run.compiled_scene import CompiledScene, cables_of_scene
from ..run.load_functions import LoadFunctions, StateFunctions
from ..run.parts_in_one import CompiledParts
from ..run.scene_loads import SceneLoads
from ..run.spring_functions import SpringFunctions
from ..scene.bodies import bodies_rates
from .evaluated_scene import SceneOfExudyn
from .joint_rows import JointRows
from .known.contacts import disturb
from .known.scene import read_known_items
from .known.unknown import UnknownItemError

TOLERANCE = 1e-9  # of forces, accelerations, joints and their rates, relative
OF_DIFFERENCES = 1e-4  # of second derivatives, which Exudyn's side finds by differences
SMALLEST = 1e-6  # scale of forces and accelerations
STATES = 3  # random ones, besides the first
WAY, SPEED = 0.01, 1.0  # of random states [m, -] from the first one, and [m/s, 1/s]
ALONG = 0.1  # that way at most, of the elements along which joints slide: they stay clear of folds


def compiled_parts(scene: SceneOfExudyn, t: float, q: Array, v: Array) -> CompiledParts:
    """The cables, bodies and joints of a scene in compiled code; arguments: see `compiled_form`."""
    form = compiled_form(scene, t, q, v, has_forces=False)
    return CompiledParts(form, scene.size - len(scene.map.indices))


def compiled_form(
    scene: SceneOfExudyn, t: float, q: Array, v: Array, has_forces: bool = True, follows_state: bool = False
) -> CompiledScene:
    """The same scene in compiled code, which agrees with it about the state (q, v) at t [s].

    Args:
        scene: that Exudyn evaluates, in the state (q, v) of all parts.
        has_forces: whether it has the springs and loads.
        follows_state: whether functions of loads may depend on the state.

    Raises:
        UnknownItemError: there is none; the message says of what, or where they differ.
    """
    places = scene.map.slices[:-1]
    loads = [cable.loads for cable in scene.cables]
    if len(scene.held.numbers):
        raise UnknownItemError("held coordinates")
    if not_compiled := next(filter(None, (of_cable.not_compiled for of_cable in loads)), ""):
        raise UnknownItemError(not_compiled)
    on_cables = places[-1].stop if places else 0
    q, v = _with_unit_quaternions(scene.rows, np.array([[q, v]]))[0]
    scene.native_items.set_state(t, q, v)
    known, numbers = read_known_items(scene, q, has_forces, follows_state)
    scene.native_items.forget()
    if len(known.rows) != len(scene.system.drift_correction):
        raise UnknownItemError("equations of joints")
    chains = [system for system, _ in scene.groups]
    of_loads, of_springs = LoadFunctions(numbers.functions), SpringFunctions(numbers.asked_springs)
    if numbers.asked_springs or not all(function.is_pure for function in numbers.functions):
        of_loads = StateFunctions(numbers.functions, partial(_bring, scene, known.data), of_springs)
    follows = has_forces and bool(step_functions(scene.mbs))
    acting = SceneLoads(loads, known.functions, numbers.moved, of_loads, follows)
    native = scene.system
    still = held_coordinates([cable.system for cable in scene.cables])
    cables = cables_of_scene(scene.groups, loads)
    memory = native.drift_correction, still, scene.path
    system = build_scene(cables, chains, places, known, scene.size, native.zeta, *memory)
    if not scene.body_system.share_drift_correction(
        known.bodies["first"] - on_cables, known.bodies["drift_correction"]
    ):
        raise UnknownItemError("bodies that share coordinates")
    own = list(zip(places, scene.cable_systems, loads, strict=True))
    joints = scene.native_items.joints
    of_springs.take(system)
    form = CompiledScene(system, chains, acting, own, joints, numbers)
    require_agreement(scene, form, t, q, v, has_forces)
    return form


def _bring(scene: SceneOfExudyn, data: Array, t: float, q: Array, v: Array) -> None:
    """Bring mbs to a state, with these data of contacts, and distances of a GeneralContact there."""
    scene.native_items.forget()
    if data.shape[1]:
        scene.mbs.systemData.SetDataCoordinates(data[0].tolist())
    scene.native_items.set_state(t, q, v)
    for contact in active_general_contacts(scene.mbs):
        contact.UpdateContacts(scene.mbs)


def require_agreement(
    scene: SceneOfExudyn, form: CompiledScene, t: float, q: Array, v: Array, has_forces: bool = True
) -> None:
    """Compare forces, masses and joints with Exudyn's, at (q, v) and at random states near to it.

    has_forces: whether the form has the springs and loads; otherwise they are given to it.

    Raises:
        UnknownItemError: they differ; the message says where.
    """
    wanted, found, external = [], [], form.loads.at(t)
    states, remembered = _states(scene, q, v), form.data[0].copy()
    random = np.random.default_rng(1) if form.remembers else None
    for number, (at, rates) in enumerate(states):
        if number and random:
            disturb(form.data, form.contacts.records, form.system.items.connectors, random)
        scene.remember(form.data)
        if not form.remembers:  # else a GeneralContact does nothing, and nothing else may settle
            settle_general_contact(scene, t, at, rates)
        given = scene.native_items.act(t, at, rates)[scene.map.slices[-1]]
        if not has_forces:
            form.given[: len(scene.map.indices)] = scene.native_items.native_forces
            items = form.system.items
            subtract_inertia_forces(items.bodies, items.trees, at, rates, form.given)
            form.weigh()
        found.append(_evaluated(form, external, at, rates, len(scene.map.indices)))
        wanted.append(_evaluated_by_exudyn(scene, t, at, rates, given, form.multipliers))
        if number and form.remembers:
            _compare_contacts(scene, form, t, at, rates)
    form.data[:] = remembered
    if not form.remembers:
        settle_general_contact(scene, t, q, v)
    parts, own_parts = (np.array([one[0] for one in side]) for side in (wanted, found))
    _compare_parts(scene, parts, own_parts, np.array([sizes for _, _, sizes in wanted]))
    if scene.joints:
        size, speed = np.abs(states).max(axis=(0, 2), initial=1.0).tolist()
        rows, own_rows = (np.array([one[1] for one in side]) for side in (wanted, found))
        _compare_joints(scene, rows, own_rows, size, speed)


def settle_general_contact(scene: SceneOfExudyn, t: float, q: Array, v: Array) -> None:
    """Let a GeneralContact act as it does at (t, q, v), whoever has looked at another state."""
    if scene.mbs.NumberOfGeneralContacts():
        scene.native_items.settled(t, q, v)


def active_general_contacts(mbs: Any) -> list[Any]:
    """Those of mbs that are switched on."""
    contacts = map(mbs.GetGeneralContact, range(mbs.NumberOfGeneralContacts()))
    return [contact for contact in contacts if contact.isActive]


def _states(scene: SceneOfExudyn, q: Array, v: Array) -> Array:
    """(1 + STATES, 2, n) coordinates and velocities, the given ones first."""
    states = np.tile(np.array([q, v]), (1 + STATES, 1, 1))
    way = min(WAY, ALONG * scene.rows.shortest)
    states[1:] += _random_changes(len(q)) * np.array([[way], [SPEED]])
    scene.map.repeat(states)
    return _with_unit_quaternions(scene.rows, states)


@lru_cache(maxsize=8)
def _random_changes(size: int) -> Array:
    """(STATES, 2, size) of coordinates and velocities, at most 1, always the same ones."""
    return np.random.default_rng(1).uniform(-1.0, 1.0, (STATES, 2, size))


def _with_unit_quaternions(rows: JointRows, states: Array) -> Array:
    """The same states (k, 2, n), see `_states`, in which quaternions have, and keep, the norm of one."""
    if not len(rows.quaternions):
        return states
    p, rate = np.moveaxis(states[:, :, rows.quaternions], 1, 0)
    p = p + rows.references
    normal = p / np.sqrt((p * p).sum(axis=2, keepdims=True))
    states[:, 0, rows.quaternions] += normal - p
    states[:, 1, rows.quaternions] -= normal * (normal * rate).sum(axis=2, keepdims=True)
    return states


def _evaluated(form: CompiledScene, external: Array, q: Array, v: Array, number: int) -> tuple[Array, Array]:
    """(number,) forces on the cables, and accelerations of the bodies; and (4, m) of joints."""
    system, (result, rate) = form.system, np.zeros((2, len(q)))
    form.accelerate(external, q, v, 0.0, result, rate)
    result[: system.cable_dofs] = system.items.force[: system.cable_dofs]
    joints = system.items.joints
    drift = -joints.rows["drift"]
    rows = np.array([joints.value, joints.rate - drift, joints.gamma, drift])
    return result[:number], rows[:, : joints.holding]


def _evaluated_by_exudyn(
    scene: SceneOfExudyn, t: float, q: Array, v: Array, given: Array, multipliers: Array
) -> tuple[Array, Array, Array]:
    """As `_evaluated`, with these multipliers (m,) of the joints.   given: forces on the bodies.

    Of the joints: values, rates, second derivatives along the motion, and rates of what moves them. The last
    result is the sizes (n,) of what may cancel: accelerations by each row of the joints.
    """
    result, bodies, rows = scene.native_items.native_forces.copy(), scene.map.slices[-1], np.zeros((4, 0))
    if scene.joints:
        terms = scene.native_items.constrain(t, q, v)
        rows = np.array([terms.value, np.zeros(len(terms.value)), terms.gamma, terms.drift])
    rate = np.zeros(bodies.stop - bodies.start)
    bodies_rates(scene.body_system, given, q[bodies], v[bodies], result[bodies], rate)
    sizes = np.abs(result)
    for block in scene.native_items.blocks:
        rows[1, block.rows] += block.jacobian @ v[block.dofs]
        if block.dofs == bodies:
            pulls = scene.body_system.responses(multipliers[block.rows, np.newaxis] * block.jacobian)
            result[bodies] -= pulls.sum(axis=0)
            sizes[bodies] += np.abs(pulls).sum(axis=0)
    return result, rows, sizes


def _compare_parts(scene: SceneOfExudyn, wanted: Array, found: Array, sizes: Array) -> None:
    """wanted, found, sizes: (states, n)."""
    for dofs in scene.map.slices:
        scale = sizes[:, dofs].max(initial=SMALLEST)
        wrong = np.flatnonzero(~(np.abs(wanted - found)[:, dofs] <= TOLERANCE * scale).all(axis=0))
        if len(wrong):
            where = scene.coordinate_name(scene.map.indices[dofs][wrong[0]])
            raise UnknownItemError(f"{where}, on which Exudyn's forces are others")


def _compare_contacts(scene: SceneOfExudyn, form: CompiledScene, t: float, q: Array, v: Array) -> None:
    """What contacts remember once they have settled."""
    form.settle(t, q, v)
    wanted, found = scene.native_items.settled(t, q, v), form.data[0]
    scale = max(1.0, float(np.abs(wanted).max(initial=0.0)))
    if not (np.abs(wanted - found) <= TOLERANCE * scale).all():
        raise UnknownItemError("contact, which Exudyn settles otherwise")


def _compare_joints(scene: SceneOfExudyn, wanted: Array, found: Array, size: float, speed: float) -> None:
    """wanted, found: (states, 4, m).   size, speed: largest coordinate and velocity, at least 1."""
    gamma, drift = np.abs(found[:, 2:]).max(axis=(0, 2)).tolist()
    gamma, drift = OF_DIFFERENCES * max(size * speed**2, gamma), OF_DIFFERENCES * max(size, drift)
    tolerance = (TOLERANCE * size, TOLERANCE * size * speed, gamma, drift)
    is_right = (np.abs(wanted - found) <= np.array(tolerance)[:, np.newaxis]).all(axis=(0, 1))
    if not is_right.all():
        which = scene.native_items.joints[int(np.argmin(is_right))]
        raise UnknownItemError(f"{which} which Exudyn evaluates otherwise")
