"""Cables, sections, shapes, ways of enforcement."""

import re
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import ObjectALEANCFCable2D, ObjectANCFCable, ObjectANCFCable2D, ObjectMassPoint

from exudyn_inext import (
    AddPointMass,
    Algebraic,
    CableDrag,
    CableShape,
    CreateInextensibleCable,
    InextensibleCable,
    PenaltyMass,
    Projection,
    ReplaceNativeCables,
    SetCableDrag,
)

from ..rows import Row, all_but_the_time, nothing_more, rows
from ..scenes import (
    LINE,
    SECTION,
    bodies,
    cable_arguments,
    empty,
    native_cables,
    pendulum,
    ring_points,
    settings,
)
from ..values import INF, NAN, Of, itself

MBS = Of(lambda scene: scene.mbs)
CABLE = Of(lambda scene: scene.cable)
UNIT = {"massPerLength": 1.0, "bendingStiffness": 1.0}
BENT = {"positions": [[0, 0], [0.5, 0], [1, 0]], "slopes": [[1, 0]] * 3}
RING, RING_SLOPES = ring_points()


def section(**changes: Any) -> dict[str, Any]:
    return {"beamTemplate": InextensibleCable(**(UNIT | changes))}


def shape(**changes: Any) -> dict[str, Any]:
    return dict.fromkeys(LINE) | {"shape": CableShape(**(BENT | changes))}


def of_cable(cases: Any, **options: Any) -> list[Row]:
    """Rows of CreateInextensibleCable, in a system that has a cable already."""
    return rows(CreateInextensibleCable, {"mbs": MBS, **cable_arguments()}, cases, **options)


NO_NUMBERS = [0.0, -1.5, NAN, INF, "heavy", None, True, 1j, [1.0], np.array([1.0, 2.0])]
NATIVE = (ObjectANCFCable, ObjectANCFCable2D)

