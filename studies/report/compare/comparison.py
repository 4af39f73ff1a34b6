"""What became slower, less accurate, or another conclusion than in an earlier report."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from studies.harness.document import Document
from studies.report.stored import code_of, commit_of, differences

from .figures import Change, MatchedRow, changes, is_time, machine_factor, match_rows, statuses
from .sentences import Pair, Sentences, compare_sentences


@dataclass(frozen=True)
class Comparison:
    """Two reports beside each other.

    studies: those that both have.   only_old, only_new: on one side.
    origins: sentences on commits, versions, machines.
    factor, times: common factor of all times, and over how many; native_factor, native_times: of native rows.
    slower, less_accurate, better: beyond noise, the worst first.   compared: how many figures.
    statuses: (row, old, new) of rows that fail now, or no longer.
    flipped, undecided: conclusions.   counts: of the other ones, in words.
    rows, added, vanished: how many rows are matched, new, gone.
    """

    studies: list[str]
    only_old: list[str]
    only_new: list[str]
    origins: list[str]
    factor: float
    times: int
    native_factor: float
    native_times: int
    slower: list[Change]
    less_accurate: list[Change]
    better: list[Change]
    compared: int
    statuses: list[tuple[MatchedRow, str, str]]
    flipped: list[Pair]
    undecided: list[Pair]
    counts: str
    rows: int
    added: int
    vanished: int

    @property
    def is_worse(self) -> bool:
        """Whether anything is slower, less accurate, failing now, or adverse now."""
        failing = [old for _, old, _ in self.statuses if old == "ok"]
        adverse = [pair for pair in self.flipped if pair.is_worse]
        return bool(self.slower or self.less_accurate or failing or adverse)

    @property
    def summary(self) -> list[str]:
        """In sentences."""
        return [*self.origins, *_figures(self), _conclusions(self)]


def compare(old: Mapping[str, Document], new: Mapping[str, Document]) -> Comparison:
    """Two sets of documents, by name of the study."""
    common = [name for name in new if name in old]
    matched = match_rows(old, new)
    factor, times = machine_factor(matched.rows)
    native_factor, native_times = machine_factor(matched.rows, native_only=True)
    all_changes = changes(matched.rows, factor)
    worse = sorted((change for change in all_changes if change.is_worse), key=lambda c: -c.factor / c.noise)
    found = [compare_sentences(n, old[n].get("conclusions", []), new[n]["conclusions"]) for n in common]
    return Comparison(
        studies=common,
        only_old=[name for name in old if name not in new],
        only_new=[name for name in new if name not in old],
        origins=_origins([old[name] for name in common], [new[name] for name in common]),
        factor=factor,
        times=times,
        native_factor=native_factor,
        native_times=native_times,
        slower=[change for change in worse if is_time(change)],
        less_accurate=[change for change in worse if not is_time(change)],
        better=sorted((change for change in all_changes if change.is_better), key=lambda c: c.factor),
        compared=len(all_changes),
        statuses=statuses(matched.rows),
        flipped=[pair for one in found for pair in one.flipped],
        undecided=[pair for one in found for pair in one.undecided],
        counts=_counts(found),
        rows=len(matched.rows),
        added=matched.added,
        vanished=matched.vanished,
    )


def _counts(found: Sequence[Sentences]) -> str:
    total = {
        key: sum(getattr(one, key) for one in found) for key in ("kept", "reworded", "added", "vanished")
    }
    return (
        f"{total['kept']} say the same but for their numbers, {total['reworded']} say it of another row, "
        f"{total['added']} are new, {total['vanished']} are gone"
    )


def _origins(old: Sequence[Document], new: Sequence[Document]) -> list[str]:
    """Commits, versions and machines, where they differ."""
    sentences = []
    commits = [_unique(commit_of(code_of(document)) for document in side) for side in (old, new)]
    sentences.append(
        f"Both of {commits[0]}." if commits[0] == commits[1] else f"Then {commits[0]}, now {commits[1]}."
    )
    other = _unique(
        differences(code_of(before), code_of(now)).removesuffix("sources").rstrip("; ")
        for before, now in zip(old, new, strict=True)
    )
    if other:
        sentences.append(f"Versions then and now: {other}.")
    if any(before["machine"] != now["machine"] for before, now in zip(old, new, strict=True)):
        machines = [_unique(_machine(document) for document in side) for side in (old, new)]
        sentences.append(f"Another MACHINE: then {machines[0]}, now {machines[1]}.")
    return sentences


def _machine(document: Document) -> str:
    return ", ".join(f"{key} {value}" for key, value in document["machine"].items())


def _unique(texts: Iterable[str]) -> str:
    return "; ".join(dict.fromkeys(text for text in texts if text))


def _figures(found: Comparison) -> list[str]:
    native = (
        f" ({found.native_factor:.2f} over {found.native_times} times of native cables, which run none of "
        "this project's code)"
        if found.native_times
        else ""
    )
    return [
        f"{found.rows} rows of {len(found.studies)} studies are in both, {found.added} are new, "
        f"{found.vanished} are gone; {found.compared} figures are compared.",
        f"Times are divided by the factor that all have in common: {found.factor:.2f}, the median over "
        f"{found.times} times{native}.",
        f"Beyond noise: {len(found.slower)} figures slower, {len(found.less_accurate)} less accurate or "
        f"limited more, {len(found.better)} better; {len(found.statuses)} rows with another status.",
    ]


def _conclusions(found: Comparison) -> str:
    return (
        f"Conclusions: {len(found.flipped)} FLIPPED, {len(found.undecided)} are undecided on one side; "
        f"{found.counts}."
    )
