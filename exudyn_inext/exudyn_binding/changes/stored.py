"""What has been changed, as data of a restart file: the run that continues begins with it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import InputError
from ...items.parameters import Parameter
from .constraints import SteppedReader
from .limit import StepLimit
from .log import ChangeLog

_FUNCTION = "function"  # in place of one, which a file cannot hold


def stored_changes(log: ChangeLog, reader: SteppedReader, limit: StepLimit, moves: bool) -> dict[str, Any]:
    """All that has been changed so far, as JSON has it; empty if nothing has.

    moves: whether something has moved through the last step.
    """
    if not log.first:
        return {}
    parameters = [[*key, _as_data(key.value(log.mbs))] for key in log.first]
    seen = [[*key, size] for key, size in limit.seen.items()]
    return {"parameters": parameters, "seen": seen, "moves": moves, **reader.memory()}


def restore_limit(data: Mapping[str, Any], limit: StepLimit) -> None:
    """Let the limit be looked at when it would have been without an interruption."""
    limit.seen = {Parameter(*names): size for *names, size in data.get("seen", [])}


def restore_changes(data: Mapping[str, Any], log: ChangeLog, reader: SteppedReader) -> None:
    """Set the parameters of mbs, and what the reader knows, to what they were when a file was written.

    Raises:
        InputError: a function had been replaced.
    """
    for *names, value in data["parameters"]:
        key = Parameter(*names)
        if value == _FUNCTION:
            raise InputError(
                f"restart file: {key} was replaced by another function before the file was written, which a "
                "file cannot hold: let one function tell the cases apart, or start anew."
            )
        log.first[key] = key.value(log.mbs)
        key.set(log.mbs, value)
    reader.restore(data)


def _as_data(value: Any) -> Any:
    """Numbers, lists of them, or text; the index of an item is its number."""
    if callable(value):
        return _FUNCTION
    if isinstance(value, str):
        return value
    numbers = np.asarray(value)
    return int(value) if numbers.dtype == object and numbers.ndim == 0 else numbers.tolist()