SECTIONS = of_cable(
    [
        *[
            (section(**{name: value}), rf"{name} = {re.escape(repr(value))}: must be a finite number > 0")
            for name in ("massPerLength", "bendingStiffness")
            for value in NO_NUMBERS
        ],
        *[
            (
                section(**{name: value}),
                rf"{name} = {re.escape(repr(value))}: must lie between 1e-30 and 1e\+30.*units",
            )
            for name in ("massPerLength", "bendingStiffness")
            for value in (1e300, 1e-300)
        ],
        (section(massPerLength=10**400), r"massPerLength = 10{400}: must be a finite number > 0"),
        (section(curvatureMeasure="exact"), r"curvatureMeasure = 'exact'.*secondDerivative.*product"),
        (section(curvatureMeasure=["product"]), r"curvatureMeasure = \['product'\].*secondDerivative"),
        *[
            (section(numberOfLengthConstraints=n), rf"numberOfLengthConstraints = {n!r}: .* 0 .* 3")
            for n in (-1, 4, 2.5, True, 2**64)
        ],
        (section(referenceCurvature=NAN), r"referenceCurvature = nan: .*finite"),
        (section(referenceCurvature="round"), r"referenceCurvature = 'round': .*finite number \[1/m\]"),
        (section(bendingDamping=INF), r"bendingDamping = inf: .*finite"),
        (section(bendingDamping=np.zeros(2)), r"bendingDamping = array.*finite number >= 0"),
        *[
            (section(axialStiffness=value), rf"axialStiffness = {value!r}: must be a finite number > 0")
            for value in (0.0, -1e4, INF, NAN)
        ],
        (section(axialStiffness=1e4, axialDamping=-1.0), r"axialDamping = -1.0: .*>= 0"),
        (section(axialDamping=1.0), r"axialDamping = 1.0 without axialStiffness: .*give axialStiffness"),
        (section(referenceAxialStrain=0.1), r"referenceAxialStrain = 0.1 without axialStiffness: .*give"),
        (section(axialStiffness=1e4, referenceAxialStrain=-1.0), r"referenceAxialStrain = -1.0: .*above -1"),
        (section(strainIsRelativeToReference=np.nan), r"strainIsRelativeToReference = nan: must be a finite"),
        (section(axialStiffness=1e4, curvatureMeasure="product"), r"curvatureMeasure = 'product' with axial"),
        (
            section(axialStiffness=1e4, numberOfLengthConstraints=1),
            r"numberOfLengthConstraints = 1 with axial",
        ),
        (
            section(axialStiffness=1e4) | {"enforcement": "algebraic"},
            r"enforcement = 'algebraic' with axialStiffness = 10000.0",
        ),
        ({"extensible": "yes"}, r"extensible = .yes.: "),
        ({"beamTemplate": None}, r"beamTemplate = None: must be an InextensibleCable"),
        ({"beamTemplate": InextensibleCable}, r"beamTemplate = <class.*: must be an InextensibleCable"),
        ({"beamTemplate": SECTION}, r"beamTemplate = \{'mass.*: must be an InextensibleCable"),
        ({"beamTemplate": ObjectMassPoint()}, r"beamTemplate = ObjectMassPoint: must be an Inext"),
        (
            {"beamTemplate": ObjectALEANCFCable2D()},
            r"ObjectALEANCFCable2D: .*\(ALE\) have no counterpart.*ObjectANCFCable2D",
        ),
        *[
            ({"beamTemplate": native(**UNIT, bendingDamping=-0.1)}, r"bendingDamping = -0.1: .*>= 0")
            for native in NATIVE
        ],
        *[
            (
                {"beamTemplate": native(**UNIT, referenceAxialStrain=0.1)},
                r"referenceAxialStrain = 0.1: .*extensible=True.* zero",
            )
            for native in NATIVE
        ],
        (
            {"beamTemplate": ObjectANCFCable2D(**UNIT, bendingMomentUserFunction=[1, [2, 3]])},
            r"bendingMomentUserFunction = \[1, \[2, 3\]\]: must be a function, or zero",
        ),
        (
            {"beamTemplate": ObjectANCFCable2D(**UNIT, referenceCurvature=2.0), "dimension": 3},
            r"referenceCurvature = 2.0 in 3D: .*dimension=2",
        ),
        ({"beamTemplate": ObjectANCFCable2D(bendingStiffness=1.0)}, r"massPerLength = 0.*> 0"),
    ],
    of=InextensibleCable,
)

