"""Which rows form a front together."""

from collections.abc import Callable, Mapping, Sequence

from reference_models.peers.rigid_links import FORMULATION as RIGID_LINKS
from studies.harness.front import is_explicit, is_explicit_by_default, is_implicit, is_implicit_by_default
from studies.harness.study import Row

INEXTENSIBLE = "inextensible"
BY_NATIVE_SOLVERS = "inextensible, native solvers"
CONVENTIONAL = "conventional"
IMPLICIT, EXPLICIT = "conventional, implicit", "conventional, explicit"
PEER = "rigid links (MuJoCo)"


def family_of(row: Row) -> str:
    """The family that a row belongs to."""
    if row["formulation"] == RIGID_LINKS:
        return PEER
    if row["formulation"] == INEXTENSIBLE:
        return INEXTENSIBLE if row.get("enforcement", "projection") == "projection" else BY_NATIVE_SOLVERS
    return IMPLICIT if is_implicit(row) else EXPLICIT


FAMILIES = (INEXTENSIBLE, BY_NATIVE_SOLVERS, IMPLICIT, EXPLICIT, PEER)


def _conventional(belongs: Callable[[Row], bool]) -> Callable[[Row], bool]:
    return lambda row: row["formulation"] == CONVENTIONAL and belongs(row)


OPPONENTS: Mapping[str, Callable[[Row], bool]] = {
    IMPLICIT: _conventional(is_implicit),
    f"{IMPLICIT}, default quadrature": _conventional(is_implicit_by_default),
    EXPLICIT: _conventional(is_explicit),
    f"{EXPLICIT}, default quadrature": _conventional(is_explicit_by_default),
    PEER: lambda row: family_of(row) == PEER,
    BY_NATIVE_SOLVERS: lambda row: family_of(row) == BY_NATIVE_SOLVERS,
}
"""What the inextensible cable, moved by explicit steps, is compared with."""


def members(rows: Sequence[Row], family: str) -> list[Row]:
    """The rows of a family, in their order."""
    return [row for row in rows if family_of(row) == family]


def method_of(row: Row) -> str:
    """Integrator of an inextensible row, with what makes a scheme of its own."""
    if family_of(row) == BY_NATIVE_SOLVERS:
        return f"{row['enforcement']}, {row['integrator']}"
    name = row["integrator"] + (" with corrector" if row.get("corrector") else "")
    return name + (", mass scaling" if row.get("massScaling") else "")
