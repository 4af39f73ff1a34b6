"""Rings, hangers, rollers and moved nodes, against native cables and independent trajectories."""

from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadForceVector,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
)

from exudyn_inext import (
    CableShape,
    CreatePrescribedMotion,
    DivergenceError,
    InextensibleCable,
    InputError,
    RedundantConstraintError,
    SceneError,
)
from reference_models.data import reference_trajectory
from reference_models.scenes import load_scene
from tests.exudyn_binding.items import SECTION, hang, native_cable, solve_native, trajectory


def largest_distance(new_mbs, add_sensor, build_ours, build_native, solve, end_time):
    """Between the tip of our cable and of a native one, over the whole run."""
    ours, native = new_mbs(), new_mbs()
    tip = add_sensor(ours, build_ours(ours)[-1])
    native_tip = add_sensor(native, build_native(native)[-1])
    ours.Assemble()
    native.Assemble()
    solve(ours, end_time)
    solve_native(native, end_time)
    return np.abs(trajectory(ours, tip) - trajectory(native, native_tip)).max()


def made_of(stiffness):
    """Arguments of an inextensible cable, or one that stretches; and of its native twin."""
    if stiffness is None:
        return {}, {}
    native = {"section": SECTION | {"useReducedOrderIntegration": 2}, "axial_stiffness": stiffness}
    return {"beamTemplate": InextensibleCable(**SECTION, axialStiffness=stiffness)}, native


@pytest.mark.parametrize(("dim", "stiffness"), [(2, None), (3, 50.0)])  # each is compiled for itself
def test_cable_on_a_hanger_moves_like_a_native_one(new_mbs, add_cable, add_sensor, solve, dim, stiffness):
    anchor = [0.0, 0.3, 0.0] if dim == 2 else [0.0, 0.3, 0.4]
    length = float(np.linalg.norm(anchor))
    own, twin = made_of(stiffness)

    def ours(mbs):
        nodes = add_cable(mbs, numberOfElements=10, dimension=dim, **own)["nodes"]
        hang(mbs, nodes[0], anchor, length)
        return nodes

    def native(mbs):
        nodes = native_cable(mbs, dim, 20, **twin)["nodes"]
        hang(mbs, nodes[0], anchor, length)
        return nodes

    assert largest_distance(new_mbs, add_sensor, ours, native, solve, 0.8) < 3e-3


def shake(t):
    return [0.1 * (1.0 - np.cos(6.0 * t)), 0.05 * np.sin(3.0 * t) ** 2]


def shake_rate(t):
    return [0.6 * np.sin(6.0 * t), 0.15 * np.sin(6.0 * t)]


def shake_rate_of_change(t):
    return [3.6 * np.cos(6.0 * t), 0.9 * np.cos(6.0 * t)]


def native_shaken(mbs, **twin):
    nodes = native_cable(mbs, 2, 20, **twin)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], shake, shake_rate)
    return nodes


@pytest.mark.parametrize(
    "derivatives", [(), (shake_rate,), (shake_rate, shake_rate_of_change)], ids=["0", "1", "2"]
)
def test_shaken_cable_moves_like_a_native_one(new_mbs, add_cable, add_sensor, solve, derivatives):
    def ours(mbs):
        nodes = add_cable(mbs, numberOfElements=10)["nodes"]
        CreatePrescribedMotion(mbs, nodes[0], shake, *derivatives)
        return nodes

    assert largest_distance(new_mbs, add_sensor, ours, native_shaken, solve, 0.8) < 3e-3


def test_shaken_cable_that_stretches_moves_like_a_native_one(new_mbs, add_cable, add_sensor, solve):
    own, twin = made_of(20.0)

    def ours(mbs):
        nodes = add_cable(mbs, numberOfElements=10, **own)["nodes"]
        CreatePrescribedMotion(mbs, nodes[0], shake)
        return nodes

    native = partial(native_shaken, **twin)
    assert largest_distance(new_mbs, add_sensor, ours, native, solve, 0.8) < 1e-3


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
def test_moved_node_is_where_it_shall_be(mbs, add_cable, add_sensor, solve, integrator):
    nodes = add_cable(mbs)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], shake, shake_rate, shake_rate_of_change)
    outputs = [add_sensor(mbs, nodes[0], output) for output in ("Position", "Velocity", "Acceleration")]
    mbs.Assemble()
    report = solve(mbs, 1.0, integrator=integrator)
    tolerances = {
        "RATTLE": (1e-9, 1e-8, 2e-2),
        "RK4": (1e-7, 1e-6, 2e-2),
        "Zhai": (1e-5, 1e-3, 2e-2),
    }[integrator]
    for sensor, function, tolerance in zip(
        outputs, (shake, shake_rate, shake_rate_of_change), tolerances, strict=True
    ):
        stored = trajectory(mbs, sensor)
        expected = np.array([function(t) for t in stored[:, 0]])
        first = 1 if function is shake_rate_of_change else 0
        assert np.abs(stored[first:, 1:3] - expected[first:]).max() < tolerance
    assert "in one compiled call" in report["path"]