LINES = of_cable(
    [
        *[
            ({"mbs": value}, rf"mbs = {re.escape(repr(value))}: must be a system of Exudyn.*AddSystem")
            for value in (None, "mbs", 5, exudyn.MainSystem, [])
        ],
        ({"mbs": Of(lambda scene: scene.container)}, r"mbs = .*must be a system of Exudyn.*AddSystem"),
        *[
            (
                {"numberOfElements": n},
                rf"numberOfElements = {re.escape(repr(n))}: must be an integer of at least 1 ",
            )
            for n in (0, -1, 2.5, True, None, "5", [3])
        ],
        ({"numberOfElements": 10**12}, r"numberOfElements = 10+: .* at most 1000000"),
        ({"positionEnd": [0, 0, 0]}, r"length = 0 m: .*\[0.0, 0.0, 0.0\]; give two different points"),
        ({"positionEnd": [NAN, 0, 0]}, r"positionEnd = \[nan, 0.0, 0.0\]: .* finite"),
        ({"positionEnd": [1e300, 0, 0]}, r"positionEnd = \[1e\+300, 0.0, 0.0\]: .*1e\+30 in size.*units"),
        ({"positionEnd": [1e-300, 0, 0]}, r"length = 0 m: .*two different points"),
        ({"positionStart": [0, INF, 0]}, r"positionStart = \[0.0, inf, 0.0\]: .* finite"),
        ({"positionStart": [0]}, r"positionStart .*\(1,\).* 2 or 3 components"),
        ({"positionStart": []}, r"positionStart .*\(0,\).* 2 or 3 components"),
        ({"positionEnd": [1, 0, 0, 0]}, r"positionEnd .*\(4,\).* 2 or 3 components"),
        ({"positionEnd": 1.8}, r"positionEnd .* 2 or 3 components"),
        ({"positionStart": [[0, 0, 0], [1, 1, 1]]}, r"positionStart .*\(2, 3\)"),
        ({"positionStart": "here"}, r"positionStart = 'here': must be numbers"),
        ({"positionStart": ["0", "0", "0"]}, r"positionStart = \['0', '0', '0'\]: must be numbers"),
        ({"positionStart": [10**400, 0, 0]}, r"positionStart = \[10+, 0, 0\]: must be numbers"),
        ({"positionEnd": [1j, 0, 0]}, r"positionEnd = \[1j, 0, 0\]: must be numbers"),
        ({"positionEnd": itself()}, r"positionEnd = \[\[...\]\]: must be numbers"),
        ({"positionStart": None}, r"positionStart"),
        ({"gravity": [0, -9.81]}, r"gravity = \[0, -9.81\]: .* 3 numbers"),
        ({"gravity": [0, NAN, 0]}, r"gravity = \[0.0, nan, 0.0\]: .* finite"),
        ({"gravity": [0, 1e300, 0]}, r"gravity = \[0.0, 1e\+300, 0.0\]: .*1e\+30.*units"),
        ({"gravity": -9.81}, r"gravity = -9.81: .* 3 numbers"),
        ({"gravity": [True] * 3}, r"gravity = \[True, True, True\]: must be numbers"),
        ({"dimension": 4}, r"dimension = 4: must be 2, 3 or None"),
        ({"dimension": 2.0}, r"dimension = 2.0: must be 2, 3 or None"),
        ({"dimension": np.array([2, 3])}, r"dimension = array.*: must be 2, 3 or None"),
        ({"dimension": 2, "gravity": [0, 0, -9.81]}, r"dimension = 2, but .* dimension = 3"),
        ({"dimension": 2, "positionEnd": [1, 0, 1]}, r"dimension = 2, but .* z .* dimension = 3"),
        ({"groundConstraintsStart": [True] * 3}, r"groundConstraintsStart = .* has 3 entries: needs 4"),
        ({"groundConstraintsEnd": [True] * 6}, r"groundConstraintsEnd = .* has 6 entries: needs 4"),
        ({"groundConstraintsStart": True}, r"groundConstraintsStart"),
        (
            {"groundConstraintsStart": [[1, 2], [3], 0, 0]},
            r"groundConstraintsStart\[0\] = \[1, 2\]: must be T",
        ),
        ({"groundConstraintsStart": np.array(True)}, r"groundConstraintsStart = array.* needs 4"),
        ({"groundConstraintsStart": "pin"}, r"groundConstraintsStart = 'pin'.* needs 4"),
        (
            {"groundConstraintsStart": [True, "yes", 0, 0]},
            r"groundConstraintsStart\[1\] = 'yes': must be True or False",
        ),
        (
            {"groundConstraintsStart": [True, False, True, False]},
            r"groundConstraintsStart .*\[\[1, 0\], \[1, 0\]\].* hold all or no slopes",
        ),
        (
            {"groundConstraintsEnd": [True, True, True, False]},
            r"groundConstraintsEnd .*\[\[1, 1\], \[1, 0\]\].* hold all or no slopes",
        ),
        *[
            (
                shape() | {name: LINE[name]},
                r"shape is given together with positionStart",
            )
            for name in LINE
        ],
        ({"enforcement": "springs"}, r"enforcement = 'springs' is unknown: .*'algebraic', 'penaltyMass'"),
        ({"enforcement": None}, r"enforcement = None is unknown: .*'projection'"),
    ]
)

