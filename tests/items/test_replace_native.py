"""ReplaceNativeCables: native elements, replaced, move as cables that were created in their place."""

from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodePosition,
    MassPoint2D,
    NodeGenericODE2,
    NodePoint2DSlope1,
    ObjectALEANCFCable2D,
    ObjectANCFCable,
    ObjectANCFCable2D,
    SensorBody,
    SensorNode,
)

from exudyn_inext import (
    CableShape,
    CreateCableForceSensor,
    CreateCompanionCables,
    CreateInextensibleCable,
    InputError,
    ReplaceNativeCables,
    SceneError,
    SolveEquilibrium,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import PINNED, trajectory
from tests.random_scenes import RandomScene

POSITION = exudyn.OutputVariableType.Position
GRAVITY = [0.0, -9.81, 0.0]
THICK = {"massPerLength": 0.2, "bendingStiffness": 0.05, "axialStiffness": 2e4, "bendingDamping": 1e-3}
THIN = {"massPerLength": 0.1, "bendingStiffness": 0.01, "axialStiffness": 1e4}


def template(dim=2, section=THICK, **more):
    return (ObjectANCFCable2D if dim == 2 else ObjectANCFCable)(**section, **more)


def line(dim=2, start=0.0, end=1.0, elements=6, pinned=True, **more):
    """Arguments that both generators take."""
    supports = {"groundConstraintsStart": PINNED if dim == 2 else [True] * 3 + [False] * 3} if pinned else {}
    ends = {"positionStart": [start, 0, 0], "positionEnd": [end, 0, 0], "numberOfElements": elements}
    return {"beamTemplate": template(dim), "gravity": GRAVITY} | ends | supports | more


def generated(mbs, replaced, extensible=True, **arguments):
    """The cable of one generator or the other; what is replaced has to be replaced afterwards."""
    if replaced:
        return GenerateBeamElementsAlongLine(mbs, **arguments)
    return CreateInextensibleCable(mbs, extensible=extensible, **arguments)


def watched(mbs, *nodes):
    """Sensors of their positions."""
    return [
        mbs.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=POSITION))
        for node in nodes
    ]


def move(mbs, solve, settings, **explicit):
    """By `solve`; False: by Exudyn's own solver."""
    if solve:
        solve(mbs, settings=settings, **explicit)
    else:
        with silence():
            mbs.SolveDynamic(settings)


def require_the_same(new_mbs, solve, build, number_of_cables=1, extensible=True, atol=1e-9):
    """build(mbs, replaced) -> sensors, which show the same whichever way the cables came about."""
    found = []
    for replaced in (False, True):
        mbs = new_mbs()
        sensors = build(mbs, replaced)
        if replaced:
            assert len(ReplaceNativeCables(mbs, extensible=extensible)) == number_of_cables
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.3, 60, 0.05), stepSize=5e-4)
        found.append(np.array([trajectory(mbs, sensor)[:, 1:] for sensor in sensors]))
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=atol)
    assert np.abs(found[0] - found[0][:, :1]).max() > 0.02


@pytest.mark.parametrize("extensible", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_weights_loads_and_sensors_of_elements_act_on_the_cable(new_mbs, solve, dim, extensible):
    def build(mbs, replaced):
        cable = generated(mbs, replaced, extensible, **line(dim))
        elements = cable["elements"] if replaced else CreateCompanionCables(mbs, cable)
        on_element = {"bodyNumber": elements[3], "localPosition": [0.05, 0, 0]}
        marker = mbs.AddMarker(MarkerBodyPosition(**on_element))
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0.2, 3.0, 0.5 if dim == 3 else 0]))
        middle = SensorBody(**on_element, storeInternal=True, outputVariableType=POSITION)
        return [*watched(mbs, cable["nodes"][-1]), mbs.AddSensor(middle)]

    require_the_same(new_mbs, solve, build, extensible=extensible)


