"""All studies: a module of this folder that defines STUDY, or STUDIES, is found by itself."""

import importlib
import pkgutil
from itertools import chain

from exudyn_inext import InputError

from .harness import Study

_PACKAGE = "studies"
_NO_STUDIES = {"__main__", "harness", "registry"}


def find_studies() -> dict[str, Study]:
    """Name -> study, in alphabetical order."""
    path = importlib.import_module(_PACKAGE).__path__
    names = sorted(info.name for info in pkgutil.iter_modules(path))
    modules = [importlib.import_module(f"{_PACKAGE}.{n}") for n in names if n not in _NO_STUDIES]
    own = [getattr(module, "STUDIES", None) or [getattr(module, "STUDY", None)] for module in modules]
    return {study.name: study for study in sorted(filter(None, chain(*own)), key=lambda study: study.name)}


def find_study(name: str) -> Study:
    """The study of that name."""
    studies = find_studies()
    if name not in studies:
        raise InputError(f"study '{name}' is unknown; there are: {', '.join(studies)}.")
    return studies[name]
