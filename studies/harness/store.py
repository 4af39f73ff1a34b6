"""Writing results: JSON and text, atomically, into a directory that is checked beforehand."""

import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from exudyn_inext import InputError

Row = dict[str, Any]
"""One case as it is stored; the keys are those of the JSON file."""


def prepare_directory(directory: Path) -> Path:
    """Create the directory and make sure that it takes files, before anything is computed."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
    except OSError as error:
        raise InputError(
            f"output directory '{directory}' cannot be written ({error.strerror}); "
            "choose another one with --output."
        ) from error
    return directory


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Write the document; NaN and infinity become null."""
    write_text(path, json.dumps(plain(document), indent=1, allow_nan=False) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write the file completely or not at all: a reader never sees half of it."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as temporary:
            temporary.write(text)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def plain(value: Any) -> Any:
    """Only what JSON knows: dict, list, str, int, float, bool, None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
