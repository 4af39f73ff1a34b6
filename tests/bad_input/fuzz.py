"""python -m tests.bad_input.fuzz: many examples, each target in a process of its own."""

import argparse
import os
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed
from hypothesis import settings as hypothesis_settings

from exudyn_inext import InextensibleError
from exudyn_inext.exudyn_binding import stepper
from exudyn_inext.run import time_grid
from tests.scene_contents import contents

from .targets import TARGETS, Target
from .values import UserError, calls, with_scene

FIGURES = ("examples", "succeeded", "refused", "foreign exceptions", "changed after refusal", "crashes")


@contextmanager
def runs_end_soon() -> Iterator[None]:
    """Valid but strange numbers may ask for months of computing: within, they are refused much earlier."""
    before = time_grid.MOST_STEPS, stepper.MOST_STEPS
    time_grid.MOST_STEPS, stepper.MOST_STEPS = 1e5, 100_000
    try:
        yield
    finally:
        time_grid.MOST_STEPS, stepper.MOST_STEPS = before


@contextmanager
def in_a_folder_of_its_own() -> Iterator[None]:
    """A nasty string may be the name of a file."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as directory:
        os.chdir(directory)
        try:
            yield
        finally:
            os.chdir(before)


def try_call(target: Target, arguments: dict[str, Any]) -> str:
    """'succeeded' or 'refused'; whatever else happens is raised.

    Raises:
        AssertionError: the call was refused, but the mbs is not as it was.
    """
    scene = target.scene()
    filled = with_scene(arguments, scene)
    before = contents(scene.mbs)
    was_assembled = scene.mbs.systemIsConsistent
    with runs_end_soon(), in_a_folder_of_its_own(), warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("ignore", UserWarning)
        try:
            target.call(scene, filled)
        except UserError:
            return "refused"
        except InextensibleError:
            is_at_fault = target.changes and scene.mbs.systemIsConsistent == was_assembled
            if is_at_fault and contents(scene.mbs) != before:
                raise AssertionError("a refused call changed the mbs") from None
            return "refused"
    return "succeeded"


def _fuzz(name: str, examples: int, start: int, log: Path) -> Counter[str]:
    """Counts of what happened; faults are written to the log, the present call before it is tried."""
    counts: Counter[str] = Counter()
    target = TARGETS[name]

    @seed(start)
    @hypothesis_settings(
        max_examples=examples,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(calls(target.valid))
    def try_one(arguments: dict[str, Any]) -> None:
        log.write_text(f"{arguments!r}")
        counts["examples"] += 1
        try:
            counts[try_call(target, arguments)] += 1
        except AssertionError as error:
            _report(counts, "changed after refusal", arguments, error)
        except Exception as error:
            _report(counts, "foreign exceptions", arguments, error)

    try_one()
    return counts


def _report(counts: Counter[str], what: str, arguments: dict[str, Any], error: Exception) -> None:
    counts[what] += 1
    frames = traceback.extract_tb(error.__traceback__)
    place = next((f for f in reversed(frames) if "exudyn_inext" in f.filename), frames[-1])
    print(f"! {type(error).__name__} at {Path(place.filename).name}:{place.lineno}: {str(error)[:160]!r}")
    print(f"    {arguments!r}"[:600])


def _in_a_process(name: str, options: argparse.Namespace) -> dict[str, int]:
    with tempfile.TemporaryDirectory() as directory:
        log = Path(directory) / "call"
        command = [sys.executable, "-X", "faulthandler", "-m", "tests.bad_input.fuzz", "--one", name]
        command += ["--examples", str(options.examples), "--seed", str(options.seed), "--log", str(log)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=options.timeout)
            output, code = done.stdout, done.returncode
        except subprocess.TimeoutExpired as error:
            output, code = (error.stdout or b"").decode(), -1
            print(f"! {name}: no end within {options.timeout} s")
        *lines, last = output.splitlines() or [""]
        print("\n".join(lines))
        if code != 0:
            print(f"! {name}: the process ended with {code} in {log.read_text() if log.exists() else '?'}")
            return {"crashes": 1}
    return dict(zip(FIGURES, map(int, last.split()), strict=False))


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0 if all examples succeeded or were refused by an error of the package."""
    parser = argparse.ArgumentParser(prog="python -m tests.bad_input.fuzz", description=__doc__)
    parser.add_argument("--examples", type=int, default=1000, help="of each target")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--timeout", type=float, default=600.0, help="of each target [s]")
    parser.add_argument("--targets", nargs="*", default=list(TARGETS), choices=list(TARGETS))
    parser.add_argument("--one", help=argparse.SUPPRESS)
    parser.add_argument("--log", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.one:
        counts = _fuzz(options.one, options.examples, options.seed, options.log)
        print(*(counts[figure] for figure in FIGURES))
        return 0
    table = {name: _in_a_process(name, options) for name in options.targets}
    width = max(map(len, table))
    print(f"{'target':{width}} | " + " | ".join(FIGURES))
    for name, row in table.items():
        print(f"{name:{width}} | " + " | ".join(f"{row.get(f, 0):{len(f)}}" for f in FIGURES))
    total = {figure: sum(row.get(figure, 0) for row in table.values()) for figure in FIGURES}
    print(f"{'all':{width}} | " + " | ".join(f"{total[f]:{len(f)}}" for f in FIGURES))
    return int(any(total[figure] for figure in FIGURES[3:]))


if __name__ == "__main__":
    sys.exit(main())
