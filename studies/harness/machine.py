"""What the measurements were made on: processor and versions, no names of hosts or paths."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import exudyn

PACKAGES = ("exudyn", "exudyn_inext", "numpy", "scipy", "numba", "mujoco")


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
    found |= {package: _version(package) for package in PACKAGES}
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
        return platform.processor() or "unknown"
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or "unknown")
