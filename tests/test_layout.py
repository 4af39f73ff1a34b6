"""The folders of the package: no one of them may become the place for everything."""

from pathlib import Path

import exudyn_inext

LARGEST_SHARE = 0.25


def lines_in(folder):
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in folder.rglob("*.py"))


def test_no_folder_holds_more_than_a_quarter_of_the_package():
    package = Path(exudyn_inext.__file__).parent
    shares = {
        folder.name: lines_in(folder) / lines_in(package) for folder in package.iterdir() if folder.is_dir()
    }
    assert max(shares.values()) <= LARGEST_SHARE, shares
