"""Run a script as if further modules lay in the repository's folders; those stay as they are.

python extended_packages.py FOLDER SCRIPT: folders below FOLDER join the packages of the same name.
"""

import importlib.machinery
import runpy
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


class ExtendedPackages:
    """Finder of packages whose folders have a counterpart below `folder`."""

    def __init__(self, folder):
        self._folder = folder

    def find_spec(self, name, path=None, target=None):
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        added = self._folder.joinpath(*name.split("."))
        if spec is not None and spec.submodule_search_locations is not None and added.is_dir():
            spec.submodule_search_locations = [*spec.submodule_search_locations, str(added)]
        return spec


def extend(folder):
    """From now on, modules below `folder` are part of the packages."""
    sys.path.insert(0, str(ROOT))
    sys.meta_path.insert(0, ExtendedPackages(Path(folder)))


if __name__ == "__main__":
    extend(sys.argv[1])
    runpy.run_path(sys.argv[2], run_name="__main__")
