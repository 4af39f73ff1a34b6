"""Settings, solvers, stepper, ensembles; scenes that cannot start."""

import re
from pathlib import Path
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerNodePosition,
    Node1D,
    NodePointGround,
    ObjectGenericODE2,
    SensorNode,
)

from exudyn_inext import (
    ComputeEigenvalues,
    DivergenceError,
    EquilibriumError,
    ExplicitSettings,
    ExplicitStepper,
    Rattle,
    RedundantConstraintError,
    RungeKutta4,
    SceneError,
    SolveEnsemble,
    SolveEquilibrium,
    SolveExplicit,
    StaticSettings,
    StepSizeError,
    Zhai,
)

from ..rows import Row, all_but_the_time, nothing_more, rows
from ..scenes import empty, loose_pendulum, pendulum, run, settings
from ..values import INF, NAN, Of

MBS = Of(lambda scene: scene.mbs)
NO_SYSTEMS = (None, "mbs", 5, exudyn.MainSystem, {})
NOT_POSITIVE = (-1e-3, 0.0, NAN, INF, "1e-3", True, [1e-3], 1j)


def no_system(call: Any, name: str = "mbs") -> list[Row]:
    return rows(
        call,
        {},
        [
            ({name: value}, rf"mbs = {re.escape(repr(value))}: must be a system of Exudyn.*AddSystem")
            for value in NO_SYSTEMS
        ],
    )


SETTINGS = rows(
    ExplicitSettings,
    {},
    [
        ({"integrator": "Euler"}, r"integrator = 'Euler' is unknown: .*'Zhai'"),
        ({"integrator": None}, r"integrator = None is unknown: .*'RATTLE'"),
        ({"integrator": ["Zhai"]}, r"integrator = \['Zhai'\] is unknown"),
        ({"scheme": (0.5, 0.5)}, r"scheme = \(0.5, 0.5\): .*Rattle\(...\)"),
        ({"scheme": Zhai()}, r"scheme = Zhai\(.*'RATTLE' takes Rattle\(...\)"),
        ({"integrator": Rattle}, r"integrator = <class .* is unknown"),
        ({"dependsOnTimeOnly": [1.0]}, r"dependsOnTimeOnly = \[1.0\]: must be a list of functions"),
        ({"dependsOnTimeOnly": abs}, r"dependsOnTimeOnly = <.*: must be a list of functions"),
        ({"integrator": Zhai(psi=NAN)}, r"psi = nan: must be a finite number"),
        ({"scheme": Rattle}, r"scheme = <class.*takes Rattle\(...\)"),
        *[
            ({name: value}, rf"{name} = {re.escape(repr(value))}: must be a finite number > 0")
            for name in ("stepSize", "stabilizationRate", "stepConstant", "stepSafety", "startTolerance")
            for value in NOT_POSITIVE
        ],
        ({"stepSize": 1e-300}, r"stepSize = 1e-300: must lie between.*units"),
        ({"stabilizationRate": 1e300}, r"stabilizationRate = 1e\+300: must lie between.*units"),
        ({"stepSafety": 1.5}, r"stepSafety = 1.5: must be at most 1, the stability limit"),
        *[
            ({"massScaling": value}, rf"massScaling = {value!r}: must be a finite number >= 0")
            for value in (-0.3, NAN, "0.3")
        ],
        (
            {"massScaling": 0.3, "stepSize": 1e-3, "adaptiveStep": True},
            r"massScaling = 0.3 with adaptiveStep: .*leave one",
        ),
        ({"adaptiveStep": "yes"}, r"adaptiveStep = 'yes': must be True or False"),
        ({"energyTolerance": 0.0}, r"energyTolerance = 0.0: must be a finite number > 0"),
        ({"energyTolerance": np.nan}, r"energyTolerance = nan: must be a finite number > 0"),
        ({"allowUnstableStep": 2}, r"allowUnstableStep = 2: must be True or False"),
    ],
    scene=empty,
)

