"""The commands: write pages from committed results; run studies, and commit what they give."""

import argparse
import re
import shutil
from pathlib import Path

from exudyn_inext import InputError
from studies.harness.provenance import ROOT
from studies.harness.store import write_text
from studies.harness.study import announce, run
from studies.registry import find_study
from studies.report.documents import Gathered, read
from studies.report.text import as_markdown

from .results import COMPARISONS, FOLDER, Figures, reduced, store
from .tables import BLOCKS

NEEDED = (*COMPARISONS, "scene_cost", "coupled")
PAGES = ("README.md", "docs/results.md", "docs/scenes.md", "examples/README.md")
REPORT = Path("docs/report/report.md")
_BLOCK = re.compile(r"(<!-- figures: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def add_commands(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """`figures` and `remake`."""
    pages = f"{', '.join(PAGES)} and {REPORT}"
    commands.add_parser("figures", help=f"write all tables of {pages} from docs/figures")
    remake = commands.add_parser(
        "remake", help="run studies, store what they give in docs/figures, write the pages"
    )
    add = remake.add_argument
    add("names", nargs="*", metavar="NAME", default=NEEDED, help=f"default: {' '.join(NEEDED)}")
    add("--times", type=int, default=1, help="run each study so often, and store how far its times differ")
    add("--output", type=Path, default=Path("results"), help="default: results")
    add("--stored", action="store_true", help="take what OUTPUT holds; run nothing")
    add("--provisional", default="", metavar="WHY", help="a note that all tables print")


def remake(options: argparse.Namespace, root: Path = ROOT, folder: Path = FOLDER) -> None:
    """Run one study after another; pages are written when each one ends.   root: of the pages."""
    studies = [find_study(name) for name in options.names]
    if options.times < 1:
        raise InputError(f"--times {options.times}: a study runs at least once.")
    for study in studies:
        documents = []
        for time in range(options.times):
            announce(study.name, f"run {time + 1} of {options.times}")
            if not options.stored:
                run(study, options.output)
            documents.append(read(options.output / f"{study.name}.json"))
        for picture in documents[-1]["pictures"]:
            shutil.copy(options.output / picture, root / REPORT.parent / picture)
        print(f"Stored: {store(reduced(documents, options.provisional), folder)}")
        write_pages(root, folder)


def write_pages(root: Path = ROOT, folder: Path = FOLDER) -> None:
    """Write all pages that differ from what the results say, and print which."""
    for path, text in remade(root, Figures(folder)).items():
        if text != path.read_text(encoding="utf-8"):
            write_text(path, text)
            print(f"Written: {path}")


def remade(root: Path, figures: Figures) -> dict[Path, str]:
    """Page -> its text, as the results have it.

    Raises:
        InputError: a page asks for a table that does not exist; see also `Figures`.
    """
    pages = {root / name: filled((root / name).read_text(encoding="utf-8"), figures) for name in PAGES}
    folder = root / REPORT.parent
    documents = {name: document | {"note": figures.note(name)} for name, document in figures.all.items()}
    return pages | {root / REPORT: as_markdown(Gathered(documents), folder, False, None)}


def filled(text: str, figures: Figures) -> str:
    """A page with its tables."""

    def block(found: "re.Match[str]") -> str:
        start, name, end = found.groups()
        if name not in BLOCKS:
            raise InputError(f"a page asks for the figures '{name}'; there are: {', '.join(BLOCKS)}.")
        return f"{start}\n{BLOCKS[name](figures)}\n\n{end}"

    return _BLOCK.sub(block, text)
