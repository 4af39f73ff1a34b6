"""What a report says, before it has a form."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from studies.harness.document import Document
from studies.harness.table import TextTable, number

from .compare.comparison import Comparison
from .compare.figures import Change
from .compare.sentences import UNDECIDED, Pair, is_adverse
from .gather import Gathered
from .stored import code_of, commit_of

LONG = 20
"""Lines from which a table is folded in, where the form can."""
EQUAL_ACCURACY = "at equal accuracy, the closest: "


@dataclass(frozen=True)
class Section:
    """A study.   pictures: file names; missing: those that are not there."""

    name: str
    document: Document
    pictures: list[str]
    missing: list[str]


@dataclass(frozen=True)
class Report:
    """All parts of a report, in its order; `headline` and `changes` are tables."""

    title: str
    subtitle: str
    headline: TextTable | None
    findings: list[tuple[str, str]]
    adverse: list[tuple[str, str]]
    undecided: int
    absent: Mapping[str, str]
    comparison: Comparison | None
    changes: list[TextTable]
    sections: list[Section]
    origins: list[TextTable]


def make_report(gathered: Gathered, folder: Path, quick: bool, comparison: Comparison | None) -> Report:
    """From documents, whatever their studies are.   folder: of the pictures."""
    documents = list(gathered.documents.values())
    sentences = [(d["study"], sentence) for d in documents for sentence in d["conclusions"]]
    return Report(
        title="Quick report of all measurements" if quick else "Report of all measurements",
        subtitle=_subtitle(documents, quick),
        headline=_headline(documents),
        findings=[(d["study"], d["conclusions"][0]) for d in documents if d["conclusions"]],
        adverse=[pair for pair in sentences if is_adverse(pair[1])],
        undecided=sum(bool(UNDECIDED.search(sentence)) for _, sentence in sentences),
        absent=gathered.absent,
        comparison=comparison,
        changes=_changes(comparison) if comparison else [],
        sections=[_section(document, folder) for document in documents],
        origins=_origins(documents),
    )


def _subtitle(documents: Sequence[Document], quick: bool) -> str:
    now = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    commits = "; ".join(dict.fromkeys(commit_of(code_of(document)) for document in documents))
    mode = (
        " Quick runs: short motions, few and short measurements. Verdicts on times are given only where "
        "these decide them."
        if quick
        else ""
    )
    return f"{now}. {len(documents)} studies{', ' + commits if commits else ''}.{mode}"


def _headline(documents: Sequence[Document]) -> TextTable | None:
    """Ratios beside the paper's; of those at equal accuracy, the closest of each study."""
    lines = [line for document in documents for line in _ratio_lines(document)]
    header = ("native CPU time over that of the inextensible cable", "paper", "here", "study")
    return TextTable("", header, lines) if lines else None


def _ratio_lines(document: Document) -> list[tuple[str, ...]]:
    study = document["study"]
    paper = [ratio for ratio in document["ratios"] if ratio["paper"] is not None]
    tuned = [r for r in document["ratios"] if r["paper"] is None and r["here"] is not None]
    lines: list[tuple[str, ...]] = [(r["what"], number(r["paper"]), number(r["here"]), study) for r in paper]
    if tuned and not document["quick"]:  # the few rows of quick runs are not the best of their kind
        closest = min(tuned, key=lambda ratio: ratio["here"])
        lines.append((EQUAL_ACCURACY + closest["what"], "", number(closest["here"]), study))
    return lines


def _section(document: Document, folder: Path) -> Section:
    names = document["pictures"]
    there = [name for name in names if (folder / name).is_file()]
    return Section(document["study"], document, there, [name for name in names if name not in there])


def _origins(documents: Sequence[Document]) -> list[TextTable]:
    """Machine, versions, dates: one table for each set of them."""
    groups: dict[str, list[Document]] = {}
    for document in documents:
        groups.setdefault(repr((document["machine"], code_of(document))), []).append(document)
    return [_origin(group) for group in groups.values()]


def _origin(documents: Sequence[Document]) -> TextTable:
    first = documents[0]
    dates = sorted(document["date"] for document in documents)
    lines = [("date", " to ".join(dict.fromkeys((dates[0], dates[-1]))))]
    lines += [(key, str(value)) for key, value in (first["machine"] | first["versions"]).items()]
    lines.append(("hash of the sources", first["sources"]))
    return TextTable("", ("of " + ", ".join(d["study"] for d in documents), ""), lines)


def _changes(found: Comparison) -> list[TextTable]:
    """Those that are beyond noise, flipped conclusions first."""
    tables = [
        _pairs("Conclusions that flipped:", found.flipped),
        _pairs("Conclusions that are undecided on one side:", found.undecided),
        TextTable(
            "Rows with another status:",
            ("row", "study", "then", "now"),
            [(row.label, row.study, old, new) for row, old, new in found.statuses],
        ),
        _figures("Slower beyond noise:", found.slower),
        _figures("Less accurate, or limited more:", found.less_accurate),
        _figures("Better beyond noise:", found.better),
    ]
    return [table for table in tables if table.lines]


def _pairs(title: str, pairs: Sequence[Pair]) -> TextTable:
    return TextTable(title, ("then", "now", "study"), [(pair.old, pair.new, pair.study) for pair in pairs])


def _figures(title: str, changes: Sequence[Change]) -> TextTable:
    header = ("row", "study", "figure", "then", "now", "worse by a factor", "noise")
    lines = [
        (c.row, c.study, c.key, number(c.old), number(c.new), f"{c.factor:.3f}", f"{c.noise:.2f}")
        for c in changes
    ]
    return TextTable(title, header, lines)
