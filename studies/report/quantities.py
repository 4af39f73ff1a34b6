"""What the figures in stored rows are, and which way is better: all that a comparison knows of studies.

A key means the same in all rows, unless "KIND.KEY" says otherwise for rows of one kind. A figure of a study
that is not named here is not compared; a new study adds its keys, or uses those that there are. What `Advise`
predicts and achieves is left out: it chooses by measured times, so that the next run may choose another.

TIME      CPU or wall time, divided by the common factor of both machines; noise from the repeats if
          they are stored, otherwise GENERIC_NOISE.
QUOTIENT  of two times of one run: the machine cancels, the noise is that of both.
SPEED     motion or work a second: an inverse time.
TAIL      of a distribution of times: the slowest of thousands of steps, which other programs decide, too.
ERROR     deterministic, what the method is off by; changes of more than DETERMINISTIC count.
LIMIT     deterministic, what the method can still do: stable steps, survived times.
MEMORY    resident memory.
"""

from dataclasses import dataclass
from typing import Any

from studies.harness import Row

TIME, QUOTIENT, SPEED, TAIL, ERROR, LIMIT, MEMORY = (
    "time", "quotient of times", "speed", "tail of times", "error", "limit", "memory",
)  # fmt: skip
SLOWER = {TIME, QUOTIENT, SPEED, TAIL}
LESS, MORE = "less", "more"

LEAST_NOISE = 0.1
"""Of medians over repeats: repeated runs on a quiet machine differ by some 10 %."""
SPREADS = 3.0
"""How many times (median - minimum)/median of the repeats the noise of a median is taken to be."""
GENERIC_NOISE = {TIME: 0.25, QUOTIENT: 0.2, SPEED: 0.25, TAIL: 4.0, MEMORY: 0.05}
"""Relative, of full runs, where no spread is stored."""
QUICK = 2.0
"""How many times as large the noise of times is in quick runs."""
DETERMINISTIC = 0.01
"""Relative change of an error or a limit that counts: bisection is to 0.4 %, rounding far below."""


@dataclass(frozen=True)
class Quantity:
    """kind, better: see above.   spread: key of the least time of the repeats whose median it is.

    floor: what is below it is rounding, and equal.
    """

    kind: str
    better: str = LESS
    spread: str | None = None
    floor: float = 0.0


FLOORS = {
    "alone.share": 0.03, "among bodies.share": 0.03, "stretch": 1e-10, "violation": 1e-11, "rate": 1e-10,
    "range": 1e-9, "kilobytesAScene": 50.0,
}  # fmt: skip
SPREADS_OF = {"cpuSeconds": "cpuSecondsMin"}
KEYS = {
    (TIME, LESS): (
        "cpuSeconds", "microseconds", "nativeMicroseconds", "startMilliseconds", "startSeconds", "alone",
        "together", "wallOfAllCores", "median", "cpuMedian", "change.seconds", "change.baseSeconds",
        "achievedSeconds",
    ),
    (TAIL, LESS): ("percentile999", "cpuPercentile999"),
    (QUOTIENT, LESS): (
        "ratio.ratio", "ratioLobatto", "costRatio", "alone.share", "among bodies.share",
    ),
    (QUOTIENT, MORE): ("gain",),
    (SPEED, MORE): ("realTime",),
    (ERROR, LESS): (
        "errorMax", "errorHalved", "errorRms", "error", "baseError", "referenceUncertainty", "stretch",
        "violation", "rate", "range",
    ),
    (LIMIT, MORE): ("found", "hours"),
    (MEMORY, LESS): ("peakMegabytes", "lastMegabytes", "kilobytesAScene"),
}  # fmt: skip
QUANTITIES = {
    key: Quantity(kind, better, SPREADS_OF.get(key), FLOORS.get(key, 0.0))
    for (kind, better), keys in KEYS.items()
    for key in keys
}

IDENTITY = (
    "kind", "label", "what", "scene", "scheme", "cable", "formulation", "integrator", "curvatureMeasure",
    "enforcement", "elements", "dimension", "value", "theta", "zeta", "motion", "endTime",
    "members", "garbageCollection", "cables", "springs", "points", "bodies", "joints",
)  # fmt: skip
"""What a row is about: rows with the same of these are the same row."""


def quantity(row: Row, key: str) -> Quantity | None:
    """What the figure of that key in that row is; None if it is not compared."""
    return QUANTITIES.get(f"{row.get('kind')}.{key}") or QUANTITIES.get(key)


def identity(study: str, row: Row) -> tuple[Any, ...]:
    """Of a row of a study."""
    return (study, *((key, repr(row[key])) for key in IDENTITY if row.get(key) is not None))


def noise(meaning: Quantity, row: Row, key: str, quick: bool) -> float:
    """Relative, of one figure."""
    if meaning.kind in (ERROR, LIMIT):
        return DETERMINISTIC
    if meaning.kind == MEMORY:
        return GENERIC_NOISE[MEMORY]
    least = row.get(meaning.spread) if meaning.spread else None
    relative = GENERIC_NOISE[meaning.kind]
    if least is not None:
        relative = max(LEAST_NOISE, SPREADS * (row[key] - least) / row[key])
    return QUICK * relative if quick else relative
