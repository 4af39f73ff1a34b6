"""SolveEquilibrium: what it finds is the stable state in which a following run stays."""

import math

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SensorNode,
    SensorObject,
    SphericalJoint,
)

from exudyn_inext import (
    AddPointMass,
    CableShape,
    CreateInextensibleCable,
    CreatePrescribedMotion,
    EquilibriumError,
    InextensibleCable,
    InputError,
    SceneError,
    SolveEquilibrium,
    StaticSettings,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import hang, load_node, native_cable

PIN, CLAMP = [True, True, False, False], [True, True, True, True]
SPAN, LENGTH = 1.2, 1.8


def parabola(number=10, span=SPAN, sag=0.5):
    """A shape near that of a hanging cable of the length `LENGTH`, which it does not have."""
    x = np.linspace(0.0, span, number + 1)
    shape = -4.0 * sag * x * (span - x) / span**2
    slope = np.stack([np.ones(number + 1), -4.0 * sag * (span - 2.0 * x) / span**2], axis=1)
    return CableShape(
        positions=np.stack([x, shape], axis=1),
        slopes=slope / np.linalg.norm(slope, axis=1)[:, None],
        lengthReference="straight",
    )


@pytest.fixture
def add_hanging(add_cable):
    """A cable that hangs between two pins; returns its nodes."""

    def add(mbs, number=10, **changes):
        both = {"groundConstraintsStart": PIN, "groundConstraintsEnd": PIN}
        return add_cable(mbs, shape=parabola(number), **(both | changes))["nodes"]

    return add


@pytest.fixture
def drift(solve, coordinates):
    """(mbs, nodes) -> how far a cable moves within 0.5 s [m]."""

    def measure(mbs, nodes, **settings):
        before = coordinates(mbs, nodes)
        solve(mbs, 0.5, steps=5, **settings)
        return np.abs(coordinates(mbs, nodes) - before).max()

    return measure


def test_run_from_the_equilibrium_stays_at_rest(mbs, add_hanging, drift, coordinates):
    nodes = add_hanging(mbs)
    mbs.Assemble()
    before = coordinates(mbs, nodes)
    report = SolveEquilibrium(mbs)
    assert np.abs(coordinates(mbs, nodes) - before).max() > 1e-3
    assert report["success"]
    assert report["residual"] < 1e-8
    assert report["violation"] < 1e-10
    assert report["smallestEigenvalue"] > 0.0
    assert drift(mbs, nodes) < 1e-8


@pytest.mark.parametrize("axial_stiffness", [None, 5e7])
def test_a_line_in_coordinates_of_a_map_comes_to_rest_as_beside_the_origin(mbs, axial_stiffness):
    def rest(place):
        shape = CableShape.Catenary(place, np.add(place, [280, 100, 20]), 320.0, 20, gravity=[0, 0, -1])
        section = InextensibleCable(1.5, 500.0, axialStiffness=axial_stiffness)
        pinned = {f"groundConstraints{end}": [True] * 3 + [False] * 3 for end in ("Start", "End")}
        nodes = CreateInextensibleCable(
            mbs, beamTemplate=section, shape=shape, gravity=[0, 0, -9.81], **pinned
        )["nodes"]
        mbs.Assemble()
        SolveEquilibrium(mbs)
        found = mbs.GetNodeOutput(nodes[10], exudyn.OutputVariableType.Position) - place
        mbs.Reset()
        return found

    np.testing.assert_allclose(rest(np.array([4e5, 5.3e6, 100.0])), rest(np.zeros(3)), atol=1e-7)


def test_result_survives_a_new_assembly(mbs, add_hanging, coordinates, drift):
    nodes = add_hanging(mbs)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    found = coordinates(mbs, nodes)
    mbs.Assemble()
    np.testing.assert_allclose(coordinates(mbs, nodes), found, atol=1e-14)
    assert drift(mbs, nodes) < 1e-8


def test_velocities_are_set_to_rest_and_kept_by_whoever_follows_the_warning(mbs, add_cable, drift):
    shape = CableShape.Line([0, 0, 0], [0, -1.8, 0], 5, velocityEnd=[2.0, 0, 0])
    nodes = add_cable(mbs, shape=shape, groundConstraintsStart=PIN)["nodes"]
    mbs.Assemble()
    before = mbs.systemData.GetODE2Coordinates_t(exudyn.ConfigurationType.Initial)
    with pytest.warns(UserWarning, match="set the initial velocities of mbs to zero"):
        SolveEquilibrium(mbs)
    assert drift(mbs, nodes) < 1e-8
    mbs.Assemble()
    assert drift(mbs, nodes) < 1e-8
    SolveEquilibrium(mbs)
    mbs.systemData.SetODE2Coordinates_t(before, exudyn.ConfigurationType.Initial)
    assert drift(mbs, nodes) > 1e-2


def test_lengths_are_those_of_the_elements_where_the_shape_is_only_near(mbs, add_hanging, coordinates):
    shape = parabola()
    lengths = np.linalg.norm(np.diff(shape.positions, axis=0), axis=1)
    nodes = add_hanging(mbs)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    q = coordinates(mbs, nodes)
    chords = np.linalg.norm(np.diff(q[:, 0], axis=0), axis=1)
    np.testing.assert_allclose(np.linalg.norm(q[:, 1], axis=1), 1.0, atol=1e-10)
    assert np.abs(chords / lengths - 1.0).max() < 0.02


def test_load_steps_lead_to_the_same_state(new_mbs, add_hanging, coordinates):
    ends = []
    for steps in (1, 4):
        mbs = new_mbs()
        nodes = add_hanging(mbs)
        load_node(mbs, nodes[3], [3.0, -2.0, 0.0])
        mbs.Assemble()
        SolveEquilibrium(mbs, staticSettings=StaticSettings(loadSteps=steps))
        ends.append(coordinates(mbs, nodes))
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_cantilever_agrees_with_the_native_static_solution(new_mbs, add_cable, coordinates, dim):
    ours, native = new_mbs(), new_mbs()
    clamp = {"groundConstraintsStart": [True] * (2 * dim)}
    nodes = add_cable(ours, numberOfElements=16, dimension=dim, **clamp)["nodes"]
    theirs = native_cable(native, dim, 32, axial_stiffness=1e5, **clamp)["nodes"]
    for mbs, last in ((ours, nodes[-1]), (native, theirs[-1])):
        load_node(mbs, last, [0.02, 0.03, 0.0 if dim == 2 else 0.05])
        mbs.Assemble()
    SolveEquilibrium(ours)
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.staticSolver.numberOfLoadSteps = 10
    settings.staticSolver.verboseMode = 0
    with silence():
        native.SolveStatic(settings)
    tip = np.array(native.GetNodeOutput(theirs[-1], exudyn.OutputVariableType.Position))[:dim]
    found = coordinates(ours, nodes)[-1, 0]
    assert found[1] < -0.8
    np.testing.assert_allclose(found, tip, atol=2e-4)


def test_every_cable_finds_its_own_equilibrium(mbs, add_cable, add_hanging, coordinates, drift):
    """A chain that hangs straight down: its lowest frequency is j_0 / 2 sqrt(g / L)."""
    soft = InextensibleCable(massPerLength=0.03, bendingStiffness=1e-5)
    down = {"positionEnd": [0, -1.8, 0], "groundConstraintsStart": PIN}
    chain = add_cable(mbs, beamTemplate=soft, numberOfElements=20, **down)["nodes"]
    hanging = add_hanging(mbs)
    mbs.Assemble()
    report = SolveEquilibrium(mbs)
    eigenvalues = [row["smallestEigenvalue"] for row in report["cables"]]
    assert eigenvalues[0] == pytest.approx((0.5 * 2.404825557695773) ** 2 * 9.81 / 1.8, rel=1e-3)
    assert report["smallestEigenvalue"] == min(eigenvalues)
    for nodes, row in zip((chain, hanging), report["cables"], strict=True):
        np.testing.assert_allclose(coordinates(mbs, nodes), row["coordinates"], atol=1e-14)
    assert max(drift(mbs, nodes) for nodes in (chain, hanging)) < 1e-7


def test_inverted_pendulum_swings_down_to_hang(mbs, add_cable, coordinates):
    nodes = add_cable(mbs, positionEnd=[0, 1.8, 0], groundConstraintsStart=PIN)["nodes"]
    mbs.Assemble()
    SolveEquilibrium(mbs)
    np.testing.assert_allclose(coordinates(mbs, nodes)[-1], [[0.0, -1.8], [0.0, -1.0]], atol=1e-8)


def test_cable_on_a_hanger_comes_to_rest_below_it(mbs, add_cable, coordinates, drift):
    nodes = add_cable(mbs, numberOfElements=10, groundConstraintsStart=PIN)["nodes"]
    hang(mbs, nodes[-1], [1.5, 0.3, 0.0], 0.3)
    mbs.Assemble()
    report = SolveEquilibrium(mbs)
    q = coordinates(mbs, nodes)
    rod = q[-1, 0] - [1.5, 0.3]
    assert np.linalg.norm(rod) == pytest.approx(0.3, abs=1e-11)
    assert rod[1] < -0.2
    assert report["smallestEigenvalue"] > 0.0
    assert drift(mbs, nodes) < 1e-8


@pytest.mark.parametrize("start", [(0, 1, 0), (1, 0, 0), (0, -1, 0)], ids=["top", "side", "bottom"])
def test_ring_that_hangs_at_a_node_is_the_oval_of_the_textbook(mbs, add_cable, start):
    """Roark: a thin ring under its weight becomes (pi^2 / 4 - 2) w R^4 / EI higher and narrower."""
    radius, stiffness = 0.5, 10.0
    weight = 1e-3 * stiffness / radius**3
    template = InextensibleCable(massPerLength=1.0, bendingStiffness=stiffness)
    shape = CableShape.Circle([0, 0], radius, 24, start=start)
    held = {"beamTemplate": template, "gravity": [0, -weight, 0], "groundConstraintsStart": PIN}
    add_cable(mbs, shape=shape, **held)
    mbs.Assemble()
    (row,) = SolveEquilibrium(mbs)["cables"]
    width, height = np.ptp(row["coordinates"][:, 0], axis=0) - 2.0 * radius
    unit = weight * radius**4 / stiffness
    assert row["coordinates"][12, 0, 1] == pytest.approx(row["coordinates"][0, 0, 1] - 2 * radius, abs=1e-2)
    assert width == pytest.approx(-(2.0 - 0.5 * np.pi) * unit, rel=2e-3)
    assert height == pytest.approx((0.25 * np.pi**2 - 2.0) * unit, rel=2e-3)


def test_moving_support_is_where_it_is_at_the_start_time(mbs, add_cable, coordinates):
    nodes = add_cable(mbs, numberOfElements=8, groundConstraintsStart=PIN)["nodes"]
    CreatePrescribedMotion(mbs, nodes[-1], lambda t: [1.8 - t, 0.1 * t])
    mbs.Assemble()
    settings = quiet_settings(1.0, 1)
    settings.timeIntegration.startTime = 0.5
    assert SolveEquilibrium(mbs, settings)["success"]
    np.testing.assert_allclose(coordinates(mbs, nodes)[-1, 0], [1.3, 0.05], atol=1e-11)


def loaded_step_by_step(mbs, made, solve, file):
    """Rows of a sensor of the tip, of one of a support's force, and times in the solution file."""
    tip = made["nodes"][-1]
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=tip))
    load = mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0]))
    kinds = exudyn.OutputVariableType
    place = SensorNode(nodeNumber=tip, storeInternal=True, outputVariableType=kinds.Position)
    force = SensorObject(
        objectNumber=made["constraintObjects"][1], storeInternal=True, outputVariableType=kinds.Force
    )
    sensors = [mbs.AddSensor(place), mbs.AddSensor(force)]
    mbs.Assemble()
    settings = quiet_settings(1.0, 1)
    settings.solution.file.write, settings.solution.file.name = True, str(file)
    settings.solution.file.writeInitialValues = False
    for step in range(3):
        mbs.SetLoadParameter(load, "loadVector", [0, -0.02 * (step + 1), 0])
        settings.staticSolver.loadStepStart = step
        solve(mbs, settings)
        settings.solution.file.append = settings.solution.sensors.append = True
        settings.solution.file.writeHeader = False
    stored = [np.array(mbs.GetSensorStoredData(sensor))[-3:] for sensor in sensors]
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    return [*stored, np.array([float(line.split(",")[0]) for line in lines])]


