"""A truly inextensible cable of another make: rigid links on hinges with springs, moved by MuJoCo.

n uniform links of length l = L / n. In the plane a joint is a hinge, in space a universal joint, that is two
hinges. The bending of half a link on each side of a joint gives a spring of stiffness EI / l, the half link
at a clamp 2 EI / l, and a pin has none: the trapezoidal rule for the energy of bending. Such a chain
converges with l^2. As long as the links are uniform rods, its errors of mass and springs cancel in bending
vibrations to that order; what is left is mainly that chords are shorter than arcs.

The universal joint of a pin is singular where the first link points along the y axis of its frame, in which
the cable starts along x. A ball joint would not help: a chain without torsion has no inertia about itself.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from exudyn_inext import DivergenceError
from exudyn_inext.checks import LARGEST_NUMBER_OF_ITEMS, require_integer, require_positive
from exudyn_inext.errors import InputError

from ..model import SENSOR_PERIOD
from ..scenes import Clamp, Line, Pin, Scene
from ..scenes.checks import Vector
from ..trajectory import Array, Case, Trajectory, Untimed

FORMULATION = "rigid links"
IMAGINARY_LIMIT = {"RK4": 2.0 * math.sqrt(2.0), "Euler": 2.0, "implicitfast": 2.0, "implicit": 2.0}
"""h w at which the scheme becomes unstable for an undamped oscillator; springs are explicit in all."""

_SLENDER = 1e-6  # inertia of a link about itself over that across: none, but MuJoCo wants a positive one
_TIP = "tip"


@dataclass(frozen=True)
class RigidLinks:
    """What distinguishes one chain from another.

    links: n.   step_size [s], the one used divides the sensors' period.   integrator: MuJoCo's name of it.
    rotary_inertia: of a link about its centre, over that of a uniform rod.
    """

    links: int
    step_size: float
    integrator: str = "RK4"
    rotary_inertia: float = 1.0

    def __post_init__(self) -> None:
        require_integer("links", self.links, 1, LARGEST_NUMBER_OF_ITEMS)
        require_positive("step_size", self.step_size)
        require_positive("rotary_inertia", self.rotary_inertia)

    @property
    def steps_per_sample(self) -> int:
        return max(1, math.ceil(SENSOR_PERIOD / self.step_size - 1e-9))


def is_installed() -> bool:
    """Whether MuJoCo can be imported."""
    try:
        import mujoco  # noqa: F401
    except ImportError:
        return False
    return True


def has_integrator(name: str) -> bool:
    """Whether the installed MuJoCo has an integrator of that name."""
    return f"mjINT_{name.upper()}" in _mujoco().mjtIntegrator.__members__


def build(scene: Scene, chain: RigidLinks) -> tuple[Any, Any]:
    """MuJoCo's model and data, in the initial state of the scene; its site 0 is the free end.

    Raises:
        InputError: MuJoCo is not installed, or it has no such integrator; a scene other than a straight cable
            that is pinned or clamped at its start, free at its end and loaded by gravity alone.
    """
    mujoco = _mujoco()
    if not has_integrator(chain.integrator):
        raise InputError(
            f"integrator = '{chain.integrator}' is unknown to MuJoCo {mujoco.__version__}; use 'RK4'."
        )
    _require_free_cable(scene)
    model = mujoco.MjModel.from_xml_string(_description(scene, chain))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    root = _joints(scene)
    data.qvel[:root] = np.linalg.lstsq(_tip_jacobian(model, data)[:, :root], scene.end_velocity, rcond=None)[
        0
    ]
    return model, data


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise InputError("MuJoCo is not installed; pip install 'exudyn_inext[peers]'.") from error
    return mujoco


def _require_free_cable(scene: Scene) -> None:
    owner = f"scene '{scene.name}'"
    if not isinstance(scene.cable.shape, Line) or scene.loads or scene.starts_from_equilibrium:
        raise InputError(
            f"{owner}: rigid links start along a Line, under gravity alone; use another formulation."
        )
    if [type(s) for s in scene.supports if s.at == 0.0] not in ([Pin], [Clamp]) or len(scene.supports) != 1:
        raise InputError(f"{owner}: rigid links hang on one Pin or Clamp at 0.0; got {scene.supports}.")
    if scene.observe[scene.main_point] != 1.0:
        raise InputError(f"{owner}: of rigid links, the free end is observed, at 1.0; got {scene.observe}.")


def _joints(scene: Scene) -> int:
    """Hinges between two links."""
    return 1 if scene.is_planar else 2


def _description(scene: Scene, chain: RigidLinks) -> str:
    """The chain in MuJoCo's own format: bodies that are nested, with given inertias and nothing else."""
    length = scene.cable.length / chain.links
    mass = scene.cable.section.mass_per_length * length
    inertia = chain.rotary_inertia * mass * length**2 / 12.0
    spring = scene.cable.section.bending_stiffness / length
    first = 2.0 * spring if isinstance(scene.supports[0], Clamp) else 0.0
    assert isinstance(scene.cable.shape, Line)
    x, y = _frame(scene.cable.shape.direction)
    inertial = (
        f'<inertial pos="{0.5 * length!r} 0 0" mass="{mass!r}" '
        f'diaginertia="{_SLENDER * inertia!r} {inertia!r} {inertia!r}"/>'
    )
    root = f'<body pos="{_text(scene.cable.shape.start)}" xyaxes="{_text(x)} {_text(y)}">'
    bodies = root + _hinges(scene, first) + inertial
    for _ in range(chain.links - 1):
        bodies += f'<body pos="{length!r} 0 0">' + _hinges(scene, spring) + inertial
    bodies += f'<site name="{_TIP}" pos="{length!r} 0 0"/>' + chain.links * "</body>"
    step = SENSOR_PERIOD / chain.steps_per_sample
    return (
        '<mujoco><compiler angle="radian"/>'
        f'<option timestep="{step!r}" gravity="{_text(scene.gravity)}" integrator="{chain.integrator}">'
        '<flag contact="disable" constraint="disable" autoreset="disable"/></option>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )


def _frame(direction: Vector) -> tuple[Array, Array]:
    """x along the cable; y across it and, if that can be, in the x-y plane."""
    x = np.array(direction)
    y = np.cross([0.0, 0.0, 1.0], x)
    if np.linalg.norm(y) < 1e-6:
        y = np.array([0.0, 1.0, 0.0])
    return x, y / np.linalg.norm(y)


def _hinges(scene: Scene, stiffness: float) -> str:
    axes = ("0 0 1",) if scene.is_planar else ("0 1 0", "0 0 1")
    return "".join(f'<joint axis="{axis}" stiffness="{stiffness!r}"/>' for axis in axes)


def _text(vector: Any) -> str:
    return " ".join(repr(float(value)) for value in vector)


def _tip_jacobian(model: Any, data: Any) -> Array:
    """Velocity of the free end over those of the joints (3, n_joints)."""
    jacobian = np.zeros((3, model.nv))
    _mujoco().mj_jacSite(model, data, jacobian, None, 0)
    return jacobian


def largest_frequency(model: Any, data: Any) -> float:
    """w_max [rad/s] of the straight chain, gravity aside."""
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv), strict=True):
        _mujoco().mj_mulM(model, data, column, unit)
    return float(np.sqrt(eigh(np.diag(np.ravel(model.jnt_stiffness)), mass, eigvals_only=True)[-1]))


