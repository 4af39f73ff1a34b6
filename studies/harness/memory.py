"""Memory of a long cable, measured in a process of its own."""

import json
import resource
import subprocess
import sys
import time
from pathlib import Path

from .study import Row

_ROOT_FOLDER = Path(__file__).parents[2]
_KILO = 1024


def memory_of(scene: str, elements: int, steps: int) -> Row:
    """Memory in bytes, and seconds, of a cable that is built, checked and stepped.

    Returns:
        "libraries": before anything is built; "model": with the Exudyn model; "peak": of all;
        "startSeconds": of making and starting the stepper; "stepSeconds": of one step.
    """
    process = subprocess.run(
        [sys.executable, "-m", __name__, scene, str(elements), str(steps)],
        cwd=_ROOT_FOLDER,
        capture_output=True,
        text=True,
        check=True,
    )
    return dict(json.loads(process.stdout))


def _peak() -> int:
    """Largest resident memory so far [bytes].

    Linux hands what getrusage tells down from parent to child; its status file counts from the start.
    """
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) * _KILO for line in lines if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        pass
    unit = 1 if sys.platform == "darwin" else _KILO
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _run(scene: str, elements: int, steps: int) -> Row:
    from exudyn_inext import ExplicitSettings, ExplicitStepper
    from reference_models.inextensible import build
    from reference_models.scenes import load_scene

    row: Row = {"libraries": _peak()}
    model = build(load_scene(scene), elements)
    row["model"] = _peak()
    start = time.perf_counter()
    stepper = ExplicitStepper(model.mbs, ExplicitSettings(stepSize=2e-3, massScaling=0.3))
    stepper.Start()
    row["startSeconds"] = time.perf_counter() - start
    stepper.Step()
    start = time.perf_counter()
    stepper.Step(steps)
    row["stepSeconds"] = (time.perf_counter() - start) / steps
    return row | {"peak": _peak()}


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))
