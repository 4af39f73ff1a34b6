"""The step of a run that is given none: by accuracy, with implicit bending where that would decide."""

from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    ObjectANCFCable,
    ObjectANCFCable2D,
    SensorBody,
    SphericalJoint,
    SpringDamper,
)
from exudyn.utilities import InertiaCylinder

from examples import overhead_line
from exudyn_inext import (
    AttachToBody,
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    ReplaceNativeCables,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.run.coupled_run import CoupledRun
from exudyn_inext.run.watch import _errors_of_waves
from reference_models.inextensible import Inextensible, inextensible_case, solved
from reference_models.model import quiet_settings, sensor_trajectory, silence
from reference_models.scenes import load_scene
from tests.exudyn_binding.items import that_remembers
from tests.random_scenes import RandomScene

END, PERIOD = 1.0, 0.01
POSITION = exudyn.OutputVariableType.Position


@pytest.fixture
def swing(new_mbs, add_cable, add_sensor, solve):
    """(section, elements, supports, settings) -> path of the free end of a cable of 1 m, and report."""

    def run(section, elements, supports, end=END, at_rest=False, dimension=2, **explicit):
        mbs = new_mbs()
        cable = add_cable(
            mbs,
            positionEnd=[1, 0, 0],
            numberOfElements=elements,
            beamTemplate=section,
            groundConstraintsStart=supports,
            dimension=dimension,
        )
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        if at_rest:
            SolveEquilibrium(mbs)
        report = solve(mbs, settings=quiet_settings(end, 1, PERIOD), **explicit)
        return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4], report

    return run


PINNED, CLAMPED = [True, True, False, False], [True] * 4
STIFF = InextensibleCable(massPerLength=10.0, bendingStiffness=10937.5)  # Exudyn's flexible pendulum


def test_a_stiff_pendulum_takes_few_steps(swing):
    """Its bending bounds plain explicit steps to 1.4e-6 s; it swings as a rigid rod."""
    path, report = swing(STIFF, 25, PINNED)
    assert report["massScaling"] == 0.3 and report["decidedBy"] == "accuracy" and report["steps"] < 5000
    fine, _ = swing(STIFF, 25, PINNED, stepSize=5e-5, massScaling=0.3)
    assert np.abs(path - fine).max() < 2e-4


@pytest.mark.parametrize("stiffness", [1.0, 100.0])
@pytest.mark.parametrize("elements", [4, 16])
def test_vibrations_that_are_the_motion_are_resolved(swing, stiffness, elements):
    """A cantilever that is let go: 2 to 18 periods of its first vibration."""
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=stiffness)
    path, report = swing(section, elements, CLAMPED)
    finer = report["stepSize"] / 8
    fine, _ = swing(section, elements, CLAMPED, stepSize=finer, massScaling=report["massScaling"])
    assert np.abs(path - fine).max() < 0.01 * np.ptp(fine[:, 1])


@pytest.fixture
def rope_with_one_short_element(new_mbs, add_sensor, solve):
    """(length of a short element [m] or 0, whether a body hangs on it, settings) -> paths, and report."""

    def run(short, has_body, **explicit):
        mbs = new_mbs()
        places = np.linspace(0, 10, 11)
        places = np.sort(np.append(places, 5 + short)) if short else places
        line = places[:, None] * np.array([0.8, -0.6])
        shape = CableShape(line, np.tile([0.8, -0.6], (len(line), 1)))
        section = InextensibleCable(massPerLength=0.5, bendingStiffness=20)
        given = {"shape": shape, "beamTemplate": section, "groundConstraintsStart": PINNED}
        nodes = CreateInextensibleCable(mbs, gravity=[0, -9.81, 0], **given)["nodes"]
        if has_body:
            tip = [*line[-1], 0]
            body = mbs.CreateMassPoint(referencePosition=tip, mass=1, gravity=[0, -9.81, 0], create2D=True)
            pair = [MarkerNodePosition(nodeNumber=nodes[-1]), MarkerBodyPosition(bodyNumber=body)]
            pair = [mbs.AddMarker(marker) for marker in pair]
            mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
        sensors = [add_sensor(mbs, node) for node in (nodes[5], nodes[-1])]
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(1, 100, 0.01), **explicit)
        return np.hstack([mbs.GetSensorStoredData(sensor)[:, 1:3] for sensor in sensors]), report

    return run


@pytest.mark.parametrize("has_body", [False, True])
def test_a_single_short_element_does_not_shorten_the_step(rope_with_one_short_element, has_body):
    """It resolves no waves that its neighbours do not."""
    _, even = rope_with_one_short_element(0, has_body)
    path, report = rope_with_one_short_element(0.002, has_body)
    assert report["steps"] <= 2 * even["steps"]
    given = {"stepSize": report["stepSize"] / 8, "massScaling": report["massScaling"]}
    fine, _ = rope_with_one_short_element(0.002, has_body, **given)
    assert np.abs(path - fine).max() < 0.001 * np.ptp(fine, axis=0).max()


