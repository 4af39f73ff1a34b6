"""python -m studies: list the studies, run one, report on all, write the tables of pages."""

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from exudyn_inext import InputError

from .harness.study import Study, run
from .harness.terminal import as_text, terminal_width, text_table
from .pages.command import add_commands, remake, write_pages
from .registry import find_studies, find_study
from .report.command import add_options, report
from .report.documents import read

MAIN_STUDY = "table1"


def _parser(program: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=program, description="Measured comparisons with native cables.")
    commands = parser.add_subparsers(dest="command")
    commands.add_parser("list", help="show all studies, their questions, and how long they take")
    one = commands.add_parser("run", help=f"run one study (without a command: {MAIN_STUDY})")
    one.add_argument("name", help="as shown by 'list'")
    one.add_argument("--quick", action="store_true", help="a short motion and few, cheap cases")
    one.add_argument("--output", type=Path, default=Path("results"), help="default: results")
    add_commands(commands)
    add_options(commands.add_parser("report", help="everything measured, as one Markdown and one HTML page"))
    return parser


def _listed(studies: Iterable[Study]) -> str:
    """Name, question and duration of each."""
    lines = [(study.name, study.question, _duration(study.minutes)) for study in studies]
    return text_table(("study", "question", "takes"), lines, terminal_width())


def _duration(minutes: float) -> str:
    return f"{minutes:g} min" if minutes >= 1 else f"{60 * minutes:g} s" if minutes else "-"


def main(arguments: Sequence[str] | None = None, program: str = "python -m studies") -> int:
    """Return the exit code: 0 done, 1 a report on something that failed or became worse, 2 wrong input."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = _parser(program).parse_args(given or ["run", MAIN_STUDY])
    try:
        if options.command == "list":
            print(_listed(find_studies().values()))
        elif options.command == "report":
            return report(options)
        elif options.command == "figures":
            write_pages()
        elif options.command == "remake":
            remake(options)
        else:
            study = find_study(options.name)
            run(study, options.output, options.quick)
            print(as_text(read(options.output / f"{study.name}.json"), terminal_width()))
            print(f"\nWritten to {options.output}")
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
