"""What is installed: the studies' command, libraries that may be missing, versions that are admitted."""

import os
import re
import subprocess
import sys

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

import exudyn_inext
from tests.documents import ROOT

WITHOUT = """
import runpy, sys
for library in {missing}:
    sys.modules[library] = None  # as if it were not installed
sys.argv[1:] = ["list"]
runpy.run_module({module!r}, run_name="__main__", alter_sys=True)
"""


def run(*command, cwd):
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return subprocess.run(
        [sys.executable, *command],
        cwd=cwd,
        env=environment | {"PYTHONPATH": str(ROOT), "COLUMNS": "80"},
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_the_command_runs_its_own_studies_wherever_it_is_called_without_modules_of_unix(tmp_path):
    """As on Windows."""
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "__init__.py").write_text("raise RuntimeError('these are of somebody else')\n")
    unix = ["resource", "fcntl", "pwd", "grp", "termios"]
    result = run("-c", WITHOUT.format(missing=unix, module="exudyn_inext.studies"), cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert re.search("^table1 ", result.stdout, re.MULTILINE)


def test_without_libraries_of_the_studies_the_message_names_the_extra(tmp_path):
    script = WITHOUT.format(missing=["matplotlib", "tqdm"], module="exudyn_inext.studies")
    result = run("-c", script, cwd=tmp_path)
    assert (result.returncode, result.stdout) == (2, "")
    assert "need matplotlib and tqdm" in result.stderr and "exudyn_inext[studies]" in result.stderr


def test_the_lowest_versions_that_are_admitted_are_those_that_are_tried():
    """On the oldest Python: newer ones need newer versions than some of these."""
    tomllib = pytest.importorskip("tomllib", reason="part of Python from 3.11 on")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / ".ci" / "lowest.txt").read_text()
    tried = [Requirement(line) for line in text.splitlines() if not line.startswith("#")]
    oldest = {"python_version": project["requires-python"].removeprefix(">=")}
    tried = {
        one.name: str(one.specifier) for one in tried if one.marker is None or one.marker.evaluate(oldest)
    }
    admitted = map(Requirement, [*project["dependencies"], *project["optional-dependencies"]["studies"]])
    for one in admitted:
        (least,) = (bound.version for bound in one.specifier if bound.operator == ">=")
        lowest = Version(tried.pop(one.name).removeprefix("=="))
        assert lowest.release[:2] == Version(least).release[:2] and lowest >= Version(least), one.name
    assert tried == {}


def test_the_version_to_cite_is_that_of_the_package():
    cited = (ROOT / "CITATION.cff").read_text()
    assert re.findall(r"^version: (.+)$", cited, re.MULTILINE) == [exudyn_inext.__version__]