def test_offset_user_function_of_a_native_constraint_moves_a_node(mbs, add_cable, add_sensor, solve):
    nodes = add_cable(mbs, groundConstraintsStart=[False, True, False, False])["nodes"]
    pair = [(mbs.AddNode(NodePointGround()), 0), (nodes[0], 0)]
    markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=c)) for n, c in pair]
    times = []

    def offset(mbs, t, item, constant):
        times.append(t)
        return constant + 0.1 * (1.0 - np.cos(6.0 * t)) - 0.25

    mbs.AddObject(CoordinateConstraint(markerNumbers=markers, offset=0.25, offsetUserFunction=offset))
    sensor = add_sensor(mbs, nodes[0])
    mbs.Assemble()
    report = solve(mbs, 0.5)
    stored = trajectory(mbs, sensor)
    assert stored[:, 1] == pytest.approx(0.1 * (1.0 - np.cos(6.0 * stored[:, 0])), abs=1e-7)
    assert np.abs(stored[:, 2]).max() < 1e-9
    assert max(times) >= 0.5
    assert "one call for each of Exudyn's steps" in report["path"]


def test_exudyn_asks_a_given_motion_for_its_place_once(mbs, add_cable):
    times = []

    def place(t):
        times.append(t)
        return [0.3 + 0.1 * t**2, 0.0]

    node = add_cable(mbs, positionStart=[0.3, 0, 0], positionEnd=[2.1, 0, 0])["nodes"][0]
    number = CreatePrescribedMotion(mbs, node, place)["constraintObjects"][0]
    offset = mbs.GetObject(number)["offsetUserFunction"]["function"]
    times.clear()
    assert offset(mbs, 2.0, number, 0.0) == pytest.approx(0.4)
    assert times == [2.0]


def test_roller_lets_one_coordinate_go(mbs, add_cable, add_sensor, solve):
    nodes = add_cable(mbs, groundConstraintsStart=[False, True, False, False])["nodes"]
    sensor = add_sensor(mbs, nodes[0])
    mbs.Assemble()
    solve(mbs, 0.5)
    stored = trajectory(mbs, sensor)
    assert np.abs(stored[:, 2]).max() < 1e-9
    assert stored[:, 1].max() > 0.05


def test_coordinates_that_are_held_are_named_so(mbs, add_cable, solve):
    """They were called prescribed motions, which nobody had made."""
    node = add_cable(mbs, groundConstraintsStart=[False, True, False, False])["nodes"][0]
    said = "violate the coordinate constraint at the position y of node 0 by"
    mbs.SetNodeParameter(node, "initialVelocities", [0.0, 0.5, 0.0, 0.0])
    mbs.Assemble()
    with pytest.warns(UserWarning, match=f"initial velocities .* {said} 0.5"):
        solve(mbs)
    mbs.SetNodeParameter(node, "initialCoordinates", [0.0, 0.01, 0.0, 0.0])
    mbs.Assemble()
    with pytest.raises(SceneError, match=f"initial coordinates .* {said} 0.01"):
        solve(mbs)


@pytest.fixture
def add_ring():
    """A ring of the paper's section 4.1 with its pair of forces; returns its nodes."""

    def add(mbs, number=20, **changes):
        scene = load_scene("vibrating_ring")
        section = scene.cable.section
        template = InextensibleCable(section.mass_per_length, section.bending_stiffness, **changes)
        shape = CableShape.Circle([0, 0], 0.5, number)
        from exudyn_inext import CreateInextensibleCable

        nodes = CreateInextensibleCable(mbs, shape=shape, beamTemplate=template)["nodes"]
        for node, sign in ((nodes[0], 1.0), (nodes[number // 2], -1.0)):
            marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))

            def force(mbs, t, load, sign=sign):
                return [sign * 10.0 * np.sin(10.0 * np.pi * t), 0.0, 0.0]

            mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=force))
        return nodes

    return add


def test_ring_follows_the_independent_trajectory(mbs, add_ring, add_sensor, solve):
    nodes = add_ring(mbs)
    sensor = add_sensor(mbs, nodes[0])
    mbs.Assemble()
    solve(mbs, 1.0, integrator="Zhai", stepSize=2.4842e-4)
    stored = trajectory(mbs, sensor)
    reference = reference_trajectory(load_scene("vibrating_ring"))
    rows = np.searchsorted(reference.times, stored[:, 0] - 1e-9)
    assert np.abs(stored[:, 1:3] - reference.positions[rows, :2]).max() < 2e-4


