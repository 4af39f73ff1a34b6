"""What is put on a cable, or measured on it."""

import re
from typing import Any

import exudyn
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import NodePoint, ObjectANCFCable2D

from exudyn_inext import (
    AddMarkerOnCable,
    AddPointMass,
    AttachToBody,
    CableDrag,
    CableForces,
    CableShape,
    CreateCableEnergySensor,
    CreateCableForceSensor,
    CreateCompanionCables,
    CreateInextensibleCable,
    CreatePrescribedMotion,
    SceneError,
    SetCableDrag,
    WarnOfExplicitTraps,
)

from ..rows import Row, rows
from ..scenes import bodies, cable_arguments, empty, loose_pendulum, pendulum, ring_points
from ..values import INF, NAN, Of

MBS = Of(lambda scene: scene.mbs)
CABLE = Of(lambda scene: scene.cable)
DRAG = CableDrag(1.2, 0.01, diameter=0.02, fluidDensity=1.2)
RING, RING_SLOPES = ring_points()
TAKES_A_CABLE = (
    (CableForces, {}),
    (CreateCableEnergySensor, {}),
    (CreateCableForceSensor, {"arcLength": 0.9}),
    (AddMarkerOnCable, {"arcLength": 0.9}),
    (CreateCompanionCables, {}),
    (AddPointMass, {"arcLength": 0.9, "mass": 0.1}),
    (SetCableDrag, {"drag": DRAG}),
    (AttachToBody, {"end": "end", "bodyNumber": 0}),
)


def changed_dict(**changes: Any) -> Of:
    """What CreateInextensibleCable returned, with other entries."""
    return Of(lambda scene: scene.cable | changes)


def without(key: str) -> Of:
    return Of(lambda scene: {name: value for name, value in scene.cable.items() if name != key})


def after_reset() -> Any:
    """The system was reset; the dict of its first cable is still there, and another cable with its number."""
    scene = loose_pendulum()
    stale = scene.cable
    scene.mbs.Reset()
    scene.cable = CreateInextensibleCable(scene.mbs, **cable_arguments(numberOfElements=4))
    scene.stale = stale
    scene.mbs.Assemble()
    return scene


def emptied() -> Any:
    """A system that was reset, and the dict of what was in it."""
    scene = loose_pendulum()
    scene.stale = scene.cable
    scene.mbs.Reset()
    del scene.cable
    return scene


def native_cable() -> Any:
    """A native cable, as GenerateBeamElementsAlongLine returns it, beside ours."""
    scene = loose_pendulum()
    section = {"massPerLength": 1.0, "bendingStiffness": 1.0, "axialStiffness": 1e3}
    line = {"positionStart": [0, 1, 0], "positionEnd": [1, 1, 0], "numberOfElements": 1}
    native = GenerateBeamElementsAlongLine(scene.mbs, beamTemplate=ObjectANCFCable2D(**section), **line)
    scene.native = (
        dict(zip(("nodes", "elements"), native[:2], strict=True)) if isinstance(native, tuple) else native
    )
    scene.mbs.Assemble()
    return scene


def in_order(scene: Any) -> None:
    """The system can still be assembled."""
    scene.mbs.Assemble()


NEITHER = r"must be what CreateInextensibleCable returned, or its object number"
NO_CABLES = [
    *[
        (value, rf"cable = {re.escape(repr(value))}: {NEITHER}")
        for value in (None, "cable", 1.5, True, -1, {}, [])
    ],
    (exudyn.NodeIndex(0), NEITHER),
    (np.zeros(3), NEITHER),
    (99, r"object 99 is no inextensible cable: use CreateInextensibleCable's result"),
    (2**70, r"object 2147483647 is no inextensible cable"),
    (1, r"object 1 is no inextensible cable: use CreateInextensibleCable's result"),
    (changed_dict(elements=[]), NEITHER),
    (changed_dict(elements="ab"), NEITHER),
    (changed_dict(elements=[None]), NEITHER),
    (changed_dict(elements=[99]), r"object 99 is no inextensible cable"),
    (changed_dict(nodes=[0, 1]), r"object 0 of mbs lies on the nodes \[0, 1, 2, 3\]; use what"),
    (without("elements"), NEITHER),
    (without("nodes"), r"object 0 of mbs lies on the nodes \[0, 1, 2, 3\]; use what"),
]