@pytest.fixture
def swing_in_pieces(new_mbs, add_sensor, solve):
    """(length, elements and stiffness of pieces in a row, settings) -> path of the tip, and report."""

    def run(*pieces, **explicit):
        mbs, x, held = new_mbs(), 0.0, {"groundConstraintsStart": PINNED}
        for length, elements, stiffness in pieces:
            line = {"positionStart": [x, 0, 0], "positionEnd": [x + length, 0, 0]}
            section = InextensibleCable(massPerLength=1, bendingStiffness=stiffness)
            given = {"numberOfElements": elements, "beamTemplate": section, "gravity": [0, -9.81, 0]}
            x, tip = x + length, CreateInextensibleCable(mbs, **line, **given, **held)["nodes"][-1]
            held = {"nodeNumberStart": tip}
        sensor = add_sensor(mbs, tip)
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(0.5, 10, 0.05), **explicit)
        return mbs.GetSensorStoredData(sensor)[:, 1:3], report

    return run


@pytest.mark.parametrize("stiffness", [10.0, 1000.0])
def test_a_short_piece_of_a_cable_does_not_shorten_the_step(swing_in_pieces, stiffness):
    """It took 500 and 5000 times as many, as if it vibrated by itself."""
    pieces = (2.0, 4, 10.0), (0.02, 2, stiffness)
    path, report = swing_in_pieces(*pieces)
    _, even = swing_in_pieces(pieces[0], (1.0, 2, 10.0))
    assert report["steps"] <= 2 * even["steps"]
    given = {"stepSize": report["stepSize"] / 8, "massScaling": report["massScaling"]}
    fine, _ = swing_in_pieces(*pieces, **given)
    assert np.abs(path - fine).max() < 0.001 * np.ptp(fine, axis=0).max()


@pytest.fixture
def line(new_mbs, add_sensor, solve):
    """settings -> paths of the contact wire under a pantograph, and report."""

    def run(**explicit):
        mbs = new_mbs()
        nodes = overhead_line.build(mbs, elements=2)["cables"][1]["nodes"]
        sensors = [add_sensor(mbs, node) for node in nodes]
        mbs.Assemble()
        SolveEquilibrium(mbs)
        report = solve(mbs, settings=quiet_settings(1.2, 60, 0.02), **explicit)
        return np.stack([mbs.GetSensorStoredData(sensor)[:, 1:4] for sensor in sensors], axis=1), report

    return run


def test_small_fast_waves_of_a_line_do_not_shorten_its_step(line):
    path, report = line()
    fine, _ = line(stepSize=report["stepSize"] / 8, massScaling=report["massScaling"])
    assert report["stepSize"] > 0.5 * report["bounds"].safety * report["bounds"].stability_limit
    size = np.linalg.norm(fine - fine[0], axis=2).max()
    assert np.sqrt(((path - fine) ** 2).sum(axis=2).mean()) < 0.005 * size


@pytest.fixture
def weighed_cantilever(new_mbs, add_cable, add_sensor, solve):
    """(section, elements, end, mass, settings) -> path of its end, where a mass is, and report."""

    def run(section, elements, end, heavy=0.05, **explicit):
        mbs = new_mbs()
        cable = add_cable(
            mbs,
            positionEnd=[1, 0, 0],
            numberOfElements=elements,
            beamTemplate=section,
            groundConstraintsStart=CLAMPED,
        )
        mass = mbs.CreateMassPoint(mass=heavy, referencePosition=[1, 0, 0], gravity=[0, -9.81, 0])
        ends = [MarkerNodePosition(nodeNumber=cable["nodes"][-1]), MarkerBodyPosition(bodyNumber=mass)]
        mbs.AddObject(
            SphericalJoint(markerNumbers=[mbs.AddMarker(end) for end in ends], constrainedAxes=[1, 1, 0])
        )
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(end, 1, PERIOD), **explicit)
        return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4], report

    return run


def test_vibrations_of_cables_among_bodies_are_resolved(weighed_cantilever):
    """10 periods."""
    run = partial(weighed_cantilever, InextensibleCable(massPerLength=0.1, bendingStiffness=100.0), 4, END)
    path, report = run()
    fine, _ = run(stepSize=report["stepSize"] / 16, massScaling=0.3)
    assert np.abs(path - fine).max() < 0.01 * np.ptp(fine[:, 1])
    assert report["decidedBy"] == "accuracy" and report["stepSize"] > 5.0 * report["bounds"].rule


@pytest.mark.parametrize(
    ("stiffness", "has_mass", "share"),
    [(None, False, 0.01), (None, True, 0.02), (1e5, False, 0.01), (1e5, True, 0.02)],
)
def test_long_vibrations_keep_their_phase(swing, weighed_cantilever, stiffness, has_mass, share):
    """40 periods of a cantilever that falls, with a light mass at its end or without; axial stiffness [N]."""
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=2.0, axialStiffness=stiffness)
    end = 40 * 2.0 * np.pi / 3.516 * np.sqrt(0.1 / 2.0)
    given = (section, 4, end, 0.01) if has_mass else (section, 4, CLAMPED, end)
    run = partial(weighed_cantilever if has_mass else swing, *given)
    path, report = run()
    fine, _ = run(stepSize=report["stepSize"] / 4, massScaling=report["massScaling"])
    assert report["massScaling"]
    assert np.abs(path - fine).max() < share * np.ptp(fine[:, 1])


