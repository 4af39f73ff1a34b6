"""Writes docs/verification_results.md: known answers, faults and bad inputs, as the tests find them.

    python -m tests.verification

The tests record them as properties, see tests/conftest.py; here they are run, and what they record is sorted.
"""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from datetime import date
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]
TESTED = [
    *("known_answers", "statics", "cable", "integrators", "exudyn_binding", "native", "reference_models"),
    *("bad_input", "properties"),
]
TITLE = """# Verification: what the tests found

Written by `python -m tests.verification` on {date} (Python {python}, Exudyn {exudyn}, numba {numba}).
Each line comes from a test that passed, and is written anew by each run.
"""


def run_tests(report: Path) -> int:
    """Run all tests that record something; returns pytest's exit code."""
    folders = [str(ROOT / "tests" / name) for name in TESTED]
    command = [sys.executable, "-m", "pytest", "-q", f"--junitxml={report}", *folders]
    return subprocess.run(command, cwd=ROOT, check=False).returncode


def passed_tests(report: Path) -> Iterator[tuple[str, str, list[tuple[str, str]]]]:
    """(file below tests/, name, properties) of each test that passed."""
    for case in ElementTree.parse(report).iter("testcase"):
        if any(case.find(kind) is not None for kind in ("failure", "error", "skipped")):
            continue
        properties = [(p.get("name", ""), p.get("value", "")) for p in case.iter("property")]
        file = case.get("classname", "").removeprefix("tests.").replace(".", "/") + ".py"
        yield file, case.get("name", ""), properties


def table(columns: list[str], rows: list[list[str]]) -> str:
    """Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def recorded(report: Path, kind: str) -> list[list[str]]:
    """Parts of each property of that kind, and the file of its test, sorted by file."""
    rows = [
        [*value.split("|"), f"`{file}`"]
        for file, _, properties in passed_tests(report)
        for name, value in properties
        if name == kind
    ]
    return sorted(rows, key=lambda row: (row[-1], row[0]))


def summary(report: Path) -> str:
    """The document."""
    tests = list(passed_tests(report))
    bad = sum(file.startswith("bad_input/test_bad_input") for file, _, _ in tests)
    fuzzed = sum(file.startswith("bad_input/test_fuzz") for file, _, _ in tests)
    properties = sum(file.startswith("properties/") for file, _, _ in tests)
    answers, faults = recorded(report, "known answer"), recorded(report, "fault")
    versions = {"exudyn": version("exudyn"), "numba": version("numba")}
    python = ".".join(map(str, sys.version_info[:3]))
    head = TITLE.format(date=date.today().isoformat(), python=python, **versions)
    counts = [
        ["known answers found", str(len(answers)), "below"],
        ["faults tried and survived", str(len(faults)), "below"],
        ["bad inputs refused, nothing changed", str(bad), "`bad_input/test_bad_input.py`"],
        ["public functions and settings fuzzed", str(fuzzed), "`bad_input/test_fuzz.py`"],
        ["properties of the motion (hypothesis)", str(properties), "`properties/`"],
    ]
    parts = [
        head,
        table(["what", "number", "where"], counts),
        "## Known answers\n",
        table(["answer", "relative error", "observed order", "test"], answers),
        "## Faults\n",
        table(["fault", "what came of it", "test"], faults),
    ]
    return "\n".join(parts)


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        failed = run_tests(report)
        (ROOT / "docs" / "verification_results.md").write_text(summary(report), encoding="utf-8")
    return failed


if __name__ == "__main__":
    sys.exit(main())