def test_equilibria_are_written_as_by_the_native_static_solver(new_mbs, add_cable, tmp_path):
    """One after the other, in the same solution file and sensors, of cables of EA = 1e5 N."""
    ours, native = new_mbs(), new_mbs()
    clamp = {"groundConstraintsStart": [True] * 4}
    made = add_cable(ours, numberOfElements=16, dimension=2, **clamp)
    theirs = native_cable(native, 2, 32, axial_stiffness=1e5, **clamp)

    def solve_static(mbs, settings):
        mbs.SolveStatic(settings, updateInitialValues=True)

    with silence():
        found = loaded_step_by_step(ours, made, SolveEquilibrium, tmp_path / "ours.txt")
        expected = loaded_step_by_step(native, theirs, solve_static, tmp_path / "native.txt")
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(own, other, atol=1e-3)
    assert found[1].shape == (3, 2) and found[2].shape == (3,)
    assert SolveEquilibrium(ours)["success"]  # and writes nothing
    assert len(ours.GetSensorStoredData(1)) == 3


# ------------------------------------------------------------------- refusals


def test_what_cannot_be_solved_is_refused(new_mbs, add_pendulum):
    mbs = new_mbs()
    add_pendulum(mbs)
    with pytest.raises(SceneError, match="not assembled"):
        SolveEquilibrium(mbs, autoAssemble=False)
    mbs.CreateMassPoint(referencePosition=[1, 0, 0], mass=1.0)
    mbs.Assemble()
    with pytest.raises(SceneError, match="MassPoint"):
        SolveEquilibrium(mbs)
    native = new_mbs()
    native_cable(native, 2, 2)
    native.Assemble()
    with pytest.raises(SceneError, match=r"no inextensible cable: use mbs\.SolveStatic"):
        SolveEquilibrium(native)