def test_mass_points_that_came_before_are_part_of_the_cable(new_mbs, solve):
    def build(mbs, replaced):
        cable = generated(mbs, replaced, **line())
        mbs.AddObject(MassPoint2D(nodeNumber=cable["nodes"][3], mass=0.5))
        return watched(mbs, cable["nodes"][3], cable["nodes"][-1])

    require_the_same(new_mbs, solve, build)


def test_where_the_section_changes_cables_share_a_node(new_mbs, solve):
    def build(mbs, replaced):
        first = generated(mbs, replaced, **line(elements=4))
        node = first["nodes"][-1]
        onwards = line(start=1.0, end=1.6, elements=4, pinned=False, nodeNumberStart=node)
        second = generated(mbs, replaced, **onwards | {"beamTemplate": template(section=THIN)})
        end = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddLoad(LoadForceVector(markerNumber=end, loadVector=[0.0, 1.0, 0.0]))
        return watched(mbs, node, second["nodes"][-1])

    require_the_same(new_mbs, solve, build, number_of_cables=2)


def test_user_functions_of_moments_stay(new_mbs, solve):
    def stiffening(mbs, t, number, x, curvature, rate, curvature_0, stiffness, damping, *rest):
        return stiffness * curvature * (1.0 + 0.3 * curvature**2) + damping * rate

    def build(mbs, replaced):
        bends = template(section=THIN, bendingMomentUserFunction=stiffening)
        cable = generated(mbs, replaced, **line() | {"beamTemplate": bends})
        return watched(mbs, cable["nodes"][-1])

    require_the_same(new_mbs, solve, build)


@pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")
def test_elements_in_a_ring_become_a_closed_cable(new_mbs, solve):
    radius, number = 0.4, 8
    angles = 2.0 * np.pi * np.arange(number) / number
    outward = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    slopes, length = outward[:, ::-1] * [-1, 1], 2.0 * np.pi * radius / number

    def native_ring(mbs):
        rows = zip(radius * outward, slopes, strict=True)
        nodes = [
            mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=np.concatenate(row).tolist())) for row in rows
        ]
        for k, node in enumerate(nodes):
            ends = [node, nodes[(k + 1) % number]]
            body = mbs.AddObject(ObjectANCFCable2D(**THIN, length=length, nodeNumbers=ends))
            marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
            mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=GRAVITY))
        return nodes

    def build(mbs, replaced):
        if replaced:
            nodes = native_ring(mbs)
        else:
            shape = CableShape(radius * outward, slopes, length, closed=True, lengthReference="straight")
            arguments = {"beamTemplate": template(section=THIN), "gravity": GRAVITY, "extensible": True}
            nodes = CreateInextensibleCable(mbs, shape=shape, **arguments)["nodes"]
        end = mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[0]))
        mbs.AddLoad(LoadForceVector(markerNumber=end, loadVector=[0.5, 1.0, 0.0]))
        return watched(mbs, nodes[0], nodes[3])

    require_the_same(new_mbs, solve, build)


@pytest.mark.parametrize("seed", [2, 8, 11, 13])
def test_random_scenes_of_native_cables_move_as_those_that_were_created(solve, seed):
    created, replaced = RandomScene(seed, stretches=True), RandomScene(seed, native=True, elements=8)
    ReplaceNativeCables(replaced.mbs)
    replaced.mbs.Assemble()
    for scene in (created, replaced):
        solve(scene.mbs, settings=quiet_settings(0.2, 100, 0.02))
    paths = created.paths()
    np.testing.assert_allclose(replaced.paths(), paths, rtol=0, atol=1e-11)
    assert np.abs(paths - paths[0]).max() > 0.1


HINGE, SLIDE = [1, 1, 1, 0, 0, 1], [0, 0, 1, 0, 0, 1]  # about z, and in the plane across it