def test_short_waves_of_a_light_blade_do_not_shorten_the_step(weighed_cantilever):
    """A mass 20 times as heavy falls onto it, and vibrates three times."""
    stiffness, blade, mass = 100.0, 0.05, 1.0
    section = InextensibleCable(massPerLength=blade, bendingStiffness=stiffness)
    path, report = weighed_cantilever(section, 8, END, mass)
    rate = np.sqrt(3.0 * stiffness / (mass + 33.0 / 140.0 * blade))
    sag = 9.81 * (mass + 3.0 / 8.0 * blade) / (3.0 * stiffness)
    expected = -sag * (1.0 - np.cos(rate * PERIOD * np.arange(len(path))))
    assert np.abs(path[:, 1] - expected).max() < 0.01 * np.ptp(expected)  # slopes reach 0.1
    assert report["steps"] < 5_000  # 14 300 if all waves of the mesh were resolved


@pytest.mark.parametrize("kick", [0.0, 0.5])  # when the light mass begins to move [s]
def test_light_parts_are_resolved_beside_heavy_ones(new_mbs, add_cable, solve, kick):
    """A light mass on a spring, beside a heavy pendulum, in whose energy it has no share."""
    mbs, mass, stiffness, rate, speed = new_mbs(), 0.01, 100.0, 100.0, 5.0
    line = {"positionEnd": [1, -1, 0], "numberOfElements": 4, "groundConstraintsStart": PINNED}
    cable = add_cable(mbs, beamTemplate=InextensibleCable(massPerLength=1.0, bendingStiffness=0.4), **line)
    heavy = mbs.CreateMassPoint(mass=20, referencePosition=[1, -1, 0], gravity=[0, -9.81, 0])
    ends = [MarkerNodePosition(nodeNumber=cable["nodes"][-1]), MarkerBodyPosition(bodyNumber=heavy)]
    joint = {"markerNumbers": [mbs.AddMarker(end) for end in ends], "constrainedAxes": [1, 1, 0]}
    mbs.AddObject(SphericalJoint(**joint))
    start = {"initialVelocity": [0, 0.0 if kick else speed, 0]}
    light = mbs.CreateMassPoint(mass=mass, referencePosition=[3, 0, 0], create2D=True, **start)
    spring = {"stiffness": [stiffness, stiffness, 0], "itemNumbers": [mbs.CreateGround(), light]}
    mbs.CreateCartesianSpringDamper(**spring, localPosition0=[3, 0, 0])
    marker, width = mbs.AddMarker(MarkerBodyPosition(bodyNumber=light)), 0.02
    turn = 2.0 * np.pi / width

    def push(mbs, t, load):
        inside = kick <= t < kick + width
        return [0, mass * speed / width * (1.0 - np.cos(turn * (t - kick))) if inside else 0.0, 0]

    if kick:
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=push))
    place = exudyn.OutputVariableType.Position
    sensor = mbs.AddSensor(SensorBody(bodyNumber=light, storeInternal=True, outputVariableType=place))
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(END, 1, PERIOD))
    times, _, heights, _ = np.asarray(mbs.GetSensorStoredData(sensor)).T
    expected = speed / rate * np.sin(rate * times)
    if kick:
        since = [np.maximum(times - kick - begin, 0.0) for begin in (0.0, width)]
        waves = [(np.cos(turn * t) - np.cos(rate * t)) / (rate**2 - turn**2) for t in since]
        steps = [(1.0 - np.cos(rate * t)) / rate**2 for t in since]
        expected = speed / width * (steps[0] - waves[0] - steps[1] + waves[1])
    error = np.sqrt(((heights - expected) ** 2).mean()) / np.abs(expected).max()
    assert error < 0.01


def test_a_tether_in_orbit_takes_the_steps_of_one_that_only_turns(new_mbs, add_cable, add_sensor, solve):
    """All of it flies along, with 7.7 km/s, which pulls nothing."""

    def turning(speed):
        mbs, length, masses, turn, ends = new_mbs(), 100.0, [50.0, 10.0], 0.1, []
        section = InextensibleCable(massPerLength=0.01, bendingStiffness=0.01, axialStiffness=1e4)
        speeds = {"velocityStart": [0, speed, 0], "velocityEnd": [0, speed + turn * length, 0]}
        shape = CableShape.Line([0, 0, 0], [length, 0, 0], 4, **speeds)
        cable = add_cable(mbs, beamTemplate=section, shape=shape)
        for x, mass, node in zip([0, length], masses, cable["nodes"][::4], strict=True):
            start = {"referencePosition": [x, 0, 0], "initialVelocity": [0, speed + turn * x, 0]}
            end = mbs.CreateMassPoint(mass=mass, **start)
            ends.append(mbs.AddMarker(MarkerBodyPosition(bodyNumber=end)))
            joint = [ends[-1], mbs.AddMarker(MarkerNodePosition(nodeNumber=node))]
            mbs.AddObject(SphericalJoint(markerNumbers=joint, constrainedAxes=[1, 1, 0]))
        sensors = [add_sensor(mbs, node) for node in cable["nodes"]]
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(4.0, 4, 1.0))
        paths = [np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4] for sensor in sensors]
        return report["steps"], np.array(paths) - paths[0]

    (steps, path), (steps_in_orbit, path_in_orbit) = turning(0.0), turning(7700.0)
    assert steps_in_orbit == steps
    np.testing.assert_allclose(path_in_orbit, path, atol=1e-6)


