"""What the how-to pages show is put in place and run, each page by a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.documents import DOCS, ROOT, python_blocks, require_printed

RUNNER = ROOT / "tests" / "extended_packages.py"
PAGES = sorted(page for page in (DOCS / "howto").glob("*.md") if page.stem != "index")
SHORT_KERNELS = {"integrator", "constraint", "load"}  # quicker than to compile them


def run(folder, script, page):
    """What a script prints with the modules below `folder` in place."""
    path = folder / "script.py"
    path.write_text(script)
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1" if page.stem in SHORT_KERNELS else "0"}
    done = subprocess.run(
        [sys.executable, "-W", "error", RUNNER, folder / "added", path],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def put_in_place(folder, page):
    """Write the modules of a page below folder/added."""
    for block in python_blocks(page):
        if block.path:
            module = folder / "added" / block.path
            assert not (ROOT / block.path).exists()
            assert (ROOT / block.path).parent.is_dir()
            module.parent.mkdir(parents=True, exist_ok=True)
            module.write_text(block.code)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_part_that_a_page_adds_works_as_printed(page, tmp_path):
    put_in_place(tmp_path, page)
    scripts = [block for block in python_blocks(page) if not block.path]
    assert len(scripts) == 1 and scripts[0].printed
    contracts = CONTRACTS if page.stem == "integrator" else ""
    printed = run(tmp_path, scripts[0].code + contracts, page)
    printed, *swept = printed.partition(SWEPT)
    require_printed(printed, scripts[0].printed)
    assert ("3 passed" in "".join(swept)) == bool(contracts)


def test_without_its_module_a_page_does_not_work(tmp_path):
    page = DOCS / "howto" / "constraint.md"
    (script,) = [block for block in python_blocks(page) if not block.path]
    with pytest.raises(AssertionError, match=r"No module named 'exudyn_inext\.constraints\.rail'"):
        run(tmp_path, script.code, page)


SWEPT = "contract tests of the added integrator:"
CONTRACTS = f"""
import pytest, sys
print({SWEPT!r})
sys.exit(pytest.main([
    "-q", "-p", "no:xdist", "-p", "no:cacheprovider", "-o", "addopts=", "--import-mode=importlib",
    "-k", "RK3 and (order_on_a_forced or limits_are_positive or find_their)",
    "--rootdir={ROOT}", "{ROOT}/tests/contracts/test_every_integrator.py",
]))
"""


def test_pages_are_all_there():
    assert [Path(page).stem for page in PAGES] == ["constraint", "integrator", "load", "scene", "study"]
