"""Small scenes that bad calls meet."""

from types import SimpleNamespace
from typing import Any

import exudyn
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import ObjectANCFCable2D, SensorNode
from exudyn.utilities import InertiaCuboid

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, InextensibleCable, SolveExplicit
from reference_models.model import quiet_settings, silence

SECTION = {"massPerLength": 0.0348, "bendingStiffness": 0.0866}
LINE = {"positionStart": [0, 0, 0], "positionEnd": [1.8, 0, 0], "numberOfElements": 3}
PINNED = {"groundConstraintsStart": [True, True, False, False]}


def empty() -> SimpleNamespace:
    """A system without any item; the container lives as long as the scene."""
    container = exudyn.SystemContainer()
    return SimpleNamespace(container=container, mbs=container.AddSystem())


def cable_arguments(**changes: Any) -> dict[str, Any]:
    """Of a straight cable of 1.8 m under gravity; with a shape, without those of the line."""
    line = {} if changes.get("shape") is not None else LINE
    return {**line, "beamTemplate": InextensibleCable(**SECTION), "gravity": [0, -9.81, 0], **changes}


def loose_pendulum(**changes: Any) -> SimpleNamespace:
    """A pinned cable, a ground and a rigid body at its tip; not assembled."""
    scene = empty()
    scene.cable = CreateInextensibleCable(scene.mbs, **cable_arguments(**(PINNED | changes)))
    scene.nodes = [int(node) for node in scene.cable["nodes"]]
    scene.node = scene.nodes[-1]
    return scene


def pendulum(**changes: Any) -> SimpleNamespace:
    """The same, with a sensor of its tip, assembled."""
    scene = loose_pendulum(**changes)
    position = exudyn.OutputVariableType.Position
    scene.tip = scene.mbs.AddSensor(
        SensorNode(nodeNumber=scene.node, storeInternal=True, outputVariableType=position)
    )
    scene.mbs.Assemble()
    return scene


def bodies() -> SimpleNamespace:
    """A pinned cable, and at its tip a rigid body and a ground; not assembled."""
    scene = loose_pendulum()
    there = {"referencePosition": [1.8, 0, 0]}
    scene.ground = int(scene.mbs.CreateGround(**there))
    scene.body = int(scene.mbs.CreateRigidBody(inertia=InertiaCuboid(1000, [0.1] * 3), **there))
    return scene


def native_cables(**changes: Any) -> SimpleNamespace:
    """Three native elements from a pin on, one of them with other properties, if changes are given."""
    scene, section = empty(), SECTION | {"axialStiffness": 1e4}
    line = {"groundConstraintsStart": [1, 1, 0, 0], "gravity": [0, -9.81, 0]} | LINE
    made = GenerateBeamElementsAlongLine(scene.mbs, beamTemplate=ObjectANCFCable2D(**section), **line)
    scene.elements = [int(element) for element in made["elements"]]
    for name, value in changes.items():
        scene.mbs.SetObjectParameter(scene.elements[1], name, value)
    return scene


def settings(**time: Any) -> Any:
    """Of a quiet, short run; keywords replace those of the time integration."""
    quiet = quiet_settings(2e-3, 2)
    for name, value in time.items():
        setattr(quiet.timeIntegration, name, value)
    return quiet


def run(mbs: Any, simulation: Any = None, explicit: Any = None) -> dict[str, Any]:
    """A short, quiet run."""
    with silence():
        return SolveExplicit(mbs, simulation or settings(), explicit or ExplicitSettings())


def ring_points(nodes: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """(nodes, 2) positions and slopes of a ring."""
    angle = 2.0 * np.pi * np.arange(nodes)[:, None] / nodes
    return np.hstack([np.cos(angle), np.sin(angle)]), np.hstack([-np.sin(angle), np.cos(angle)])
