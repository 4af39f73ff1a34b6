"""All items of a scene but its cables, if each has a compiled form."""

from collections.abc import Sequence
from typing import Any

from ...arrays import Array, collected
from ...items.attach.inert import is_inert_cable
from ...multibody.connectors import CONNECTOR
from ...multibody.build import KnownItems
from ..bodies import Body
from ..coordinates import CoordinateMap
from ..joint_items import JointItem
from .bodies import read_body_records
from .connectors import read_connector
from .joints import read_rows
from .loads import read_loads
from .points import PointReader
from .unknown import Unknown

def read_known_items(
    mbs: Any,
    bodies: Sequence[Body],
    joints: Sequence[JointItem],
    coordinates: CoordinateMap,
    on_cables: int,
    elsewhere: frozenset[int],
    q: Array,
) -> KnownItems:
    """Read all items but the cables.

    Args:
        mbs: in the configuration q (n,).   bodies: all objects with mass but the cables.
        joints: all constraints, in the order of their rows.
        coordinates: of the scene; those on cables are the first `on_cables` ones.
        elsewhere: objects that belong to the cables.

    Raises:
        Unknown: an item has no compiled form.
    """
    if mbs.systemData.DataSize() or mbs.systemData.ODE1Size() or mbs.NumberOfGeneralContacts():
        raise Unknown("contact, or states of first order")
    records = read_body_records(mbs, bodies, coordinates, q)
    firsts = [coordinates.place(int(body.coordinates[0])) for body in bodies]
    order = {int(first): number for number, first in enumerate(records["first"])}
    of_bodies = {body.number: order[first] for body, first in zip(bodies, firsts, strict=True)}
    reader = PointReader(mbs, coordinates, on_cables, records, of_bodies)
    rows = read_rows(mbs, joints, reader)
    done = {*of_bodies, *elsewhere, *(joint.number for joint in joints)}
    connectors = []
    for number in range(mbs.systemData.NumberOfObjects()):
        if number in done:
            continue
        data = mbs.GetObject(number)
        if data["objectType"] == "Ground" or is_inert_cable(data) or not data.get("activeConnector", True):
            continue
        connectors.append(read_connector(data, number, reader))
    loads, functions = read_loads(mbs, reader)
    springs = collected(CONNECTOR, connectors)
    return KnownItems(records, reader.records, rows, springs, loads, functions)
