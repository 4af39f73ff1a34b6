"""The folder of compiled kernels: which one an installation uses, and which old ones it removes.

Numba invalidates a cached function when *its own* file changes, not when a function that it inlines
does. The name of the folder therefore carries a hash of all sources that hold kernels, and one of the
installation (its path and the versions of Python, Numba and NumPy): installations that share a root leave
each other's folders alone.
"""

import hashlib
import os
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numba
import numpy as np

PACKAGE = Path(__file__).parent
DAYS_KEPT = 60  # unused folders of whatever installation are removed after that

_PREFIX = "exudyn_inext_kernels_"
_DAY = 24 * 3600.0  # [s]

# What a source imports, or is, that defines kernels.
_MARKS_OF_KERNELS = (b"compiled import", b"implements", b"numba.njit", b"numba.extending")


def cache_folder() -> Path | None:
    """Of this installation: in NUMBA_CACHE_DIR, beside the sources, or among the user's caches.

    The first of them that can be written to is taken. If there is none, a warning says so, and every process
    compiles for itself (None).
    """
    roots, name = cache_roots(), name_of_folder(PACKAGE, source_hash(PACKAGE))
    folder = next(filter(_is_writable, (root / name for root in roots)), None)
    if folder is None:
        warnings.warn(
            f"compiled kernels cannot be kept, none of {', '.join(map(str, roots))} can be written to: each "
            "process compiles them anew, which takes a minute or so. Set NUMBA_CACHE_DIR to a folder that "
            "can be written to.",
            RuntimeWarning,
            stacklevel=2,
        )
        return None
    remove_stale(folder)
    return folder


def cache_roots() -> list[Path]:
    """Where kernels may be kept, the preferred place first."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    return [*([Path(given)] if given else []), PACKAGE / "__pycache__", *_user_caches()]


def _user_caches() -> Iterator[Path]:
    """Where the platform wants caches of this user; nothing if the user has no home."""
    variable = {"win32": "LOCALAPPDATA", "darwin": ""}.get(sys.platform, "XDG_CACHE_HOME")
    place = {"win32": "AppData/Local", "darwin": "Library/Caches"}.get(sys.platform, ".cache")
    with suppress(RuntimeError):
        yield Path(os.environ.get(variable) or Path.home() / place) / "exudyn_inext"


def source_hash(package: Path) -> str:
    """Of all sources of the package that hold kernels."""
    digest = hashlib.sha256(_versions().encode())
    for source in sorted(package.rglob("*.py")):
        text = source.read_bytes()
        if any(mark in text for mark in _MARKS_OF_KERNELS):
            digest.update(source.relative_to(package).as_posix().encode() + text)
    return digest.hexdigest()[:16]


def name_of_folder(package: Path, sources: str) -> str:
    """Which installation of the package it belongs to, and the hash of its sources."""
    installation = f"{package.resolve()} {_versions()}"
    return f"{_PREFIX}{hashlib.sha256(installation.encode()).hexdigest()[:8]}_{sources}"


def _versions() -> str:
    return f"python {sys.version_info[:2]} numba {numba.__version__} numpy {np.__version__}"


def _is_writable(folder: Path) -> bool:
    """Whether it is there, or can be made, and takes files; marked as used now."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            os.utime(folder)
        return True
    except OSError:
        return False


def remove_stale(folder: Path) -> None:
    """Remove what older sources of the same installation left beside the folder, and what nobody uses.

    Folders of other installations stay, unless they have not been used for `DAYS_KEPT` days.
    """
    mine = folder.name.rpartition("_")[0]
    for other in folder.parent.glob(f"{_PREFIX}*"):
        is_mine = other.name.rpartition("_")[0] == mine
        if other.name != folder.name and (is_mine or _days_unused(other) > DAYS_KEPT):
            shutil.rmtree(other, ignore_errors=True)


def _days_unused(folder: Path) -> float:
    try:
        return (time.time() - folder.stat().st_mtime) / _DAY
    except OSError:  # another process has removed it
        return 0.0
