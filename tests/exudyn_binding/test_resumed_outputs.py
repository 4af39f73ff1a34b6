"""Files of a run that was killed and continued: those of the whole run, bit for bit."""

import multiprocessing
import os
import shutil
import signal
from pathlib import Path

import numpy as np
import pytest

from exudyn_inext import InputError
from exudyn_inext.run.output_files import cut_rows_after
from tests.exudyn_binding.written_run import FILES, run

SWAPPED = {"sensors.writePeriod": 0.02, "file.writePeriod": 0.005}  # the files have each other's period


def rows_of(folder):
    return {name: np.loadtxt(Path(folder) / name, delimiter=",", ndmin=2) for name in FILES}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """(kind, changes) -> rows of all files of an uninterrupted run."""
    results = {}

    def of(kind, **changes):
        key = (kind, *changes)
        if key not in results:
            folder = tmp_path_factory.mktemp("whole")
            run(folder, kind, **changes)
            results[key] = rows_of(folder)
        return results[key]

    return of


def require_same(folder, expected):
    for name, rows in rows_of(folder).items():
        assert (np.diff(rows[:, 0]) > 0.0).all(), name
        np.testing.assert_array_equal(rows, expected[name], err_msg=name)


@pytest.fixture(scope="module")
def killed_early(tmp_path_factory):
    """(folder, kind, changes): a folder with what a run has left that was killed at 0.178 s."""
    folders = {}

    def copy_to(folder, kind, **changes):
        key = (kind, *changes)
        if key not in folders:
            folders[key] = tmp_path_factory.mktemp("killed")
            killed(folders[key], kind, 0.178, **changes)
        shutil.copytree(folders[key], folder, dirs_exist_ok=True)

    return copy_to


def killed(folder, kind, time, **changes):
    """Run until `time` [s] in a process that is killed there; one that has imported all is its parent."""
    processes = multiprocessing.get_context("forkserver")
    processes.set_forkserver_preload([run.__module__])
    process = processes.Process(target=run, args=(folder, kind), kwargs={"die_at": time, **changes})
    process.start()
    process.join(300)
    assert process.exitcode == -signal.SIGKILL


@pytest.mark.parametrize(
    ("kind", "changes"), [("cable", {}), ("cable", SWAPPED), ("user", {}), ("coupled", {})]
)
def test_a_killed_run_leaves_the_files_of_the_whole_run(tmp_path, whole, killed_early, kind, changes, fault):
    """Killed while it writes, one twice; restart files lie between the rows of the longer period."""
    killed_early(tmp_path, kind, **changes)
    headers = {name: header_of(tmp_path / name) for name in FILES}
    if kind == "coupled":
        killed(tmp_path, kind, 0.271, **changes)
    report = run(tmp_path, kind, **changes)
    assert report["resumedAt"] == pytest.approx(0.25 if kind == "coupled" else 0.15)
    require_same(tmp_path, whole(kind, **changes))
    for name, header in headers.items():
        assert header_of(tmp_path / name) == header
    assert not list(tmp_path.glob("*.part"))
    fault("SIGKILL while outputs are written", "sensor and solution files of the whole run, bit for bit")


def header_of(path):
    """All lines of comment but the two of the footer; there is one header."""
    lines = [line for line in path.read_text().splitlines() if line.startswith("#")]
    return [line for line in lines if not line.startswith(("#simulation finished", "#Solver Info"))]


@pytest.mark.parametrize("torn", [1, 5, 40])
def test_a_torn_line_is_no_part_of_the_continued_file(tmp_path, whole, killed_early, torn, fault):
    killed_early(tmp_path, "cable")
    for name in FILES:
        path = tmp_path / name
        path.write_bytes(path.read_bytes()[:-torn])
    run(tmp_path, "cable")
    require_same(tmp_path, whole("cable"))
    fault(f"the last {torn} bytes of output files are missing", "cut back to whole rows, and continued")


def test_rows_until_the_restart_file_are_on_disk_when_it_is_written(tmp_path, whole):
    """However short they are: Exudyn keeps some kB of them back."""
    killed(tmp_path, "cable", 0.1501)
    rows = rows_of(tmp_path)
    for name in FILES:
        expected = whole("cable")[name]
        until = expected[expected[:, 0] < 0.1505]
        np.testing.assert_array_equal(rows[name][: len(until)], until)


