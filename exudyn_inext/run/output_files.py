"""Files of a run: looked at before anything is computed, and those of a run that is continued.

These are cut back to where it goes on, and appended to.
"""

import mmap
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from ..errors import InputError


def require_writable_outputs(settings: Any, sensors: Sequence[Any]) -> None:
    """Raise InputError unless the files of solution, sensors and restarts can be written.

    Missing folders are no fault, they are added.

    Args:
        settings: exudyn.SimulationSettings; where the solution goes.
        sensors: data of all sensors, which may write files.
    """
    for what, name in _files(settings.solution, sensors):
        try:
            _try_to_write(Path(name))
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            raise InputError(
                f"{what} = {name!r} cannot be written ({why}): choose another folder, or switch the file off."
            ) from None


def _files(solution: Any, sensors: Sequence[Any]) -> Iterator[tuple[str, str]]:
    """What writes which file."""
    if solution.file.write:
        yield "solution.file.name", solution.file.name
    if solution.restart.write:
        yield "solution.restart.name", solution.restart.name
    for number, path in sensor_files(solution, sensors):
        yield f"fileName of sensor {number} '{sensors[number]['name']}'", str(path)


def solution_file(solution: Any) -> Path:
    """Where Exudyn writes the solution: it adds an ending to names without any dot."""
    name, ending = solution.file.name, ".sol" if solution.file.binary else ".txt"
    return Path(name if "." in name else name + ending)


def sensor_files(solution: Any, sensors: Sequence[Any]) -> Iterator[tuple[int, Path]]:
    """Numbers of the sensors that write files, and where to."""
    if not solution.sensors.active:
        return
    for number, sensor in enumerate(sensors):
        if sensor["writeToFile"] and sensor["fileName"]:
            yield number, Path(sensor["fileName"])


def _try_to_write(path: Path) -> None:
    """Nothing is left behind; OSError if the file, or a folder on the way to it, cannot be written."""
    if path.exists():
        with path.open("ab"):
            return
    folder = next(parent for parent in path.absolute().parents if os.path.lexists(parent))
    with tempfile.TemporaryFile(dir=folder):
        return


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
        self._solution = [path for path in of_solution if path.is_file()]
        self._sensors = [path for _, path in sensor_files(solution, sensors) if path.is_file()]
        if self._solution and solution.file.binary:
            raise InputError(
                f"solution.file.binary: '{self._solution[0]}' cannot be continued, as Exudyn does not append "
                "to binary solution files: choose another solution.file.name for the rest of the run, or "
                "text."
            )

    def cut(self, time: float) -> None:
        """Cut what a killed run has written after `time` [s], and footers, off the files."""
        for path in dict.fromkeys([*self._solution, *self._sensors]):
            cut_rows_after(path, time)

    def settings(self, solution: Any) -> Iterator[tuple[Any, str, Any]]:
        """What Exudyn has to be told: (part of the settings, name, value)."""
        yield solution.sensors, "append", True
        yield solution.file, "writeInitialValues", False
        if self._sensors:
            yield solution.sensors, "writeHeader", False
        if self._solution:
            yield solution.file, "append", True
            yield solution.file, "writeHeader", False


def cut_rows_after(path: Path, time: float) -> None:
    """Cut a file of comma separated rows behind its last whole row at or before `time` [s].

    Rows begin with their time. If there is no such row, the comments at the beginning stay.

    Raises:
        InputError: the file cannot be written.
    """
    target = path.resolve()
    try:
        length = _length_until(target, time)
        if length == target.stat().st_size:
            return
        with open(target, "rb") as file, written_aside(target) as kept:
            shutil.copymode(target, kept.name)
            while remaining := length - kept.tell():
                kept.write(file.read(min(remaining, 1 << 20)))
    except OSError as error:
        raise InputError(
            f"'{path}' cannot be cut back to t = {time:.6g} s, where the run goes on ({error.strerror}): "
            "make it writable, or choose another file."
        ) from error


@contextmanager
def written_aside(path: Path) -> Iterator[IO[bytes]]:
    """A file to be written, which takes the place of `path` if that has succeeded.

    A process that is killed meanwhile leaves the old one.
    """
    aside = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        with open(aside, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)


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