@pytest.mark.parametrize(("dim", "start"), [(2, None), (3, None), (3, HINGE), (3, SLIDE)])
def test_it_moves_as_the_native_elements_do(new_mbs, solve, dim, start):
    found = []
    for replaced in (True, False):
        mbs = new_mbs()
        supports = {"groundConstraintsStart": start} if start else {}
        cable = GenerateBeamElementsAlongLine(mbs, **line(dim, elements=12) | supports)
        (tip,) = watched(mbs, cable["nodes"][-1])
        end = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        mbs.AddLoad(LoadForceVector(markerNumber=end, loadVector=[0.0, 0.0, 0.3 if start else 0.0]))
        if replaced:
            ReplaceNativeCables(mbs)
        mbs.Assemble()
        move(mbs, replaced and solve, quiet_settings(0.3, 300, 0.05))
        found.append(trajectory(mbs, tip)[:, 1:])
    np.testing.assert_allclose(found[0], found[1], atol=2e-3)  # of 0.4 m


def three_at_a_node(mbs):
    """Nodes of a Y, whose arms go on along the slope of the stem."""
    stem = GenerateBeamElementsAlongLine(mbs, **line(elements=4))
    node = stem["nodes"][-1]
    arms = [
        GenerateBeamElementsAlongLine(
            mbs, **line(start=1.0, end=end, elements=4, pinned=False, nodeNumberStart=node)
        )
        for end in (1.8, 1.5)
    ]
    return [node, *(arm["nodes"][-1] for arm in arms)]


def loop_at_an_end(mbs):
    """Nodes of a stem with a loop, which begins and ends at the last node of the stem."""
    stem = GenerateBeamElementsAlongLine(mbs, **line(elements=4))
    radius, number = 0.2, 12
    angles = 2.0 * np.pi * np.arange(1, number) / number
    rows = np.stack(
        [1.0 + radius * np.sin(angles), radius * (1.0 - np.cos(angles)), np.cos(angles), np.sin(angles)],
        axis=1,
    )
    inner = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=row)) for row in rows.tolist()]
    around, length = [stem["nodes"][-1], *inner, stem["nodes"][-1]], 2.0 * np.pi * radius / number
    for pair in pairwise(around):
        body = mbs.AddObject(ObjectANCFCable2D(**THICK, length=length, nodeNumbers=list(pair)))
        marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=GRAVITY))
    return [around[0], inner[number // 2]]


@pytest.mark.parametrize("build", [three_at_a_node, loop_at_an_end])
def test_elements_that_branch_move_as_the_native_ones_do(new_mbs, solve, build):
    found = []
    for replaced in (True, False):
        mbs = new_mbs()
        sensors = watched(mbs, *build(mbs))
        if replaced:
            ReplaceNativeCables(mbs)
        mbs.Assemble()
        move(mbs, replaced and solve, quiet_settings(0.3, 300, 0.05), stepSize=5e-5)
        found.append(np.array([trajectory(mbs, sensor)[:, 1:] for sensor in sensors]))
    np.testing.assert_allclose(found[0], found[1], atol=2e-3)
    assert np.abs(found[0] - found[0][:, :1]).max() > 0.3


def test_initial_states_of_nodes_stay_also_where_cables_share_one(mbs):
    states = {
        "initialCoordinates": [0.0, 0.1, 0.0, 0.0],
        "initialVelocities": [0.0, 0.3, 0.0, 0.2],
    }
    places = [0.0, 0.5, 1.0]
    nodes = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[x, 0, 1, 0], **states)) for x in places]
    for pair, section in zip((nodes[:2], nodes[1:]), (THICK, THIN), strict=True):
        mbs.AddObject(ObjectANCFCable2D(**section, length=0.5, nodeNumbers=pair))
    first, second = ReplaceNativeCables(mbs)
    mbs.Assemble()
    for node in (*nodes, second["elements"] and mbs.GetObject(1)["nodeNumbers"][0]):
        for name, value in states.items():
            np.testing.assert_array_equal(mbs.GetNodeParameter(int(node), name), value)
    assert [*map(int, first["nodes"])] == [*map(int, nodes[:2])]
    assert [*map(int, second["nodes"])] == [*map(int, nodes[1:])]