SCHEMES = [
    *rows(
        ExplicitSettings,
        {},
        [
            ({"integrator": Rattle(tolerance=0.0)}, r"tolerance = 0.0: must be a finite number > 0"),
            ({"integrator": Rattle(tolerance=NAN)}, r"tolerance = nan: must be a finite number > 0"),
            ({"integrator": Rattle(tolerance="small")}, r"tolerance = 'small': .*> 0"),
            ({"integrator": Rattle(iterations=0)}, r"iterations = 0: must be an integer of at least 1"),
            ({"integrator": Rattle(iterations=2.5)}, r"iterations = 2.5: must be an integer of at least 1"),
        ],
        of=Rattle,
        scene=empty,
    ),
    *rows(
        ExplicitSettings,
        {},
        [
            ({"integrator": Zhai(psi=NAN)}, r"psi = nan: must be a finite number"),
            ({"integrator": Zhai(phi="half")}, r"phi = 'half': must be a finite number"),
            ({"integrator": Zhai(gamma_newmark=1e300)}, r"gamma_newmark = 1e\+300: must lie between"),
            ({"integrator": Zhai(corrector="on")}, r"corrector = 'on': must be True or False"),
            ({"integrator": Zhai(projected_rate=None)}, r"projected_rate = None: must be True or False"),
        ],
        of=Zhai,
        scene=empty,
    ),
    *rows(
        ExplicitSettings,
        {"integrator": "RK4"},
        [
            ({"integrator": RungeKutta4("RK5")}, r"name = 'RK5': choose one of \('RK4',\)"),
            ({"integrator": RungeKutta4(4)}, r"name = 4: choose one of \('RK4',\)"),
            ({"scheme": Rattle()}, r"scheme = Rattle\(.*'RK4' takes RungeKutta4"),
        ],
        of=RungeKutta4,
        scene=empty,
    ),
]

STATIC_SETTINGS = rows(
    StaticSettings,
    {},
    [
        *[({"tolerance": value}, rf"tolerance = {value!r}: .*> 0") for value in (0.0, -1.0, NAN, "1e-9")],
        *[
            ({name: value}, rf"{name} = {value!r}: must be an integer of at least 1 and at most 1000000")
            for name in ("maxIterations", "loadSteps")
            for value in (0, -1, 2.5, True, None, 10**12)
        ],
    ],
    scene=empty,
)


def with_time(**time: Any) -> dict[str, Any]:
    """Settings whose times are at fault."""
    return {"simulationSettings": settings(**time)}


def solution_in(name: str) -> dict[str, Any]:
    """Settings that write a solution file."""
    simulation = settings()
    simulation.solution.file.write = True
    simulation.solution.file.name = name
    return {"simulationSettings": simulation}


def restart_in(name: str, **options: Any) -> dict[str, Any]:
    """Settings that write restart files, or continue from one."""
    simulation = settings()
    for option, value in {"name": name, **options}.items():
        setattr(simulation.solution.restart, option, value)
    return {"simulationSettings": simulation}


A_FILE = str(Path(__file__).resolve())  # where a folder ought to be


def sensor_in(name: str) -> Any:
    """A scene with a sensor that writes a file of that name."""

    def build() -> Any:
        scene = pendulum()
        position = exudyn.OutputVariableType.Position
        scene.mbs.AddSensor(
            SensorNode(nodeNumber=scene.node, fileName=name, outputVariableType=position, name="tip")
        )
        scene.mbs.Assemble()
        return scene

    return build


def without_files(scene: Any) -> None:
    """The same run with the sensors switched off."""
    simulation = settings()
    simulation.solution.sensors.active = False
    assert run(scene.mbs, simulation)["success"]


def loaded(force: Any) -> Any:
    """A scene with a load by a user function of the time alone."""

    def build() -> Any:
        scene = loose_pendulum()

        def push(mbs: Any, t: float, load: Any) -> Any:
            return force(t) if t > 1e-3 else [0.0, 0.0, 0.0]

        marker = scene.mbs.AddMarker(MarkerNodePosition(nodeNumber=scene.node))
        load = {"loadVector": [0, 0, 0], "loadVectorUserFunction": push}
        scene.mbs.AddLoad(LoadForceVector(markerNumber=marker, **load))
        scene.mbs.Assemble()
        return scene

    return build


def overloaded() -> Any:
    """A force beyond all units."""
    scene = loose_pendulum()
    marker = scene.mbs.AddMarker(MarkerNodePosition(nodeNumber=scene.node))
    scene.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[1e300, 1e300, 0]))
    scene.mbs.Assemble()
    return scene


def starting_with(what: str, values: list[float]) -> Any:
    """A scene whose last node has these initial values."""

    def build() -> Any:
        scene = loose_pendulum()
        scene.mbs.SetNodeParameter(scene.node, what, values)
        scene.mbs.Assemble()
        return scene

    return build


