"""Which code a result belongs to: commit, sources, versions."""

import hashlib
import subprocess
from functools import lru_cache
from pathlib import Path
from typing import Any

from .machine import versions

_ROOT = Path(__file__).parents[2]
_PACKAGES = ("exudyn_inext", "reference_models", "studies")
_UNKNOWN = "unknown"


@lru_cache
def provenance() -> dict[str, Any]:
    """What this process runs, found once.

    Returns:
        "commit": its hash, "unknown" outside of a repository; "changed": whether sources differ from it;
        "sources": hash of all sources; "versions": of Python and packages.
    """
    commit = _commit()
    changed = commit != _UNKNOWN and bool(_git("status", "--porcelain", "--", *_PACKAGES))
    return {"commit": commit, "changed": changed, "sources": _source_hash(), "versions": versions()}


def code_name(found: dict[str, Any]) -> str:
    """A provenance in short: "commit 1a2b3c4d5e, with changes"."""
    return f"commit {str(found['commit'])[:10]}" + (", with changes" if found["changed"] else "")


def code_versions() -> dict[str, str]:
    """Versions of Python and packages, and the commit, for what is stored."""
    found = provenance()
    return {**found["versions"], "commit": found["commit"] + (" with changes" if found["changed"] else "")}


def _commit() -> str:
    is_own_repository = Path(_git("rev-parse", "--show-toplevel") or "/").resolve() == _ROOT.resolve()
    return (is_own_repository and _git("rev-parse", "HEAD")) or _UNKNOWN


def _git(*arguments: str) -> str:
    """What git prints; empty where it fails."""
    try:
        run = subprocess.run(["git", *arguments], cwd=_ROOT, capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return run.stdout.strip() if run.returncode == 0 else ""


def _source_hash() -> str:
    digest = hashlib.sha256()
    for package in _PACKAGES:
        for source in sorted((_ROOT / package).rglob("*.py")):
            digest.update(source.relative_to(_ROOT).as_posix().encode() + source.read_bytes())
    return digest.hexdigest()[:20]
