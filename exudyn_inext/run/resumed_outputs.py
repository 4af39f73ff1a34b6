"""Sensor and solution files of a run that is continued: cut back to where it goes on, and appended to."""

import mmap
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from .output_files import sensor_files, solution_file


class ResumedOutputs:
    """The output files of a run that goes on at a given time.

    Args:
        settings: exudyn.SimulationSettings.   sensors: data of all sensors, which may write files.

    Raises:
        InputError: a file that cannot be continued.
    """

    def __init__(self, settings: Any, sensors: Sequence[Any]) -> None:
        solution = settings.solution
        of_solution = [solution_file(solution)] if solution.file.write else []
        self._solution_exists = any(path.is_file() for path in of_solution)
        of_sensors = [path for _, path in sensor_files(solution, sensors) if path.is_file()]
        self._sensors_exist = bool(of_sensors)
        if self._solution_exists and solution.file.binary:
            raise InputError(
                f"solution.file.binary: '{of_solution[0]}' cannot be continued, as Exudyn does not append to "
                "binary solution files: choose another solution.file.name for the rest of the run, or text."
            )
        existing = of_solution if self._solution_exists else []
        self._files = list(dict.fromkeys([*existing, *of_sensors]))

    def cut(self, time: float) -> None:
        """Cut what a killed run has written after `time` [s], and footers, off the files."""
        for path in self._files:
            cut_rows_after(path, time)

    def settings(self, solution: Any) -> Iterator[tuple[Any, str, Any]]:
        """What Exudyn has to be told: (part of the settings, name, value)."""
        yield solution.sensors, "append", True
        yield solution.file, "writeInitialValues", False
        if self._sensors_exist:
            yield solution.sensors, "writeHeader", False
        if self._solution_exists:
            yield solution.file, "append", True
            yield solution.file, "writeHeader", False


def cut_rows_after(path: Path, time: float) -> None:
    """Cut a file of comma separated rows behind its last whole row at or before `time` [s].

    Rows begin with their time. If there is no such row, the comments at the beginning stay. The file is
    written aside and renamed, so that a process that is killed meanwhile leaves the old one.

    Raises:
        InputError: the file cannot be written.
    """
    target = path.resolve()
    aside = target.with_name(f"{target.name}.{os.getpid()}.part")
    try:
        length = _length_until(target, time)
        if length == target.stat().st_size:
            return
        with open(target, "rb") as file, open(aside, "wb") as kept:
            _copy(file, kept, length)
            kept.flush()
            os.fsync(kept.fileno())
        shutil.copymode(target, aside)
        os.replace(aside, target)
    except OSError as error:
        raise InputError(
            f"'{path}' cannot be cut back to t = {time:.6g} s, where the run goes on ({error.strerror}): "
            "make it writable, or choose another file."
        ) from error
    finally:
        aside.unlink(missing_ok=True)


def _copy(source: Any, target: Any, length: int) -> None:
    remaining = length
    while remaining:
        remaining -= target.write(source.read(min(remaining, 1 << 20)))


def _length_until(path: Path, time: float) -> int:
    """Bytes up to the end of the last whole row at or before that time."""
    if path.stat().st_size == 0:
        return 0
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as text:
        end = text.rfind(b"\n") + 1  # what follows is torn
        while end:
            start = text.rfind(b"\n", 0, end - 1) + 1
            if _is_row_until(text[start:end], time):
                return end
            end = start
        while text[end : end + 1] == b"#" and text.find(b"\n", end) >= 0:
            end = text.find(b"\n", end) + 1
        return end


def _is_row_until(line: bytes, time: float) -> bool:
    try:
        return float(line.partition(b",")[0]) <= time
    except ValueError:
        return False