def changed_after_assembly() -> Any:
    scene = pendulum()
    scene.mbs.AddNode(NodePointGround())
    return scene


def reset() -> Any:
    """Nothing in an assembled system."""
    scene = empty()
    scene.mbs.Assemble()
    return scene


def taut_cable() -> Any:
    return pendulum(groundConstraintsEnd=[True, True, False, False])


def body_beside() -> Any:
    """A cable, and a mass point that is not joined to it."""
    scene = loose_pendulum()
    scene.mbs.CreateMassPoint(mass=1.0, name="stone")
    scene.mbs.Assemble()
    return scene


def function_beside() -> Any:
    """A cable, and an item that has no compiled form."""
    scene = loose_pendulum()
    node = scene.mbs.AddNode(Node1D(referenceCoordinates=[0.0]))
    resist = {"forceUserFunction": lambda mbs, t, i, q, v: [-v[0]]}
    scene.mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=[[1.0]], name="axle", **resist))
    scene.mbs.Assemble()
    return scene


def falling_cable() -> Any:
    """Nothing holds it: it has no equilibrium."""
    return pendulum(groundConstraintsStart=None)


INCONSISTENT = [
    ("initialCoordinates", [0.1, 0, 0, 0], r"initial coordinates .*by 0\.\d+ \(limit 1e-06\): correct"),
    ("initialCoordinates", [1e30, 0, 0, 0], r"initial coordinates .*\(limit 1e-06\): correct"),
    ("initialCoordinates", [0, 0, 0.1, 0], r"initial coordinates .*slope of node 3 .*startTolerance"),
    ("initialVelocities", [NAN, 0, 0, 0], r"initial velocities .* by nan \(limit .*correct the initial"),
    ("initialVelocities", [0, 0, -INF, 0], r"initial velocities .* by nan \(limit .*correct the initial"),
]
NOT_ASSEMBLED = {"mbs": MBS, "autoAssemble": False}
NEEDS_ASSEMBLY = r"not assembled: call mbs.Assemble\(\) before"

