"""What a scene is made of, as texts: what must not change between two parts of a run.

All parameters of objects, nodes, markers, loads and general contacts count, and step functions of the mbs;
names, drawing, sensors and files do not. Of user functions see `fingerprint`; an entry of mbs.variables
counts if its name stands in one of them. The initial state that a script sets in mbs.systemData does not.
"""

import json
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..items.cable_data import belongs_to_a_cable, find_cable_item
from ..run.fingerprint import strings_in, text_of, texts_of_function
from ..run.settings import ExplicitSettings
from ..scene.model import CableItem

Identity = Mapping[str, Mapping[str, str]]
"""Item -> its parameters -> their values, as texts."""

_FREE_TO_CHANGE = {"energyTolerance"}
_KINDS = ("Object", "Node", "Marker", "Load")
_NAME, _NUMBER = "name", "number"
_STEP_FUNCTIONS = ("PreStepUserFunction", "PostStepUserFunction", "PostNewtonUserFunction")
_OF_KERNELS = ("objectType", "nodeNumbers")  # all that counts of a cable's object, besides the cable
_OF_ENFORCEMENT = ("objectType",)
_NOT_OF_A_CONTACT = {"verboseMode", "visualization"}
_OF_A_SPHERE = ("markerIndex", "contactStiffness", "contactDamping", "radius", "frictionMaterialIndex")


def scene_identity(mbs: Any, explicit: ExplicitSettings, start_time: float) -> dict[str, dict[str, str]]:
    """Identity of a run at its start.

    Args:
        mbs: assembled.   explicit: settings of the run.   start_time: [s].
    """
    given = {
        f.name: repr(getattr(explicit, f.name)) for f in fields(explicit) if f.name not in _FREE_TO_CHANGE
    }
    data = mbs.systemData
    counts = {f"{_NUMBER} of {kind.lower()}s": getattr(data, f"NumberOf{kind}s")() for kind in _KINDS}
    counts[f"{_NUMBER} of general contacts"] = mbs.NumberOfGeneralContacts()
    numbers = {name: str(count) for name, count in counts.items()}
    identity: dict[str, dict[str, str]] = {"": {"startTime": repr(start_time), **given, **numbers}}
    identity |= _items(mbs)
    functions = {name: getattr(mbs, f"Get{name}")() for name in _STEP_FUNCTIONS}
    identity["mbs"] = dict(_parameters(functions)) | _variables(mbs, functions.values())
    for number in range(mbs.NumberOfGeneralContacts()):
        identity[f"general contact {number}"] = dict(_of_contact(mbs.GetGeneralContact(number)))
    if has_functions(identity):
        identity[""]["Python"] = f"{sys.version_info[0]}.{sys.version_info[1]}"
    return identity


def has_functions(identity: Identity) -> bool:
    """Whether it contains user functions, which may change parameters during a run."""
    return any(name.endswith("UserFunction") for parameters in identity.values() for name in parameters)


def difference(mine: Identity, theirs: Identity, meanwhile: Identity) -> str:
    """The first parameter that is another one: which it is, what it was, and what it is; empty if none.

    meanwhile: what the other run has changed since its start; both values are the same to us.
    """
    for item in {**mine, **theirs}:
        old, new, changed = (identity.get(item, {}) for identity in (theirs, mine, meanwhile))
        for name in {**new, **old}:
            was, now = old.get(name), new.get(name)
            if name != _NAME and now != was and (name not in changed or now != changed[name]):
                label = f"{item} '{new[_NAME]}'" if _NAME in new else item
                of_what = f"{name} of {label}" if item else name
                return f"{of_what} was {was or 'not set'}, and is {now or 'not set'} now"
    return ""


def changes(before: Identity, after: Identity) -> dict[str, dict[str, str]]:
    """Parameters that differ, with their values afterwards."""
    found = {
        item: {name: text for name, text in parameters.items() if before.get(item, {}).get(name) != text}
        for item, parameters in after.items()
    }
    return {item: parameters for item, parameters in found.items() if parameters}


def packed_identity(identity: Identity) -> Array:
    """As bytes for a restart file."""
    return np.frombuffer(zlib.compress(json.dumps(identity).encode()), dtype=np.uint8)


def unpacked_identity(data: Array) -> dict[str, dict[str, str]]:
    """What `packed_identity` made of it."""
    return dict(json.loads(zlib.decompress(data.tobytes())))


def _variables(mbs: Any, step_functions: Iterable[Any]) -> dict[str, str]:
    """Entries of mbs.variables that user functions may read."""
    if not mbs.variables:
        return {}
    values = [value for _, data in _all_items(mbs) for value in data.values()]
    functions = [value["function"] for value in [*values, *step_functions] if _is_user_function(value)]
    read = set[str]().union(*map(strings_in, functions))
    return {f"variables['{name}']": text_of(value) for name, value in mbs.variables.items() if name in read}


def _is_user_function(value: Any) -> bool:
    return isinstance(value, dict) and callable(value.get("function"))


def _items(mbs: Any) -> Iterator[tuple[str, dict[str, str]]]:
    for item, data in _all_items(mbs):
        yield item, {_NAME: data["name"], **dict(_of_item(data))}


def _all_items(mbs: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    for kind in _KINDS:
        get: Callable[[int], dict[str, Any]] = getattr(mbs, f"Get{kind}")
        for number in range(getattr(mbs.systemData, f"NumberOf{kind}s")()):
            yield f"{kind.lower()} {number}", get(number)


def _of_item(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    if "objectType" not in data:
        yield from _parameters(data)
    elif (cable := find_cable_item(data)) is not None:
        yield from _parameters({name: data[name] for name in _OF_KERNELS})
        yield from _of_cable(cable)
    elif belongs_to_a_cable(data):
        yield from _parameters({name: data[name] for name in _OF_ENFORCEMENT})
    else:
        yield from _parameters(data)


def _of_cable(item: CableItem) -> Iterator[tuple[str, str]]:
    yield from _fields(item.cable)
    yield from _parameters({"gravity": item.gravity, "held": item.held})


def _fields(data: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    for field in fields(data):
        value = getattr(data, field.name)
        if is_dataclass(value):
            yield from _fields(value, f"{prefix}{field.name}.")
        else:
            yield f"{prefix}{field.name}", text_of(value)


def _parameters(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for name, value in data.items():
        if name == _NAME or name.startswith(("V", "temp")):
            continue
        if _is_user_function(value):
            yield from texts_of_function(name, value["function"]).items()
        elif not (name.endswith("UserFunction") and value == 0):
            yield name, text_of(value)


def _of_contact(contact: Any) -> Iterator[tuple[str, str]]:
    """Settings, friction and spheres; of triangles and cables Exudyn tells nothing but their number."""
    for name in dir(contact):
        if not name.startswith(("_", "parallel")) and name not in _NOT_OF_A_CONTACT:
            value = getattr(contact, name)
            if not callable(value):
                yield name, text_of(value)
    known = contact.GetPythonObject()
    yield "frictionPairings", text_of(known["frictionPairings"])
    for name, value in known.items():
        if name.startswith("numberOf"):
            yield name, text_of(value)
    for number in range(known["numberOfSpheresMarkerBased"]):
        sphere = contact.GetSphereMarkerBased(number, addData=True)
        for name in _OF_A_SPHERE:
            yield f"{name} of sphere {number}", text_of(sphere[name])
