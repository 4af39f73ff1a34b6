"""The compiled form of a scene, compared with what Exudyn says of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..multibody.build import build_scene
from ..multibody.joints import effect_of_joints
from ..multibody.scene import accelerate_and_project_scene, subtract_inertia_forces
from ..run.compiled_scene import CompiledScene, SceneLoads, cables_of_kinds
from ..run.parts_in_one import CompiledParts
from ..scene.bodies import bodies_rates
from .known.scene import read_known_items
from .known.unknown import UnknownItemError

if TYPE_CHECKING:
    from .coupled_scene import CoupledCable, CoupledScene

MOST_KINDS = 2  # of cables
TOLERANCE = 1e-9  # of forces, accelerations, joints and their rates, relative
OF_DIFFERENCES = 1e-4  # of second derivatives, which Exudyn's side finds by differences
SMALLEST = 1e-6  # scale of forces and accelerations
STATES = 3  # random ones, besides the first
WAY, SPEED = 0.01, 1.0  # of random states [m, -] from the first one, and [m/s, 1/s]


def compiled_parts(scene: CoupledScene, t: float, q: Array, v: Array) -> CompiledParts:
    """The cables, bodies and joints of a scene in compiled code; arguments: see `compiled_form`."""
    form = compiled_form(scene, t, q, v, has_forces=False)
    return CompiledParts(form, scene.map.slices[-1])


def compiled_form(
    scene: CoupledScene, t: float, q: Array, v: Array, has_forces: bool = True
) -> CompiledScene:
    """The same scene in compiled code, which agrees with it about the state (q, v) at t [s].

    Args:
        scene: that Exudyn evaluates, in the state (q, v) of all parts.
        has_forces: whether it has the springs and loads.

    Raises:
        UnknownItemError: there is none; the message says of what, or where they differ.
    """
    places = scene.map.slices[:-1]
    loads = [cable.loads for cable in scene.cables]
    if len(scene.groups) > MOST_KINDS:
        raise UnknownItemError(f"cables of more than {MOST_KINDS} kinds")
    if len(scene.held.numbers):
        raise UnknownItemError("held coordinates")
    if not_compiled := next(filter(None, (of_cable.not_compiled for of_cable in loads)), ""):
        raise UnknownItemError(not_compiled)
    on_cables = places[-1].stop if places else 0
    scene.surroundings.forces(t, q, v)  # mbs is in this state, too
    elsewhere = scene.elsewhere.union(cable.number for cable in scene.cables)
    known, numbers = read_known_items(
        scene.mbs, scene.bodies, scene.joints, scene.map, on_cables, elsewhere, q, has_forces
    )
    if len(known.rows) != len(scene.system.foresight):
        raise UnknownItemError("equations of joints")
    cables = cables_of_kinds(scene.groups, loads)
    acting = SceneLoads(loads, known.functions)
    external = sum(len(of_cable.constant) for of_cable in loads)
    native = scene.system
    still = _held_coordinates(scene.cables)
    system = build_scene(cables, external, places, known, scene.size, native.zeta, native.foresight, still)
    if not scene.body_system.share_foresight(known.bodies["first"] - on_cables, known.bodies["foresight"]):
        raise UnknownItemError("bodies that share coordinates")
    own = [(place, c.system, c.loads) for place, c in zip(places, scene.cables, strict=True)]
    form = CompiledScene(system, acting, own, scene.surroundings.joints, numbers.read_again)
    require_agreement(scene, form, t, q, v, has_forces)
    return form


def _held_coordinates(cables: Sequence[CoupledCable]) -> np.ndarray:
    """(n_cables,) which coordinates supports hold."""
    chains = [cable.system.chain for cable in cables]
    held = [np.repeat(chain.nodes["free"].ravel() == 0.0, len(chain.axes)) for chain in chains]
    return np.concatenate([np.zeros(0, dtype=bool), *held])


def require_agreement(
    scene: CoupledScene, form: CompiledScene, t: float, q: Array, v: Array, has_forces: bool = True
) -> None:
    """Compare forces, masses and joints with Exudyn's, at (q, v) and at random states near to it.

    has_forces: whether the form has the springs and loads; otherwise they are given to it.

    Raises:
        UnknownItemError: they differ; the message says where.
    """
    random = np.random.default_rng(1)
    scales = np.full(len(scene.map.slices), SMALLEST)
    for number in range(1 + STATES):
        at, rates = q.copy(), v.copy()
        if number < STATES:  # the first state comes last: springs at rest have forces of round-off alone
            at += WAY * random.uniform(-1.0, 1.0, len(q))
            rates += SPEED * random.uniform(-1.0, 1.0, len(q))
            scene.map.repeat(at)
            scene.map.repeat(rates)
        _normalise(form.system.items.bodies, at)
        scene.surroundings.forces(t, at, rates)
        scene.body_system.project(rates[scene.map.slices[-1]])
        if not has_forces:
            form.given[:] = scene.surroundings.native_forces
            subtract_inertia_forces(form.system.items.bodies, at, rates, form.given)
        _compare_parts(scene, form, t, at, rates, scales)
        if scene.joints:
            _compare_joints(scene, form, t, at, rates)


def _normalise(bodies: Any, q: Array) -> None:
    """Quaternions in q (n,) to the norm of one, in place."""
    turning = bodies[bodies["rotations"] == 4]
    places = (turning["first"] + turning["translations"])[:, np.newaxis] + np.arange(4)
    p = q[places] + turning["reference"][:, 3:]
    q[places] += p / np.linalg.norm(p, axis=1, keepdims=True) - p


def _compare_parts(
    scene: CoupledScene, form: CompiledScene, t: float, q: Array, v: Array, scales: Array
) -> None:
    """Forces on the cables, and accelerations of the bodies without joints.

    scales: largest ones of each part so far, which are brought up to date.
    """
    given = scene.surroundings.forces(t, q, v)
    bodies, items, number = scene.map.slices[-1], form.system.items, form.system.cable_dofs
    wanted, found, rate = np.zeros((3, len(q)))
    bodies_rates(scene.body_system, given[-1], q[bodies], v[bodies], wanted[bodies], rate[bodies])
    accelerate_and_project_scene(form.system, form.loads.at(t), q, v, 0.0, found, rate)
    of_joints, pulls = effect_of_joints(items.joints, len(q))
    found += of_joints
    wanted[:number], found[:number] = scene.surroundings.native_forces[:number], items.force[:number]
    for k, dofs in enumerate(scene.map.slices):
        scales[k] = max(float(np.abs(x[dofs]).max(initial=scales[k])) for x in (wanted, pulls))
        wrong = np.flatnonzero(~(np.abs(wanted - found)[dofs] <= TOLERANCE * scales[k]))
        if len(wrong):
            where = scene.coordinate_name(scene.map.indices[dofs][wrong[0]])
            raise UnknownItemError(f"{where}, on which Exudyn's forces are others")


def _compare_joints(scene: CoupledScene, form: CompiledScene, t: float, q: Array, v: Array) -> None:
    """Values, rates and second derivatives along the motion, as `_compare_parts` has left them."""
    terms, joints = scene.surroundings.constrain(t, q, v), form.system.items.joints
    size, speed = max(1.0, float(np.abs(q).max())), max(1.0, float(np.abs(v).max()))
    rates = np.zeros(len(joints.value))
    for block in scene.surroundings.blocks:
        rates[block.rows] += block.jacobian @ v[block.dofs]
    drift = -joints.rows["drift"][:, 0]
    acceleration = max(size * speed**2, float(np.abs(joints.gamma).max()))
    compared = (
        (terms.value, joints.value, TOLERANCE * size),
        (rates, joints.rate - drift, TOLERANCE * size * speed),
        (terms.gamma, joints.gamma, OF_DIFFERENCES * acceleration),
        (terms.drift, drift, OF_DIFFERENCES * max(1.0, float(np.abs(drift).max(initial=0.0)))),
    )
    for wanted, found, tolerance in compared:
        wrong = np.flatnonzero(~(np.abs(wanted - found) <= tolerance))
        if len(wrong):
            raise UnknownItemError(f"{scene.surroundings.joints[wrong[0]]} which Exudyn evaluates otherwise")
