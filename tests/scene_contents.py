"""Everything in an mbs that a refused call must leave as it was."""

from typing import Any

import exudyn
import numpy as np

_KINDS = ("Node", "Object", "Marker", "Load", "Sensor")
_MEMORY = "temp"  # of user functions, in native objects
_SHOWN = (exudyn.ConfigurationType.Current, exudyn.ConfigurationType.Initial)


def contents(mbs: Any) -> list[Any]:
    """Items with all their parameters; of an assembled mbs also its states and its time."""
    data = mbs.systemData
    items = [
        _plain(getattr(mbs, f"Get{kind}")(number))
        for kind in _KINDS
        for number in range(getattr(data, f"NumberOf{kind}s")())
    ]
    if not mbs.systemIsConsistent:
        return items
    states = [_plain(np.asarray(part)) for shown in _SHOWN for part in data.GetSystemState(shown)[:2]]
    return [items, states, data.GetTime()]


def _plain(value: Any) -> Any:
    """What can be compared: NaN equals NaN, a function itself only."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items() if not key.startswith(_MEMORY)}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    return id(value) if callable(value) else repr(value)
