"""What the README prints runs as printed."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"

# What takes long to import, and only other scenes, or compiling, need.
NEEDLESS = ["scipy.sparse", "scipy.linalg", "scipy.optimize", "matplotlib"]
NEEDLESS += ["numba.np.arrayobj", "numba.typed.typedlist"]


def test_the_readme_script_runs_and_swings_the_tip_to_where_the_reference_has_it(
    tmp_path, monkeypatch, capsys
):
    (script,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    monkeypatch.chdir(tmp_path)  # Exudyn writes its solution file here
    variables = {}
    exec(script, variables)
    step, *tip = map(float, re.findall(r"[-+\d.e]+", capsys.readouterr().out))
    assert step == variables["report"]["stepSize"] and variables["report"]["decidedBy"] == "accuracy"
    assert tip == pytest.approx([1.7645, -0.1798, 0.0], abs=1e-3)  # MBDyn limit at 5 s


def test_where_kernels_are_in_the_cache_the_script_imports_nothing_needless(tmp_path, monkeypatch):
    (script,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    asked = f"{script}\nimport sys; print([name for name in {NEEDLESS} if name in sys.modules])"
    exec(script, {})  # compiles what is not in the cache
    run = subprocess.run([sys.executable, "-c", asked], cwd=tmp_path, capture_output=True, text=True)
    assert run.stdout.endswith("\n[]\n"), run.stdout + run.stderr


def test_the_script_is_short():
    (script,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    lines = [line for line in script.splitlines() if line]
    assert len(lines) <= 15 and max(map(len, lines)) <= 110


def test_the_readme_is_short():
    assert len(README.read_bytes()) <= 6000