SOLVE_EXPLICIT = [
    *no_system(SolveExplicit),
    *rows(
        SolveExplicit,
        {"mbs": MBS},
        [
            *[
                (
                    {"simulationSettings": value},
                    rf"simulationSettings = {re.escape(repr(value))}: must be Simu",
                )
                for value in (0, "", 5, {"endTime": 1.0}, exudyn.SimulationSettings, [])
            ],
            *[
                (
                    {"explicitSettings": value},
                    rf"explicitSettings = {re.escape(repr(value))}: must be Explicit",
                )
                for value in (0, "RATTLE", 1e-3, {}, ExplicitSettings)
            ],
            *[
                (
                    with_time(startTime=start, endTime=end),
                    rf"endTime - startTime = {end - start} s: must be a finite number > 0.*endTime",
                )
                for start, end in ((0.0, 0.0), (1.0, 0.5), (INF, 1.0))
            ],
            (with_time(endTime=1e300), r"endTime - startTime \[s\] = 1e\+300: must lie between .*units"),
            (with_time(endTime=5e-324), r"endTime - startTime \[s\] = 5e-324: must lie between .*units"),
            (with_time(endTime=1e25), r"endTime - startTime = 1e\+25 s in .* steps of .* more than .*units"),
            (with_time(numberOfSteps=0.5), r"numberOfSteps = .*: must be from 1 to 2147483647"),
            (with_time(numberOfSteps=2**40), r"numberOfSteps = .*: must be from 1 to 2147483647"),
            (
                {"explicitSettings": ExplicitSettings(stepSize=1e-25)},
                r"in steps of 1e-25 s: these are more than .*check the units",
            ),
            (
                solution_in(f"{A_FILE}/solution"),
                r"solution.file.name = .* cannot be written .*another folder",
            ),
            (solution_in(f"{A_FILE}/a/solution"), r"solution.file.name = .* cannot be written .*another"),
            (solution_in("/proc/solution"), r"solution.file.name = '/proc/solution' cannot be written"),
            (solution_in(str(Path(A_FILE).parent)), r"solution.file.name = .* cannot be written"),
            (
                restart_in(f"{A_FILE}/run.restart", write=True),
                r"solution.restart.name = .* cannot be written .*another folder",
            ),
            (
                restart_in("run.restart", write=True, writePeriod=0.0),
                r"solution.restart.writePeriod = 0.0: must be a finite number > 0",
            ),
            (
                restart_in(A_FILE, continueIfAvailable=True),
                r"restart file '.*runs.py' is damaged, or is none .*remove it to start anew",
            ),
        ],
    ),
    Row(
        SolveExplicit,
        {"mbs": MBS, "simulationSettings": settings()},
        r"fileName of sensor 1 'tip' = .* cannot be written .*another folder",
        scene=sensor_in(f"{A_FILE}/tip.txt"),
        good=without_files,
    ),
    *[
        Row(
            SolveExplicit,
            {"mbs": MBS, "simulationSettings": settings()},
            rf"user function of the load on node 3 returned {shown} at t = .* must return 3 finite number",
            SceneError,
            scene=loaded(force),
            good=nothing_more,
            kept=all_but_the_time,
        )
        for force, shown in (
            (lambda t: [0, NAN, 0], r"\[0, nan, 0\]"),
            (lambda t: [0, 1], r"\[0, 1\]"),
            (lambda t: "down", "'down'"),
            (lambda t: None, "None"),
        )
    ],
    Row(
        SolveExplicit,
        {"mbs": MBS, "explicitSettings": ExplicitSettings(stepSize=1.0)},
        r"stepSize = 1 s is above .* cable 'object0': reduce",
        StepSizeError,
    ),
    *[
        Row(SolveExplicit, {"mbs": MBS}, message, SceneError, scene=starting_with(what, values), good=good)
        for what, values, message in INCONSISTENT
        for good in [nothing_more]
    ],
    Row(
        SolveExplicit,
        {"mbs": MBS},
        r"largest frequency of cable 'object0' .* no finite number: check the units of .*loads",
        SceneError,
        scene=overloaded,
        good=nothing_more,
    ),
    *rows(
        SolveExplicit,
        {"mbs": MBS},
        [
            (
                {"solverType": exudyn.DynamicSolverType.RK44},
                r"solverType = .*RK44.*SolveExplicit has no such argument; ExplicitSettings\(integrator=",
            ),
            (
                {"showHints": True},
                "showHints = True: .* no such argument; leave it out, as errors name cause",
            ),
            ({"stepSize": 1e-3}, r"stepSize = 0.001: .* no such argument; help\(SolveExplicit\) lists"),
        ],
    ),
    Row(SolveExplicit, NOT_ASSEMBLED, NEEDS_ASSEMBLY, SceneError, scene=loose_pendulum),
    Row(SolveExplicit, NOT_ASSEMBLED, NEEDS_ASSEMBLY, SceneError, scene=changed_after_assembly),
    Row(SolveExplicit, NOT_ASSEMBLED, NEEDS_ASSEMBLY, SceneError, scene=empty),
    Row(
        SolveExplicit,
        {"mbs": MBS},
        r"mbs has nothing that moves: add a cable with CreateInextensibleCable",
        SceneError,
        scene=reset,
    ),
    Row(
        SolveExplicit,
        {"mbs": MBS},
        r"nodes \d and \d of cable 'object0' is not independent.*let it sag",
        RedundantConstraintError,
        scene=taut_cable,
        good=nothing_more,
    ),
]

STEPPER = [
    *no_system(ExplicitStepper),
    *rows(
        ExplicitStepper,
        {"mbs": MBS},
        [
            *[
                ({"explicitSettings": value}, r"explicitSettings = .*: must be ExplicitSettings")
                for value in ("Zhai", 1e-3, ExplicitSettings)
            ],
            *[
                ({"stepSize": value}, rf"stepSize = {re.escape(repr(value))}: must be a finite number > 0")
                for value in NOT_POSITIVE
            ],
            *[
                ({"startTime": value}, rf"startTime = {value!r}: must be a finite number \[s\]")
                for value in (NAN, INF, "now", None)
            ],
            *[
                ({name: value}, rf"{name} = {re.escape(repr(value))}: must be a finite number > 0")
                for name in ("interval", "duration")
                for value in NOT_POSITIVE
            ],
            ({"interval": 1e9}, r"interval = 1e\+09 s in steps of .*: these are more than 1e\+09; check"),
        ],
    ),
    Row(
        ExplicitStepper,
        {"mbs": MBS, "stepSize": 1.0},
        r"stepSize = 1 s is above .* cable 'object0': reduce",
        StepSizeError,
    ),
    Row(ExplicitStepper, {"mbs": MBS}, NEEDS_ASSEMBLY, SceneError, scene=loose_pendulum),
    Row(ExplicitStepper, {"mbs": MBS}, r"no inextensible cable to step: add one", SceneError, scene=reset),
    Row(
        ExplicitStepper,
        {"mbs": MBS},
        r"ExplicitStepper needs .* because of object \d .axle. .*, which has a user function: use Solve",
        SceneError,
        scene=function_beside,
    ),
]