def shifted_support(mbs, node, shift):
    """A native constraint that holds a position away from its reference."""
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for axis, offset in enumerate(shift):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker], offset=offset))


@pytest.mark.parametrize(
    ("hold", "distance", "reach"),
    [
        (lambda mbs, node: hang(mbs, node, [2.2, 0.0, 0.0], 0.3), "2.2", "2.1"),
        (lambda mbs, node: shifted_support(mbs, node, [0.2, 0.1]), "2.002498", "1.8"),
    ],
    ids=["hanger", "shifted"],
)
def test_supports_out_of_reach_are_refused(mbs, add_pendulum, contents, hold, distance, reach):
    nodes = add_pendulum(mbs)["nodes"]
    hold(mbs, nodes[-1])
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(SceneError, match=rf"{distance}.* m apart, .* reaches {reach} m only"):
        SolveEquilibrium(mbs)
    assert contents(mbs) == before


def test_without_a_stable_equilibrium_the_last_state_is_reported(mbs, add_cable, contents):
    add_cable(mbs)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(EquilibriumError, match=r"after .* iterations .* add supports") as refusal:
        SolveEquilibrium(mbs)
    report = refusal.value.report
    assert not report["success"]
    (row,) = report["cables"]
    assert row["coordinates"].shape == (6, 2, 2)
    assert np.isfinite(row["coordinates"]).all()
    assert contents(mbs) == before


