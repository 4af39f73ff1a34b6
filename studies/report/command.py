"""The command: gather, compare, write."""

import argparse
from importlib.util import find_spec
from pathlib import Path

from exudyn_inext import InputError
from studies.harness import Study
from studies.harness.store import write_text
from studies.registry import find_studies, find_study

from .compare import compare
from .documents import gather, read_earlier
from .text import as_markdown

NAME = "report"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Of the command `report`."""
    add = parser.add_argument
    add("--quick", action="store_true", help="run all studies in quick mode, into OUTPUT/quick; some minutes")
    add("--output", type=Path, default=Path("results"), help="default: results")
    add("--only", nargs="+", metavar="NAME", help="these studies, as shown by 'list'")
    add("--fresh", action="store_true", help="discard what is stored, and run all studies anew")
    add(
        "--compare", nargs="+", type=Path, metavar="OLD",
        help="folder, or NAME.json files, of an earlier report: what became worse beyond noise",
    )  # fmt: skip
    add("--strict", action="store_true", help="exit code 1 if anything became worse than in OLD")


def report(options: argparse.Namespace) -> int:
    """Write report.md and report.html; print where, and what was found.

    Returns:
        0; 1 if a study failed, or, with --strict, if anything is worse than in the earlier report.

    Raises:
        InputError: see `gather`, `read_earlier`; a missing library; --strict without --compare.
    """
    if find_spec("markdown_it") is None:
        raise InputError(
            "the report needs markdown_it, not installed here: pip install 'exudyn_inext[report]'."
        )
    from .page import as_html

    if options.strict and not options.compare:
        raise InputError("--strict judges a comparison: give --compare OLD, or leave it out.")
    studies, left_out = _studies(options)
    folder = options.output / "quick" if options.quick else options.output
    old = read_earlier(options.compare, options.quick) if options.compare else None
    gathered = gather(studies, folder, options.quick, options.fresh)
    gathered.absent |= left_out
    comparison = None if old is None else compare(old, gathered.documents)
    text = as_markdown(gathered, folder, options.quick, comparison)
    for form, written in (("md", text), ("html", as_html(text, folder))):
        write_text(folder / f"{NAME}.{form}", written)
        print(f"Written: {folder / NAME}.{form}")
    for sentence in comparison.summary if comparison else ():
        print(sentence)
    for name, reason in gathered.absent.items():
        print(f"Left out: {name}: {reason}")
    return int(gathered.has_failed or (options.strict and comparison is not None and comparison.is_worse))


def _studies(options: argparse.Namespace) -> tuple[dict[str, Study], dict[str, str]]:
    """Those that are asked for; and why others are not part of a quick report."""
    if options.only:
        return {name: find_study(name) for name in options.only}, {}
    found = find_studies()
    left_out = {name: found[name].not_in_quick_report for name in found if options.quick}
    left_out = {name: reason for name, reason in left_out.items() if reason}
    return {name: study for name, study in found.items() if name not in left_out}, left_out
