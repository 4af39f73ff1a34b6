"""Where outcomes are kept: one file a case, written whole or not at all, all of one state of the code."""

import json
import shutil
from pathlib import Path
from typing import Any

from exudyn_inext.errors import InputError

from ..provenance import code_name, provenance
from ..store import prepare_directory, write_json
from ..study import Row
from .case import Outcome, Sweep, key_of

FOLDER = "sweeps"
_STAMP = "provenance.json"
_DECIDING = ("commit", "sources", "versions")


class CaseFolder:
    """The finished cases of one sweep below an output directory.

    Args:
        output: the directory.   sweep: whose cases they are.
        fresh: discard what is there: the cases of this sweep, or all if they belong to another state.

    Raises:
        InputError: results of another commit, of changed sources or of other versions are there.
    """

    def __init__(self, output: Path, sweep: Sweep, fresh: bool = False) -> None:
        self._folder = output / FOLDER / sweep.name
        if fresh:
            is_foreign = bool(_foreign(output))
            shutil.rmtree(output / FOLDER if is_foreign else self._folder, ignore_errors=True)
        else:
            require_same_state(output)
        prepare_directory(self._folder)
        write_json(output / FOLDER / _STAMP, provenance())

    def load(self, case: Row) -> Outcome | None:
        """What became of the case earlier, or None."""
        stored = _read(self._path(case))
        return Outcome(stored["status"], stored["result"], stored["provenance"]) if stored else None

    def save(self, case: Row, outcome: Outcome) -> None:
        """Keep an outcome, at once."""
        document = {"case": case, "status": outcome.status, "result": outcome.result}
        write_json(self._path(case), document | {"provenance": outcome.provenance})

    def _path(self, case: Row) -> Path:
        return self._folder / f"{key_of(case)}.json"


def require_same_state(output: Path) -> None:
    """Refuse (InputError) a directory with cases of another commit, changed sources or other versions."""
    difference = _foreign(output)
    if difference:
        raise InputError(
            f"'{output}' holds cases that belong to another state of the code ({difference}): "
            "choose another --output, go back to that state, or give --fresh to discard them."
        )


def _foreign(output: Path) -> str:
    """What separates the state of stored cases from the present one; empty if nothing does."""
    stamp = output / FOLDER / _STAMP
    found = _read(stamp)
    if found is None and stamp.parent.exists() and any(stamp.parent.iterdir()):
        found = {"commit": "unknown", "changed": True, "sources": "", "versions": {}}
    return _difference(found) if found else ""


def _difference(found: dict[str, Any]) -> str:
    """What separates a stored provenance from the present one; empty if nothing does."""
    present = provenance()
    which = [key for key in _DECIDING if found.get(key) != present[key]]
    if not which:
        return ""
    if which == ["versions"]:
        return f"versions {found['versions']}, now {present['versions']}"
    return f"{code_name(found)}, now {code_name(present)}; different: {', '.join(which)}"


def _read(path: Path) -> dict[str, Any] | None:
    """A JSON document, None if there is none."""
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