def test_search_that_is_cut_off_reports_its_figures(mbs, add_hanging, contents):
    add_hanging(mbs)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(EquilibriumError, match="no stable equilibrium within reach") as refusal:
        SolveEquilibrium(mbs, staticSettings=StaticSettings(maxIterations=1))
    assert refusal.value.report["iterations"] == 1
    assert refusal.value.report["residual"] > 1e-6
    assert contents(mbs) == before


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        *[
            ({"tolerance": x}, "tolerance = .*: must be a finite number > 0")
            for x in (0.0, -1.0, math.nan, "small")
        ],
        *[
            ({name: x}, f"{name} = .*: must be an integer of at least 1")
            for name in ("maxIterations", "loadSteps")
            for x in (0, 2.5, True, None)
        ],
    ],
)
def test_bad_settings_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        StaticSettings(**changes)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stiffness", [1e3, 1e5, 1e7, 1e9])
def test_stiff_cables_are_as_easy_as_inextensible_ones(add_cable, new_mbs, stiffness, dimension):
    """A cantilever that falls by nine tenths of its length; EA of ropes, wires and rods [N]."""
    reports, section = [], {"massPerLength": 0.5, "bendingStiffness": 2.0}
    for axial in (None, stiffness):
        mbs = new_mbs()
        template = InextensibleCable(**section, axialStiffness=axial)
        clamp = [True] * 2 * dimension
        line = {"positionEnd": [2.0, 0.0, 0.0], "numberOfElements": 16, "gravity": [0.0, -9.81, 0.0]}
        add_cable(mbs, beamTemplate=template, dimension=dimension, groundConstraintsStart=clamp, **line)
        mbs.Assemble()
        reports.append(SolveEquilibrium(mbs))
    rigid, found = reports
    assert found["iterations"] <= 1.5 * rigid["iterations"]
    places = [report["cables"][0]["coordinates"][:, 0] for report in reports]
    np.testing.assert_allclose(*places, atol=20.0 / stiffness + 2e-5)
    tolerance = 10.0 / stiffness + 2e-3  # lengths between nodes are held a little otherwise
    assert found["smallestEigenvalue"] == pytest.approx(rigid["smallestEigenvalue"], rel=tolerance)