def largest_step(scene: Scene, chain: RigidLinks) -> float:
    """Stability limit [s] of the straight chain; infinite where none is known."""
    limit = IMAGINARY_LIMIT.get(chain.integrator, math.inf)
    return limit / largest_frequency(*build(scene, chain))


def prepare(scene: Scene, chain: RigidLinks) -> "Stepping":
    """A run that is ready to go."""
    return Stepping(scene, *build(scene, chain), chain.steps_per_sample)


@dataclass(frozen=True, eq=False)
class Stepping:
    """Steps to the end of the motion, and stores the joints' coordinates at each sample."""

    scene: Scene
    model: Any
    data: Any
    steps: int

    def __call__(self) -> Untimed:
        """Returns a function that gives the path of the free end; nothing but MuJoCo's steps is timed.

        Raises:
            DivergenceError: MuJoCo warns of huge values.
        """
        mujoco, model, data = _mujoco(), self.model, self.data
        coordinates = np.zeros((round(self.scene.end_time / SENSOR_PERIOD) + 1, model.nq))
        coordinates[0] = data.qpos
        with _silence():
            for sample in range(1, len(coordinates)):
                mujoco.mj_step(model, data, self.steps)
                coordinates[sample] = data.qpos
        lost = [name for name in ("BADQPOS", "BADQVEL", "BADQACC") if _warnings(data, name)]
        if lost:
            raise DivergenceError(
                f"MuJoCo warns of {', '.join(lost)} (h = {model.opt.timestep:g} s); use a smaller step."
            )
        return lambda: self._path(coordinates)

    def _path(self, coordinates: Array) -> Trajectory:
        positions = np.zeros((len(coordinates), 3))
        for sample, joints in enumerate(coordinates):
            self.data.qpos[:] = joints
            _mujoco().mj_kinematics(self.model, self.data)
            positions[sample] = self.data.site_xpos[0]
        return Trajectory(SENSOR_PERIOD * np.arange(len(coordinates)), positions)


def _warnings(data: Any, name: str) -> int:
    return int(data.warning[getattr(_mujoco().mjtWarning, f"mjWARN_{name}")].number)


@contextmanager
def _silence() -> Iterator[None]:
    """Warnings are counted in the data; they need not be printed, nor written to a file."""
    mujoco = _mujoco()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)


def rigid_links_case(scene: Scene, chain: RigidLinks) -> Case:
    """One row of a comparison; elements are links."""
    per_sample = chain.steps_per_sample
    return Case(
        label=_label(chain),
        formulation=FORMULATION,
        integrator=chain.integrator,
        elements=chain.links,
        step_size=SENSOR_PERIOD / per_sample,
        steps=round(scene.end_time / SENSOR_PERIOD) * per_sample,
        prepare=lambda: prepare(scene, chain),
        details={"rotaryInertia": chain.rotary_inertia},
    )


def _label(chain: RigidLinks) -> str:
    step = SENSOR_PERIOD / chain.steps_per_sample
    inertia = f", rotary inertia times {chain.rotary_inertia:.3g}" if chain.rotary_inertia != 1.0 else ""
    return f"rigid links, {chain.integrator}, n = {chain.links}, h = {step:.3g} s{inertia}"