def test_a_towed_cable_takes_the_steps_of_one_that_hangs(new_mbs, add_cable, solve):
    """Behind an aircraft, which climbs and falls, and flies with 80 m/s or not at all."""

    def resolving_step(speed):
        mbs = new_mbs()
        section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.05)
        shape = CableShape.Line([0, 0], [-60, 0], 6, velocityStart=[speed, 0], velocityEnd=[speed, 0])
        front = add_cable(mbs, beamTemplate=section, shape=shape)["nodes"][0]
        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))

        def along(mbs, t, item, offset):
            return speed * t

        def across(mbs, t, item, offset):
            return 1.0 - np.cos(t)

        for coordinate, motion in enumerate((along, across)):
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=front, coordinate=coordinate))
            joint = {"markerNumbers": [ground, marker], "offsetUserFunction": motion}
            mbs.AddObject(CoordinateConstraint(**joint))
        mbs.Assemble()
        return solve(mbs, settings=quiet_settings(0.1, 1, 0.1))["bounds"].accuracy

    assert resolving_step(80.0) == pytest.approx(resolving_step(0.0))


@pytest.mark.parametrize("floor", ["spring", "load"])
def test_a_rope_that_falls_on_a_floor_resolves_its_fall(new_mbs, add_cable, solve, floor):
    """What Exudyn evaluates may be hit, and stops it as fast as it comes: it is no flight then."""

    def bounds_of_step(speed):
        mbs = new_mbs()
        section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.01, axialStiffness=5e4)
        fall = {"velocityStart": [0, -speed], "velocityEnd": [0, -speed]}
        shape = CableShape.Line([0, 0], [2, 0.4], 8, **fall)
        node = add_cable(mbs, beamTemplate=section, shape=shape)["nodes"][0]
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))

        def push(mbs, t, item, stretch, rate, stiffness, damping, force):
            return min(stiffness * (stretch - 0.5), 0.0)

        def hold(mbs, t, load):
            return [0, max(-2e3 * (mbs.GetNodeOutput(node, POSITION)[1] + 0.5), 0.0), 0]

        if floor == "load":
            mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=hold))
        else:
            ground = mbs.CreateGround(referencePosition=[0, -1, 0])
            ends = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground)), marker]
            spring = {"stiffness": 2e3, "referenceLength": 0.5, "springForceUserFunction": push}
            mbs.AddObject(SpringDamper(markerNumbers=ends, **spring))
        mbs.Assemble()
        return solve(mbs, settings=quiet_settings(0.01, 1, 0.01))["bounds"]

    assert bounds_of_step(20.0).accuracy < 0.25 / (20.0 * 20.0)  # steps while a wave passes an element
    assert bounds_of_step(0.0).accuracy > 0.25 / (20.0 * 20.0)


def test_strains_at_the_start_do_not_shorten_the_step(weighed_cantilever):
    """They make axial waves, which steps need not resolve."""

    def resolving_step(strain):
        stretching = {"axialStiffness": 1e4, "axialDamping": 10.0, "referenceAxialStrain": strain}
        section = InextensibleCable(massPerLength=0.1, bendingStiffness=1.0, **stretching)
        return weighed_cantilever(section, 8, PERIOD)[1]["bounds"].accuracy

    assert resolving_step(0.05) == resolving_step(0.0)


@pytest.fixture
def pushed_cantilever(new_mbs, add_cable, add_sensor, solve):
    """(EI, force of time, settings) -> path of its end, where a mass is, from rest; and report."""

    def run(stiffness, force, **explicit):
        mbs = new_mbs()
        section = InextensibleCable(massPerLength=0.1, bendingStiffness=stiffness)
        line = {"positionEnd": [1, 0, 0], "numberOfElements": 8, "groundConstraintsStart": CLAMPED}
        cable = add_cable(mbs, beamTemplate=section, **line)
        mass = mbs.CreateMassPoint(mass=0.05, referencePosition=[1, 0, 0], gravity=[0, -9.81, 0])
        markers = [MarkerNodePosition(nodeNumber=cable["nodes"][-1]), MarkerBodyPosition(bodyNumber=mass)]
        tip, point = map(mbs.AddMarker, markers)
        mbs.AddObject(SphericalJoint(markerNumbers=[tip, point], constrainedAxes=[1, 1, 0]))
        load = mbs.AddLoad(LoadForceVector(markerNumber=tip, loadVector=[0, 0, 0]))

        def change(mbs, t):
            mbs.SetLoadParameter(load, "loadVector", [0, force(t), 0])
            return True

        mbs.SetPreStepUserFunction(change)
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        SolveEquilibrium(mbs)
        report = solve(mbs, settings=quiet_settings(0.5, 250, PERIOD), **explicit)
        return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4], report

    return run