def test_flexible_stiff_cables_in_space_are_stable(add_cable, mbs):
    """EA is 5e12 EI / L^2: round-off of the solves must not count as an eigenvalue below zero."""
    template = InextensibleCable(massPerLength=1.0, bendingStiffness=0.2, axialStiffness=5e9)
    line = {"positionEnd": [12.0, 3.0, -6.0], "numberOfElements": 16, "gravity": [3.0, -8.0, 5.0]}
    clamp = {"groundConstraintsStart": [True] * 6, "dimension": 3}
    nodes = add_cable(mbs, beamTemplate=template, **line, **clamp)["nodes"]
    mbs.Assemble()
    found = SolveEquilibrium(mbs)
    assert 0.0 < found["smallestEigenvalue"] < 10.0  # a chain: some 1.4 g / L
    tip = mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position)
    down = np.array(line["gravity"]) / np.linalg.norm(line["gravity"])
    assert np.linalg.norm(tip) > 0.95 * np.linalg.norm(line["positionEnd"])
    assert tip @ down > 0.95 * np.linalg.norm(tip)


def loaded_across(add_cable, mbs, template, **shape):
    both = {"groundConstraintsStart": PIN, "groundConstraintsEnd": PIN}
    add_cable(mbs, beamTemplate=template, gravity=[0.0, -9.81, 0.0], **both, **shape)
    mbs.Assemble()
    return SolveEquilibrium(mbs)


def test_a_straight_cable_between_supports_needs_its_axial_stiffness(add_cable, new_mbs):
    section = {"massPerLength": 0.5, "bendingStiffness": 0.01}
    line = {"positionEnd": [2.0, 0.0, 0.0], "numberOfElements": 8}
    said = r"cable .* is straight between the supports of nodes 0 and 8, .*: give it its axialStiffness"
    with pytest.raises(EquilibriumError, match=said):
        loaded_across(add_cable, new_mbs(), InextensibleCable(**section), **line)
    template = InextensibleCable(**section, axialStiffness=1e4)
    assert loaded_across(add_cable, new_mbs(), template, **line)["success"]


