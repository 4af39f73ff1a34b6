"""Which rows win: their kinds, cheapest at a given accuracy, the front of cost and accuracy, ratios."""

from collections.abc import Iterable

from .study import Row

IMPLICIT_INTEGRATORS = frozenset({"generalizedAlpha", "trapezoidal"})


def is_implicit(row: Row) -> bool:
    return row["integrator"] in IMPLICIT_INTEGRATORS


def is_explicit(row: Row) -> bool:
    return not is_implicit(row)


def is_explicit_zhai(row: Row) -> bool:
    """The paper's scheme."""
    return bool(row["integrator"].lower() == "zhai")


def is_implicit_by_default(row: Row) -> bool:
    """Implicit, with Exudyn's default quadrature of the elastic forces."""
    return is_implicit(row) and _has_default_quadrature(row)


def is_explicit_by_default(row: Row) -> bool:
    """Explicit, with Exudyn's default quadrature of the elastic forces."""
    return is_explicit(row) and _has_default_quadrature(row)


def _has_default_quadrature(row: Row) -> bool:
    return bool(row.get("quadrature", "full") == "full")


def is_usable(row: Row) -> bool:
    """Whether the row has both a time and an error."""
    return row["cpuSeconds"] is not None and row["errorMax"] is not None


def cheapest(rows: Iterable[Row], error_bound: float) -> Row | None:
    """The usable row of least CPU time with errorMax <= error_bound [m]; None if there is none."""
    candidates = [row for row in rows if is_usable(row) and row["errorMax"] <= error_bound]
    return min(candidates, key=lambda row: row["cpuSeconds"], default=None)


def front(rows: Iterable[Row]) -> list[Row]:
    """The rows that no other one beats in both time and error, cheapest first."""
    kept: list[Row] = []
    for row in sorted(filter(is_usable, rows), key=lambda row: row["cpuSeconds"]):
        if not kept or row["errorMax"] < kept[-1]["errorMax"]:
            kept.append(row)
    return kept


def time_ratio(slow: Row | None, quick: Row | None) -> float | None:
    """CPU time of `slow` over that of `quick`; None where a time is missing."""
    if slow is None or quick is None or not slow["cpuSeconds"] or not quick["cpuSeconds"]:
        return None
    return float(slow["cpuSeconds"] / quick["cpuSeconds"])
