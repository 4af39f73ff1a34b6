"""Random scenes: ropes that are released in any direction, alone, and with bodies, springs and contact.

A scene follows from its seed. All are 1 m long and have 0.1 kg/m.
"""

from dataclasses import dataclass
from typing import Any

import exudyn
import exudyn.utilities as items
import numpy as np

from examples.contact import Surface, add_circle_contact
from exudyn_inext import AttachToBody, CableShape, CreateInextensibleCable, InextensibleCable
from reference_models.conventional.native_cables import NativeCables
from reference_models.conventional.supports import add_constraint
from reference_models.scenes import Clamp, Pin
from reference_models.trajectory import Array
from studies.harness.stretching_scenes import hang_mass

LENGTH, DENSITY, GRAVITY = 1.0, 0.1, [0.0, -9.81, 0.0]  # [m], [kg/m], [m/s^2]
STRETCH = 1e4  # axial stiffness of native cables [N]: strains of 2e-3 under the largest weights at rest
LONE, MASS, BODY, SPRING, CONTACT = "lone", "mass point", "rigid body", "springs", "contact"
MIXED = (MASS, BODY, SPRING, CONTACT)


@dataclass(frozen=True)
class Rope:
    """A random rope.

    stiffness: EI [N m^2].   tip_mass: [kg].   direction: (dim,) unit vector in which it lies at the start.
    clamped: whether its slope is held, too.   partner: what else is in the scene.
    """

    seed: int
    elements: int
    stiffness: float
    tip_mass: float
    direction: tuple[float, ...]
    clamped: bool
    partner: str = LONE

    @property
    def dimension(self) -> int:
        return len(self.direction)

    @property
    def end(self) -> list[float]:
        """Its free end at the start (3,) [m]."""
        return [LENGTH * x for x in (*self.direction, 0.0)[:3]]


def lone_rope(seed: int) -> Rope:
    """A rope with or without a point mass at its end."""
    random = np.random.default_rng(seed)
    stiffness = float(10.0 ** random.uniform(-5.0, 0.0))
    elements = int(random.integers(4, 25))
    tip_mass = float(random.choice([0.0, 0.3, 2.0]))
    dimension = int(random.choice([2, 3]))
    clamped = bool(random.integers(0, 2))
    direction = random.normal(size=dimension)
    unit = tuple((direction / np.linalg.norm(direction)).tolist())
    return Rope(seed, elements, stiffness, tip_mass, unit, clamped)


def mixed_rope(seed: int) -> Rope:
    """A rope with something else; contact is planar, and below."""
    rope = lone_rope(seed)
    partner = MIXED[seed % len(MIXED)]
    direction = rope.direction
    if partner == CONTACT:
        x, y = direction[:2]
        direction = (x / np.hypot(x, y), abs(y) / np.hypot(x, y))
    return Rope(seed, rope.elements, rope.stiffness, 0.0, direction, rope.clamped, partner)


def build(rope: Rope, add_cable: Any = CreateInextensibleCable) -> tuple[Any, Any, int]:
    """Container, assembled mbs, sensor of the free end's position.   add_cable: or `NATIVE`."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    template = InextensibleCable(massPerLength=DENSITY, bendingStiffness=rope.stiffness)
    shape = CableShape.Line([0.0, 0.0, 0.0], rope.end, rope.elements)
    cable = add_cable(mbs, shape=shape, beamTemplate=template, gravity=GRAVITY, dimension=rope.dimension)
    nodes = cable["nodes"]
    add_constraint(mbs, nodes[0], (Clamp if rope.clamped else Pin)(at=0.0), rope.dimension)
    if rope.tip_mass:
        hang_mass(mbs, cable, rope.end, rope.tip_mass, GRAVITY, add_cable is CreateInextensibleCable)
    if rope.partner in _PARTNERS:
        random = np.random.default_rng(rope.seed + 1_000_000)
        mass = float(random.choice([0.1, 0.3, 1.0]))
        _PARTNERS[rope.partner](mbs, rope, cable, mass, random)
    position = exudyn.OutputVariableType.Position
    end = items.SensorNode(nodeNumber=nodes[-1], outputVariableType=position, storeInternal=True)
    sensor = int(mbs.AddSensor(end))
    mbs.Assemble()
    return container, mbs, sensor


NATIVE = NativeCables(STRETCH, "lobatto")


def _add_point(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    is_planar = rope.dimension == 2
    point = mbs.CreateMassPoint(mass=mass, referencePosition=rope.end, gravity=GRAVITY, create2D=is_planar)
    AttachToBody(mbs, cable, "end", point)


def _add_body(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """A cube, held at the middle of a face."""
    is_planar = rope.dimension == 2
    offset = np.array([0.0, -SIDE / 2, 0.0] if is_planar else [0.0, 0.0, SIDE / 2])
    centre, cuboid = np.add(rope.end, offset), items.InertiaCuboid(mass / SIDE**3, [SIDE] * 3)
    body = mbs.CreateRigidBody(referencePosition=centre, inertia=cuboid, gravity=GRAVITY, create2D=is_planar)
    AttachToBody(mbs, cable, "end", body, (-offset).tolist())


def _add_springs(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """Two springs to ground, one of them with a dashpot."""
    ground = mbs.CreateGround()
    stiffness = float(10.0 ** random.uniform(0.0, 3.0))
    for k, damping in ((rope.elements // 2, 0.0), (rope.elements, 0.01 * stiffness)):
        place = [k / rope.elements * x for x in rope.end]
        law = {"stiffness": [stiffness] * 3, "damping": [damping] * 3}
        ends = [ground, cable["nodes"][k]]
        mbs.CreateCartesianSpringDamper(itemNumbers=ends, localPosition0=place, **law)


def _add_circle(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """A circle that the rope falls onto."""
    side = 1.0 if rope.direction[0] >= 0.0 else -1.0
    stiffness = float(10.0 ** random.uniform(2.0, 4.0)) * SEGMENTS * rope.elements / LENGTH
    dashpot, friction = 1e-3 * stiffness, float(random.choice([0.0, 0.3]))
    surface = Surface(0.15, friction, stiffness, dashpot, 0.1 * stiffness, dashpot, SEGMENTS)
    add_circle_contact(mbs, cable["nodes"], LENGTH, surface, lambda s: False, [0.5 * side, -0.25, 0.0])


SIDE, SEGMENTS = 0.1, 3  # of the cube [m]; of an element in contact
_PARTNERS = {MASS: _add_point, BODY: _add_body, SPRING: _add_springs, CONTACT: _add_circle}


def moved(path: Array) -> float:
    """Largest distance of a path (T, 3) from its start [m]."""
    return float(np.linalg.norm(path - path[0], axis=1).max())