def test_a_load_that_sets_in_late_is_not_taken_for_fast_motion(pushed_cantilever):
    """Its first steps have accelerations and hardly any velocity, after a long time at rest."""

    def late(t):
        return -1.0 if t > 0.2 else 0.0

    path, report = pushed_cantilever(1.0, late)
    fine, _ = pushed_cantilever(1.0, late, stepSize=report["stepSize"] / 8, massScaling=0.3)
    assert report["steps"] < 2000
    assert np.abs(path - fine).max() < 0.01 * np.ptp(fine[:, 1])


def test_a_cable_at_rest_is_not_taken_for_a_fast_one(swing):
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=0.1)
    path, report = swing(section, 8, CLAMPED, at_rest=True)
    assert report["stepSize"] > 0.5 * report["bounds"].accuracy
    assert np.ptp(path, axis=0).max() < 1e-6


@pytest.fixture
def shaken_loop(new_mbs, add_sensor, solve):
    """(settings) -> path of a plate of 2 kg that rests on a stiff half circle, and is shaken; and report."""

    def run(**explicit):
        mbs = new_mbs()
        turn = np.linspace(0.0, np.pi, 9)
        loop = CreateInextensibleCable(
            mbs,
            shape=CableShape(
                0.04 * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)]),
                np.column_stack([np.cos(turn), np.sin(turn)]),
            ),
            beamTemplate=InextensibleCable(massPerLength=0.2, bendingStiffness=1.5),
            groundConstraintsStart=CLAMPED,
            groundConstraintsEnd=[True, False, True, True],
        )
        plate = mbs.CreateMassPoint(mass=2.0, referencePosition=[0, 0.08, 0], create2D=True)
        AttachToBody(mbs, loop, "end", plate)
        marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=plate))

        def force(mbs, t, load):
            return [0, -20 + 4 * np.sin(75 * t) ** 2, 0]

        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=force))
        sensor = add_sensor(mbs, loop["nodes"][-1])
        mbs.Assemble()
        SolveEquilibrium(mbs)
        report = solve(mbs, settings=quiet_settings(0.5, 1, PERIOD), **explicit)
        return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:3], report

    return run


def test_a_bent_cable_that_rests_is_not_taken_for_one_that_springs_open(shaken_loop):
    """Its bending energy, set free, would make it as fast as 70 m/s."""
    path, report = shaken_loop()
    fine, _ = shaken_loop(stepSize=2e-5, massScaling=0.3)
    assert report["steps"] < 5000
    assert np.abs(path - fine).max() < 0.01 * np.ptp(fine, axis=0).max()


def hanging_rotor(spin, end, node_type=None):
    """Angular velocities (T, 3) [rad/s] of a rotor that hangs on a cable by the end of its axis; report.

    node_type: None: with a native cable.
    """
    mbs, gravity = exudyn.SystemContainer().AddSystem(), [0, 0, -9.81]
    template = ObjectANCFCable(massPerLength=0.05, bendingStiffness=0.002, axialStiffness=2e4)
    where = {"positionStart": [0, 0, 1], "positionEnd": [0, 0, 0], "numberOfElements": 8, "gravity": gravity}
    where["groundConstraintsStart"] = [True] * 3 + [False] * 3
    native = node_type is None
    create = GenerateBeamElementsAlongLine if native else partial(CreateInextensibleCable, extensible=True)
    cable = create(mbs, beamTemplate=template, **where)
    rotor = mbs.CreateRigidBody(
        inertia=InertiaCylinder(1000, 0.02, 0.12, axis=0),
        referencePosition=[0.05, 0, 0],
        initialAngularVelocity=[spin, 0, 0],
        gravity=gravity,
        nodeType=node_type or exudyn.NodeType.RotationEulerParameters,
    )
    hook = mbs.AddMarker(MarkerBodyPosition(bodyNumber=rotor, localPosition=[-0.05, 0, 0]))
    end_of_cable = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    mbs.AddObject(SphericalJoint(markerNumbers=[hook, end_of_cable]))
    kind = exudyn.OutputVariableType.AngularVelocity
    sensor = mbs.AddSensor(SensorBody(bodyNumber=rotor, outputVariableType=kind, storeInternal=True))
    mbs.Assemble()
    settings = quiet_settings(end, 40, end / 40)
    if native:
        settings.timeIntegration.numberOfSteps = round(end * 12 * spin)
        mbs.SolveDynamic(settings)
    report = {} if native else SolveExplicit(mbs, settings)
    return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:], report


@pytest.mark.parametrize(
    ("node_type", "spin", "end", "largest"),
    [("RotationEulerParameters", 150.0, 0.6, 0.005), ("RotationRxyz", 600.0, 0.4, 0.02)],
)
def test_steps_resolve_how_bodies_spin(node_type, spin, end, largest):
    """It hides from the accelerations of coordinates; angles are off by more than 100 % without it."""
    found, _ = hanging_rotor(spin, end, getattr(exudyn.NodeType, node_type))
    native, _ = hanging_rotor(spin, end)
    assert np.abs(found - native).max() < largest * np.ptp(native, axis=0).max()


def test_a_rotor_that_spins_for_long_does_not_shorten_the_steps_more_and_more():
    steps = [
        hanging_rotor(600.0, end, exudyn.NodeType.RotationEulerParameters)[1]["steps"] / end
        for end in (0.4, 4.0)
    ]
    assert steps[1] < 1.5 * steps[0]


