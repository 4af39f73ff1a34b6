"""docs/items.md has each item type of Exudyn, and says which of them move in compiled code."""

import inspect
import re

import exudyn.itemInterface
import pytest

from exudyn_inext.native.contact_rates import WITH_CIRCLES
from exudyn_inext.native.known import bodies, connectors, joints
from tests.documents import DOCS

KINDS = "Object", "Node", "Marker", "Load", "Sensor"
WORDS = {"compiled", "evaluated", "refused", "taken"}
SLIDING = {"JointSliding", "JointSliding2D"}


def rows():
    """(names, word) of each row of the tables."""
    text = (DOCS / "items.md").read_text(encoding="utf-8")
    cells = re.findall(r"^\| (`[^|]*) \| (\w+) \|", text, re.MULTILINE)
    return [(re.findall(r"`(\w+)`", names), word) for names, word in cells]


def item_types():
    def is_item(value):
        return inspect.isclass(value) and value.__name__.startswith(KINDS)

    found = inspect.getmembers(exudyn.itemInterface, is_item)  # some by several names
    return {value.__name__ for _, value in found if not getattr(value, "_is_protocol", False)}


@pytest.mark.skipif(not exudyn.__version__.startswith("1.13"), reason="the page is that of Exudyn 1.13")
def test_each_item_type_stands_there_once():
    names = [name for row, _ in rows() for name in row]
    assert sorted(names) == sorted(item_types())
    assert {word for _, word in rows()} == WORDS


def test_compiled_are_those_that_the_package_reads():
    said = {name for row, word in rows() if word == "compiled" for name in row}
    known = {*bodies._OBJECTS, *connectors._READERS, *joints._READERS, *WITH_CIRCLES, *SLIDING}
    known |= bodies._OF_MATRICES
    assert said == {f"Object{name}" for name in {*known, "Ground"}}