def test_ring_has_one_node_an_element(mbs, add_ring):
    nodes = add_ring(mbs, 12)
    mbs.Assemble()
    assert len(nodes) == 12
    assert mbs.systemData.ODE2Size() == 48


BAD_RINGS = [
    ({"closed": True, "positions": [[0, 0], [1, 0]], "slopes": [[1, 0]] * 2}, "needs at least 3"),
    (
        {
            "closed": True,
            "positions": [[0, 0], [1, 0], [1, 1], [0, 0]],
            "slopes": [[1, 0], [0, 1], [-1, 0], [1, 0]],
        },
        r"positions\[0\] and positions\[-1\] are both .*leave the last row out",
    ),
    (
        {
            "closed": True,
            "positions": [[0, 0], [1, 0], [2, 0], [3, 0]],
            "slopes": [[1, 0]] * 4,
            "elementLengths": 1.0,
        },
        "nodes 3 and 0 are 3 m apart.*1 m long",
    ),
    (
        {"closed": False, "lengthReference": "curved", "positions": [[0, 0], [1, 0]], "slopes": [[1, 0]] * 2},
        "lengthReference = 'curved': choose one of",
    ),
]


@pytest.mark.parametrize(("shape", "message"), BAD_RINGS)
def test_points_that_do_not_close_are_refused(mbs, add_cable, contents, shape, message):
    before = contents(mbs)
    with pytest.raises(InputError, match=message):
        add_cable(mbs, shape=CableShape(**shape))
    assert contents(mbs) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"radius": -1.0}, "radius .* = -1.0: must be a finite number > 0"),
        ({"numberOfElements": 2}, "numberOfElements = 2: a ring needs at least 3"),
        ({"normal": [1, 0, 0]}, "normal = .* and start = .* must not be zero or parallel"),
    ],
)
def test_bad_circles_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        CableShape.Circle(**({"center": [0, 0], "radius": 1.0, "numberOfElements": 8} | arguments))


def test_end_constraints_of_a_ring_are_refused(mbs, add_cable):
    with pytest.raises(InputError, match="a closed cable has no end"):
        add_cable(mbs, shape=CableShape.Circle([0, 0], 1.0, 8), groundConstraintsEnd=[True] * 4)


def test_circle_in_space_lies_across_its_normal(mbs, add_cable, solve):
    shape = CableShape.Circle([1, 2, 3], 0.5, 12, normal=[1, 1, 1], start=[1, -1, 0])
    nodes = np.array(shape.positions) - [1, 2, 3]
    assert np.abs(nodes @ [1, 1, 1]).max() < 1e-14
    assert np.linalg.norm(nodes, axis=1) == pytest.approx(0.5)
    assert np.cross(nodes, shape.slopes) == pytest.approx(np.full((12, 3), 0.5 / np.sqrt(3)))
    add_cable(mbs, shape=shape, groundConstraintsStart=[True] * 3 + [False] * 3)
    mbs.Assemble()
    assert solve(mbs, 0.1)["success"]


def test_hanger_of_another_length_than_its_gap_is_refused(mbs, add_pendulum, solve, contents):
    nodes = add_pendulum(mbs)["nodes"]
    hang(mbs, nodes[-1], [1.8, 0.5, 0.0], 0.4)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(SceneError, match=r"violate the distance constraint at the .*node 5.* by 0.11"):
        solve(mbs)
    assert contents(mbs) == before


def test_hanger_out_of_the_plane_is_refused(mbs, add_pendulum, solve):
    nodes = add_pendulum(mbs)["nodes"]
    hang(mbs, nodes[-1], [1.8, 0.0, 0.5], 0.5)
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"out of the plane.*dimension=3"):
        solve(mbs)


def test_node_that_is_held_and_moved_is_redundant(mbs, add_pendulum, solve):
    nodes = add_pendulum(mbs)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], lambda t: [0.0, 0.0])
    mbs.Assemble()
    with pytest.raises(RedundantConstraintError, match="prescribed motion constraint at node 0"):
        solve(mbs)


def test_a_motion_that_ends_before_the_run_is_named(mbs, add_cable, solve):
    """The run ended as "too violent"."""
    nodes = add_cable(mbs)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], lambda t: [t * t if t < 0.02 else np.nan, 0.0])
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"prescribed to a node of object0.*nan.* at t = 0\.0\d+ s"):
        solve(mbs, 0.05)