@pytest.mark.parametrize("by_nodes", [True, False])
def test_velocities_that_step_functions_set_hold_where_cables_share_a_node(new_mbs, solve, by_nodes):
    found = []
    for replaced in (True, False):
        mbs = new_mbs()
        first = GenerateBeamElementsAlongLine(mbs, **line(elements=8, end=0.5))
        onwards = line(start=0.5, elements=8, pinned=False, nodeNumberStart=first["nodes"][-1])
        second = GenerateBeamElementsAlongLine(mbs, **onwards | {"beamTemplate": template(section=THIN)})
        nodes = [int(node) for node in (*first["nodes"], *second["nodes"][1:])]

        def slow_down(mbs, t, nodes=nodes):
            if abs(t - 0.1) < 1e-9:
                v = mbs.systemData.GetODE2Coordinates_t()
                places = [mbs.systemData.GetNodeLTGODE2(node) for node in nodes] if by_nodes else slice(None)
                v[places] *= 0.2
                mbs.systemData.SetODE2Coordinates_t(v)
            return True

        mbs.SetPreStepUserFunction(slow_down)
        (tip,) = watched(mbs, nodes[-1])
        if replaced:
            ReplaceNativeCables(mbs)
        mbs.Assemble()
        move(mbs, replaced and solve, quiet_settings(0.3, 300 if replaced else 3000, 0.05))
        found.append(trajectory(mbs, tip)[:, 1:])
    np.testing.assert_allclose(found[0], found[1], atol=1e-3)  # of 0.3 m
    assert np.abs(found[1]).max() > 0.2


def test_statics_and_section_forces_know_the_cables(mbs):
    hanging = line() | {"positionEnd": [0, -1, 0]}
    GenerateBeamElementsAlongLine(mbs, **hanging)
    (cable,) = ReplaceNativeCables(mbs)
    sensor = CreateCableForceSensor(mbs, cable, 0.25)
    mbs.Assemble()
    with silence():
        SolveEquilibrium(mbs)
    assert mbs.GetSensorValues(sensor)[0] == pytest.approx(0.2 * 9.81 * 0.75, rel=1e-3)


def test_only_what_is_named_is_replaced(mbs):
    first, second = (
        GenerateBeamElementsAlongLine(mbs, **line(elements=3) | {"positionEnd": [1, y, 0]}) for y in (0, 1)
    )
    (cable,) = ReplaceNativeCables(mbs, objectNumbers=second["elements"])
    assert [*map(int, cable["nodes"])] == [*map(int, second["nodes"])]
    assert [mbs.GetObject(k)["massPerLength"] for k in first["elements"]] == [0.2] * 3
    assert [mbs.GetObject(k)["massPerLength"] for k in second["elements"]] == [0.0] * 3
    assert CreateCompanionCables(mbs, cable) == [*map(int, second["elements"])]


def test_what_is_left_on_a_node_of_a_cable_is_refused_and_can_be_replaced_later(new_mbs, solve):
    found = []
    for at_once in (True, False):
        mbs = new_mbs()
        made = GenerateBeamElementsAlongLine(mbs, **line())
        (tip,) = watched(mbs, made["nodes"][-1])
        if not at_once:
            ReplaceNativeCables(mbs, objectNumbers=made["elements"][3:])
            mbs.Assemble()
            with pytest.raises(SceneError, match=r"object 2 .* lies on nodes of .*: .*ReplaceNativeCables"):
                solve(mbs)
        ReplaceNativeCables(mbs)
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.3, 60, 0.05))
        found.append(trajectory(mbs, tip)[:, 1:])
    np.testing.assert_allclose(found[1], found[0], atol=5e-4)  # of 0.4 m