def test_a_beam_that_turns_inside_out_is_named(add_cable, mbs):
    """Pressed to a fifth of its length by its supports and its own weight."""
    template = InextensibleCable(massPerLength=0.5, bendingStiffness=1.0, axialStiffness=60.0)
    shape = CableShape.Catenary([0, 0, 0], [0.3, 0, 0], 1.0, 16)
    with pytest.raises(EquilibriumError, match=r"is compressed at node \d+ to 0\.2\d* of its length"):
        loaded_across(add_cable, mbs, template, shape=shape)


def test_an_end_that_its_weight_folds_back_is_named_with_what_keeps_it_straight(new_mbs):
    """Eight elements of a limp cable: the end would rest a quarter of an element too high."""

    def place(loaded):
        mbs = new_mbs()
        limp = InextensibleCable(massPerLength=0.5, bendingStiffness=1e-6)
        ends = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": 8}
        cable = CreateInextensibleCable(
            mbs, **ends, beamTemplate=limp, gravity=[0, -9.81, 0], groundConstraintsStart=PIN
        )
        if loaded:
            AddPointMass(mbs, cable, 1.0, 0.2 * 0.5 / 8)
        mbs.Assemble()
        SolveEquilibrium(mbs)
        return mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position)

    with pytest.warns(
        UserWarning, match=r"node 8, .* of 0.125 m .*\(limit 0.0235 m\).*0.031 m off.*AddPoint"
    ):
        assert place(loaded=False)[1] == pytest.approx(-1.0 + 0.255 / 8, abs=1e-4)
    np.testing.assert_allclose(place(loaded=True), [0, -1, 0], atol=1e-6)


def test_a_stiff_chain_that_hangs_straight_leaves_its_unstable_equilibrium(mbs):
    """Its last slope turns without a stretch: along a straight line it would turn by 1e-4 at most."""
    limp = InextensibleCable(massPerLength=0.5, bendingStiffness=1e-6, axialStiffness=1e5)
    ends = {"positionStart": [0, 0, 0], "positionEnd": [0, -1, 0], "numberOfElements": 24}
    CreateInextensibleCable(mbs, **ends, beamTemplate=limp, gravity=[0, -9.81, 0], groundConstraintsStart=PIN)
    mbs.Assemble()
    with pytest.warns(UserWarning, match="folds back at node 24"):
        report = SolveEquilibrium(mbs)
    assert report["smallestEigenvalue"] > 1.0


@pytest.mark.parametrize("length", [1e-3, 1e-2, 1e3])
@pytest.mark.parametrize("has_mass", [False, True])
def test_a_cable_of_any_size_swings_down_to_hang(new_mbs, coordinates, length, has_mass):
    """Slopes turn as far in a cable of 1 mm as in one of 1 m."""

    def places(size):
        mbs = new_mbs()
        section = InextensibleCable(massPerLength=0.1 * size**2, bendingStiffness=1e-2 * size**5)
        start = {"positionStart": [0, 0, 0], "positionEnd": [0.6 * size, 0.8 * size, 0]}
        hung = {"gravity": [0, -9.81, 0], "groundConstraintsStart": PIN}
        nodes = CreateInextensibleCable(mbs, **start, numberOfElements=6, beamTemplate=section, **hung)[
            "nodes"
        ]
        if has_mass:
            mass = mbs.CreateMassPoint(mass=0.1 * size**3, referencePosition=start["positionEnd"])
            own = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mass))
            tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[-1]))
            mbs.AddObject(SphericalJoint(markerNumbers=[own, tip], constrainedAxes=[1, 1, 0]))
        mbs.Assemble()
        with silence():
            SolveEquilibrium(mbs)
        kind = exudyn.OutputVariableType.Position
        return np.array([mbs.GetNodeOutput(node, kind) for node in nodes]) / size

    np.testing.assert_allclose(places(length), places(1.0), atol=1e-8)
    assert places(length)[-1, 1] == pytest.approx(-1.0)
