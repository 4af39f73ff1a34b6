"""All items of a scene but its cables, if each has a compiled form."""

from collections.abc import Sequence
from typing import Any

from ...arrays import Array, collected
from ...items.attach.inert import is_inert_cable
from ...multibody.build import FunctionOfTime, KnownItems
from ...multibody.connectors import CONNECTOR
from ...multibody.loads import LOAD, NONE
from ..bodies import Body
from ..coordinates import CoordinateMap
from ..joint_items import JointItem
from .bodies import read_body_records
from .connectors import read_connector
from .joints import read_rows
from .loads import read_load
from .points import PointReader
from .unknown import UnknownItemError


def read_known_items(
    mbs: Any,
    bodies: Sequence[Body],
    joints: Sequence[JointItem],
    coordinates: CoordinateMap,
    on_cables: int,
    elsewhere: frozenset[int],
    q: Array,
    has_forces: bool,
) -> tuple[KnownItems, "KnownNumbers"]:
    """Read all items but the cables; and by their numbers, those that may be read again.

    Args:
        mbs: in the configuration q (n,).   bodies: all objects with mass but the cables.
        joints: all constraints, in the order of their rows.
        coordinates: of the scene; those on cables are the first `on_cables` ones.
        elsewhere: objects that belong to the cables.
        has_forces: whether springs and loads are read.

    Raises:
        UnknownItemError: an item has no compiled form.
    """
    if mbs.systemData.ODE1Size():
        raise UnknownItemError("states of first order")
    if has_forces and (mbs.systemData.DataSize() or mbs.NumberOfGeneralContacts()):
        raise UnknownItemError("contact")
    records = read_body_records(mbs, bodies, coordinates, q)
    firsts = [coordinates.place(int(body.coordinates[0])) for body in bodies]
    order = {int(first): number for number, first in enumerate(records["first"])}
    of_bodies = {body.number: order[first] for body, first in zip(bodies, firsts, strict=True)}
    reader = PointReader(mbs, coordinates, on_cables, records, of_bodies)
    rows, offsets = read_rows(mbs, joints, reader)
    done = {*of_bodies, *elsewhere, *(joint.number for joint in joints)}
    items = KnownNumbers(mbs, reader, offsets)
    if has_forces:
        for number in range(mbs.systemData.NumberOfObjects()):
            if number not in done:
                items.add_object(number)
        for number in range(mbs.systemData.NumberOfLoads()):
            items.add_load(number)
    springs, loads = collected(CONNECTOR, items.connectors), collected(LOAD, items.loads)
    return KnownItems(records, reader.records, rows, springs, loads, items.functions), items


class KnownNumbers:
    """Connectors and loads as records, by their numbers, so that they can be read again.

    connectors, loads: records, in the order in which they were added.   functions: of time, to which those of
    the loads are added.
    """

    def __init__(self, mbs: Any, reader: PointReader, functions: Sequence[FunctionOfTime]) -> None:
        self._mbs, self._reader = mbs, reader
        self.connectors: list[Any] = []
        self.loads: list[Any] = []
        self.functions = list(functions)
        self._places: dict[tuple[str, int], int] = {}  # of kind and number

    def add_object(self, number: int) -> None:
        """A connector, or what does nothing; UnknownItemError if it has no compiled form."""
        data = self._mbs.GetObject(number)
        if data["objectType"] != "Ground" and not is_inert_cable(data) and data.get("activeConnector", True):
            self._places["Object", number] = len(self.connectors)
            self.connectors.append(read_connector(data, number, self._reader))

    def add_load(self, number: int) -> None:
        """UnknownItemError if it has no compiled form."""
        read = read_load(self._mbs, number, self._reader)
        if read is None:
            return
        record, function = read
        if function is not None:
            record.function = 3 * len(self.functions)
            self.functions.append(function)
        self._places["Load", number] = len(self.loads)
        self.loads.append(record)

    def read_again(self, kind: str, number: int, connectors: Any, loads: Any) -> bool:
        """Bring the records of an item, 'Object' or 'Load', up to date; False if they cannot be.

        connectors, loads: records that a system holds now.
        """
        place = self._places.get((kind, number))
        if place is None:
            return False
        before = self._reader.number_of_points
        try:
            if kind == "Load":
                record, function = read_load(self._mbs, number, self._reader) or (None, None)
                if record is None or function is not None or loads[place].function != NONE:
                    return False
                loads[place] = record
            else:
                data = self._mbs.GetObject(number)
                if not data.get("activeConnector", True):
                    return False
                connectors[place] = read_connector(data, number, self._reader)
        except UnknownItemError:
            return False
        return self._reader.number_of_points == before
