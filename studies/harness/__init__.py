"""How every study is run: timing, errors, storage, tables, plots. One concept a file; here what all use."""

from .store import Row
from .study import Order, Results, Study, announce
from .table import (
    UNDECIDED,
    Table,
    TextTable,
    at_most,
    column,
    groups,
    number,
    percent,
    tables,
    verdict,
    verdict_on,
)

__all__ = [
    "UNDECIDED", "Order", "Results", "Row", "Study", "Table", "TextTable", "announce", "at_most", "column",
    "groups", "number", "percent", "tables", "verdict", "verdict_on",
]  # fmt: skip
