"""Bad input is refused with value, limit or culprit, and remedy; the mbs stays as it was, and still works."""

from collections import Counter
from typing import Any

import exudyn
import pytest

import exudyn_inext
from exudyn_inext import ExplicitTrapWarning, InextensibleError
from reference_models.model import silence
from studies.__main__ import main

from .rows import Row
from .tables import advice, attached, cables, runs, stepping
from .values import with_scene

ROWS: list[Row] = [*cables.ROWS, *runs.ROWS, *attached.ROWS, *advice.ROWS, *stepping.ROWS]
A_FILE = __file__
COMMANDS = [
    (["run", "no_such"], r"error: study 'no_such' is unknown; there are: .*table1"),
    (["run", ""], r"error: study '' is unknown; there are: .*table1"),
    (["run", "table1", "--quick", "--output", A_FILE], r"cannot be written .*another one with --output"),
    (
        ["run", "kernel", "--quick", "--output", f"{A_FILE}/a"],
        r"cannot be written .*another one with --output",
    ),
    (
        ["run", "ring", "--quick", "--output", "/proc/results"],
        r"cannot be written .*another one with --output",
    ),
    (["run"], r"the following arguments are required: name"),
    (["walk"], r"invalid choice: 'walk'"),
    (["run", "table1", "--output"], r"argument --output: expected one argument"),
]


def settings_in(arguments: dict[str, Any]) -> list[str]:
    return [
        repr(value.GetDictionary())
        for value in arguments.values()
        if isinstance(value, exudyn.SimulationSettings)
    ]


@pytest.mark.parametrize("row", ROWS, ids=str)
def test_bad_input_is_refused_and_nothing_changes(row):
    scene = row.scene()
    arguments = with_scene(row.arguments, scene)
    before, settings = row.kept(scene.mbs), settings_in(arguments)
    with silence(), pytest.raises(row.error, match=f"(?s){row.message}"):
        row.call(**arguments)
    assert row.kept(scene.mbs) == before
    assert settings_in(arguments) == settings
    row.good(scene)


@pytest.mark.parametrize(("arguments", "message"), COMMANDS, ids=lambda value: " ".join(value)[:60])
def test_a_bad_command_ends_with_code_2_and_leaves_nothing(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(arguments)
    except SystemExit as exit_of_parser:
        code = exit_of_parser.code
    assert code == 2
    assert capsys.readouterr().err and not list(tmp_path.iterdir())


def callables() -> dict[str, Any]:
    return {name: getattr(exudyn_inext, name) for name in exudyn_inext.__all__}


def test_every_public_name_has_rows():
    tried = Counter(row.who for row in ROWS)
    expected = {row.error for row in ROWS}
    for name, what in callables().items():
        if not isinstance(what, type) or not issubclass(what, InextensibleError | Warning):
            assert tried[name] >= 3, (
                f"{name} has {tried[name]} rows: add at least 3 to tests/bad_input/tables"
            )
        elif what not in (InextensibleError, ExplicitTrapWarning, exudyn_inext.EnforcementError):
            assert what in expected, f"no row expects {name}: add one to tests/bad_input/tables"


def test_the_table_is_large():
    assert len(ROWS) + len(COMMANDS) >= 400