SHARED_NODES = of_cable(
    [
        *[
            (
                {name: number},
                rf"{name} = {re.escape(repr(number))}: must be the number of a node, .* \d+ nodes; .*'nodes'",
            )
            for name in ("nodeNumberStart", "nodeNumberEnd")
            for number in (-1, 99, 2.0, True, "tip", [0])
        ],
        (
            {"nodeNumberStart": 3},
            r"nodeNumberStart = 3: the position .*1.8, 0.0.*start \[0.0, 0.0\] \[m\], 1.8 apart .*move",
        ),
        (
            {"nodeNumberEnd": 2},
            r"nodeNumberEnd = 2: the position .*end \[1.8, 0.0\] \[m\], 0.6 apart",
        ),
        (
            {"nodeNumberStart": 0, "positionEnd": [0, -1.8, 0]},
            r"nodeNumberStart = 0: the slope .*1.41 apart .*shape=CableShape.*shareSlopeStart=False",
        ),
        (
            {"nodeNumberEnd": 0, "positionStart": [1.8, 0, 0], "positionEnd": [0, 0, 0]},
            r"nodeNumberEnd = 0: the slope .*cable's end \[-1.0, 0.0\].*shareSlopeEnd=False",
        ),
        (
            shape(velocities=[[0, 1]] * 3) | {"nodeNumberStart": 0},
            r"nodeNumberStart = 0: the velocity .*\[0.0, 1.0\] \[m/s\], 1 apart .*velocities=",
        ),
        (
            shape(slopeVelocities=[[0, 2]] * 3) | {"nodeNumberStart": 0},
            r"nodeNumberStart = 0: the slope velocity .*\[0.0, 2.0\] \[1/s\], 2 apart .*slopeVelocities=",
        ),
        (
            {"nodeNumberStart": 0, "dimension": 3},
            r"nodeNumberStart = 0 is a node in 2D, .*dimension = 3: .*same dimension",
        ),
        (
            {"nodeNumberStart": 0, "enforcement": "penaltyMass"},
            r"nodeNumberStart = 0 with enforcement = 'penaltyMass': .*'projection'.*'algebraic'",
        ),
        ({"shareSlopeStart": "yes"}, r"shareSlopeStart = 'yes': must be True or False"),
        ({"shareSlopeEnd": None}, r"shareSlopeEnd = None: must be True or False"),
        (
            shape(positions=RING, slopes=RING_SLOPES, closed=True) | {"nodeNumberEnd": 0},
            r"nodeNumberEnd is given, but a closed cable has no end: use nodeNumberStart",
        ),
    ]
)

SHARED_NODES += of_cable(
    [({"nodeNumberStart": 5}, r"nodeNumberStart = 5: .*RigidBody.* no inextensible cable; .*AttachToBody")],
    scene=bodies,
)

SHAPES = of_cable(
    [
        (shape(slopes=[[1, 0], [0.6, 0.6], [1, 0]]), r"slopes\[1\] = .*0\.848.* unit .*divide"),
        (shape(slopes=[[1, 0]] * 2), r"slopes has 2 rows: needs 3"),
        (shape(slopes=[[1, 0], [NAN, 0], [1, 0]]), r"slopes = .*nan.* finite"),
        (shape(slopes=None), r"slopes = None: must be numbers|slopes = nan: all numbers must be finite"),
        (shape(velocities=[[0, 0]] * 4), r"velocities has 4 rows: needs 3"),
        (shape(velocities=[[0, INF]] * 3), r"velocities = .*inf.* finite"),
        (shape(slopeVelocities=[0, 0]), r"slopeVelocities .*\(\d,\)"),
        (shape(positions=[[0, 0]], slopes=[[1, 0]]), r"positions has 1 point\(s\): .* at least 2"),
        (shape(positions=[]), r"positions has shape \(0,\): needs one row"),
        (shape(positions=[[0, 0], [1]]), r"positions = \[\[0, 0\], \[1\]\]: must be numbers"),
        (shape(positions=[[0, 0], [0, 0], [1, 0]]), r"element 0, .* = 0.0: .*> 0"),
        (shape(elementLengths=0.4), r"0\.5 m apart.* 0\.4 m long.*lengthen the element"),
        (shape(elementLengths=0.6), r"mean square stretch of 0\.7 .* 0\.6 m.*correct elementLengths"),
        (shape(elementLengths=[0.5, -0.5]), r"element 1, .* = -0.5: .*> 0"),
        (shape(elementLengths=[0.5] * 3), r"elementLengths .*3.* 2 elements"),
        (shape(elementLengths="long"), r"elementLengths = 'long': must be numbers"),
        (shape(slopes=[[-1, 0]] * 3), r"slope"),
        (shape(lengthReference="arc"), r"lengthReference = 'arc': choose one of .*'straight'"),
        (shape(lengthReference=np.zeros(2)), r"lengthReference = array.*choose one of"),
        (shape(closed="yes"), r"closed = 'yes': must be True or False"),
        (shape(closed=True), r"nodes 2 and 0 are|the curve through nodes"),
        (
            shape(positions=RING, slopes=RING_SLOPES, closed=True) | {"groundConstraintsEnd": [True] * 4},
            r"groundConstraintsEnd is given, but a closed cable has no end: use groundConstraintsStart",
        ),
        (
            shape(positions=RING[[0, 1, 2, 0]], slopes=RING_SLOPES, closed=True),
            r"positions\[0\] and positions\[-1\] are both .*leave the last row out",
        ),
        ({"shape": [[0, 0], [1, 0]], **dict.fromkeys(LINE)}, r"shape = .*CableShape"),
        ({"shape": CableShape, **dict.fromkeys(LINE)}, r"shape = .*must be a CableShape"),
    ],
    of=CableShape,
)

