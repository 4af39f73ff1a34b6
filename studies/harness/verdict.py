"""Verdicts: what was measured against a bar; none where the measurement cannot tell."""

QUICK_NOISE = 1.5
"""Factor by which a quotient of CPU times from few, short runs may be off either way."""
UNDECIDED = "undecided within noise"


def timing_noise(quick: bool) -> float:
    """Factor within which a timed figure counts as equal to a bar; full runs are taken as measured."""
    return QUICK_NOISE if quick else 1.0


def at_most(value: float, bar: float, noise: float = 1.0) -> bool | None:
    """Whether value <= bar; None if a factor `noise` could turn it.   value, bar: positive."""
    if value <= bar / noise:
        return True
    return False if not value <= bar * noise else None


def verdict(is_kept: bool | None, kept: str = "kept", missed: str = "MISSED") -> str:
    """The words for it."""
    if is_kept is None:
        return UNDECIDED
    return kept if is_kept else missed


def judged(value: float, bar: float, noise: float = 1.0, kept: str = "kept", missed: str = "MISSED") -> str:
    """The words for whether value <= bar."""
    return verdict(at_most(value, bar, noise), kept, missed)
