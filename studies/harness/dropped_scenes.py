"""Resident memory of a process that builds, runs and drops scene after scene."""

import gc
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_ROOT_FOLDER = Path(__file__).parents[2]
_KILO = 1024
END_TIME, STEP = 0.05, 5e-4


@dataclass(frozen=True)
class Kind:
    """Scenes of one kind.   contents: keywords of `Contents`.   run: mbs -> None; who moves it."""

    contents: dict[str, Any]
    run: Callable[[Any], None]


def _settings(steps: int) -> Any:
    from reference_models.model import quiet_settings

    return quiet_settings(END_TIME, steps)


def _explicit(mbs: Any) -> None:
    from exudyn_inext import ExplicitSettings, SolveExplicit

    SolveExplicit(mbs, _settings(1), ExplicitSettings(stepSize=STEP))


def _explicit_at_each_step(mbs: Any) -> None:
    from exudyn_inext import ExplicitSettings, SolveExplicit

    SolveExplicit(mbs, _settings(round(END_TIME / STEP)), ExplicitSettings(stepSize=STEP))


def _stepper(mbs: Any) -> None:
    from exudyn_inext import ExplicitSettings, ExplicitStepper

    stepper = ExplicitStepper(mbs, ExplicitSettings(stepSize=STEP))
    stepper.Start()
    stepper.Step(round(END_TIME / STEP))


def _native_explicit(mbs: Any) -> None:
    import exudyn

    mbs.SolveDynamic(_settings(round(END_TIME / STEP)), solverType=exudyn.DynamicSolverType.RK44)


def _native_implicit(mbs: Any) -> None:
    settings = _settings(round(END_TIME / (10 * STEP)))
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    mbs.SolveDynamic(settings)


KINDS = {
    "compiled steps": Kind({}, _explicit),
    "user functions": Kind({"watched": True}, _explicit_at_each_step),
    "joined to bodies": Kind({"bodies": 1}, _explicit),
    "stepper": Kind({}, _stepper),
    "penaltyMass, native RK44": Kind({"enforcement": "penaltyMass"}, _native_explicit),
    "algebraic, native generalized-alpha": Kind({"enforcement": "algebraic"}, _native_implicit),
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


def _build_run_drop(kind: Kind) -> None:
    from reference_models.model import silence

    from .joined_scenes import Contents, joined_scene

    mbs = joined_scene(Contents(elements=5, **kind.contents))
    container = mbs.variables.pop("container")  # it owns the mbs, which would own it
    with silence():
        kind.run(mbs)
    del mbs, container


def _memory_after_each(kind: Kind, number: int) -> list[int]:
    memory = []
    for _ in range(number):
        _build_run_drop(kind)
        gc.collect()
        memory.append(resident())
    return memory


if __name__ == "__main__":
    print(json.dumps(_memory_after_each(KINDS[sys.argv[1]], int(sys.argv[2]))))
