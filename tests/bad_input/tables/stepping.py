"""Solver objects that are driven call by call, and what drives them."""

import re
from types import SimpleNamespace
from typing import Any

from exudyn_inext import ExplicitSettings, ExplicitSolver, ExplicitSteps, SceneError, StepSizeError

from ..rows import Row, rows
from ..scenes import loose_pendulum, pendulum, settings
from ..values import Of
from .runs import A_FILE, MBS, NEEDS_ASSEMBLY, NO_SYSTEMS, NOT_POSITIVE, restart_in, solution_in

SOLVER = Of(lambda scene: scene.solver)


def with_solver() -> SimpleNamespace:
    scene = pendulum()
    scene.solver = ExplicitSolver()
    return scene


def initialised() -> SimpleNamespace:
    scene = with_solver()
    scene.solver.InitializeSolver(scene.mbs, settings())
    return scene


def finished() -> SimpleNamespace:
    """No time is left after the steps."""
    scene = initialised()
    scene.solver.SolveSteps(scene.mbs, settings())
    return scene


def go_on(scene: Any) -> None:
    """The solver that has refused something takes its steps."""
    scene.solver.InitializeSolver(scene.mbs, settings())
    assert scene.solver.SolveSteps(scene.mbs, settings())
    scene.solver.FinalizeSolver(scene.mbs, settings())


def dialog(mbs: Any, **attributes: Any) -> None:
    """What an InteractiveDialog does first."""
    kind = type("Dialog", (ExplicitSteps,), attributes)
    host = kind()
    host.mbs, host.simulationSettings, host.doTimeIntegration = mbs, settings(), True
    host.InitializeSolver()


NOT_INITIALISED = r"has not been initialised for this mbs: call InitializeSolver first"
CALLS = (
    ExplicitSolver.InitializeSolverInitialConditions,
    ExplicitSolver.SolveSteps,
)

ROWS = [
    *rows(
        ExplicitSolver,
        {},
        [
            ({"explicitSettings": 1e-3}, r"explicitSettings = 0.001: must be ExplicitSettings"),
            *[
                ({"duration": value}, rf"duration = {re.escape(repr(value))}: must be a finite number > 0")
                for value in NOT_POSITIVE
            ],
        ],
    ),
    *rows(
        ExplicitSolver.InitializeSolver,
        {"self": SOLVER, "mbs": MBS, "simulationSettings": settings()},
        [
            *[({"mbs": value}, r"must be a system of Exudyn.*AddSystem") for value in NO_SYSTEMS],
            ({"simulationSettings": 1.0}, r"simulationSettings = 1.0: must be SimulationSettings"),
            (solution_in(f"{A_FILE}/a.txt"), r"cannot be written .*choose another folder"),
            (
                restart_in("restart.npz", write=True),
                r"solution.restart: ExplicitSolver neither writes .* use SolveExplicit",
            ),
        ],
        scene=with_solver,
        good=go_on,
    ),
    *[
        Row(
            call,
            {"self": SOLVER, "mbs": MBS, "simulationSettings": settings()},
            NOT_INITIALISED,
            scene=with_solver,
            good=go_on,
        )
        for call in CALLS
    ],
    *[
        Row(
            call,
            {"self": SOLVER, "mbs": Of(lambda scene: pendulum().mbs), "simulationSettings": settings()},
            NOT_INITIALISED,
            scene=initialised,
            good=go_on,
        )
        for call in (ExplicitSolver.SolveSteps, ExplicitSolver.FinalizeSolver)
    ],
    Row(
        ExplicitSolver.SolveSteps,
        {"self": SOLVER, "mbs": MBS, "simulationSettings": settings()},
        r"endTime - startTime \[s\] = 0.*: must be a finite number > 0",
        scene=finished,
        good=go_on,
    ),
    Row(dialog, {"mbs": MBS}, NEEDS_ASSEMBLY, SceneError, scene=loose_pendulum, of=ExplicitSteps),
    Row(
        dialog,
        {"mbs": MBS, "explicitSettings": "Zhai"},
        r"explicitSettings = 'Zhai': must be ExplicitSettings",
        of=ExplicitSteps,
    ),
    Row(
        dialog,
        {"mbs": MBS, "explicitSettings": ExplicitSettings(stepSize=1.0)},
        r"stepSize = 1 s is above .* cable 'object0': reduce",
        StepSizeError,
        of=ExplicitSteps,
    ),
]
