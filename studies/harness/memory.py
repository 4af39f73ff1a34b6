"""Resident memory, measured in a process of its own: of a long cable, and of scenes that are dropped."""

import gc
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import exudyn

from exudyn_inext import ExplicitSettings, ExplicitStepper, SolveExplicit
from reference_models.inextensible import build
from reference_models.model import quiet_settings, silence
from reference_models.scenes import load_scene

from .joined_scenes import Contents, joined_scene
from .store import Row

_KILO = 1024


def long_cable(scene: str, elements: int, steps: int) -> Row:
    """Memory and time of a cable that is built, checked and stepped, for a process of its own.

    Returns:
        "librariesMegabytes": before anything is built; "modelMegabytes": with the Exudyn model;
        "peakMegabytes": of all; "startSeconds": of making and starting the stepper;
        "microseconds": of one step of an element.
    """
    row: Row = {"librariesMegabytes": peak_memory() / 1e6}
    model = build(load_scene(scene), elements)
    row["modelMegabytes"] = peak_memory() / 1e6
    start = time.perf_counter()
    stepper = ExplicitStepper(model.mbs, ExplicitSettings(stepSize=2e-3, massScaling=0.3))
    stepper.Start()
    row["startSeconds"] = time.perf_counter() - start
    stepper.Step()
    start = time.perf_counter()
    stepper.Step(steps)
    row["microseconds"] = 1e6 * (time.perf_counter() - start) / steps / elements
    return row | {"peakMegabytes": peak_memory() / 1e6}


def peak_memory() -> int:
    """Largest resident memory so far [bytes].

    Linux hands what getrusage tells down from parent to child; its status file counts from the start.
    """
    try:
        return _told("status", "VmHWM")
    except (OSError, StopIteration):
        import resource  # not on Windows, where all that needs no memory runs

        unit = 1 if sys.platform == "darwin" else _KILO
        return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _told(file: str, name: str) -> int:
    """What the system tells of this process [bytes]."""
    lines = Path(f"/proc/self/{file}").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) * _KILO for line in lines if line.startswith(f"{name}:"))


MANY, FEW = 60, 15  # elements of a cable, moved by kernels and by native solvers: a scene is not negligible
LONG, SHORT, STEPS = 5e-4, 2e-4, 40  # time steps [s], and how many
EXPLICIT = ExplicitSettings(stepSize=LONG, massScaling=0.3)


def _explicit(mbs: Any, loop_steps: int = 1) -> None:
    SolveExplicit(mbs, quiet_settings(STEPS * LONG, loop_steps), EXPLICIT)


def _stepper(mbs: Any) -> None:
    stepper = ExplicitStepper(mbs, EXPLICIT)
    stepper.Start()
    stepper.Step(STEPS)


def _native_explicit(mbs: Any) -> None:
    mbs.SolveDynamic(quiet_settings(STEPS * SHORT, STEPS), solverType=exudyn.DynamicSolverType.RK44)


def _native_implicit(mbs: Any) -> None:
    settings = quiet_settings(STEPS * SHORT, STEPS // 10)
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    mbs.SolveDynamic(settings)


OF_KERNELS = Contents(elements=MANY)
PENALTY, ALGEBRAIC = (Contents(elements=FEW, enforcement=way) for way in ("penaltyMass", "algebraic"))


@dataclass(frozen=True)
class Kind:
    """Scenes of one kind.

    run: mbs -> None; who moves it.   contents: of the scene.
    keeps: whether the scenes are not dropped, as a control.
    """

    run: Callable[[Any], None]
    contents: Contents = OF_KERNELS
    keeps: bool = False


KINDS = {
    "compiled steps": Kind(_explicit),
    "user functions": Kind(lambda mbs: _explicit(mbs, STEPS), replace(OF_KERNELS, watched=True)),
    "joined to bodies": Kind(_explicit, replace(OF_KERNELS, bodies=1)),
    "stepper": Kind(_stepper),
    "penaltyMass, native RK44": Kind(_native_explicit, PENALTY),
    "algebraic, native generalized-alpha": Kind(_native_implicit, ALGEBRAIC),
    "control: compiled steps, kept": Kind(_explicit, keeps=True),
    "control: penaltyMass, kept": Kind(_native_explicit, PENALTY, keeps=True),
}


def dropped_scenes(name: str, number: int) -> list[int]:
    """Resident memory [bytes] after each of so many scenes of one of the `KINDS`, built, run and dropped.

    For a process of its own; read from /proc, as on Linux.
    """
    kind, memory, kept = KINDS[name], [], []
    for _ in range(number):
        mbs = joined_scene(kind.contents)
        container = mbs.variables.pop("container")  # it owns the mbs, which would own it
        with silence():
            kind.run(mbs)
        if kind.keeps:
            kept.append((mbs, container))
        del mbs, container
        gc.collect()
        memory.append(_told("smaps_rollup", "Rss"))
    return memory
