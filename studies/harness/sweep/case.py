"""A sweep, its cases, and what becomes of one."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..provenance import provenance
from ..store import plain
from ..study import Row

OK = "ok"


@dataclass(frozen=True)
class Sweep:
    """One function over many cases.

    name: of its folder.
    run: case -> result, both of what JSON knows; a function of a module, so that workers find it.
    cases: all different; {"timed": True} has a case run alone, in this process.
    """

    name: str
    run: Callable[[Row], Row]
    cases: Sequence[Row]


@dataclass(frozen=True)
class Outcome:
    """status: "ok", or "failed: " and why.   result: empty if it failed.   provenance: of the worker."""

    status: str
    result: Row
    provenance: Mapping[str, Any]


def key_of(case: Row) -> str:
    """The same for equal cases, in whichever order their entries are."""
    text = json.dumps(case, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def is_timed(case: Row) -> bool:
    """Whether a case needs a core of its own."""
    return bool(case.get("timed", False))


def execute(run: Callable[[Row], Row], case: Row) -> Outcome:
    """Run one case, wherever that is; an exception is kept as the outcome."""
    provenance()  # found before anything runs: sources may be edited meanwhile
    try:
        return Outcome(OK, plain(run(case)), provenance())
    except Exception as error:  # a failing case must not take the others with it
        return failed(f"{type(error).__name__}: {error}")


def failed(why: str) -> Outcome:
    """The outcome of a case that gave no result."""
    return Outcome(f"failed: {why}", {}, provenance())