def test_a_motion_may_begin_and_end_with_the_run(mbs, add_cable, solve):
    """As tables of measurements, which know nothing before and after it."""
    node = add_cable(mbs)["nodes"][0]

    def of_table(t):
        if not 0.0 <= t <= 0.1 + 1e-12:
            raise ValueError("outside of the table")
        return [0.5 * t**2, 0.0]

    CreatePrescribedMotion(mbs, node, of_table)
    mbs.Assemble()
    solve(mbs, 0.1)
    velocity = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Velocity)
    np.testing.assert_allclose(velocity, [0.1, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("outside", ["rests", "raises"])
def test_a_body_may_begin_to_move_with_the_run(mbs, add_pendulum, solve, outside):
    add_pendulum(mbs)
    cart = mbs.CreateMassPoint(mass=1.0, initialVelocity=[0.5, 0, 0], returnDict=True)["nodeNumber"]
    ground = mbs.AddNode(NodePointGround())
    ends = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=0)) for n in (ground, cart)]

    def of_table(mbs, t, item, offset):
        if t < 0.0 and outside == "raises":
            raise ValueError("outside of the table")
        return 0.5 * max(t, 0.0) + 0.3 * max(t, 0.0) ** 2

    mbs.AddObject(CoordinateConstraint(markerNumbers=ends, offsetUserFunction=of_table))
    mbs.Assemble()
    report = solve(mbs, 0.1, steps=10)
    velocity = mbs.GetNodeOutput(cart, exudyn.OutputVariableType.Velocity)
    np.testing.assert_allclose(velocity, [0.56, 0.0, 0.0], atol=1e-6)
    assert "in one compiled call" in report["path"]


def test_a_support_whose_velocity_jumps_is_named_and_the_remedy_works(mbs, add_cable, solve):
    """The motion was called too violent for the step."""
    node = add_cable(mbs)["nodes"][0]
    CreatePrescribedMotion(mbs, node, lambda t: [0.3 * max(0.0, t - 0.05), 0.0])
    mbs.Assemble()
    with pytest.raises(DivergenceError, match=r"velocity of a support jumps by 0\.3 m/s near t = 0\.0"):
        solve(mbs, 0.1)
    solve(mbs, 0.1, energyTolerance=10.0)
    place = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Displacement)
    np.testing.assert_allclose(place, [0.015, 0.0, 0.0], atol=1e-8)


NOT_SMOOTH = [
    (lambda t: [abs(t), 0.0], None, "velocity jumps by 2"),
    (lambda t: [t * abs(t), 0.0], None, "acceleration jumps"),
    (lambda t: [0.1 * t**2, 0.0], lambda t: [0.3, 0.0], "differences give"),
    (lambda t: [float("nan") if t else 0.0, 0.0], None, "is not finite at t = 0 s"),
]


@pytest.mark.parametrize(("position", "velocity", "message"), NOT_SMOOTH)
def test_motion_that_is_not_smooth_at_the_start_is_refused(
    mbs, add_cable, solve, contents, position, velocity, message
):
    nodes = add_cable(mbs)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], position, velocity)
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises((InputError, SceneError), match=message):
        solve(mbs)
    assert contents(mbs) == before


def test_motion_that_starts_with_a_velocity_the_cable_does_not_have_pulls_it_along(mbs, add_cable, solve):
    nodes = add_cable(mbs, gravity=[0, 0, 0])["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], lambda t: [0.5 * t, 0.0])
    mbs.Assemble()
    with pytest.warns(UserWarning, match=r"initial velocities .* prescribed motion .* by 0.5"):
        solve(mbs, 0.1)
    for node in (nodes[0], nodes[-1]):
        velocity = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Velocity)
        np.testing.assert_allclose(velocity, [0.5, 0, 0], atol=1e-8)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"nodeNumber": 99}, "mbs has no such node"),
        ({"position": [0, 0]}, "must be a function of the time"),
        ({"position": lambda t: 1.0}, "finite"),
        ({"velocity": lambda t: [1.0, float("nan")]}, "finite"),
    ],
)
def test_bad_motions_are_refused(mbs, add_cable, contents, changes, message):
    nodes = add_cable(mbs)["nodes"]
    before = contents(mbs)
    arguments = {"nodeNumber": nodes[0], "position": shake} | changes
    with pytest.raises(InputError, match=message):
        CreatePrescribedMotion(mbs, **arguments)
    assert contents(mbs) == before


def test_small_violations_are_projected_and_reported(mbs, add_pendulum, solve):
    nodes = add_pendulum(mbs)["nodes"]
    mbs.SetNodeParameter(nodes[3], "initialCoordinates", [1e-4, 0, 0, 0])
    mbs.Assemble()
    report = solve(mbs, 0.1, startTolerance=1e-3)
    (correction,) = report["startCorrections"]
    assert 1e-5 < correction.position < 2e-4
    assert exudyn.config.printToConsole
