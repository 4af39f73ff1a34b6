"""The file that a run can be continued from: named arrays and a few numbers, checked when read.

It is a NumPy archive without pickled objects. It is written aside and renamed, so that a run that is killed
meanwhile leaves the last complete one; its parts carry checksums.
"""

import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import InputError
from .output_files import written_aside

FORMAT, VERSION = "exudyn_inext restart", 23
_HEADER, _DATA = "header", "data"
_EMPTY = zlib.compress(b"{}")  # data of older versions


@dataclass(frozen=True, eq=False)
class Restart:
    """A run at the end of a step of Exudyn's time loop.

    header: numbers and names, as JSON has them.   arrays: states and memories, by name.
    """

    header: dict[str, Any]
    arrays: dict[str, Array]


def write_restart(name: str | Path, restart: Restart) -> None:
    """Write a restart file, or leave the one that is there.

    Raises:
        InputError: the folder cannot be written to.
    """
    path = Path(name)
    header = np.array(json.dumps({"format": FORMAT, "version": VERSION}))
    data = np.frombuffer(zlib.compress(json.dumps(restart.header).encode()), dtype=np.uint8)
    contents: dict[str, Any] = {_HEADER: header, _DATA: data, **restart.arrays}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_aside(path) as file:
            np.savez(file, **contents)
    except OSError as error:
        raise InputError(
            f"restart file '{path}' cannot be written ({error.strerror}): choose another "
            "solution.restart.name, or switch solution.restart.write off."
        ) from error


def read_restart(name: str | Path) -> Restart:
    """Read a restart file.

    Raises:
        InputError: it is damaged, none of ours, or of another version.
    """
    remedy = "remove it to start anew, or take an older one."
    try:
        with open(name, "rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
        header = json.loads(str(arrays.pop(_HEADER)))
        data = json.loads(zlib.decompress(arrays.pop(_DATA, _EMPTY)))
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"restart file '{name}' is damaged, or is none ({error}): {remedy}") from error
    if not isinstance(header, Mapping) or header.get("format") != FORMAT:
        raise InputError(f"restart file '{name}' is not of the format '{FORMAT}': {remedy}")
    if header.get("version") != VERSION:
        raise InputError(
            f"restart file '{name}' is of version {header.get('version')}, this package reads version "
            f"{VERSION}: continue with the package that wrote it, or {remedy}"
        )
    return Restart(dict(data), arrays)


def packed(prefix: str, memory: Mapping[str, Any]) -> dict[str, Array]:
    """Arrays of nested dicts by names with the prefix: {'a': {'b': x}} as {'prefix/a/b': x}."""
    arrays: dict[str, Array] = {}
    for name, value in memory.items():
        key = f"{prefix}/{name}"
        if isinstance(value, Mapping):
            arrays |= packed(key, value)
        else:
            arrays[key] = np.asarray(value)
    return arrays


def unpack(prefix: str, memory: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
    """Set the arrays of nested dicts, in place, to what `packed` made of them.

    Raises:
        InputError: an array is missing, or of another shape or type.
    """
    for name, value in memory.items():
        key = f"{prefix}/{name}"
        if isinstance(value, Mapping):
            unpack(key, value, arrays)
        elif key not in arrays or arrays[key].shape != value.shape or arrays[key].dtype != value.dtype:
            found = f"shape {arrays[key].shape}" if key in arrays else "nothing"
            raise InputError(
                f"restart file: '{key}' must be of shape {value.shape}, found {found}: the scene or the "
                "integrator is another one."
            )
        else:
            value[...] = arrays[key]
