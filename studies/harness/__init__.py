"""How every study is run: timing, errors, storage, tables, plots. One concept a file; here what all use."""

from .store import Row
from .study import Order, Results, Study, announce
from .table import Table, TextTable, column, groups, largest, number
from .verdict import UNDECIDED, at_most, judged, verdict

__all__ = [
    "UNDECIDED", "Order", "Results", "Row", "Study", "Table", "TextTable", "announce", "at_most", "column",
    "groups", "judged", "largest", "number", "verdict",
]  # fmt: skip