CABLES = [
    row
    for call, arguments in TAKES_A_CABLE
    for row in [
        *rows(call, {"mbs": MBS, **arguments}, [({"cable": cable}, message) for cable, message in NO_CABLES]),
        *rows(
            call,
            {"cable": CABLE, **arguments},
            [
                ({"mbs": value}, rf"mbs = {re.escape(repr(value))}: must be a system of Exudyn.*AddSystem")
                for value in (None, 5, exudyn)
            ],
        ),
        Row(
            call,
            {"mbs": MBS, "cable": Of(lambda scene: scene.stale), **arguments},
            r"object 0 of mbs lies on the nodes \[0, 1, 2, 3, 4\]; use what .* after its last Reset\(\)",
            scene=after_reset,
        ),
        Row(
            call,
            {"mbs": MBS, "cable": Of(lambda scene: scene.stale), **arguments},
            r"object 0 is no inextensible cable",
            scene=emptied,
        ),
        Row(
            call,
            {"mbs": MBS, "cable": Of(lambda scene: scene.native), **arguments},
            r"object \d is no inextensible cable",
            scene=native_cable,
            good=in_order,
        ),
    ]
]

NOT_ON_IT = [
    (value, rf"arcLength = {re.escape(repr(value))} m is not on the cable: it runs from 0 to 1.8 m")
    for value in (-0.1, 1.9, NAN, INF, "0.9", None, [0.9], True, 1e300, np.array([0.1, 0.2]))
]
ARC_LENGTHS = [
    row
    for call, arguments in TAKES_A_CABLE
    if "arcLength" in arguments
    for row in rows(
        call,
        {"mbs": MBS, "cable": CABLE, **arguments},
        [({"arcLength": value}, message) for value, message in NOT_ON_IT],
        scene=loose_pendulum,
    )
]

FORCES = [
    *rows(
        CableForces,
        {"mbs": MBS, "cable": CABLE},
        [
            *[
                (
                    {"arcLengths": value},
                    rf"arcLengths = {re.escape(repr(value))}: must be .*at (least 2|most 1000000)",
                )
                for value in (1, 0, -5, 10**12)
            ],
            *[
                (
                    {"arcLengths": value},
                    rf"arcLengths = {re.escape(repr(value))}: must be points",
                )
                for value in (2.5, "all", True, {})
            ],
            ({"arcLengths": NAN}, r"arcLengths = nan: must be points"),
            ({"arcLengths": [0.0, NAN]}, r"arcLength = nan m is not on the cable: .* 1.8 m"),
            ({"arcLengths": []}, r"arcLengths = \[\]: must be points"),
            ({"arcLengths": np.zeros(0)}, r"arcLengths = array.*: must be points"),
            ({"arcLengths": [0.0, 2.0]}, r"arcLength = 2.0 m is not on the cable: .* 1.8 m"),
            ({"arcLengths": ["0.1"]}, r"arcLength = '0.1' m is not on the cable"),
            ({"arcLengths": [[0.1, 0.2]]}, r"arcLength = \[0.1, 0.2\] m is not on the cable"),
        ],
    ),
    Row(CableForces, {"mbs": MBS, "cable": CABLE}, r"not assembled", SceneError, scene=loose_pendulum),
    *rows(
        CreateCableForceSensor,
        {"mbs": MBS, "cable": CABLE, "arcLength": 0.9},
        [
            ({"fileName": None}, r"fileName = None: must be a string"),
            ({"fileName": 5}, r"fileName = 5: must be a string"),
            ({"storeInternal": "yes"}, r"storeInternal = 'yes': must be True or False"),
        ],
    ),
    *rows(
        CreateCompanionCables,
        {"mbs": MBS, "cable": CABLE},
        [({"show": value}, rf"show = {value!r}: must be True or False") for value in ("yes", None, 2)],
    ),
]

