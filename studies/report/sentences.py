"""Conclusions of two reports beside each other, their numbers left aside."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

ADVERSE = re.compile(r"\b(?:MISSED|NOT(?: EQUAL)?|DIVERGES|DRIFTS|ABOVE|FAILED|LOSES)\b")
"""How studies say that something is not as it should be: in capitals."""
UNDECIDED = re.compile(r"\bundecided\b")
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?")
_VERDICT = re.compile(
    r"\b(?:MISSED|kept|(?:is |are )?NOT|DIVERGES|survives|DRIFTS|does not drift|ABOVE|within|undecided)\b"
)
ALIKE = 0.6  # share of two sentences, numbers and verdicts left aside, from which they say the same


@dataclass(frozen=True)
class Pair:
    """One conclusion, then and now."""

    study: str
    old: str
    new: str

    @property
    def is_worse(self) -> bool:
        """Whether it has become adverse."""
        return is_adverse(self.new) and not is_adverse(self.old)


@dataclass(frozen=True)
class Sentences:
    """flipped: from good to adverse or back.   undecided: a verdict on one side only.

    kept: how many say the same.   reworded: how many say it of another row.
    added, vanished: on one side only.
    """

    flipped: list[Pair]
    undecided: list[Pair]
    kept: int
    reworded: int
    added: int
    vanished: int


def masked(sentence: str) -> str:
    """Without its numbers."""
    return _NUMBER.sub("#", sentence)


def is_adverse(sentence: str) -> bool:
    """Whether it says that something is not as it should be."""
    return ADVERSE.search(sentence) is not None


def compare_sentences(study: str, old: Sequence[str], new: Sequence[str]) -> Sentences:
    """Sentence by sentence: first those that are equal but for numbers, then those that are alike."""
    pairs, rest_old, rest_new = _matched(old, new, masked)
    more, rest_old, rest_new = _matched(rest_old, rest_new, lambda text: _VERDICT.sub("", masked(text)))
    alike, rest_old, rest_new = _alike(rest_old, rest_new)
    changed = [Pair(study, *pair) for pair in more + alike]
    flipped = [pair for pair in changed if _state(pair.old) * _state(pair.new) < 0]
    undecided = [pair for pair in changed if abs(_state(pair.old)) != abs(_state(pair.new))]
    return Sentences(
        flipped,
        undecided,
        len(pairs),
        len(changed) - len(flipped) - len(undecided),
        len(rest_new),
        len(rest_old),
    )


def _state(sentence: str) -> int:
    """-1 if adverse, 0 if undecided, 1 otherwise."""
    if is_adverse(sentence):
        return -1
    return 0 if UNDECIDED.search(sentence) else 1


def _matched(
    old: Sequence[str], new: Sequence[str], key: Callable[[str], str]
) -> tuple[list[tuple[str, str]], list[str], list[str]]:
    """Pairs of equal keys, each sentence used once; what is left of both."""
    left, pairs, rest = list(new), [], []
    for sentence in old:
        match = next((other for other in left if key(other) == key(sentence)), None)
        if match is None:
            rest.append(sentence)
        else:
            left.remove(match)
            pairs.append((sentence, match))
    return pairs, rest, left


def _alike(old: Sequence[str], new: Sequence[str]) -> tuple[list[tuple[str, str]], list[str], list[str]]:
    """Pairs that differ in some words, the most alike first."""
    likeness = sorted(((_likeness(a, b), a, b) for a in old for b in new), reverse=True)
    left, rest, pairs = list(new), list(old), []
    for value, a, b in likeness:
        if value >= ALIKE and a in rest and b in left:
            pairs.append((a, b))
            rest.remove(a)
            left.remove(b)
    return pairs, rest, left


def _likeness(old: str, new: str) -> float:
    first, second = (_VERDICT.sub("", masked(text)).split() for text in (old, new))
    return SequenceMatcher(None, first, second).ratio()
