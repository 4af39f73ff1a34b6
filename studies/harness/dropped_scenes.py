"""Resident memory of a process that builds, runs and drops scene after scene."""

import gc
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

_ROOT_FOLDER = Path(__file__).parents[2]
_KILO = 1024
MANY, FEW = 60, 15  # elements of a cable, moved by kernels and by native solvers: a scene is not negligible
LONG, SHORT, STEPS = 5e-4, 2e-4, 40  # time steps [s], and how many


@dataclass(frozen=True)
class Kind:
    """Scenes of one kind.

    run: mbs -> None; who moves it.   elements: of its cable.   contents: further keywords of `Contents`.
    keeps: whether the scenes are not dropped, as a control.
    """

    run: Callable[[Any], None]
    elements: int = MANY
    contents: dict[str, Any] = field(default_factory=dict)
    keeps: bool = False


def _settings(h: float, steps: int) -> Any:
    from reference_models.model import quiet_settings

    return quiet_settings(STEPS * h, steps)


def _explicit_settings() -> Any:
    from exudyn_inext import ExplicitSettings

    return ExplicitSettings(stepSize=LONG, massScaling=0.3)


def _explicit(mbs: Any) -> None:
    from exudyn_inext import SolveExplicit

    SolveExplicit(mbs, _settings(LONG, 1), _explicit_settings())


def _explicit_at_each_step(mbs: Any) -> None:
    from exudyn_inext import SolveExplicit

    SolveExplicit(mbs, _settings(LONG, STEPS), _explicit_settings())


def _stepper(mbs: Any) -> None:
    from exudyn_inext import ExplicitStepper

    stepper = ExplicitStepper(mbs, _explicit_settings())
    stepper.Start()
    stepper.Step(STEPS)


def _native_explicit(mbs: Any) -> None:
    import exudyn

    mbs.SolveDynamic(_settings(SHORT, STEPS), solverType=exudyn.DynamicSolverType.RK44)


def _native_implicit(mbs: Any) -> None:
    settings = _settings(SHORT, STEPS // 10)
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    mbs.SolveDynamic(settings)


_PENALTY, _ALGEBRAIC = {"enforcement": "penaltyMass"}, {"enforcement": "algebraic"}

KINDS = {
    "compiled steps": Kind(_explicit),
    "user functions": Kind(_explicit_at_each_step, contents={"watched": True}),
    "joined to bodies": Kind(_explicit, contents={"bodies": 1}),
    "stepper": Kind(_stepper),
    "penaltyMass, native RK44": Kind(_native_explicit, FEW, _PENALTY),
    "algebraic, native generalized-alpha": Kind(_native_implicit, FEW, _ALGEBRAIC),
    "control: compiled steps, kept": Kind(_explicit, keeps=True),
    "control: penaltyMass, kept": Kind(_native_explicit, FEW, _PENALTY, keeps=True),
}


def memory_of_scenes(kind: str, number: int) -> list[int]:
    """Resident memory [bytes] after each of so many scenes of one of the `KINDS`, in a process of its own.

    Raises:
        CalledProcessError: where the system does not tell (it is read from /proc, as on Linux).
    """
    process = subprocess.run(
        [sys.executable, "-m", __name__, kind, str(number)],
        cwd=_ROOT_FOLDER,
        capture_output=True,
        text=True,
        check=True,
    )
    return list(json.loads(process.stdout))


def resident() -> int:
    """Resident memory of this process [bytes]."""
    lines = Path("/proc/self/smaps_rollup").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) * _KILO for line in lines if line.startswith("Rss:"))


def _built_and_run(kind: Kind) -> tuple[Any, Any]:
    """mbs and its container, which nobody else holds."""
    from reference_models.model import silence

    from .joined_scenes import Contents, joined_scene

    mbs = joined_scene(Contents(elements=kind.elements, **kind.contents))
    container = mbs.variables.pop("container")  # it owns the mbs, which would own it
    with silence():
        kind.run(mbs)
    return mbs, container


def _memory_after_each(kind: Kind, number: int) -> list[int]:
    memory, kept = [], []
    for _ in range(number):
        scene = _built_and_run(kind)
        if kind.keeps:
            kept.append(scene)
        del scene
        gc.collect()
        memory.append(resident())
    return memory


if __name__ == "__main__":
    print(json.dumps(_memory_after_each(KINDS[sys.argv[1]], int(sys.argv[2]))))