SHAPES += [
    *rows(
        CableShape.Line,
        LINE,
        [
            *[
                ({"velocityEnd": velocity}, r"velocityEnd")
                for velocity in ([0, NAN, 0], [0], "fast", [[0, 0, 0], [0, 1, 0]])
            ],
            ({"velocityStart": None}, r"velocityStart = "),
            ({"numberOfElements": 2**63}, r"numberOfElements = 9223372036854775808: .* at most 1000000"),
        ],
        scene=empty,
    ),
    *rows(
        CableShape.Catenary,
        {"positionStart": [0, 0], "positionEnd": [1, 0], "length": 1.3, "numberOfElements": 6},
        [
            ({"length": 0.9}, r"length = 0\.9 m is less than 1 m, .*longer cable"),
            ({"length": NAN}, r"length \[m\] = nan"),
            ({"positionEnd": [0, 1]}, r"one above the other.*move one end"),
            ({"gravity": [0, 0, 0]}, r"gravity = \[0\.0, 0\.0, 0\.0\].*direction"),
        ],
        scene=empty,
    ),
    *rows(
        CableShape.Circle,
        {"center": [0, 0], "radius": 1.0, "numberOfElements": 4},
        [
            ({"radius": 0.0}, r"radius \[m\] = 0.0: .*> 0"),
            ({"radius": "1 m"}, r"radius \[m\] = '1 m': .*> 0"),
            ({"numberOfElements": 2}, r"numberOfElements = 2: a ring needs at least 3"),
            ({"center": [0]}, r"center has shape \(1,\).* 2 or 3 components"),
            ({"normal": [0, 0, 0]}, r"normal = \[0.0, 0.0, 0.0\].*zero or parallel.*choose another start"),
            ({"start": [0, 0, 2]}, r"start = \[0.0, 0.0, 2.0\].*parallel"),
        ],
        scene=empty,
    ),
]


def solve_dynamic(mbs: Any, solver: str) -> None:
    """A native solver."""
    mbs.SolveDynamic(settings(), solverType=getattr(exudyn.DynamicSolverType, solver))


def solve_static(mbs: Any) -> None:
    """The native static solver."""
    quiet = settings()
    quiet.staticSolver.verboseMode = 0
    mbs.SolveStatic(quiet)


def algebraic_pendulum() -> Any:
    return pendulum(enforcement="algebraic")


def penalty_pendulum() -> Any:
    return pendulum(enforcement="penaltyMass")


NATIVE_SOLVERS = [
    *[
        Row(
            solve_dynamic,
            {"mbs": MBS, "solver": solver},
            r"object 0 has enforcement = 'projection'.*use exudyn_inext.SolveExplicit.*'penaltyMass'",
            exudyn.ExudynError,
            of=Projection,
        )
        for solver in ("VelocityVerlet", "RK44", "DOPRI5", "ExplicitEuler", "GeneralizedAlpha")
    ],
    Row(
        solve_static,
        {"mbs": MBS},
        r"SolveEquilibrium\(mbs\)",
        exudyn.ExudynError,
        of=Projection,
        kept=all_but_the_time,
    ),
    Row(
        solve_dynamic,
        {"mbs": MBS, "solver": "RK44"},
        r".",
        exudyn.ExudynError,
        scene=algebraic_pendulum,
        of=Algebraic,
    ),
]

