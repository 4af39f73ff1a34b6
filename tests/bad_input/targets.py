"""What is fuzzed: public functions, the valid values of their arguments, and what follows a success."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerNodePosition,
    ObjectANCFCable,
    ObjectANCFCable2D,
)

from exudyn_inext import (
    AddMarkerOnCable,
    AddPointMass,
    AdviceSettings,
    Advise,
    AttachToBody,
    CableDrag,
    CableForces,
    CableShape,
    ComputeEigenvalues,
    CreateCableEnergySensor,
    CreateCableForceSensor,
    CreateCompanionCables,
    CreateInextensibleCable,
    CreatePrescribedMotion,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    PenaltyMass,
    Rattle,
    ReplaceNativeCables,
    RungeKutta4,
    SetCableDrag,
    SolveEnsemble,
    SolveEquilibrium,
    SolveExplicit,
    StaticSettings,
    WarnOfExplicitTraps,
    Zhai,
)
from reference_models.model import silence

from .scenes import (
    bodies,
    cable_arguments,
    empty,
    loose_pendulum,
    native_cables,
    pendulum,
    ring_points,
    run,
    settings,
)
from .values import Of, UserError

RING, RING_SLOPES = (points.tolist() for points in ring_points())
BENT = {"positions": [[0, 0], [0.5, 0], [1, 0]], "slopes": [[1, 0]] * 3}


@dataclass(frozen=True)
class Target:
    """A call to be fuzzed.

    scene: builds what it acts on.   call: (scene, arguments); may go on with what succeeded.
    valid: values of each argument.
    changes: whether a refused call might have left something in the mbs, which is then compared.
    """

    scene: Callable[[], Any]
    call: Callable[..., Any]
    valid: Mapping[str, Sequence[Any]]
    changes: bool = True


def mbs_of(scene: Any) -> Any:
    return scene.mbs


def cable_of(scene: Any) -> Any:
    return scene.cable


def fresh_mbs(scene: Any) -> Any:
    return pendulum().mbs


MBS = {"mbs": [Of(mbs_of)]}


def resting() -> Any:
    scene = pendulum()
    SolveEquilibrium(scene.mbs)
    return scene


ON_CABLE = MBS | {"cable": [Of(cable_of), Of(lambda scene: scene.cable["elements"][0])]}
ARC = {"arcLength": [0.0, 0.9, 1.8]}


def assembled_run(scene: Any, explicit: ExplicitSettings | None = None) -> None:
    scene.mbs.Assemble()
    run(scene.mbs, explicit=explicit)


def create_line(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(**arguments)
    assembled_run(scene)


def create_section(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(scene.mbs, **cable_arguments(beamTemplate=InextensibleCable(**arguments)))
    assembled_run(scene)


def create_native_section(scene: Any, arguments: dict[str, Any]) -> None:
    kind = arguments.pop("kind")
    if kind is not ObjectANCFCable:
        kind = ObjectANCFCable2D
    try:
        template = kind(**arguments)
    except (TypeError, ValueError):
        return  # Exudyn's own check
    CreateInextensibleCable(scene.mbs, **cable_arguments(beamTemplate=template))
    assembled_run(scene)


def create_shape(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(scene.mbs, **cable_arguments(shape=CableShape(**arguments)))
    assembled_run(scene)


def create_circle(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(scene.mbs, **cable_arguments(shape=CableShape.Circle(**arguments)))
    assembled_run(scene)


def create_catenary(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(scene.mbs, **cable_arguments(shape=CableShape.Catenary(**arguments)))
    assembled_run(scene)


def create_line_shape(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(scene.mbs, **cable_arguments(shape=CableShape.Line(**arguments)))
    assembled_run(scene)


def create_penalty_cable(scene: Any, arguments: dict[str, Any]) -> None:
    CreateInextensibleCable(scene.mbs, **cable_arguments(enforcement=PenaltyMass(**arguments)))
    scene.mbs.Assemble()
    simulation = settings()
    with silence(), suppress(exudyn.ExudynError):  # of the native solver, which stops by itself
        scene.mbs.SolveDynamic(simulation, solverType=exudyn.DynamicSolverType.RK44)


def solve(scene: Any, arguments: dict[str, Any]) -> None:
    with silence():
        SolveExplicit(**arguments)


def solve_with_times(scene: Any, arguments: dict[str, Any]) -> None:
    simulation = settings()
    sensors = simulation.solution.sensors
    for name, value in arguments.items():
        owner = sensors if name == "writePeriod" else simulation.timeIntegration
        try:
            setattr(owner, name, value)
        except exudyn.ExudynError:
            return  # Exudyn's own check
    run(scene.mbs, simulation)


def solve_with_settings(scene: Any, arguments: dict[str, Any]) -> None:
    run(scene.mbs, explicit=ExplicitSettings(**arguments))


def solve_with_rattle(scene: Any, arguments: dict[str, Any]) -> None:
    run(scene.mbs, explicit=ExplicitSettings(integrator=Rattle(**arguments)))


def solve_with_zhai(scene: Any, arguments: dict[str, Any]) -> None:
    run(scene.mbs, explicit=ExplicitSettings(integrator=Zhai(**arguments)))


def solve_with_initial_values(scene: Any, arguments: dict[str, Any]) -> None:
    try:
        for name, value in arguments.items():
            scene.mbs.SetNodeParameter(scene.node, name, value)
        scene.mbs.Assemble()
    except exudyn.ExudynError:
        return  # Exudyn's own check
    run(scene.mbs)


def solve_with_load(scene: Any, arguments: dict[str, Any]) -> None:
    returned = arguments["returned"]

    def load_user_function(mbs: Any, t: float, load: Any) -> Any:
        return guarded(returned)(t) if callable(returned) else returned

    marker = scene.mbs.AddMarker(MarkerNodePosition(nodeNumber=scene.node))
    scene.mbs.AddLoad(
        LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=load_user_function)
    )
    assembled_run(scene, ExplicitSettings(dependsOnTimeOnly=arguments["dependsOnTimeOnly"]))


def step(scene: Any, arguments: dict[str, Any]) -> None:
    calls = {name: arguments.pop(name) for name in ("n", "which", "node", "force")}
    stepper = ExplicitStepper(**arguments)
    stepper.Start()
    stepper.SetNodeForce(calls["node"], calls["force"])
    stepper.Step(calls["n"])
    stepper.State(calls["which"])
    stepper.WriteToSystem()


def measure_energy(scene: Any, arguments: dict[str, Any]) -> None:
    CreateCableEnergySensor(**arguments)
    assembled_run(scene)


def measure_force(scene: Any, arguments: dict[str, Any]) -> None:
    CreateCableForceSensor(**arguments)
    assembled_run(scene)


def guarded(value: Any) -> Any:
    """A user's function whose faults can be told from those of the package."""

    def call(*arguments: Any) -> Any:
        try:
            return value(*arguments)
        except Exception as error:
            raise UserError from error

    return call if callable(value) else value


