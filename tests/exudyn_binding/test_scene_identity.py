"""Which changes of a scene a restart file refuses, by name; and which ones it takes."""

import functools
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    NodePointGround,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid
from scipy.interpolate import CubicSpline

from exudyn_inext import CableDrag, CreatePrescribedMotion, ExplicitSettings, InputError, SetCableDrag
from exudyn_inext.exudyn_binding.scene_identity import difference, scene_identity
from exudyn_inext.run.fingerprint import text_of, texts_of_function
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import load_node

ROOT = Path(__file__).parents[2]
STRENGTH = 0.1


def pull(mbs, t, load):
    return [STRENGTH * np.sin(9.0 * t), 0, 0]


def pull_harder(mbs, t, load):
    return [2.0 * STRENGTH * np.sin(9.0 * t), 0, 0]


def swing(amplitude):
    return lambda t: [0.0, 2.0 + amplitude * (1.0 - np.cos(5.0 * t))]


class Controller:
    """A user function that is an object."""

    def __init__(self, gain):
        self.gain = gain

    def __call__(self, mbs, t):
        return self.control(t)

    def control(self, t):
        return self.gain * t < 100.0


DEFAULTS = {
    "gravity": -9.81,
    "mass": 1.0,
    "spring": 20.0,
    "offset": 0.05,
    "load": 0.1,
    "function": pull,
    "amplitude": 0.1,
    "reference": 1.0,
    "step": Controller(2.0),
    "initial": 3.0,
    "names": "",
}


@pytest.fixture
def build(new_mbs, add_pendulum, add_cable, add_sensor):
    """(changes of DEFAULTS) -> assembled mbs with an item of each kind that matters."""

    def scene(**changed):
        given = SimpleNamespace(**(DEFAULTS | changed))
        mbs = new_mbs()
        gravity = [0, given.gravity, 0]
        cable = add_pendulum(mbs, gravity=gravity)
        moved = add_cable(mbs, positionStart=[0, 2, 0], positionEnd=[1.8, 2, 0])
        CreatePrescribedMotion(mbs, moved["nodes"][0], swing(given.amplitude))
        load_node(mbs, cable["nodes"][3], [given.load, 0, 0])
        load_node(mbs, cable["nodes"][2], [0, 0, 0], loadVectorUserFunction=given.function)
        arm = mbs.CreateRigidBody(
            name=f"arm{given.names}",
            inertia=InertiaCuboid(1000 * given.mass, [0.05, 0.02, 0.03]),
            referencePosition=[0, given.reference, 0],
            initialAngularVelocity=[given.initial, 1, 2],
            returnDict=True,
        )
        mass = mbs.AddMarker(MarkerBodyMass(bodyNumber=arm["bodyNumber"]))
        mbs.AddLoad(LoadMassProportional(markerNumber=mass, loadVector=gravity))
        ground = mbs.CreateGround(referencePosition=[0, given.reference, 0])
        at = {ground: [0, 0, 0], arm["bodyNumber"]: [0, 0, 0]}
        markers = [
            mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=point))
            for body, point in at.items()
        ]
        mbs.AddObject(SphericalJoint(markerNumbers=markers))
        fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        at_tip = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=cable["nodes"][-1], coordinate=1))
        mbs.AddObject(
            CoordinateSpringDamper(
                name="spring", markerNumbers=[fixed, at_tip], stiffness=given.spring, offset=given.offset
            )
        )
        mbs.SetPreStepUserFunction(given.step)
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return SimpleNamespace(mbs=mbs, cable=cable, tip=tip)

    return scene


def identity(mbs, **explicit):
    return scene_identity(mbs, ExplicitSettings(**explicit), 0.0)


def found(before, after, meanwhile=None):
    return difference(after, before, meanwhile or {})