def started() -> Any:
    """A pendulum with a stepper that has taken steps."""
    scene = pendulum()
    scene.stepper = ExplicitStepper(scene.mbs, stepSize=1e-3)
    scene.stepper.Start()
    scene.stepper.Step(3)
    return scene


def not_started() -> Any:
    scene = pendulum()
    scene.stepper = ExplicitStepper(scene.mbs, stepSize=1e-3)
    return scene


def step_on(scene: Any) -> None:
    """The stepper goes on where it was."""
    assert scene.stepper.time == 3e-3
    scene.stepper.Step()
    assert np.isfinite(scene.stepper.State()[0]).all()


def pulled_apart() -> Any:
    """A stepper with a force that no step can follow."""
    scene = started()
    scene.stepper.SetNodeForce(3, [1e20, 1e20, 0])
    return scene


def start_anew(scene: Any) -> None:
    """The stepper after a divergence."""
    scene.stepper.SetNodeForce(3, [0, 0, 0])
    scene.stepper.Start()
    scene.stepper.Step(3)
    step_on(scene)


STEPPER_CALLS = [
    *rows(
        ExplicitStepper.Step,
        {"self": Of(lambda scene: scene.stepper)},
        [
            ({"n": value}, rf"n = {re.escape(repr(value))}: must be an integer of at least 1")
            for value in (0, -1, 1.5, "3", None, True, 10**20, [1])
        ],
        scene=started,
        good=step_on,
    ),
    *rows(
        ExplicitStepper.State,
        {"self": Of(lambda scene: scene.stepper)},
        [
            ({"cable": value}, rf"cable = {re.escape(repr(value))}: must be an integer of .*counted from 0")
            for value in (1, -2, "first", None, 0.0)
        ],
        scene=started,
        good=step_on,
    ),
    *rows(
        ExplicitStepper.SetNodeForce,
        {"self": Of(lambda scene: scene.stepper), "node": 3, "force": [0, 1, 0]},
        [
            *[
                ({"node": value}, rf"node = {re.escape(repr(value))} is on no inextensible cable: .* 0 and 3")
                for value in (4, -1, 2.5, "3", None, 2**70, [3])
            ],
            *[
                ({"force": value}, r"force = .* on node 3: must be 3 finite numbers \[N\]")
                for value in ([0, 1], [0, NAN, 0], 5.0, "abc", None, [1j, 0, 0], [1e300, 0, 0], {0, 1, 2})
            ],
            ({"force": [0, 0, 1]}, r"force on node 3 has the z component 1 N, .*dimension=3"),
        ],
        scene=started,
        good=step_on,
    ),
    Row(
        ExplicitStepper.Step,
        {"self": Of(lambda scene: scene.stepper), "n": 50},
        r"diverged before t = .*cable 'object0': .*reduce stepSize.* stepper holds the state at t = 0.003 s",
        DivergenceError,
        scene=pulled_apart,
        good=start_anew,
    ),
    Row(
        ExplicitStepper.Step,
        {"self": Of(lambda scene: scene.stepper)},
        r"not been started: call Start\(\) before Step\(\)",
        scene=not_started,
    ),
]

ONE = Of(lambda scene: [scene.mbs])


def rods_too_short(scene: Any) -> list[Any]:
    return [scene.mbs, pendulum(numberOfElements=4).mbs]


