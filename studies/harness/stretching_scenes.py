"""Scenes whose cables stretch, with native cables of the same axial stiffness: what `stretch` solves."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from exudyn.itemInterface import LoadForceVector, MarkerNodePosition, SphericalJoint

from exudyn_inext import AddPointMass, CableShape, CreateInextensibleCable, InextensibleCable
from reference_models.conventional.supports import add_constraint
from reference_models.scenes import Pin, load_scene

from .coupled_scenes import CoupledScene

Build = Callable[..., dict[str, Any]]

PENDULUM, LINE = load_scene("planar_pendulum"), load_scene("power_line")
LENGTH, SECTION, REAL = PENDULUM.cable.length, PENDULUM.cable.section, LINE.cable.section
DENSITY = SECTION.mass_per_length
BUNGEE, WEIGHT = 20.0, 0.4  # axial stiffness [N], mass at its end [kg]
STRING, PRETENSION, BEND = 4e3, 0.01, 2e-3  # axial stiffness [N], strain [-], bending stiffness [N m^2]
PLUCK = {1: 4.0, 2: 2.0}  # half-waves along the string: velocity at the start [m/s]
SHEDDING = 0.05  # time in which the ice falls off [s]


def pendulum(
    mbs: Any,
    addCable: Build = CreateInextensibleCable,
    elements: int = 10,
    stiffness: float | None = SECTION.axial_stiffness,
    mass: float = 0.0,
    gravity: float = 9.81,
    dimension: int = 2,
) -> dict[str, Any]:
    """Released from the horizontal, with a mass [kg] at its end.   stiffness: [N]; None: inextensible."""
    template = InextensibleCable(DENSITY, SECTION.bending_stiffness, axialStiffness=stiffness)
    line, down = CableShape.Line([0, 0], [LENGTH, 0], elements), [0, -gravity, 0]
    cable = addCable(mbs, shape=line, beamTemplate=template, gravity=down, dimension=dimension)
    add_constraint(mbs, cable["nodes"][0], Pin(at=0.0), dimension)
    if mass:
        hang_mass(mbs, cable, [LENGTH, 0, 0], mass, down, addCable is CreateInextensibleCable)
    return {"cables": [cable], "bodies": []}


def hang_mass(
    mbs: Any, cable: Any, end: Sequence[float], mass: float, gravity: Sequence[float], is_part: bool
) -> None:
    """At the end of a straight cable from the origin: as a part of it, or on a joint.   mass: [kg]."""
    if is_part:
        AddPointMass(mbs, cable, float(np.linalg.norm(end)), mass)
        return
    body = mbs.CreateMassPoint(referencePosition=end, mass=mass, gravity=gravity, returnDict=True)
    numbers = (cable["nodes"][-1], body["nodeNumber"])
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=number)) for number in numbers]
    mbs.AddObject(SphericalJoint(markerNumbers=ends))


def string(mbs: Any, addCable: Build = CreateInextensibleCable, elements: int = 8) -> dict[str, Any]:
    """Pinned straight, too short for its supports, and plucked."""
    template = InextensibleCable(DENSITY, BEND, axialStiffness=STRING, referenceAxialStrain=-PRETENSION)
    x, wave = np.linspace(0.0, LENGTH, elements + 1), np.pi / LENGTH
    v, slope_v = np.zeros((2, elements + 1, 2))
    v[:, 1] = sum(speed * np.sin(k * wave * x) for k, speed in PLUCK.items())
    slope_v[:, 1] = sum(k * wave * speed * np.cos(k * wave * x) for k, speed in PLUCK.items())
    v[[0, -1]] = 0.0
    shape = CableShape(np.outer(x, [1, 0]), np.outer(x**0, [1, 0]), velocities=v, slopeVelocities=slope_v)
    cable = addCable(mbs, shape=shape, beamTemplate=template)
    for node in (cable["nodes"][0], cable["nodes"][-1]):
        add_constraint(mbs, node, Pin(at=0.0), 2)
    return {"cables": [cable], "bodies": []}


def power_line(mbs: Any, addCable: Build = CreateInextensibleCable, elements: int = 12) -> dict[str, Any]:
    """Of the paper, with its real axial stiffness; the ice falls off within a short time."""
    template = InextensibleCable(
        REAL.mass_per_length, REAL.bending_stiffness, axialStiffness=REAL.axial_stiffness
    )
    shape = CableShape(*LINE.cable.nodes(elements), LINE.cable.length / elements, lengthReference="straight")
    cable = addCable(mbs, shape=shape, beamTemplate=template, gravity=LINE.gravity)
    for support in LINE.supports:
        add_constraint(mbs, cable["nodes"][round(support.at * elements)], support, 2)
    (ice,) = LINE.start_loads
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][round(ice.at * elements)]))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=ice.force, loadVectorUserFunction=_falling))
    return {"cables": [cable], "bodies": []}


def _falling(mbs: Any, time: float, force: Sequence[float]) -> list[float]:
    share = 0.5 + 0.5 * np.cos(np.pi * min(time / SHEDDING, 1.0))
    return [float(share * component) for component in force]


bungee = partial(pendulum, stiffness=BUNGEE, mass=WEIGHT)

MESHES, STEPS = (2, 4, 6, 8, 12, 16), (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4)  # [-], [s]
SCENES = (
    CoupledScene(
        "pendulum", pendulum, 5.0, MESHES, (SECTION.axial_stiffness,), (96, 2e-4), STEPS, is_quick=True
    ),
    CoupledScene("bungee", bungee, 2.0, MESHES, (BUNGEE,), (40, 2e-4), STEPS),
    CoupledScene("string", string, 1.0, MESHES, (STRING,), (40, 5e-5), (*STEPS[3:], 2e-4, 1e-4)),
    CoupledScene(
        "power line",
        power_line,
        2.0,
        (4, 8, 12, 16, 24, 32, 48, 64),
        (REAL.axial_stiffness,),
        (96, 2e-4),
        STEPS,
        settles=True,
        is_small=False,
    ),
)