def test_zhai_keeps_the_rule_of_the_paper(swing):
    _, report = swing(STIFF, 4, PINNED, end=0.01, integrator="Zhai")
    assert report["massScaling"] == 0.0 and report["decidedBy"] == "rule (37)"


@pytest.fixture
def spring_of_a_light_rope(new_mbs, add_cable, add_sensor, solve):
    """function -> way of the end of a weightless rope on a stiff spring, and report."""

    def run(function, **explicit):
        mbs = new_mbs()
        template = InextensibleCable(massPerLength=3.16, bendingStiffness=2.27e-5)
        line = {"positionEnd": [0.12, 0, 0], "numberOfElements": 7, "groundConstraintsStart": PINNED}
        node = add_cable(mbs, beamTemplate=template, gravity=[0, 0, 0], **line)["nodes"][-1]
        fixed = MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[0.18, 0.04, 0])
        ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)), mbs.AddMarker(fixed)]
        spring = SpringDamper(markerNumbers=ends, stiffness=181, damping=0.16, referenceLength=0.0719)
        if function == "spring":
            spring.springForceUserFunction = lambda mbs, t, item, u, v, k, d, f: k * u + d * v
        elif function == "prestep":
            mbs.SetPreStepUserFunction(lambda mbs, t: len(mbs.GetNodeOutput(node, POSITION)) == 3)
        mbs.AddObject(spring)
        sensor = add_sensor(mbs, node)
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(1.0, 10, PERIOD), **explicit)
        path = np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4]
        return path - path[0], report

    return run


@pytest.mark.parametrize("function", ["spring", "prestep"])
def test_a_fast_motion_is_resolved_from_its_start_though_functions_look(spring_of_a_light_rope, function):
    """Such a run cannot begin again: it was 23 % off before the step became shorter."""
    path, report = spring_of_a_light_rope(function)
    fine, _ = spring_of_a_light_rope("", stepSize=PERIOD / 128)
    assert np.abs(path - fine).max() < 0.05 * np.abs(fine).max()
    assert report["drift"]["energyLoss"] < 0.01


@pytest.mark.parametrize("seed", [3, 41])
def test_where_bending_bounds_a_step_among_bodies_the_mass_is_scaled_for_the_motion(seed):
    """It was scaled for its own step, which had to be half as long: 820 and 660 steps."""

    def run(period=0.02, **explicit):
        scene, settings = RandomScene(seed), quiet_settings(0.4, 20, period)
        with silence():
            report = SolveExplicit(scene.mbs, settings, ExplicitSettings(**explicit))
        return scene.paths(), report

    path, report = run()
    bounds, theta = report["bounds"], report["massScaling"]
    assert report["decidedBy"] == "bending" and report["steps"] <= 380
    assert 0.3 < theta <= 0.55
    assert theta * (0.7 * bounds.bending) ** 2 == pytest.approx(0.3 * bounds.accuracy**2, rel=0.04)
    exact, _ = run(stepSize=report["stepSize"] / 8)
    size = np.linalg.norm(exact - exact[0], axis=2).max()
    assert np.sqrt(((path - exact) ** 2).sum(axis=2).mean()) < 2e-3 * size
    _, often = run(period=4e-4)
    assert often["massScaling"] == 0.3 and often["decidedBy"] == "output period"


def test_a_mass_scaling_that_is_given_is_taken(swing):
    _, scaled = swing(STIFF, 25, PINNED, end=0.1, massScaling=0.26)
    assert scaled["massScaling"] == 0.26
    _, plain = swing(STIFF, 4, PINNED, end=0.01, massScaling=0.0)
    assert plain["massScaling"] == 0.0 and plain["stepSize"] < 1e-4


def test_a_load_shortens_the_step(new_mbs, add_pendulum, solve):
    """The tension that it may cause is counted: a hundred times the weight, a tenth of the step."""
    accuracies = []
    for force in (0.0, 100 * 9.81 * 0.0348 * 1.8):
        mbs = new_mbs()
        cable = add_pendulum(mbs)
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, -force, 0]))
        mbs.Assemble()
        accuracies.append(solve(mbs, 0.01)["bounds"].accuracy)
    assert accuracies[0] / accuracies[1] == pytest.approx(np.sqrt(101.0), rel=0.1)