ENSEMBLE = [
    *rows(
        SolveEnsemble,
        {"systems": ONE, "simulationSettings": settings()},
        [
            ({"systems": None}, r"systems = None: must be a sequence, one entry a member"),
            ({"systems": MBS}, r"systems = .*must be a sequence, one entry a member"),
            ({"systems": "mbs"}, r"systems = 'mbs': must be a sequence"),
            ({"systems": []}, r"the ensemble is empty: give at least one system"),
            ({"systems": [None]}, r"member 0 of the ensemble: None is no system of Exudyn"),
            ({"systems": Of(rods_too_short)}, r"member 1 .*number of coordinates = \d+, that of member 0 is"),
            ({"systems": pendulum}, r"parameters are missing"),
            ({"systems": pendulum, "parameters": 5}, r"parameters = 5: must be a sequence"),
            ({"systems": pendulum, "parameters": []}, r"the ensemble is empty"),
            ({"systems": lambda p: "mbs", "parameters": [1]}, r"member 0 .*'mbs' is no system of Exudyn"),
            ({"parameters": [1, 2]}, r"systems is no function"),
            ({"simulationSettings": 1.0}, r"simulationSettings = 1.0: must be SimulationSettings"),
            ({"explicitSettings": "RK4"}, r"explicitSettings = 'RK4': must be ExplicitSettings"),
            *[
                (
                    {"derivatives": value},
                    rf"derivatives = {re.escape(repr(value))}: must be .* 0 and at most 2",
                )
                for value in (-1, 3, 1.0, True, "2", None, np.zeros(2))
            ],
            *[
                ({"threads": value}, rf"threads = {value!r}: must be an integer of at least 1 .*None for one")
                for value in (0, -1, 2.0, True, "2", 10**9)
            ],
            (with_time(endTime=0.0), r"endTime - startTime = 0.0 s: must be"),
        ],
    ),
    Row(SolveEnsemble, {"systems": ONE}, rf"member 0 .*{NEEDS_ASSEMBLY}", SceneError, scene=loose_pendulum),
]

EQUILIBRIUM = [
    *no_system(SolveEquilibrium),
    *rows(
        SolveEquilibrium,
        {"mbs": MBS},
        [
            ({"simulationSettings": "static"}, r"simulationSettings = 'static': must be SimulationSettings"),
            ({"staticSettings": 1e-9}, r"staticSettings = 1e-09: must be StaticSettings\(\)"),
            ({"staticSettings": StaticSettings}, r"staticSettings = <class.*must be StaticSettings\(\)"),
            ({"staticSettings": {}}, r"staticSettings = \{\}: must be StaticSettings\(\)"),
            (with_time(startTime=INF), r"startTime = inf: must be a finite number \[s\]"),
        ],
    ),
    Row(
        SolveEquilibrium,
        {"mbs": MBS, "updateInitialValues": True},
        "updateInitialValues = True: SolveEquilibrium has no such argument; leave it out, as the equilibrium",
    ),
    Row(SolveEquilibrium, NOT_ASSEMBLED, NEEDS_ASSEMBLY, SceneError, scene=loose_pendulum),
    Row(
        SolveEquilibrium, {"mbs": MBS}, r"no inextensible cable: use mbs.SolveStatic", SceneError, scene=reset
    ),
    Row(
        SolveEquilibrium,
        {"mbs": MBS},
        r"nothing connects object \d+ 'stone' \(MassPoint\) to the ground.*let SolveExplicit move it",
        SceneError,
        scene=body_beside,
    ),
    Row(
        SolveEquilibrium,
        {"mbs": MBS},
        r"cable 'object0': .* after \d+ iterations .*add supports.*mbs is unchanged",
        EquilibriumError,
        scene=falling_cable,
    ),
]

EIGENVALUES = [
    *no_system(ComputeEigenvalues),
    *rows(
        ComputeEigenvalues,
        {"mbs": MBS},
        [
            ({"simulationSettings": "static"}, r"simulationSettings = 'static': must be SimulationSettings"),
            (with_time(startTime=INF), r"startTime = inf: must be a finite number \[s\]"),
            *(
                ({"numberOfEigenvalues": value}, rf"numberOfEigenvalues = {value!r}: must be an integer")
                for value in (0, -1, 2.5, None, "3")
            ),
        ],
    ),
    Row(ComputeEigenvalues, NOT_ASSEMBLED, NEEDS_ASSEMBLY, SceneError, scene=loose_pendulum),
    Row(
        ComputeEigenvalues,
        {"mbs": MBS},
        r"no inextensible cable: use mbs\.ComputeODE2Eigenvalues",
        SceneError,
        scene=reset,
    ),
    Row(
        ComputeEigenvalues,
        {"mbs": MBS},
        r"cable 'object0' does not rest .* Call SolveEquilibrium\(mbs\) before",
        SceneError,
        scene=falling_cable,
    ),
]

ROWS = [*SETTINGS, *SCHEMES, *STATIC_SETTINGS, *SOLVE_EXPLICIT, *STEPPER, *STEPPER_CALLS, *ENSEMBLE]
ROWS += [*EQUILIBRIUM, *EIGENVALUES]