@pytest.mark.parametrize("name", ["bendingStiffness", "referenceAxialStrain", "length"])
@pytest.mark.parametrize("with_body", [False, True])
def test_properties_of_elements_that_are_set_later_are_refused(mbs, solve, name, with_body):
    made = GenerateBeamElementsAlongLine(mbs, **line())
    if with_body:
        mbs.CreateMassPoint(referencePosition=[0, 1, 0], mass=1.0, gravity=GRAVITY)
    ReplaceNativeCables(mbs)
    mbs.Assemble()
    element = made["elements"][2]
    before = mbs.GetObjectParameter(element, name)
    said = rf"{name} = 0.01 was set of object 2 .*\(ANCFCable2D\), in whose place cable .*before Replace"

    def change(mbs, t):
        mbs.SetObjectParameter(element, name, 0.01)
        return True

    mbs.SetPreStepUserFunction(change)
    for _ in range(2):  # in a run, and before one
        with pytest.raises(SceneError, match=said):
            solve(mbs, 0.1, steps=10)
        mbs.SetPreStepUserFunction(0)
    mbs.SetObjectParameter(element, name, before)
    assert solve(mbs, 0.1, steps=10)["success"]


def test_places_of_nodes_that_are_set_after_assembly_are_refused(mbs, solve):
    made = GenerateBeamElementsAlongLine(mbs, **line())
    ReplaceNativeCables(mbs)
    mbs.Assemble()
    node = int(made["nodes"][2])
    before = mbs.GetNodeParameter(node, "referenceCoordinates")
    mbs.SetNodeParameter(node, "referenceCoordinates", [0.3, 0.05, 1.0, 0.0])  # native elements have it now
    with pytest.raises(SceneError, match=f"referenceCoordinates of node {node} .* were changed by 0.05"):
        solve(mbs)
    mbs.SetNodeParameter(node, "referenceCoordinates", before)
    assert solve(mbs, 0.1, steps=10)["success"]


def test_elements_that_have_other_numbers_by_now_are_refused_by_a_remedy_that_works(new_mbs, solve):
    for late in (True, False):
        mbs = new_mbs()
        ground = mbs.CreateGround()
        made = GenerateBeamElementsAlongLine(mbs, **line(elements=1))
        if late:
            ReplaceNativeCables(mbs)
        mbs.DeleteObject(ground, suppressWarnings=True)
        if late:
            mbs.Assemble()
            with pytest.raises(
                SceneError, match=r"object 1 is no longer the element on nodes \[0, 1\], .*delete"
            ):
                solve(mbs)
    ReplaceNativeCables(mbs)
    mbs.Assemble()
    assert solve(mbs, 0.1, steps=10)["success"]
    assert mbs.GetNodeOutput(made["nodes"][-1], POSITION)[1] < -0.02


def test_elements_without_counterpart_are_named_and_nothing_is_changed(mbs, contents):
    GenerateBeamElementsAlongLine(mbs, **line(elements=2))
    strained = template(section=THIN, referenceAxialStrain=-0.01)
    GenerateBeamElementsAlongLine(mbs, **line(elements=2) | {"beamTemplate": strained})
    before = contents(mbs)
    with pytest.raises(
        InputError, match=r"native elements \d+ to \d+: .*referenceAxialStrain.*extensible=True"
    ):
        ReplaceNativeCables(mbs, extensible=False)
    assert contents(mbs) == before
    assert len(ReplaceNativeCables(mbs)) == 2


def test_a_second_call_finds_nothing_to_replace(mbs):
    GenerateBeamElementsAlongLine(mbs, **line(elements=2))
    ReplaceNativeCables(mbs)
    with pytest.raises(InputError, match="no ObjectANCFCable2D or ObjectANCFCable with a mass"):
        ReplaceNativeCables(mbs)


def test_elements_through_which_the_cable_moves_are_named(mbs):
    ends = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[x, 0, 1, 0])) for x in (0, 1)]
    flow = mbs.AddNode(NodeGenericODE2(numberOfODE2Coordinates=1, referenceCoordinates=[0]))
    mbs.AddObject(ObjectALEANCFCable2D(nodeNumbers=[*ends, flow], name="pipe", massPerLength=1))
    with pytest.raises(InputError, match=r"object 0 'pipe' \(ALEANCFCable2D\).*\(ALE\).*mbs.SolveDynamic"):
        ReplaceNativeCables(mbs)