def native(section, elements, damping, step):
    """Path of the free end of a native clamped cable, 1 m, stiff along its axis."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    template = ObjectANCFCable2D(
        massPerLength=section.massPerLength,
        bendingStiffness=section.bendingStiffness,
        bendingDamping=damping,
        axialStiffness=1e4,
        useReducedOrderIntegration=2,
    )
    cable = GenerateBeamElementsAlongLine(
        mbs,
        [0, 0, 0],
        [1, 0, 0],
        elements,
        beamTemplate=template,
        gravity=[0, -9.81, 0],
        groundConstraintsStart=CLAMPED,
    )
    sensor = mbs.AddSensor(
        exudyn.itemInterface.SensorNode(
            nodeNumber=cable["nodes"][-1],
            outputVariableType=exudyn.OutputVariableType.Position,
            storeInternal=True,
        )
    )
    mbs.Assemble()
    settings = quiet_settings(END, round(END / step), PERIOD)
    settings.timeIntegration.newton.relativeTolerance = 1e-5
    with silence():
        mbs.SolveDynamic(settings)
    return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4]


@pytest.mark.parametrize("ratio", [0.02, 0.1, 0.5, 1.0])  # D / EI [s]
def test_a_damped_cantilever_moves_as_a_native_one(swing, ratio, known_answer):
    """Explicitly, its damping would bound the step to 1e-6 s and less."""
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=1.0, bendingDamping=ratio)
    path, report = swing(section, 16, CLAMPED)
    assert report["steps"] < 5000
    expected = native(section, 16, ratio, 1e-3)
    error = np.abs(path - expected).max() / np.ptp(expected[:, 1])
    assert error < 0.01
    known_answer(f"damped cantilever, D = {ratio:g} EI, against a native cable", error)


def test_damping_that_shortens_the_step_is_said_before_the_run(new_mbs, add_pendulum, solve):
    """A mass point on a dashpot without mercy that Exudyn evaluates: 2 m / d bounds explicit steps."""

    def force(mbs, t, number, stretch, rate, stiffness, damping, offset):
        return stiffness * (stretch - 0.2 * t) + damping * rate

    def scene(**law):
        mbs = new_mbs()
        add_pendulum(mbs)
        point = mbs.CreateMassPoint(mass=1.0, referencePosition=[3, 0, 0], returnDict=True)
        ends = [mbs.CreateGround(), point["bodyNumber"]]
        spring = mbs.CreateSpringDamper(itemNumbers=ends, stiffness=100.0, damping=2e4, **law)
        mbs.Assemble()
        return mbs, point["nodeNumber"], spring

    mbs, node, _ = scene(springForceUserFunction=that_remembers(force))
    match = rf"damping of .*e\+04 1/s at node {node} .* bounds the step .* let a step function set"
    with pytest.warns(UserWarning, match=match):
        report = solve(mbs, 0.1, steps=20)
    assert report["stepSize"] < 1.1e-4
    pulled = mbs.GetNodeOutput(node, POSITION)[0] - 3.0

    mbs, node, spring = scene()
    mbs.SetPreStepUserFunction(
        lambda mbs, t: mbs.SetObjectParameter(spring, "referenceLength", 3 + 0.2 * t) or True
    )
    report = solve(mbs, 0.1, steps=20)
    assert report["stepSize"] > 1e-3
    assert mbs.GetNodeOutput(node, POSITION)[0] - 3.0 == pytest.approx(pulled, rel=0.02)


def test_rk4_says_what_bending_damping_does_to_its_step(swing):
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=1.0, bendingDamping=0.02)
    with pytest.warns(UserWarning, match=r"damping .* bounds the step .* under RK4 .* integrator='RATTLE'"):
        swing(section, 8, CLAMPED, end=1e-4, integrator="RK4")


def test_among_bodies_the_step_is_what_its_own_scaled_mass_allows(new_mbs, solve, monkeypatch):
    looks = []
    look = CoupledRun.largest_frequency
    monkeypatch.setattr(CoupledRun, "largest_frequency", lambda run, t: looks.append(t) or look(run, t))

    def scene():
        mbs = new_mbs()
        stiff = InextensibleCable(massPerLength=0.05, bendingStiffness=0.05)
        cable = CreateInextensibleCable(
            mbs, [0, 0, 0], [1, 0, 0], 10, stiff, [0, -9.81, 0], [True, True, False, False]
        )
        body = mbs.CreateMassPoint(mass=0.5, referencePosition=[1, 0, 0], gravity=[0, -9.81, 0])
        AttachToBody(mbs, cable, "end", body)
        mbs.Assemble()
        return mbs

    report = solve(scene(), 0.1, massScaling=0.3)
    assert report["decidedBy"] == "bending" and report["massScaling"] > 0.0 and len(looks) <= 3
    step, theta = report["stepSize"], report["massScaling"]
    again = solve(scene(), 0.1, stepSize=step, massScaling=theta)
    allowed = again["bounds"].safety * again["bounds"].stability_limit
    assert 0.97 * allowed < step < 1.03 * allowed


@pytest.fixture
def guided_beam(new_mbs, add_cable, solve):
    """(elements, settings) -> path of the middle of a beam on two supports that is let go, and report."""

    def run(elements, **explicit):
        mbs = new_mbs()
        beam = add_cable(
            mbs,
            positionEnd=[1, 0, 0],
            numberOfElements=elements,
            beamTemplate=InextensibleCable(massPerLength=0.1, bendingStiffness=5.0),
            gravity=[0, 0, 0],
            groundConstraintsStart=PINNED,
            groundConstraintsEnd=[False, True, False, False],
        )
        middle = beam["nodes"][elements // 2]
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=middle))
        load = mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, -5, 0]))
        position = exudyn.OutputVariableType.Position
        sensor = mbs.AddSensor(
            exudyn.itemInterface.SensorNode(
                nodeNumber=middle, outputVariableType=position, storeInternal=True
            )
        )
        mbs.Assemble()
        SolveEquilibrium(mbs)
        mbs.SetLoadParameter(load, "loadVector", [0, 0, 0])
        report = solve(mbs, settings=quiet_settings(0.5, 1, PERIOD), **explicit)
        return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4], report

    return run


def of_step_over_of_mesh(run, elements, finer):
    """Errors of a run at default settings."""
    path, report = run(elements)
    given = {"stepSize": report["stepSize"] / 6, "massScaling": report["massScaling"]}
    fine = run(elements, **given)[0]
    finest = run(finer, **given)[0]
    of_step, of_mesh = (np.linalg.norm(a - b, axis=1).max() for a, b in ((path, fine), (fine, finest)))
    return of_step / of_mesh


@pytest.mark.parametrize("elements", [4, 8, 16])
def test_bending_waves_are_resolved_by_the_step_as_by_the_mesh(guided_beam, elements):
    assert 0.25 < of_step_over_of_mesh(guided_beam, elements, 32) < 1.5


@pytest.mark.parametrize(("name", "elements", "finer"), [("power_line", 16, 32), ("vibrating_ring", 14, 28)])
def test_steps_of_a_scene_are_as_accurate_as_its_mesh(name, elements, finer):
    scene = load_scene(name)

    def run(number, **explicit):
        report = inextensible_case(scene, Inextensible(number, ExplicitSettings(**explicit)))
        path = sensor_trajectory(
            solved(scene, Inextensible(number, ExplicitSettings(**explicit))), scene.main_point
        )
        return path.positions, {"stepSize": report.step_size, **report.details}

    assert 0.4 < of_step_over_of_mesh(run, elements, finer) < 1.5


@pytest.mark.parametrize("theta", [0.0, 0.3])
def test_errors_of_step_and_mesh_are_those_of_a_discretised_wave(theta):
    """Of a beam without tension, periodic: two coordinates a node, from the matrices of textbooks."""
    stiffness, length, number, h = 7.0, 0.2, 3.0, 2e-4
    mass = (
        length / 420 * np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    )
    bend = stiffness / length * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    wave = np.vstack([np.eye(2), np.exp(1j * number * length) * np.eye(2)])
    m, k = (wave.conj().T @ matrix @ wave for matrix in (mass, bend / length**2))
    exact = stiffness * number**4
    of_mesh = np.linalg.eigvals(np.linalg.solve(m, k)).real.min() / exact - 1.0
    scaled = h**2 * exact / (1.0 + theta * h**2 * exact)
    of_step = (2.0 * np.arcsin(0.5 * np.sqrt(scaled)) / h) ** 2 / exact - 1.0
    found = _errors_of_waves(np.array([0.0, stiffness, length, theta]), exact, h**2)
    assert found == pytest.approx((abs(of_step), of_mesh), rel=0.02)
    without_mesh = _errors_of_waves(np.array([0.0, 0.0, 0.0, theta]), exact, h**2)
    assert without_mesh == pytest.approx((abs(of_step), 0.0), rel=0.02)


LONG_RUN = r"node \d+ 'node\d+' vibrates at .* rad/s, so that the run takes .*e\+\d+ steps of .* s: "


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_run_that_axial_waves_of_native_cables_make_long_is_told_of_before(mbs, solve, dimension):
    """And the remedy helps."""
    arguments = {
        "positionStart": [0, 0, 0],
        "positionEnd": [1.8, 0, 0],
        "numberOfElements": 4,
        "beamTemplate": [ObjectANCFCable2D, ObjectANCFCable][dimension - 2](
            massPerLength=0.05, bendingStiffness=0.1, axialStiffness=2e5
        ),
        "gravity": [0, -9.81, 0],
    }
    with silence():
        GenerateBeamElementsAlongLine(mbs, **arguments)
    mbs.Assemble()
    said = LONG_RUN + r"let a cable .* object \d+ 'object\d+' \(ObjectANCFCable.*by ReplaceNativeCables"
    with pytest.raises(UserWarning, match=said):
        solve(mbs, settings=quiet_settings(2.0, 100, 0.1))
    ReplaceNativeCables(mbs)
    mbs.Assemble()
    assert solve(mbs, settings=quiet_settings(2.0, 100, 0.1))["steps"] < 5000


def test_a_run_that_a_stiff_spring_makes_very_long_is_told_of_before(mbs, add_pendulum, solve):
    """One that Exudyn evaluates; others are implicit, and take the steps of joints."""

    def law(mbs, t, number, stretch, rate, stiffness, damping, offset):
        return stiffness * stretch

    cable = add_pendulum(mbs)
    ground = mbs.CreateGround(referencePosition=[1.8, 1, 0])
    markers = [
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground)),
        mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1])),
    ]
    spring = mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=1.0, stiffness=1e12))
    mbs.Assemble()
    assert solve(mbs, settings=quiet_settings(0.1, 1, 0.1))["steps"] < 1000
    mbs.SetObjectParameter(spring, "springForceUserFunction", that_remembers(law))
    with pytest.raises(UserWarning, match=LONG_RUN + "let what is so stiff there be softer"):
        solve(mbs, settings=quiet_settings(10.0, 100, 0.1))
