"""Files that a run will write: looked at before anything is computed."""

import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

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