def test_the_same_scene_has_the_same_identity(build):
    assert found(identity(build().mbs), identity(build().mbs)) == ""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"gravity": -9.8},
            r"gravity of object 0 'object0' was \[0\.0, -9\.81\], and is \[0\.0, -9\.8\] now",
        ),
        ({"mass": 2.0}, r"mass of object \d+ 'arm' was 0\.03, and is 0\.06 now"),
        ({"spring": 21.0}, r"stiffness of object \d+ 'spring' was 20\.0, and is 21\.0 now"),
        ({"offset": 0.06}, r"offset of object \d+ 'spring' was 0\.05, and is 0\.06 now"),
        (
            {"load": 0.2},
            r"loadVector of load 0 'load0' was \[0\.1, 0\.0, 0\.0\], and is \[0\.2, 0\.0, 0\.0\]",
        ),
        (
            {"function": pull_harder},
            r"loadVectorUserFunction of load 1 'load1' was pull \w+, and is pull_harder",
        ),
        ({"amplitude": 0.2}, r"'place' in offsetUserFunction of object \d+ 'object\d+' was \S+ \w+, and is"),
        ({"reference": 1.1}, r"referencePosition of object \d+ 'object\d+' was \[0\.0, 1\.0, 0\.0\]"),
        ({"step": Controller(3.0)}, r"'gain' in PreStepUserFunction of mbs was 2\.0, and is 3\.0 now"),
        ({"initial": 4.0}, r"initialVelocities of node \d+"),
    ],
    ids=lambda value: str(next(iter(value))) if isinstance(value, dict) else "",
)
def test_what_changes_the_motion_is_named(build, change, message):
    difference_found = found(identity(build().mbs), identity(build(**change).mbs))
    assert re.search(message, difference_found), difference_found


@pytest.mark.parametrize("before", [True, False])
def test_a_function_that_comes_or_goes_is_named_before_the_version_of_python(mbs, add_pendulum, before):
    add_pendulum(mbs)
    mbs.Assemble()
    without = identity(mbs)
    mbs.SetPreStepUserFunction(Controller(2.0))
    ways = [identity(mbs), without] if before else [without, identity(mbs)]
    assert re.search("PreStepUserFunction of mbs was .*, and is .* now", found(*ways)) is not None


def test_names_drawing_and_sensors_may_change(build):
    before = identity(build().mbs)
    other = build(names="_2")
    for number in range(other.mbs.systemData.NumberOfObjects()):
        data = other.mbs.GetObject(number)
        if "Vshow" in data:
            other.mbs.SetObjectParameter(number, "Vshow", False)
    other.mbs.SetSensorParameter(other.tip, "outputVariableType", exudyn.OutputVariableType.Velocity)
    assert found(before, identity(other.mbs)) == ""


def test_settings_and_properties_of_cables_count(build):
    scene = build()
    before = identity(scene.mbs)
    assert found(before, identity(scene.mbs, integrator="Zhai")).startswith("integrator was 'RATTLE', and is")
    assert found(before, identity(scene.mbs, energyTolerance=0.1)) == ""
    SetCableDrag(scene.mbs, scene.cable, CableDrag(1.2, 0.01, diameter=0.01, fluidDensity=1.2))
    assert found(before, identity(scene.mbs)).startswith("drag")


def restarting(folder, end_time):
    settings = quiet_settings(end_time, round(end_time / 0.02))
    restart = settings.solution.restart
    restart.name = str(folder / "run.restart")
    restart.write = restart.continueIfAvailable = True
    restart.writePeriod = 0.02
    return settings


def test_a_run_of_another_scene_is_refused(build, solve, tmp_path, contents, fault):
    solve(build().mbs, settings=restarting(tmp_path, 0.04), stepSize=1e-3)
    other = build(spring=21.0).mbs
    before = contents(other)
    refused = (
        r"another run: stiffness of object \d+ 'spring' was 20\.0, and is 21\.0 now\. Build the same scene"
    )
    with pytest.raises(InputError, match=refused):
        solve(other, settings=restarting(tmp_path, 0.06), stepSize=1e-3)
    assert contents(other) == before
    report = solve(build().mbs, settings=restarting(tmp_path, 0.06), stepSize=1e-3)
    assert report["resumedAt"] == pytest.approx(0.04)
    fault("a restart file of a scene with another spring", "refused, with the item and its parameter")


