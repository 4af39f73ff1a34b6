"""What a report says, as Markdown: parts under headings, pictures by their names."""

from collections.abc import Sequence
from pathlib import Path

from studies.harness import UNDECIDED, TextTable, column, groups, number
from studies.harness.provenance import commit_of
from studies.harness.study import Document, bullets, section

from .compare import ADVERSE, Change, Comparison
from .documents import Gathered

EQUAL_ACCURACY = "at equal accuracy, the closest: "
Blocks = list[str]


def as_markdown(gathered: Gathered, folder: Path, quick: bool, comparison: Comparison | None) -> str:
    """From documents, whatever their studies are.   folder: of the pictures."""
    documents = list(gathered.documents.values())
    parts: dict[str, Blocks] = {
        "Headline": _headline(documents),
        "Findings": _findings(documents, gathered.absent),
        "Compared with the earlier report": _changes(comparison) if comparison else [],
        **{document["study"]: section(document, folder) for document in documents},
        "Machine and versions": _origins(documents),
    }
    parts = {title: blocks for title, blocks in parts.items() if blocks}
    questions = {document["study"]: f": {document['question']}" for document in documents}
    contents = [f"{_link(title)}{questions.get(title, '')}" for title in parts]
    title = "# Quick report of all measurements" if quick else "# Report of all measurements"
    blocks = [title, _subtitle(documents, quick), "## Contents", bullets(contents)]
    for title, own in parts.items():
        blocks += [f"## {title}", *own]
    return "\n\n".join(blocks) + "\n"


def anchor(title: str) -> str:
    """Of a heading: "Machine and versions" -> "machine-and-versions"."""
    return title.lower().replace(" ", "-")


def _link(title: str) -> str:
    return f"[{title}](#{anchor(title)})"


def _subtitle(documents: Sequence[Document], quick: bool) -> str:
    dates = sorted(str(document["date"])[:10] for document in documents) or ["never"]
    measured = " to ".join(dict.fromkeys((dates[0], dates[-1])))
    commits = "; ".join(dict.fromkeys(commit_of(document) for document in documents))
    mode = (
        " Quick runs: short motions, few and short measurements. Verdicts on times are given only where "
        "these decide them."
    )
    return f"Measured: {measured}. {len(documents)} studies, {commits}.{mode if quick else ''}"


def _headline(documents: Sequence[Document]) -> Blocks:
    """Ratios beside the paper's; of those at equal accuracy, the closest of each study."""
    lines: list[tuple[str, ...]] = []
    for document in documents:
        study, ratios = document["study"], document["ratios"]
        paper = [ratio for ratio in ratios if ratio["paper"] is not None]
        lines += [(one["what"], number(one["paper"]), number(one["here"]), study) for one in paper]
        tuned = [one for one in ratios if one["paper"] is None and one["here"] is not None]
        if tuned and not document["quick"]:  # the few rows of quick runs are not the best of their kind
            closest = min(tuned, key=lambda ratio: ratio["here"])
            lines.append((EQUAL_ACCURACY + closest["what"], "", number(closest["here"]), study))
    header = ("native CPU time over that of the inextensible cable", "paper", "here", "study")
    return [TextTable("", header, lines).markdown] if lines else []


def _findings(documents: Sequence[Document], absent: dict[str, str]) -> Blocks:
    """The first conclusion of each study, all adverse ones, and what is missing."""
    said = [(d["study"], sentence) for d in documents for sentence in d["conclusions"]]
    first = [(d, d["conclusions"][0]) for d in documents if d["conclusions"]]
    adverse = [pair for pair in said if ADVERSE.search(pair[1])]
    undecided = sum(UNDECIDED in sentence for _, sentence in said)
    dates = {d["study"]: f" ({d['date'][:10]})" if d.get("note") else "" for d in documents}  # of older ones
    blocks = [bullets(f"{_link(d['study'])}{dates[d['study']]}: {sentence}" for d, sentence in first)]
    if adverse:
        blocks.append(f"Missed, limited or failed ({len(adverse)}):")
        blocks.append(bullets(f"{_link(study)}: {sentence}" for study, sentence in adverse))
    if undecided:
        blocks.append(f"Verdicts that are undecided within noise: {undecided}.")
    if absent:
        blocks += ["Left out:", bullets(f"{name}: {reason}." for name, reason in absent.items())]
    return blocks


def _origins(documents: Sequence[Document]) -> Blocks:
    """Machine, versions, dates: one table for each set of them."""
    blocks = []
    sets = groups(
        [one | {"set": repr([one[key] for key in ("machine", "versions", "sources")])} for one in documents],
        "set",
    )
    for own in sets.values():
        first, dates = own[0], sorted(column(own, "date"))
        lines = [("date", " to ".join(dict.fromkeys((dates[0], dates[-1]))))]
        lines += [(key, str(value)) for key, value in (first["machine"] | first["versions"]).items()]
        lines.append(("hash of the sources", first["sources"]))
        blocks.append(TextTable("", ("of " + ", ".join(column(own, "study")), ""), lines).markdown)
    return blocks


def _changes(found: Comparison) -> Blocks:
    """What is beyond noise."""
    tables = [
        TextTable("Conclusions that are adverse now:", ("study", "conclusion"), found.adverse),
        TextTable("Rows with another status:", ("row", "study", "then", "now"), found.statuses),
        _figures("Worse beyond noise:", found.worse),
        _figures("Better beyond noise:", found.better),
    ]
    return [bullets(found.summary), *(table.markdown for table in tables if table.lines)]


def _figures(title: str, changes: Sequence[Change]) -> TextTable:
    header = ("row", "study", "figure", "then", "now", "worse by a factor", "noise")
    lines = [
        (c.row, c.study, c.key, number(c.old), number(c.new), f"{c.factor:.3f}", f"{c.noise:.2f}")
        for c in changes
    ]
    return TextTable(title, header, lines)
