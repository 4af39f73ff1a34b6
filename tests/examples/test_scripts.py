"""Every example runs as a script, stays short, and draws its picture."""

import dataclasses
import importlib
import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image, ImageSequence

import examples
import exudyn_inext
from examples import animation, net_film, outlines, tethered_bodies, thrown_net
from exudyn_inext import DivergenceError
from reference_models.model import silence
from tests.examples.twins import run_inextensible

PARTS = {"bodies", "contact", "flight", "meshes", "outlines", "overhead_parts", "shapes"}
HELPERS = PARTS | {"__init__", "animation", "net_film", "picture", "style"}
FILES = sorted(Path(examples.__file__).parent.glob("*.py"))
SCRIPTS = [path.stem for path in FILES if path.stem not in HELPERS]


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_runs_as_printed_and_draws(name, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(animation.picture, "FOLDER", tmp_path)
    with silence():
        importlib.import_module(f"examples.{name}").main()
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    assert "Exudyn's steps" in capsys.readouterr().out


def test_a_script_runs_from_another_folder(tmp_path):
    script = Path(examples.__file__).parent / "planar_pendulum.py"
    environment = os.environ | {"PYTHONPATH": str(Path(exudyn_inext.__file__).parents[1])}
    done = subprocess.run(
        [sys.executable, "-W", "error", script],
        cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert f"picture: {tmp_path.resolve() / 'results' / 'examples' / 'planar_pendulum.png'}" in done.stdout
    assert (tmp_path / "results" / "examples" / "planar_pendulum.png").exists()


def test_a_missing_library_is_named_with_what_installs_it(tmp_path):
    (tmp_path / "PIL.py").write_text("raise ImportError('not here', name='PIL')")
    script = Path(examples.__file__).parent / "planar_pendulum.py"
    paths = [str(tmp_path), str(Path(exudyn_inext.__file__).parents[1])]
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 1 and done.stderr.rstrip().endswith(
        "examples draw with Matplotlib, not installed here: pip install 'exudyn_inext[studies]'"
    )


def test_the_outline_of_a_box_turns_with_its_body():
    turned = outlines.box([2, 0, 1]) @ [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]  # about y
    assert np.ptp(outlines.outline(turned[:, [0, 2]]), axis=0) == pytest.approx([1, 2])


def test_no_script_asks_for_its_folder():
    assert not [path.stem for path in FILES if "from ." in path.read_text()]


def test_the_animation_is_a_film_of_the_four_scenes(tmp_path, monkeypatch):
    monkeypatch.setattr(animation.picture, "FOLDER", tmp_path)
    monkeypatch.setattr(animation, "FRAMES", 3)
    with silence():
        animation.main()
    with Image.open(tmp_path / "four_scenes.gif") as film:
        assert film.n_frames == 3
        frames = [np.array(frame.convert("L")) for frame in ImageSequence.Iterator(film)]
    height, width = frames[0].shape
    for rows in (slice(height // 2), slice(height // 2, None)):
        for columns in (slice(width // 2), slice(width // 2, None)):
            first, last = (frame[rows, columns].astype(int) for frame in (frames[0], frames[-1]))
            assert (np.abs(first - last) > 100).sum() > 100  # something moves in every quarter


def test_the_film_of_the_net_shows_it_moving(tmp_path, monkeypatch):
    monkeypatch.setattr(animation.picture, "FOLDER", tmp_path)
    monkeypatch.setattr(net_film, "thrown_net", SimpleNamespace(run=partial(thrown_net.run, endTime=0.1)))
    monkeypatch.setitem(thrown_net.SIZE, "meshes", 2)
    with silence():
        net_film.main(frames=2)
    with Image.open(tmp_path / "thrown_net.gif") as film:
        first, last = (np.array(frame.convert("L")).astype(int) for frame in ImageSequence.Iterator(film))
    assert (np.abs(first - last) > 100).sum() > 100


@pytest.mark.parametrize("name", ["four_scenes.gif", "thrown_net.gif"])
def test_the_films_in_the_docs_are_small_and_complete(name):
    path = Path(examples.__file__).parents[1] / "docs" / name
    assert path.stat().st_size < 1_500_000
    with Image.open(path) as film:
        assert film.n_frames == animation.FRAMES


def test_a_run_that_diverges_ends_in_a_message():
    settings = dataclasses.replace(
        tethered_bodies.SETTINGS, stepSize=1e-2, allowUnstableStep=True, rejectSteps=False
    )
    with (
        pytest.warns(UserWarning, match="stability limit"),
        pytest.raises(
            DivergenceError, match=r"diverged before .* 2 joint\(s\) and bodies: .* reduce stepSize"
        ),
    ):
        run_inextensible(tethered_bodies, 1.0, settings=settings)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_scripts_are_short(path):
    limit = 80 if path.stem in HELPERS else 60
    assert len(path.read_text().splitlines()) < limit


def test_every_script_has_its_own_test_and_its_picture():
    root = Path(examples.__file__).parents[1]
    for name in SCRIPTS:
        assert (root / "tests" / "examples" / f"test_{name}.py").exists()
        assert (root / "docs" / "examples" / f"{name}.png").stat().st_size < 60_000
        assert f"{name}.py" in (root / "examples" / "README.md").read_text()
        page = (root / "docs" / "gallery" / f"{name}.md").read_text()
        assert f"examples/{name}.png" in page and f"}} ../../examples/{name}.py" in page
        assert f"gallery/{name}\n" in (root / "docs" / "gallery.md").read_text()