def test_what_user_functions_change_during_a_run_is_no_other_scene(new_mbs, add_pendulum, solve, tmp_path):
    """The run goes on with the scene built anew, and with the one that the first part has left."""

    def scene():
        mbs, calls = new_mbs(), []
        cable = add_pendulum(mbs)
        load = load_node(mbs, cable["nodes"][-1], [0, 0, 0])

        def rise(mbs, t):
            calls.append(t)
            mbs.variables["force"] = 0.1 * t
            mbs.SetLoadParameter(load, "loadVector", [0, 0.1 * t, 0])
            return True

        mbs.variables["force"] = 0.0
        mbs.SetPreStepUserFunction(rise)
        mbs.Assemble()
        return mbs

    (tmp_path / "other").mkdir()
    for folder, anew in ((tmp_path, True), (tmp_path / "other", False)):
        first = scene()
        solve(first, settings=restarting(folder, 0.04), stepSize=1e-3)
        assert first.GetLoadParameter(0, "loadVector")[1] == pytest.approx(0.004)
        for end_time in (0.06, 0.08):
            mbs = scene() if anew else first
            report = solve(mbs, settings=restarting(folder, end_time), stepSize=1e-3)
        assert report["resumedAt"] == pytest.approx(0.06)
    changed = scene()
    changed.SetLoadParameter(0, "loadVector", [0, 5.0, 0])
    with pytest.raises(
        InputError, match=r"loadVector of load 0 'load0' was \[0\.0, 0\.0, 0\.0\], and is \[0\.0, 5"
    ):
        solve(changed, settings=restarting(tmp_path, 0.1), stepSize=1e-3)


PRINT_IDENTITY = """
import json, sys
sys.path.insert(0, {root!r})
import exudyn, scipy.interpolate  # as they are
from exudyn_inext import ExplicitSettings
from exudyn_inext.exudyn_binding.scene_identity import scene_identity
sys.pycache_prefix = {compiled!r}
from tests.exudyn_binding.many_functions import build
print(json.dumps(scene_identity(build(exudyn.SystemContainer()), ExplicitSettings(), 0.0)))
"""


def test_the_identity_is_the_same_in_every_process(tmp_path):
    """With functions of all kinds, other hash seeds, and sources that are compiled anew or not."""
    script = PRINT_IDENTITY.format(root=str(ROOT), compiled=str(tmp_path))
    printed = []
    for seed, cached in (("1", ""), ("2", "1")):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONDONTWRITEBYTECODE": cached}
        result = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, timeout=300, env=environment
        )
        assert result.returncode == 0, result.stderr
        printed.append(result.stdout)
        assert list(tmp_path.rglob("many_functions*.pyc"))
    assert printed[0] == printed[1]
    assert "0x" not in printed[0] and "UserFunction" in printed[0]


def functions_of(value):
    """Pairs that differ in one thing; made anew for each value."""
    table = np.array([0.0, value, 1.0])
    data = {"gain": value, "names": {"x", "y"}}

    def closure(mbs, t, load):
        return [value * t, 0, 0]

    def array(mbs, t, load):
        return [np.interp(t, [0, 1, 2], table), 0, 0]

    def in_a_dict(mbs, t, load):
        return [data["gain"], 0, 0]

    def default(mbs, t, load, factor=value):
        return [factor, 0, 0]

    def keyword(mbs, t, load, *, factor=value):
        return [factor, 0, 0]

    def with_attribute(mbs, t, load):
        return [with_attribute.gain, 0, 0]

    with_attribute.gain = value
    spline = CubicSpline([0.0, 1.0, 2.0], table)
    return {
        "closure": closure,
        "array": array,
        "dict": in_a_dict,
        "default": default,
        "keyword": keyword,
        "attribute": with_attribute,
        "lambda": lambda mbs, t, load: [value, 0, 0],
        "partial": functools.partial(closure, load=value),
        "partial of an argument": functools.partial(np.multiply, value),
        "method": Controller(value).control,
        "object": Controller(value),
        "spline": lambda mbs, t, load: [spline(t), 0, 0],
        "namespace": functools.partial(closure, load=SimpleNamespace(x=value)),
        "nested": lambda mbs, t, load: [(lambda: value)(), 0, 0],
        "function of a function": lambda mbs, t, load: closure(mbs, t, load),
    }


