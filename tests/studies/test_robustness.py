"""The study of random scenes at default settings."""

from dataclasses import replace

import exudyn
import numpy as np
import pytest

from exudyn_inext import SolveExplicit
from reference_models.model import quiet_settings, silence
from studies import robustness
from studies.harness.benchmark import Benchmark
from studies.harness.study import Results
from studies.robust.scenes import MIXED, NATIVE, build, lone_rope, mixed_rope, moved


@pytest.fixture(scope="module")
def rows():
    own, native = robustness.MEASURE.series
    cases = robustness.own_cases(True)
    few = [
        replace(own, cases=lambda quick: cases[:2] + cases[8:10]),
        replace(native, cases=lambda quick: cases[:1]),
    ]
    return Benchmark(few)(False)


def test_rows_say_what_became_of_each_scene(rows):
    own = [row for row in rows if row["kind"] == "own"]
    assert len(own) == 4 and len(rows) == 5
    for row in own:
        assert row["failure"] == "" and row["errorBeforeSnap"] <= row["error"]
        assert row["cpuSeconds"] > 0.0 and row["stepSize"] > 0.0
    assert {row["partner"] for row in own} == {"lone", "mass point", "rigid body"}


def test_conclusions_count_failures_and_accurate_runs(rows):
    said = robustness.conclude(Results(False, rows))
    assert "0 of 4 runs at default settings did not end: kept" in said[0]
    lost = [dict(rows[0], failure="lost", errorBeforeSnap=0.0), *rows[1:]]
    assert (
        "1 of 4 runs at default settings did not end: MISSED" in robustness.conclude(Results(False, lost))[0]
    )
    far = [dict(row, errorBeforeSnap=0.5) if row["kind"] == "own" else row for row in rows]
    assert "the bar of 0.01 is MISSED by 4 of 4" in robustness.conclude(Results(False, far))[1]


def test_a_seed_is_always_the_same_scene_and_others_differ():
    assert lone_rope(7) == lone_rope(7) != lone_rope(8)
    assert {mixed_rope(seed).partner for seed in range(8)} == set(MIXED)
    directions = [lone_rope(seed).direction for seed in range(20)]
    np.testing.assert_allclose([np.linalg.norm(d) for d in directions], 1.0)


@pytest.mark.parametrize("seed", [21, 23, 28, 39])
def test_a_native_twin_moves_alike(seed):
    """With a mass at the end, in the plane and in space, clamped and pinned."""
    rope = lone_rope(seed)
    paths = []
    for cables in ((), (NATIVE,)):
        _container, mbs, sensor = build(rope, *cables)
        with silence():
            run = exudyn.MainSystem.SolveDynamic if cables else SolveExplicit
            run(mbs, quiet_settings(0.2, 400, 0.01))
        paths.append(mbs.GetSensorStoredData(sensor)[:, 1:4])
    assert np.abs(paths[0] - paths[1]).max() < 0.01 * moved(paths[0])


def test_a_snap_is_seen_where_the_velocity_jumps():
    times = np.linspace(0.0, 1.0, 101)
    swing = np.stack([np.sin(3.0 * times), np.cos(3.0 * times), 0.0 * times], axis=1)
    assert robustness.periods_before_snap(swing) == 101
    caught = swing.copy()
    caught[60:] = caught[60]
    assert 59 <= robustness.periods_before_snap(caught) <= 61