def move(scene: Any, arguments: dict[str, Any]) -> None:
    for name in ("position", "velocity", "acceleration"):
        arguments[name] = guarded(arguments[name])
    CreatePrescribedMotion(**arguments)
    assembled_run(scene)


def attach(scene: Any, arguments: dict[str, Any]) -> None:
    AttachToBody(**arguments)
    assembled_run(scene)


def mark(scene: Any, arguments: dict[str, Any]) -> None:
    AddMarkerOnCable(**arguments)
    assembled_run(scene)


def accompany(scene: Any, arguments: dict[str, Any]) -> None:
    CreateCompanionCables(**arguments)
    assembled_run(scene)


def replace(scene: Any, arguments: dict[str, Any]) -> None:
    ReplaceNativeCables(**arguments)
    assembled_run(scene)


def weigh(scene: Any, arguments: dict[str, Any]) -> None:
    AddPointMass(**arguments)
    assembled_run(scene)


def drag(scene: Any, arguments: dict[str, Any]) -> None:
    SetCableDrag(**arguments)
    assembled_run(scene)


def drag_with(scene: Any, arguments: dict[str, Any]) -> None:
    SetCableDrag(scene.mbs, scene.cable, CableDrag(**arguments))
    assembled_run(scene)


def rest_with(scene: Any, arguments: dict[str, Any]) -> None:
    SolveEquilibrium(scene.mbs, None, StaticSettings(**arguments))


