"""A run that is interrupted and continued from its restart file is the whole run, bit for bit."""

import os
import signal
import subprocess
import sys
import zipfile
from pathlib import Path

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import LoadForceVector, MarkerBodyPosition, SensorBody, SphericalJoint
from exudyn.utilities import InertiaCuboid

from exudyn_inext import AttachToBody, InputError
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.run import restart_file
from exudyn_inext.run.restart_file import Restart, read_restart, write_restart
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import load_node
from tests.exudyn_binding.written_run import run

ROOT = Path(__file__).parents[2]


def state(mbs):
    data = mbs.systemData
    return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])


def restarting(settings, folder, period=0.1):
    restart = settings.solution.restart
    restart.name = str(folder / "run.restart")
    restart.write = restart.continueIfAvailable = True
    restart.writePeriod = period
    return settings


def brake(mbs, body):
    """A force against the velocity of the body that a sensor reads."""
    kind = exudyn.OutputVariableType.Velocity
    velocity = mbs.AddSensor(SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=kind))

    def force(mbs, t, load):
        return list(-2.0 * mbs.GetSensorValues(velocity))

    marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=force))


@pytest.fixture
def build(new_mbs, add_pendulum, add_sensor):
    """(what is in the scene) -> assembled mbs and the sensor of the tip."""

    def scene(kind):
        mbs = new_mbs()
        section = {}
        cable = add_pendulum(mbs, **section)
        if kind == "loads in time":

            def force(mbs, t, load):
                return [0.1 * np.sin(9 * t), 0, 0]

            load_node(mbs, cable["nodes"][3], [1, 0, 0], loadVectorUserFunction=force)
        elif kind == "user functions":
            mbs.SetPostStepUserFunction(lambda mbs, t: True)
        elif kind == "a load that is set":  # after the last step, too
            load = load_node(mbs, cable["nodes"][3], [0, 0, 0])

            def follow(mbs, t):
                place = mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position)
                mbs.SetLoadParameter(load, "loadVector", list(-0.2 * place))
                return True

            mbs.SetPostStepUserFunction(follow)
        elif kind in ("a body", "a controller"):
            body = mbs.CreateRigidBody(
                inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]),
                referencePosition=[1.85, 0, 0],
                gravity=[0, -9.81, 0],
                returnDict=True,
            )
            AttachToBody(mbs, cable, "end", body["bodyNumber"], [-0.05, 0, 0])
            arm = mbs.CreateRigidBody(
                inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]),
                referencePosition=[0, 1, 0],
                initialAngularVelocity=[3, 1, 2],
                returnDict=True,
            )
            ends = (mbs.CreateGround(referencePosition=[0, 1, 0]), arm["bodyNumber"])
            markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=end)) for end in ends]
            mbs.AddObject(SphericalJoint(markerNumbers=markers))
            if kind == "a controller":
                brake(mbs, body["bodyNumber"])
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return mbs, tip

    return scene


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(
    "kind", ["loads in time", "user functions", "a load that is set", "a body", "a controller"]
)
def test_two_halves_are_the_whole_run_bit_for_bit(build, solve, tmp_path, kind, integrator):
    explicit = {"integrator": integrator, "stepSize": 1e-3}
    whole, tip = build(kind)
    solve(whole, 0.3, **explicit)
    first, _ = build(kind)
    solve(first, settings=restarting(quiet_settings(0.15, 1), tmp_path, 0.05), **explicit)
    second, continued = build(kind)
    settings = restarting(quiet_settings(0.3, 1), tmp_path, 0.05)
    report = solve(second, settings=settings, **explicit)
    assert report["resumedAt"] == pytest.approx(0.15)
    np.testing.assert_array_equal(state(second), state(whole))
    rows, rest = (np.asarray(mbs.GetSensorStoredData(s)) for mbs, s in ((whole, tip), (second, continued)))
    np.testing.assert_allclose(
        rest[:, 0], rows[16:, 0], rtol=1e-12
    )  # the first part has all rows until 0.15 s
    np.testing.assert_array_equal(rest[:, 1:], rows[16:, 1:])


@pytest.mark.parametrize(
    "explicit",
    [
        {"adaptiveStep": True, "integrator": "Zhai"},
        {"massScaling": 0.3, "stepSize": 3e-3},
        {"integrator": "RK4"},
    ],
    ids=["adaptive", "scaled mass", "largest safe step"],
)
def test_steps_of_all_kinds_continue(build, solve, tmp_path, explicit):
    whole, _ = build("plain")
    solve(whole, 0.3, **explicit)
    for end in (0.1, 0.2, 0.3):
        part, _ = build("plain")
        report = solve(part, settings=restarting(quiet_settings(end, 1), tmp_path), **explicit)
    assert report["resumedAt"] == pytest.approx(0.2)
    np.testing.assert_array_equal(state(part), state(whole))


def initial(mbs):
    return mbs.systemData.GetSystemState(exudyn.ConfigurationType.Initial)


def test_the_initial_configuration_and_the_settings_are_as_before(build, solve, tmp_path):
    solve(build("plain")[0], settings=restarting(quiet_settings(0.1, 1), tmp_path))
    mbs, _ = build("plain")
    first, settings = initial(mbs), restarting(quiet_settings(0.2, 1), tmp_path)
    before = repr(settings.GetDictionary())
    solve(mbs, settings=settings)
    for now, then in zip(initial(mbs), first, strict=True):
        np.testing.assert_array_equal(now, then)
    assert repr(settings.GetDictionary()) == before


