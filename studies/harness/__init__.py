"""How every study is run: timing, errors, storage, tables, plots. One concept a file; here what all use."""

from .store import Row
from .study import Results, Study, announce
from .table import UNDECIDED, Table, TextTable, at_most, column, groups, number, percent, tables, verdict

__all__ = [
    "UNDECIDED", "Results", "Row", "Study", "Table", "TextTable", "announce", "at_most", "column",
    "groups", "number", "percent", "tables", "verdict",
]  # fmt: skip
