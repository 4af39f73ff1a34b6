"""Which code and which machine a result belongs to: commit, sources, versions; no names of hosts or paths."""

import hashlib
import os
import platform
import subprocess
from collections.abc import Mapping
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import exudyn

import exudyn_inext

ROOT = Path(__file__).parents[2]
_OWN = ("exudyn_inext", "reference_models", "examples", "studies")
_PACKAGES = ("exudyn", "exudyn_inext", "numpy", "scipy", "numba", "mujoco")
_UNKNOWN = "unknown"


@lru_cache
def present_code() -> dict[str, Any]:
    """What decides whether results belong together, of what this process runs; found once.

    Returns:
        "versions": of Python and packages, and "commit": its hash, "unknown" outside of a repository, and
        whether sources differ from it; "sources": hash of all sources.
    """
    is_own_repository = Path(_git("rev-parse", "--show-toplevel") or "/").resolve() == ROOT.resolve()
    commit = (is_own_repository and _git("rev-parse", "HEAD")) or _UNKNOWN
    if commit != _UNKNOWN and _git("status", "--porcelain", "--", *_OWN, ":(exclude)*.md"):
        commit += " with changes"
    digest = hashlib.sha256()
    for package in (Path(exudyn_inext.__file__).parent, *(ROOT / name for name in _OWN[1:])):
        for source in sorted(package.rglob("*.py")):
            digest.update(source.relative_to(package.parent).as_posix().encode() + source.read_bytes())
    return {"versions": {**versions(), "commit": commit}, "sources": digest.hexdigest()[:20]}


def commit_of(document: Mapping[str, Any]) -> str:
    """Of a study's document, in short: "commit 1a2b3c4d5e with changes"."""
    commit, _, changes = str(document["versions"].get("commit", _UNKNOWN)).partition(" ")
    return " ".join(filter(None, ("commit", commit[:10], changes)))


def machine() -> dict[str, str | int | None]:
    """Processor model, number of cores, operating system."""
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "architecture": platform.machine(),
    }


def versions() -> dict[str, str]:
    """Versions of Python and of all packages that take part.

    exudynRangeChecks: whether Exudyn's default module or its fast one (EXUDYN_MODULE=fast) ran.
    """
    found = {"python": platform.python_version()}
    found |= {package: _version(package) for package in _PACKAGES}
    fast = "fast" in getattr(exudyn, "_compiledModuleName", "")
    return found | {"exudynRangeChecks": "off" if fast else "on"}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _cpu_model() -> str:
    """The name of the processor as the system states it; platform's guess elsewhere."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or _UNKNOWN
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or _UNKNOWN)


def _git(*arguments: str) -> str:
    """What git prints; empty where it fails."""
    try:
        run = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return run.stdout.strip() if run.returncode == 0 else ""