def advise(scene: Any, arguments: dict[str, Any]) -> None:
    arguments["build"] = guarded(arguments["build"])
    with silence():
        Advise(**arguments)


def advise_with(scene: Any, arguments: dict[str, Any]) -> None:
    arguments["buildConventional"] = guarded(arguments["buildConventional"])
    with silence():
        Advise(built(scene), 1e-3, 2e-3, settings=AdviceSettings(**arguments))


def built(scene: Any) -> Callable[[int], tuple[Any, int]]:
    """A builder of pendulums; the scene keeps the last one alive."""

    def build(elements: int) -> tuple[Any, int]:
        scene.last = pendulum(numberOfElements=elements)
        return scene.last.mbs, scene.last.tip

    return build


def free_cable() -> Any:
    return loose_pendulum(groundConstraintsStart=None)


def swing(t: float) -> list[float]:
    return [1.8 - 0.1 * t**4, 0.0]


def at_rest(t: float) -> list[float]:
    return [0.0, 0.0]


TARGETS = {
    "CreateInextensibleCable": Target(
        empty,
        create_line,
        MBS
        | {
            "positionStart": [[0, 0, 0], [0, 0]],
            "positionEnd": [[1.8, 0, 0], [1.0, 1.0]],
            "numberOfElements": [1, 3],
            "beamTemplate": [InextensibleCable(0.03, 0.09)],
            "gravity": [(0, 0, 0), [0, -9.81, 0]],
            "groundConstraintsStart": [None, [True, True, False, False], [True] * 4],
            "groundConstraintsEnd": [None],
            "shape": [None],
            "dimension": [None, 2],
            "enforcement": ["projection", "algebraic", "penaltyMass"],
            "extensible": [False, True],
        },
    ),
    "InextensibleCable": Target(
        empty,
        create_section,
        {
            "massPerLength": [0.03],
            "bendingStiffness": [0.09],
            "curvatureMeasure": ["secondDerivative"],
            "numberOfLengthConstraints": [None, 0, 1],
            "bendingDamping": [0.0, 1e-4],
            "referenceCurvature": [0.0],
            "axialStiffness": [None, 1e3],
            "axialDamping": [0.0],
            "referenceAxialStrain": [0.0],
            "strainIsRelativeToReference": [0.0, 1.0],
        },
    ),
    "native template": Target(
        empty,
        create_native_section,
        {
            "kind": [ObjectANCFCable2D],
            "massPerLength": [0.03],
            "bendingStiffness": [0.09],
            "axialStiffness": [1e3],
            "bendingDamping": [0.0],
            "bendingMomentUserFunction": [0],
        },
    ),
    "CableShape": Target(
        empty,
        create_shape,
        {
            "positions": [BENT["positions"], RING],
            "slopes": [BENT["slopes"], RING_SLOPES],
            "elementLengths": [None],
            "velocities": [None],
            "slopeVelocities": [None],
            "closed": [False, True],
            "lengthReference": ["shape", "straight"],
        },
    ),
    "CableShape.Circle": Target(
        empty,
        create_circle,
        {
            "center": [[0, 0], [1, 2, 0]],
            "radius": [1.0],
            "numberOfElements": [12],
            "normal": [[0, 0, 1]],
            "start": [[1, 0, 0]],
        },
    ),
    "CableShape.Catenary": Target(
        empty,
        create_catenary,
        {
            "positionStart": [[0, 0, 0], [0, 0]],
            "positionEnd": [[1, 0.2, 0]],
            "length": [1.3],
            "numberOfElements": [6],
            "gravity": [[0, -9.81, 0]],
        },
    ),
    "CableShape.Line": Target(
        empty,
        create_line_shape,
        {
            "positionStart": [[0, 0, 0]],
            "positionEnd": [[1, 0, 0]],
            "numberOfElements": [3],
            "velocityStart": [[0, 0, 0]],
            "velocityEnd": [[0, 0, 0], [0, 1, 0]],
        },
    ),
    "PenaltyMass": Target(empty, create_penalty_cable, {"penalty": [1e4], "stabilizationRate": [100.0]}),
    "SolveExplicit": Target(
        pendulum,
        solve,
        MBS | {"simulationSettings": [Of(lambda scene: settings())], "explicitSettings": [None]},
        changes=False,
    ),
    "simulationSettings": Target(
        pendulum,
        solve_with_times,
        {"startTime": [0.0], "endTime": [2e-3], "numberOfSteps": [1, 2], "writePeriod": [1e-3]},
        changes=False,
    ),
    "ExplicitSettings": Target(
        pendulum,
        solve_with_settings,
        {
            "integrator": ["RATTLE", "Zhai", "RK4"],
            "scheme": [None],
            "stepSize": [None, 1e-3],
            "stabilizationRate": [100.0],
            "stepConstant": [0.7],
            "stepSafety": [None, 0.5],
            "massScaling": [0.0, 0.3],
            "startTolerance": [1e-6],
            "allowUnstableStep": [False],
            "adaptiveStep": [False, True],
        },
        changes=False,
    ),
    "Rattle": Target(pendulum, solve_with_rattle, {"tolerance": [1e-10], "iterations": [30]}, changes=False),
    "Zhai": Target(
        pendulum,
        solve_with_zhai,
        {"psi": [0.5], "phi": [0.5], "corrector": [False], "gamma_newmark": [0.5], "projected_rate": [True]},
        changes=False,
    ),
    "initial values": Target(
        pendulum,
        solve_with_initial_values,
        {"initialCoordinates": [[0, 0, 0, 0]], "initialVelocities": [[0, 0, 0, 0]]},
        changes=False,
    ),
    "load": Target(
        loose_pendulum,
        solve_with_load,
        {"returned": [[0, 0, 0], lambda t: [t, 0, 0]], "dependsOnTimeOnly": [True, False]},
        changes=False,
    ),
    "ExplicitStepper": Target(
        pendulum,
        step,
        MBS
        | {
            "explicitSettings": [None],
            "stepSize": [None, 1e-3],
            "startTime": [0.0],
            "interval": [None, 2e-3],
            "duration": [1.0],
            "n": [1, 2],
            "which": [0],
            "node": [Of(lambda scene: scene.node)],
            "force": [[0, 1, 0]],
        },
    ),
    "SolveEnsemble": Target(
        pendulum,
        lambda scene, arguments: SolveEnsemble(guarded(arguments.pop("systems")), **arguments),
        {
            "systems": [
                Of(lambda scene: [scene.mbs]),
                Of(lambda scene: [scene.mbs, pendulum().mbs]),
                fresh_mbs,
            ],
            "simulationSettings": [Of(lambda scene: settings())],
            "explicitSettings": [None, ExplicitSettings(integrator="Zhai")],
            "parameters": [None, [1, 2]],
            "derivatives": [0, 1, 2],
            "threads": [1, 2],
        },
    ),
    "SolveEquilibrium": Target(
        pendulum,
        lambda scene, arguments: SolveEquilibrium(**arguments),
        MBS | {"simulationSettings": [None], "staticSettings": [None]},
    ),
    "ComputeEigenvalues": Target(
        resting,
        lambda scene, arguments: ComputeEigenvalues(**arguments),
        MBS | {"simulationSettings": [None], "numberOfEigenvalues": [1, 3], "autoAssemble": [True, False]},
    ),
    "Advise": Target(
        pendulum,
        advise,
        {
            "build": [Of(built)],
            "tolerance": [1e-3],
            "endTime": [2e-3],
            "budget": [None, 1.0],
            "settings": [AdviceSettings(numbersOfElements=(2, 3, 4), samplePeriod=1e-3)],
        },
    ),
    "AdviceSettings": Target(
        pendulum,
        advise_with,
        {
            "samplePeriod": [1e-3],
            "numbersOfElements": [(2, 3, 4)],
            "pilotBudget": [1.0],
            "axialStiffness": [None, 1e5],
            "buildConventional": [None],
        },
    ),
    "StaticSettings": Target(
        pendulum, rest_with, {"tolerance": [1e-9], "maxIterations": [500], "loadSteps": [1]}
    ),
    "CableForces": Target(
        pendulum,
        lambda scene, arguments: CableForces(**arguments),
        ON_CABLE | {"arcLengths": [None, 5, [0.0, 0.3], np.array([0.2])]},
    ),
    "CreateCableEnergySensor": Target(
        loose_pendulum, measure_energy, ON_CABLE | {"storeInternal": [True, False], "fileName": [""]}
    ),
    "CreateCableForceSensor": Target(
        loose_pendulum,
        measure_force,
        ON_CABLE | ARC | {"storeInternal": [True, False], "fileName": [""]},
    ),
    "CreatePrescribedMotion": Target(
        free_cable,
        move,
        MBS
        | {
            "nodeNumber": [Of(lambda scene: scene.node)],
            "position": [swing],
            "velocity": [None, at_rest],
            "acceleration": [None, at_rest],
        },
    ),
    "AttachToBody": Target(
        bodies,
        attach,
        ON_CABLE
        | {
            "end": ["end"],
            "bodyNumber": [Of(lambda scene: scene.body), Of(lambda scene: scene.ground)],
            "localPosition": [(0, 0, 0)],
            "kind": ["hinge", "clamp"],
            "localDirection": [None, [1, 0, 0]],
        },
    ),
    "AddMarkerOnCable": Target(
        loose_pendulum, mark, ON_CABLE | ARC | {"offset": [0.0, -0.02], "hasFrame": [False, True]}
    ),
    "CreateCompanionCables": Target(loose_pendulum, accompany, ON_CABLE | {"show": [False, True]}),
    "ReplaceNativeCables": Target(
        native_cables,
        replace,
        MBS
        | {
            "extensible": [True, False],
            "objectNumbers": [None, Of(lambda scene: scene.elements), Of(lambda scene: scene.elements[1:])],
        },
    ),
    "AddPointMass": Target(loose_pendulum, weigh, ON_CABLE | ARC | {"mass": [0.01]}),
    "SetCableDrag": Target(
        loose_pendulum, drag, ON_CABLE | {"drag": [None, CableDrag(1.2, 0.01, 0.02, 1.2)]}
    ),
    "CableDrag": Target(
        loose_pendulum,
        drag_with,
        {
            "normalCoefficient": [1.2],
            "tangentialCoefficient": [0.01],
            "diameter": [0.02],
            "fluidDensity": [1.2],
            "flowVelocity": [(0, 0, 0), [1, 0, 0]],
        },
    ),
    "WarnOfExplicitTraps": Target(pendulum, lambda scene, arguments: WarnOfExplicitTraps(**arguments), MBS),
    "RungeKutta4": Target(
        pendulum,
        lambda scene, arguments: run(
            scene.mbs, explicit=ExplicitSettings(integrator=RungeKutta4(**arguments))
        ),
        {"name": ["RK4"]},
        changes=False,
    ),
}