def test_what_was_appended_to_stays(tmp_path, whole):
    """An earlier simulation in the same file is later than the restart file."""
    earlier = "# of another day\n0,1,2,3\n7.5,1,2,3\n"
    for name in ("first.txt", "second.txt"):
        (tmp_path / name).write_text(earlier)
    changes = {"sensors.append": True}
    run(tmp_path, "cable", end_time=0.2, **changes)
    run(tmp_path, "cable", **changes)
    for name in ("first.txt", "second.txt"):
        text = (tmp_path / name).read_text()
        assert text.startswith(earlier)
        rows = np.loadtxt((tmp_path / name), delimiter=",")[2:]
        np.testing.assert_array_equal(rows, whole("cable")[name])


def test_a_later_end_continues_the_files_behind_their_footers(tmp_path, whole):
    changes = {"sensors.writeFooter": True}
    run(tmp_path, "cable", end_time=0.2, **changes)
    run(tmp_path, "cable", **changes)
    require_same(tmp_path, whole("cable"))
    for name in FILES:
        assert (tmp_path / name).read_text().count("#simulation finished") == 1


def test_a_new_solution_file_has_a_header(tmp_path, whole):
    run(tmp_path, "cable", end_time=0.2)
    (tmp_path / "solution.txt").unlink()
    run(tmp_path, "cable")
    text = (tmp_path / "solution.txt").read_text()
    assert text.startswith("#Exudyn")
    rows = np.loadtxt(tmp_path / "solution.txt", delimiter=",")
    expected = whole("cable")["solution.txt"]
    np.testing.assert_array_equal(rows, expected[expected[:, 0] > 0.2001])


def test_a_binary_solution_file_is_refused(tmp_path):
    """Exudyn would begin it anew."""
    changes = {"file.binary": True}
    run(tmp_path, "cable", end_time=0.2, **changes)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(
        InputError, match=r"solution\.file\.binary.*cannot be continued.*solution\.file\.name"
    ):
        run(tmp_path, "cable", **changes)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_step_function_is_called_at_the_times_of_the_whole_run(tmp_path, killed_early):
    """Bit for bit, as loads may follow from them."""
    whole, rest = [], []
    (tmp_path / "whole").mkdir()
    run(tmp_path / "whole", "user", times=whole)
    killed_early(tmp_path, "user")
    run(tmp_path, "user", times=rest)
    assert rest == whole[-len(rest) :] and rest[0] == pytest.approx(0.155)


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("#h\n0,1\n0.1,2\n0.2,3\n", "#h\n0,1\n0.1,2\n"),
        ("#h\n0,1\n0.1,2\n0.1", "#h\n0,1\n0.1,2\n"),
        ("#h\n0,1\n0.1,2\n#simulation finished\n", "#h\n0,1\n0.1,2\n"),
        ("#h\n0.2,1\n", "#h\n"),
        ("#h\n", "#h\n"),
        ("#h", ""),
        ("", ""),
        ("#h\n0,1\n\0\0\0\0\n\0", "#h\n0,1\n"),
        ("5,1\n#h\n0,1\n0.2,1\n", "5,1\n#h\n0,1\n"),
        ("#h\n0,1\nnan,2\n", "#h\n0,1\n"),
        ("0.1\n", "0.1\n"),
    ],
)
def test_rows_are_cut_behind_the_last_one_that_counts(tmp_path, text, kept):
    path = tmp_path / "rows.txt"
    path.write_bytes(text.encode())
    os.chmod(path, 0o640)
    cut_rows_after(path, 0.15)
    assert path.read_bytes().decode() == kept
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_failure_while_cutting_leaves_the_file(tmp_path, monkeypatch):
    path = tmp_path / "rows.txt"
    path.write_text("0,1\n0.2,1\n")

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match=r"rows\.txt' cannot be cut back .*\(No space left on device\)"):
        cut_rows_after(path, 0.1)
    assert os.listdir(tmp_path) == ["rows.txt"] and path.read_text() == "0,1\n0.2,1\n"


def test_a_link_stays_one(tmp_path):
    target, link = tmp_path / "far.txt", tmp_path / "near.txt"
    target.write_text("0,1\n0.2,1\n")
    link.symlink_to(target)
    cut_rows_after(link, 0.1)
    assert link.is_symlink() and target.read_text() == "0,1\n"
