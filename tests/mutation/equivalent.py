"""Mutants that no test can notice, and why. Each rule is as narrow as it can be: who fits is not tried."""

import re
from collections.abc import Callable
from typing import NamedTuple


class Rule(NamedTuple):
    """Why the change of a line of a module, from `was` to `became`, is none."""

    reason: str
    module: str
    fits: Callable[[str, str], bool]


def why_equivalent(module: str, was: str, became: str) -> str:
    """The reason, or an empty text."""
    fits = (rule.reason for rule in _RULES if rule.module in ("", module) and rule.fits(was, became))
    return next(fits, "")


def _numbers(text: str) -> list[int]:
    return [int(number) for number in re.findall(r"(?<![\w.])\d+(?![\w.])", text)]


def _is_larger_memory(was: str, became: str) -> bool:
    """One of the sizes of local arrays has grown."""
    before, after = _numbers(was), _numbers(became)
    return "local_array(" in was and len(before) == len(after) and sum(after) == sum(before) + 1


def _lines(*pairs: tuple[str, str]) -> Callable[[str, str], bool]:
    """A line that contains the first text and has it replaced by the second."""
    return lambda was, became: any(
        old in was and "".join(was.replace(old, new).split()) == "".join(became.split()) for old, new in pairs
    )


_EMPTY_TABLE = "tables that are not needed are empty: loops over them end at once anyway"
_is_long_way = _lines(
    *(
        (f"{table}.shape[0] == 0", f"{table}.shape[{axis}] {sign} {number}")
        for table in ("damping", "drag")
        for axis, sign, number in (
            (0, "<", 0),
            (0, "<=", 0),
            (-1, "==", 0),
            (1, "==", 0),
            (0, "==", -1),
            (0, "==", 1),
        )
    )
)

_RULES = [
    Rule("memory that is larger than needed", "", _is_larger_memory),
    Rule(
        "the short way for equal lengths, or a guard for a cache that nobody can reach",
        "element/forms.py",
        _lines(
            ("== lengths[0]", "> lengths[0]"),
            ("== lengths[0]", "!= lengths[0]"),
            ("lengths[0]).all()", "lengths[-1]).all()"),
            ("write=False", "write=True"),
            ("_REMEMBERED = 4096", "_REMEMBERED = 4095"),
            ("_REMEMBERED = 4096", "_REMEMBERED = 4097"),
        ),
    ),
    Rule(
        "the matrix is square",
        "element/natural_curvature.py",
        _lines(("natural.shape[0]", "natural.shape[1]"), ("natural.shape[1]", "natural.shape[0]")),
    ),
    Rule(_EMPTY_TABLE, "cable/assembly.py", _is_long_way),
    Rule(_EMPTY_TABLE, "cable/energy.py", _is_long_way),
    Rule(
        "never read", "cable/attached.py", _lines(("0.0], flow", "1.0], flow"), ("0.0], flow", "-1.0], flow"))
    ),
    Rule(
        "memory that is larger than needed",
        "cable/links.py",
        _lines(("2 * cable.dimension", "3 * cable.dimension")),
    ),
    Rule(
        "each response is found twice",
        "cable/links.py",
        _lines(("range(0, len(links), 2)", "range(0, len(links), 1)")),
    ),
    Rule(
        "any negative number stands for no group", "cable/cable.py", _lines(("(number, -1)", "(number, -2)"))
    ),
    Rule(
        "counts, dimensions and numbers of elements are never negative, and dimensions are 2 or 3",
        "",
        _lines(
            ("if k > 0", "if k != 0"),
            ("len(axes) == 2", "len(axes) <= 2"),
            ("_constraints > 0", "_constraints != 0"),
        ),
    ),
    Rule("both are of equal length by construction", "", _lines(("strict=True", "strict=False"))),
    Rule(
        "the previous vector of the first row is zero",
        "cable/frequency.py",
        _lines(("norm = 0.0", "norm = -1.0")),
    ),
    Rule(
        "the other triangle and what lies behind the last row is zero, or not reached",
        "cable/saddle_point.py",
        _lines(("range(2 * len(axes))", "range(3 * len(axes))")),
    ),
    Rule("the only column", "cable/factorisation.py", _lines(("basis[1, 0] = x", "basis[1, -1] = x"))),
    Rule("empty in any case", "cable/records.py", _lines(("else (0, 8)", "else (0, 7)"))),
    Rule(
        "more accurate than needed, and a start that is as good as any other",
        "cable/frequency.py",
        _lines(("LANCZOS_STEPS = 40", "LANCZOS_STEPS = 41"), ("** 2 * 1.6", "** 3 * 1.6")),
    ),
    Rule(
        "the last node of a ring has no penalties of its own",
        "cable/penalty_mass.py",
        _lines(("of_elements[0]) if closed", "of_elements[1]) if closed")),
    ),
    Rule(
        "memory that is larger than needed, or empty in any case",
        "cable/records.py",
        _lines(
            ("(dim, dim - 1)", "(dim, dim + 1)"),
            ("else (0, 0)", "else (0, 1)"),
            ("else (0, 3)", "else (0, 4)"),
        ),
    ),
    Rule(
        "a node without an owner has entries that are zero, wherever they stand",
        "cable/sparse_forms.py",
        _lines(("colour, 0, None", "colour, -1, None")),
    ),
]
