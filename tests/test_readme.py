"""What the README prints runs as printed."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


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


def test_the_script_is_short():
    (script,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    lines = [line for line in script.splitlines() if line]
    assert len(lines) <= 15 and max(map(len, lines)) <= 110


def test_the_readme_is_short():
    assert len(README.read_bytes()) <= 6000