ENFORCEMENTS = [
    *of_cable([({"enforcement": Projection}, r"enforcement = <class.*is unknown")], of=Projection),
    *of_cable([({"enforcement": Algebraic}, r"enforcement = <class.*is unknown")], of=Algebraic),
    *of_cable([({"enforcement": PenaltyMass}, r"enforcement = <class.*PenaltyMass\(pen")], of=PenaltyMass),
    *rows(
        PenaltyMass,
        {},
        [
            *[
                (
                    {"penalty": value},
                    rf"penalty = {re.escape(repr(value))}: must be a number from 100 .*use 1e4",
                )
                for value in (10.0, 1e7, NAN, "1e4", None, True, [1e4], 10**400)
            ],
            *[
                ({"stabilizationRate": value}, rf"stabilizationRate = {value!r}: must be a finite number > 0")
                for value in (0.0, -100.0, INF, "fast")
            ],
        ],
        scene=empty,
    ),
    *[
        Row(
            call,
            {"mbs": MBS, "cable": CABLE, **arguments},
            rf"enforcement = '{name}': .*create the cable with enforcement='projection'",
            scene=scene,
            of=of,
        )
        for name, scene, of in (
            ("algebraic", algebraic_pendulum, Algebraic),
            ("penaltyMass", penalty_pendulum, PenaltyMass),
        )
        for call, arguments in (
            (AddPointMass, {"arcLength": 0.9, "mass": 0.1}),
            (SetCableDrag, {"drag": CableDrag(1.2, 0.01, 0.02, 1.2)}),
        )
    ],
]

NO_ELEMENT = r"is no ObjectANCFCable2D or ObjectANCFCable with a mass; give a list of numbers"
REPLACED = [
    *rows(
        ReplaceNativeCables,
        {"mbs": MBS},
        [
            *[
                ({"extensible": value}, rf"extensible = {value!r}: must be True or False")
                for value in ("yes", None, 2)
            ],
            *[
                ({"objectNumbers": value}, rf"objectNumbers = {re.escape(repr(value))}: .* {NO_ELEMENT}")
                for value in (5, [], "all")
            ],
            ({"objectNumbers": [0, 99]}, rf"objectNumbers = \[0, 99\]: 99 {NO_ELEMENT}"),
            ({"objectNumbers": [0, 3]}, rf"objectNumbers = \[0, 3\]: 3 {NO_ELEMENT}"),  # a support
        ],
        scene=native_cables,
    ),
    *[
        Row(ReplaceNativeCables, {"mbs": MBS} | arguments, message, scene=scene)
        for arguments, message, scene in (
            (
                {},
                r"mbs has no ObjectANCFCable2D or ObjectANCFCable with a mass .* after they were added",
                pendulum,
            ),
            (
                {"extensible": False},
                r"native elements 0 to 2: nodes 1 and 2 are 0.6 m apart, the element .* 0.5 m long: no inext",
                lambda: native_cables(length=0.5),
            ),
            (
                {"extensible": False},
                r"native element 1: beamTemplate.referenceAxialStrain = 0.1: .* extensible=True",
                lambda: native_cables(referenceAxialStrain=0.1),
            ),
        )
    ],
    Row(
        ReplaceNativeCables,
        {"mbs": MBS},
        r"native element 1: massPerLength = 0.0: must be a finite number > 0",
        scene=lambda: native_cables(massPerLength=0.0),
        good=nothing_more,
    ),
    Row(ReplaceNativeCables, {"mbs": None}, r"mbs = None"),
]

ROWS = [*REPLACED, *SECTIONS, *LINES, *SHARED_NODES, *SHAPES, *NATIVE_SOLVERS, *ENFORCEMENTS]