@pytest.mark.parametrize("kind", list(functions_of(1.0)))
def test_functions_differ_if_what_they_use_does(kind):
    texts = [texts_of_function("f", functions_of(value)[kind]) for value in (1.0, 1.0, 2.0)]
    assert texts[0] == texts[1] != texts[2]


def test_functions_differ_by_their_code():
    twins = [lambda t: t + 1.0, lambda t: t + 1.0, lambda t: t + 2.0, lambda t: t - 1.0, lambda t: np.sin(t)]
    others = [lambda t: np.cos(t), lambda t: [x + 1 for x in t], lambda t: [x + 2 for x in t]]
    texts = [text_of(function) for function in twins + others]
    assert texts[0] == texts[1] and len(set(texts)) == len(texts) - 1


def test_a_global_variable_counts(monkeypatch):
    before = texts_of_function("f", pull)
    monkeypatch.setitem(globals(), "STRENGTH", 0.2)
    after = texts_of_function("f", pull)
    assert before["'STRENGTH' in f"] == "0.1" and after["'STRENGTH' in f"] == "0.2"


def test_entries_of_mbs_variables_count_that_a_function_reads(mbs, add_pendulum):
    nodes = add_pendulum(mbs)["nodes"]

    def force(mbs, t, load):
        return [mbs.variables["amplitude"] * t, 0, 0]

    load_node(mbs, nodes[-1], [0, 0, 0], loadVectorUserFunction=force)
    mbs.variables |= {"amplitude": 0.1, "output": "here.txt"}
    mbs.Assemble()
    before = identity(mbs)
    mbs.variables["output"] = "there.txt"
    assert found(before, identity(mbs)) == ""
    mbs.variables["amplitude"] = 0.2
    assert found(before, identity(mbs)) == "variables['amplitude'] of mbs was 0.1, and is 0.2 now"


def test_what_cannot_be_compared_goes_by_its_type(mbs, tmp_path):
    """Neither addresses nor states of processes count; circles end."""
    with open(tmp_path / "a", "w") as one, open(tmp_path / "b", "w") as other:
        assert text_of([one]) == text_of([other])
    assert text_of([mbs]) == text_of([exudyn.SystemContainer().AddSystem()])
    assert text_of([np.random.default_rng(1)]) == text_of([np.random.default_rng(2)])
    circle, twin, deep = [1], [1], []
    circle.append(circle)
    twin.append(twin)
    assert text_of(circle) == text_of(twin)
    for _ in range(10_000):
        deep = [deep]
    assert text_of([deep]).startswith("list ")


def test_a_scene_with_constraints_of_all_parameters(mbs, add_cable):
    """Constraints, too: a support that is let go is another scene."""
    nodes = add_cable(mbs)["nodes"]
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=0))
    held = mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
    mbs.Assemble()
    before = identity(mbs)
    mbs.SetObjectParameter(held, "activeConnector", False)
    assert found(before, identity(mbs)) == "activeConnector of object 1 'object1' was True, and is False now"


def test_general_contacts_count(mbs, add_pendulum):
    add_pendulum(mbs)
    ball = mbs.CreateMassPoint(mass=1.0, referencePosition=[0, 5, 0])
    contact = mbs.AddGeneralContact()
    contact.SetFrictionPairings(np.zeros((1, 1)))
    marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=ball))
    contact.AddSphereWithMarker(
        marker, radius=0.1, contactStiffness=100.0, contactDamping=1.0, frictionMaterialIndex=0
    )
    mbs.Assemble()
    before = identity(mbs)
    assert "contactStiffness of sphere 0" in before["general contact 0"]
    assert found(before, identity(mbs)) == ""
    contact.SetFrictionPairings(0.1 * np.ones((1, 1)))
    assert found(before, identity(mbs)).startswith("frictionPairings of general contact 0 was [[0.0]]")
