"""The folder of compiled kernels: installations that share one, and folders that cannot be written to."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from exudyn_inext import kernel_cache

CHOOSE = """
import sys, warnings
for name in ("exudyn_inext", "numba"):  # nothing else of them is imported
    sys.modules[name] = type(sys)(name)
sys.modules["numba"].__version__ = "0"
sys.modules["exudyn_inext"].__path__ = [{package!r}]
from pathlib import Path
from exudyn_inext import kernel_cache
kernel_cache.PACKAGE = Path({installed!r})
with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    print(kernel_cache.cache_folder())
print(*[warning.message for warning in warned])
"""


@pytest.fixture
def install(tmp_path):
    """(name, kernel) -> folder of an installation of a package with that kernel."""

    def installed(name, kernel="return x"):
        package = tmp_path / name / "exudyn_inext"
        package.mkdir(parents=True, exist_ok=True)
        text = f"from .compiled import kernel\n\ndef f(x):\n    {kernel}\n"
        (package / "forces.py").write_text(text)
        return package

    return installed


@pytest.fixture
def use(tmp_path):
    """(installation, environment) -> folder that its process chooses, what it warns of."""

    def chosen(installed, **environment):
        package = str(Path(kernel_cache.__file__).parent)
        script = CHOOSE.format(package=package, installed=str(installed))
        home = {"HOME": str(tmp_path / "home"), "XDG_CACHE_HOME": "", "LOCALAPPDATA": ""}
        result = subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            timeout=120,
            env={**os.environ, "NUMBA_CACHE_DIR": "", **home, **environment},
        )
        assert result.returncode == 0, result.stderr
        folder, warned = (result.stdout + "\n").splitlines()[:2]
        return folder, warned

    return chosen


def test_environments_that_share_a_folder_keep_each_others_kernels(install, use, tmp_path):
    shared = {"NUMBA_CACHE_DIR": str(tmp_path / "shared")}
    one, other = install("one"), install("other", "return 2 * x")
    (first, _), (second, _) = use(one, **shared), use(other, **shared)
    (Path(first) / "kernel.nbi").touch()
    assert first != second and Path(first).parent == Path(second).parent == tmp_path / "shared"
    assert use(one, **shared) == (first, "")
    assert (Path(first) / "kernel.nbi").exists() and Path(second).exists()


def test_the_same_sources_in_the_same_place_are_compiled_once(install, use):
    installed = install("one")
    assert use(installed) == use(installed)


def test_an_edit_starts_a_new_folder_and_removes_the_old_one(install, use):
    old, _ = use(install("one"))
    new, _ = use(install("one", "return 2 * x"))
    assert Path(new).exists() and not Path(old).exists()
    assert Path(new).parent == install("one") / "__pycache__"


def test_folders_that_nobody_has_used_for_months_are_removed(install, use, tmp_path):
    shared = {"NUMBA_CACHE_DIR": str(tmp_path / "shared")}
    installed, other = install("one"), install("other")
    forgotten, recent = (tmp_path / "shared" / f"exudyn_inext_kernels_{name}" for name in ("x", "0_y"))
    for folder, days in ((forgotten, kernel_cache.DAYS_KEPT + 1), (recent, kernel_cache.DAYS_KEPT - 1)):
        folder.mkdir(parents=True)
        os.utime(folder, (time.time() - days * 86400,) * 2)
    used, _ = use(other, **shared)
    os.utime(used, (time.time() - 1000 * 86400,) * 2)
    assert use(other, **shared) == (used, "")  # it is in use again
    use(installed, **shared)
    assert not forgotten.exists() and recent.exists() and Path(used).exists()


def blocked(path):
    """A folder that nobody can make: a file is in its way."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("")
    return path


def test_without_a_writable_package_the_users_cache_is_taken(install, use, tmp_path):
    installed = install("one")
    blocked(installed / "__pycache__")
    given = str(blocked(tmp_path / "given"))
    folder, warned = use(installed, NUMBA_CACHE_DIR=given, XDG_CACHE_HOME=str(tmp_path / "mine"))
    assert Path(folder).parent == tmp_path / "mine" / "exudyn_inext" and not warned
    folder, warned = use(installed)
    if sys.platform.startswith("linux"):
        assert Path(folder).parent == tmp_path / "home" / ".cache" / "exudyn_inext" and not warned


def test_where_nothing_can_be_written_a_warning_says_so(install, use, tmp_path):
    installed = install("one")
    blocked(installed / "__pycache__")
    mine = str(blocked(tmp_path / "mine"))
    folder, warned = use(installed, XDG_CACHE_HOME=mine, LOCALAPPDATA=mine, HOME=mine)
    assert folder == "None"
    assert "each process compiles them anew" in warned and "Set NUMBA_CACHE_DIR" in warned


RUN = """
import exudyn
from exudyn_inext import *
mbs = exudyn.SystemContainer().AddSystem()
section = InextensibleCable(massPerLength=0.03, bendingStiffness=0.08)
CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, gravity=[0, -9.81, 0])
mbs.Assemble()
settings = exudyn.SimulationSettings()
settings.timeIntegration.endTime = 0.01
settings.solution.file.write = False
print(SolveExplicit(mbs, settings, ExplicitSettings(integrator={name!r}))["success"])
"""


@pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is kept")
def test_kernels_that_take_text_run_from_the_cache():
    """As those of RK4, whose scheme has a name: the second process only loads what this one has compiled."""
    script = RUN.format(name="RK4")
    exec(script, {})
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0 and "True" in result.stdout, result.stderr