PROPERTIES = [
    *rows(
        AddPointMass,
        {"mbs": MBS, "cable": CABLE, "arcLength": 0.9},
        [
            ({"mass": value}, rf"mass = {re.escape(repr(value))}: must be a finite number > 0; check .*units")
            for value in (0.0, -1.0, NAN, INF, "1 kg", None, [1.0], True)
        ]
        + [
            ({"mass": value}, rf"mass = {re.escape(repr(value))}: must lie between")
            for value in (1e300, 1e-300)
        ],
    ),
    *rows(
        SetCableDrag,
        {"mbs": MBS, "cable": CABLE},
        [
            ({"drag": value}, rf"drag = {re.escape(repr(value))}: must be a CableDrag or None")
            for value in (1.2, "water", {}, False, CableDrag)
        ],
    ),
    *rows(
        SetCableDrag,
        {"mbs": MBS, "cable": CABLE},
        [
            *[
                (
                    {"drag": CableDrag(*values, diameter=0.02, fluidDensity=1.2)},
                    rf"Coefficient = {culprit!r}: must be a finite number >= 0",
                )
                for values, culprit in (
                    ((-1.2, 0.01), -1.2),
                    ((1.2, NAN), NAN),
                    (("1.2", 0.01), "1.2"),
                    ((1.2, None), None),
                )
            ],
            ({"drag": CableDrag(1.2, 0.01, 0.0, 1.2)}, r"diameter = 0.0: must be a finite number > 0"),
            ({"drag": CableDrag(1.2, 0.01, 1e-300, 1.2)}, r"diameter = 1e-300: must lie between.*units"),
            ({"drag": CableDrag(1.2, 0.01, 0.02, -1.2)}, r"fluidDensity = -1.2: must be a finite number > 0"),
            (
                {"drag": CableDrag(1.2, 0.01, 0.02, 1.2, [1, 2])},
                r"flowVelocity = \[1, 2\]: .*3 numbers \[m/s\]",
            ),
            ({"drag": CableDrag(1.2, 0.01, 0.02, 1.2, 8.0)}, r"flowVelocity = 8.0: must be a vector of 3"),
            ({"drag": CableDrag(1.2, 0.01, 0.02, 1.2, [0, 0, 1])}, r"z component \[m/s\].*dimension=3"),
            ({"drag": CableDrag(1.2, 0.01, 0.02, 1.2, [NAN, 0, 0])}, r"flowVelocity = \[nan.*finite"),
        ],
        of=CableDrag,
    ),
]


def rest_at(*position: float) -> Any:
    return lambda t: list(position)


def beside_a_point() -> Any:
    """A cable, and a node of something else."""
    scene = loose_pendulum()
    scene.point = scene.mbs.AddNode(NodePoint())
    return scene


MOTIONS = [
    *rows(
        CreatePrescribedMotion,
        {"mbs": MBS, "nodeNumber": 3, "position": rest_at(1.8, 0)},
        [
            *[
                ({"mbs": value}, rf"mbs = {re.escape(repr(value))}: must be a system of Exudyn")
                for value in (None, "mbs", 5)
            ],
            *[
                ({"nodeNumber": value}, rf"nodeNumber = {re.escape(repr(value))}: mbs has no such node")
                for value in (99, -1, 2.5, "3", None, True, 2**70, [3])
            ],
            ({"nodeNumber": exudyn.ObjectIndex(0)}, r"mbs has no such node, but 5, counted from 0"),
            ({"position": None}, r"position = None: must be a function of the time, t -> 2 numbers"),
            ({"position": [1.8, 0]}, r"position = \[1.8, 0\]: must be a function of the time"),
            (
                {"position": rest_at(1.8)},
                r"position\(0\) = \[1.8\]: must be 2 finite numbers, as the node is 2D",
            ),
            ({"position": rest_at(1.8, NAN)}, r"position\(0\) = \[1.8, nan\]: all numbers must be finite"),
            (
                {"position": rest_at(1.8, 0, 1)},
                r"position\(0\) = \[1.8, 0.0, 1.0\]: must be 2 finite numbers",
            ),
            ({"position": lambda t: "here"}, r"position\(0\) = 'here': must be numbers"),
            (
                {"position": lambda t: None},
                r"position\(0\) = None: must be numbers|all numbers must be finite",
            ),
            ({"velocity": 1.0}, r"velocity = 1.0: must be a function of the time"),
            ({"velocity": rest_at(1.0)}, r"velocity\(0\) = \[1.0\]: must be 2 finite numbers"),
            ({"acceleration": "none"}, r"acceleration = 'none': must be a function"),
            (
                {"acceleration": rest_at(INF, 0)},
                r"acceleration\(0\) = \[inf, 0.0\]: all numbers must be finite",
            ),
        ],
        scene=loose_pendulum,
    ),
    Row(
        CreatePrescribedMotion,
        {"mbs": MBS, "nodeNumber": Of(lambda scene: scene.point), "position": rest_at(0, 0)},
        r"is a Point: must be a node of a cable, one of \['Point2DSlope1', 'PointSlope1'\]",
        scene=beside_a_point,
        good=in_order,
    ),
]


