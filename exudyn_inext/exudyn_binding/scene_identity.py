"""What a scene is made of, as texts: what must not change between two parts of a run.

All parameters of objects, nodes, markers, loads and general contacts count, and step functions of the mbs;
names, drawing, sensors and files do not. Of user functions see `fingerprint`; an entry of mbs.variables
counts if its name stands in one of them. The initial state that a script sets in mbs.systemData does not.
"""

import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from ..items.cable_data import belongs_to_a_cable, find_cable_item
from ..run.fingerprint import strings_in, text_of, texts_of_function
from ..run.settings import ExplicitSettings

Identity = Mapping[str, Mapping[str, str]]
"""Item -> its parameters -> their values, as texts."""

_FREE_TO_CHANGE = {"energyTolerance"}
_KINDS = ("Object", "Node", "Marker", "Load")
_NAME, _NUMBER = "name", "number"
_STEP_FUNCTIONS = ("PreStepUserFunction", "PostStepUserFunction", "PostNewtonUserFunction")
_OF_KERNELS = ("objectType", "nodeNumbers")  # all that counts of a cable's object, besides the cable
_NOT_OF_A_CONTACT = {"verboseMode", "visualization"}
_OF_A_SPHERE = ("markerIndex", "contactStiffness", "contactDamping", "radius", "frictionMaterialIndex")


def scene_identity(mbs: Any, explicit: ExplicitSettings, start_time: float) -> dict[str, dict[str, str]]:
    """Identity of a run at its start.

    Args:
        mbs: assembled.   explicit: settings of the run.   start_time: [s].
    """
    given = {
        f.name: text_of(getattr(explicit, f.name)) for f in fields(explicit) if f.name not in _FREE_TO_CHANGE
    }
    contacts = [mbs.GetGeneralContact(number) for number in range(mbs.NumberOfGeneralContacts())]
    counts = {f"{kind.lower()}s": getattr(mbs.systemData, f"NumberOf{kind}s")() for kind in _KINDS}
    counts["general contacts"] = len(contacts)
    numbers = {f"{_NUMBER} of {what}": str(count) for what, count in counts.items()}
    items = {
        f"{kind.lower()} {number}": getattr(mbs, f"Get{kind}")(number)
        for kind in _KINDS
        for number in range(counts[f"{kind.lower()}s"])
    }
    step_functions = {name: getattr(mbs, f"Get{name}")() for name in _STEP_FUNCTIONS}
    identity: dict[str, dict[str, str]] = {"": {"startTime": repr(start_time), **given, **numbers}}
    identity |= {item: {_NAME: data[_NAME]} | _texts(_of_item(data)) for item, data in items.items()}
    identity["mbs"] = _texts(step_functions) | _variables(mbs, [*items.values(), step_functions])
    identity |= {f"general contact {k}": _texts(_of_contact(contact)) for k, contact in enumerate(contacts)}
    if has_functions(identity):
        identity["Python"] = {"version": f"{sys.version_info[0]}.{sys.version_info[1]}"}  # compared last
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
            if name != _NAME and now not in (was, changed.get(name, was)):
                label = f"{item} '{new[_NAME]}'" if _NAME in new else item
                of_what = f"{name} of {label}" if item else name
                return f"{of_what} was {was or 'not set'}, and is {now or 'not set'} now"
    return ""


def changes(before: Identity, after: Identity) -> dict[str, dict[str, str]]:
    """Parameters that differ, with their values afterwards."""
    found = {item: dict(texts.items() - before.get(item, {}).items()) for item, texts in after.items()}
    return {item: texts for item, texts in found.items() if texts}


def _variables(mbs: Any, items: list[dict[str, Any]]) -> dict[str, str]:
    """Entries of mbs.variables that user functions of the items may read."""
    if not mbs.variables:
        return {}
    functions = [value["function"] for data in items for value in data.values() if _is_user_function(value)]
    read = set[str]().union(*map(strings_in, functions))
    return {f"variables['{name}']": text_of(value) for name, value in mbs.variables.items() if name in read}


def _is_user_function(value: Any) -> bool:
    return isinstance(value, dict) and callable(value.get("function"))


def _texts(data: Mapping[str, Any]) -> dict[str, str]:
    """Parameters as texts; neither names nor drawing, nor functions that are not set."""
    texts: dict[str, str] = {}
    for name, value in data.items():
        if name == _NAME or name.startswith(("V", "temp")):
            continue
        if _is_user_function(value):
            texts |= texts_of_function(name, value["function"])
        elif not (name.endswith("UserFunction") and value == 0):
            texts[name] = text_of(value)
    return texts


def _of_item(data: dict[str, Any]) -> dict[str, Any]:
    """The parameters that count."""
    if "objectType" not in data:
        return data
    if (cable := find_cable_item(data)) is not None:
        own = {name: data[name] for name in _OF_KERNELS}
        return own | _fields(cable.cable) | {"gravity": cable.gravity, "held": cable.held}
    return {"objectType": data["objectType"]} if belongs_to_a_cable(data) else data


def _fields(data: Any, prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in fields(data):
        name, value = f"{prefix}{field.name}", getattr(data, field.name)
        found |= _fields(value, f"{name}.") if is_dataclass(value) else {name: value}
    return found


def _of_contact(contact: Any) -> dict[str, Any]:
    """Settings, friction and spheres; of triangles and cables Exudyn tells nothing but their number."""
    known = contact.GetPythonObject()
    names = [name for name in dir(contact) if not name.startswith(("_", "parallel"))]
    settings = {name: getattr(contact, name) for name in names if name not in _NOT_OF_A_CONTACT}
    found = {name: value for name, value in settings.items() if not callable(value)}
    found |= {
        name: value for name, value in known.items() if name.startswith(("numberOf", "frictionPairings"))
    }
    for number in range(known["numberOfSpheresMarkerBased"]):
        sphere = contact.GetSphereMarkerBased(number, addData=True)
        found |= {f"{name} of sphere {number}": sphere[name] for name in _OF_A_SPHERE}
    return found