KILLED = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {root!r})
from exudyn_inext.exudyn_binding import restart
from tests.exudyn_binding.written_run import run
count = 0
written = restart.write_restart
def write_and_die(*arguments):
    global count
    written(*arguments)
    count += 1
    if count == 3:
        os.kill(os.getpid(), signal.SIGKILL)
restart.write_restart = write_and_die
run({folder!r}, "plain", integrator="Zhai")
"""


def test_a_run_that_is_killed_continues_where_its_last_file_was_written(tmp_path, fault):
    def ended(folder):
        report = run(folder, "plain", integrator="Zhai")
        return np.loadtxt(folder / "first.txt", delimiter=","), report

    script = KILLED.format(root=str(ROOT), folder=str(tmp_path))
    killed = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=300, cwd=tmp_path)
    assert killed.returncode == -signal.SIGKILL
    rows, report = ended(tmp_path)
    assert report["resumedAt"] == pytest.approx(0.15)
    (tmp_path / "whole").mkdir()
    whole, _ = ended(tmp_path / "whole")
    np.testing.assert_array_equal(rows, whole)
    fault("SIGKILL in a run", "continued from its restart file, the end is that of the whole run bit for bit")


def some_restart():
    return Restart({"identity": {}, "grid": {}}, {"0/state/q": np.arange(5.0)})


def test_a_failure_while_writing_leaves_the_last_file(tmp_path, monkeypatch, fault):
    path = tmp_path / "deep" / "run.restart"
    write_restart(path, some_restart())
    before = path.read_bytes()

    def full(file, **arrays):
        file.write(b"half of it")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(restart_file.np, "savez", full)
    with pytest.raises(InputError, match=r"cannot be written \(No space left on device\).*restart\.name"):
        write_restart(path, some_restart())
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]
    fault("a disk that is full while a restart file is written", "refused, the last file stays")


@pytest.mark.parametrize("place", [0, 40, 200, -30, -1])
def test_a_damaged_file_is_refused(tmp_path, place, fault):
    path = tmp_path / "run.restart"
    write_restart(path, some_restart())
    data = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        first = archive.infolist()[0]
        offset = first.header_offset + 140 if place == 200 else place
    data[offset] ^= 0xFF
    path.write_bytes(data)
    try:
        read = read_restart(path)
    except InputError as error:
        assert "damaged" in str(error) and "remove it to start anew" in str(error)
        fault(f"a restart file with one bit pattern inverted (place {place})", "refused")
    else:  # a byte that means nothing
        np.testing.assert_array_equal(read.arrays["0/state/q"], np.arange(5.0))


@pytest.mark.parametrize("length", [0, 10, 300, 600])
def test_a_file_that_was_cut_short_is_refused(tmp_path, length, fault):
    path = tmp_path / "run.restart"
    write_restart(path, some_restart())
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(InputError, match="damaged"):
        read_restart(path)
    fault(f"a restart file cut to {length} bytes", "refused")


def test_pickled_objects_are_not_loaded(tmp_path):
    path = tmp_path / "run.restart"
    with open(path, "wb") as file:
        np.savez(file, header=np.array([{"format": 1}], dtype=object))
    with pytest.raises(InputError, match="damaged"):
        read_restart(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 1}, "is of version 1, this package reads version 23"),
        ({"format": "x"}, "not of the format"),
    ],
)
def test_another_version_or_format_is_refused(tmp_path, monkeypatch, change, message):
    path = tmp_path / "run.restart"
    monkeypatch.setattr(restart_file, "VERSION", change.get("version", restart_file.VERSION))
    monkeypatch.setattr(restart_file, "FORMAT", change.get("format", restart_file.FORMAT))
    write_restart(path, some_restart())
    monkeypatch.undo()
    with pytest.raises(InputError, match=message):
        read_restart(path)


@pytest.mark.parametrize(
    ("end_time", "explicit", "message"),
    [
        (0.2, {"integrator": "Zhai"}, "integrator was 'RATTLE', and is 'Zhai' now"),
        (0.2, {"stepSize": 2e-3}, "stepSize was 0.001, and is 0.002 now"),
        (0.1, {}, r"is at t = 0\.1 s: nothing is left until endTime = 0\.1 s"),
        (0.2041, {}, r"endTime = 0\.2041 s is at no step"),
    ],
)
def test_other_settings_are_refused(build, solve, tmp_path, contents, end_time, explicit, message):
    given = {"integrator": "RATTLE", "stepSize": 1e-3}
    solve(build("plain")[0], settings=restarting(quiet_settings(0.1, 1), tmp_path), **given)
    mbs, _ = build("plain")
    before = contents(mbs)
    with pytest.raises(InputError, match=message):
        solve(mbs, settings=restarting(quiet_settings(end_time, 1), tmp_path), **(given | explicit))
    assert contents(mbs) == before


def test_another_scene_is_refused(build, solve, tmp_path, new_mbs, add_pendulum, fault):
    solve(build("plain")[0], settings=restarting(quiet_settings(0.1, 1), tmp_path))
    heavier = new_mbs()
    add_pendulum(heavier, gravity=[0, -9.80, 0])
    heavier.Assemble()
    with pytest.raises(
        InputError,
        match=r"another run: gravity of object 0 'object0' was \[0\.0, -9\.81\], and is \[0\.0, -9\.8\] now",
    ):
        solve(heavier, settings=restarting(quiet_settings(0.2, 1), tmp_path))
    with pytest.raises(InputError, match="of another run: number of objects was 3, and is 8"):
        solve(build("a body")[0], settings=restarting(quiet_settings(0.2, 1), tmp_path))
    fault("a restart file of another scene", "refused, with what differs")