def ring() -> Any:
    """A closed cable, and a ground at its first node."""
    scene = empty()
    shape = CableShape(RING, RING_SLOPES, closed=True)
    scene.cable = CreateInextensibleCable(scene.mbs, **cable_arguments(shape=shape))
    scene.ground = scene.mbs.CreateGround(referencePosition=[1, 0, 0])
    return scene


def body_of_the_scene(scene: Any) -> int:
    return scene.body


ATTACHED = [
    *rows(
        AttachToBody,
        {"mbs": MBS, "cable": CABLE, "end": "end", "bodyNumber": Of(body_of_the_scene)},
        [
            *[
                ({"end": value}, rf"end = {re.escape(repr(value))}: choose one of \('start', 'end'\)")
                for value in ("middle", 0, None, ["end"])
            ],
            *[
                ({"kind": value}, rf"kind = {re.escape(repr(value))}: choose one of \('hinge', 'clamp'\)")
                for value in ("weld", None, 1)
            ],
            *[
                ({"bodyNumber": value}, rf"bodyNumber = {re.escape(repr(value))}: mbs has objects 0 to \d")
                for value in (99, -1, 2.5, "1", None, True, 2**70, [1])
            ],
            ({"bodyNumber": 1}, r"\(ConnectorCoordinate\) has no points that a cable could be attached to"),
            ({"end": "start"}, r"node 0 of the cable at \[0.0, 0.0\] .* are 1.8 m apart .*correct localPos"),
            ({"localPosition": [0.1, 0, 0]}, r"are 0.1 m apart \(limit 1.8e-06 m.*correct localPosition"),
            ({"localPosition": [0, 0]}, r"localPosition = \[0, 0\]: must be a vector of 3 numbers"),
            ({"localPosition": "tip"}, r"localPosition = 'tip': must be numbers"),
            ({"localPosition": [NAN, 0, 0]}, r"localPosition = \[nan, 0.0, 0.0\]: .*finite"),
            ({"localDirection": [1, 0, 0]}, r"localDirection = \[1, 0, 0\] is given, but a hinge has none"),
            ({"kind": "clamp", "localDirection": [2, 0, 0]}, r"has length 2: must be a unit vector"),
            ({"kind": "clamp", "localDirection": [0, 0, 0]}, r"has length 0: must be a unit vector"),
            ({"kind": "clamp", "localDirection": [0, 1, 0]}, r"1.57 rad away .*use \[1.0, 0.0, 0.0\]"),
            ({"kind": "clamp", "localDirection": 1.0}, r"localDirection = 1.0: must be a vector of 3"),
        ],
        scene=bodies,
    ),
    Row(
        AttachToBody,
        {"mbs": MBS, "cable": CABLE, "end": "start", "bodyNumber": Of(lambda scene: scene.ground)},
        r"end = 'start': a closed cable has no ends; join one of its nodes .*SphericalJoint",
        scene=ring,
    ),
]

TRAPS = rows(
    WarnOfExplicitTraps,
    {},
    [
        ({"mbs": value}, rf"mbs = {re.escape(repr(value))}: must be a system of Exudyn.*AddSystem")
        for value in (None, "mbs", [], exudyn.MainSystem)
    ],
    scene=pendulum,
)

ROWS = [*CABLES, *ARC_LENGTHS, *FORCES, *PROPERTIES, *MOTIONS, *ATTACHED, *TRAPS]
