"""Section forces, their sensors and restart files in scenes of compiled form, nets among them."""

import exudyn
import numpy as np
import pytest
from exudyn.rigidBodyUtilities import InertiaCuboid

from examples import crane, net, slider_crank, tethered_bodies
from exudyn_inext import (
    AttachToBody,
    CableForces,
    CreateCableForceSensor,
    CreateInextensibleCable,
    InextensibleCable,
    SolveEquilibrium,
)
from exudyn_inext.items.cable_data import find_cable_item
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import trajectory
from tests.exudyn_binding.test_restart import restarting

FORCE = exudyn.OutputVariableType.Force
SCENES = [crane, tethered_bodies, slider_crank, net]


def built(mbs, scene):
    """The scene; sensors of tension and moment in the first and at the end of the last cable."""
    made = scene.build(mbs)
    first, last = made["cables"][0], made["cables"][-1]
    length = find_cable_item(mbs.GetObject(last["elements"][0])).cable.length
    sensors = [CreateCableForceSensor(mbs, first, 0.05), CreateCableForceSensor(mbs, last, length)]
    mbs.Assemble()
    return made, sensors


@pytest.mark.parametrize("scene", SCENES)
def test_sensors_leave_scenes_in_compiled_code_and_show_the_same_by_exudyn(new_mbs, solve, scene, request):
    found = []
    for by_exudyn in (False, True):
        if by_exudyn:
            request.getfixturevalue("by_exudyn")
        mbs = new_mbs()
        _, sensors = built(mbs, scene)
        report = solve(mbs, settings=quiet_settings(0.1, 10, 0.01), stepSize=5e-4)
        assert ("one call for each" in report["path"]) == by_exudyn
        found.append(np.hstack([trajectory(mbs, sensor)[:, 1:] for sensor in sensors]))
    scale = np.abs(found[1]).max(axis=0)
    np.testing.assert_allclose(found[0] / scale, found[1] / scale, atol=1e-5)
    assert scale[0] > 0.1


def constraint_on(mbs, node, kind):
    """Number of the one constraint of a kind whose markers lie on a node."""

    def nodes(data):
        return [int(mbs.GetMarker(marker).get("nodeNumber", -1)) for marker in data["markerNumbers"]]

    objects = [mbs.GetObject(number) for number in range(mbs.systemData.NumberOfObjects())]
    (found,) = [
        k for k, data in enumerate(objects) if data["objectType"] == kind and int(node) in nodes(data)
    ]
    return found


@pytest.mark.parametrize("scene", [crane, tethered_bodies, slider_crank])
def test_the_section_force_at_an_end_is_that_of_its_joint(mbs, solve, scene):
    made, _ = built(mbs, scene)
    solve(mbs, settings=quiet_settings(0.2, 20))
    accelerations = mbs.systemData.GetODE2Coordinates_tt()
    forces = CableForces(mbs, made["cables"][0], [0.0])
    assert np.array_equal(mbs.systemData.GetODE2Coordinates_tt(), accelerations)
    assert np.abs(accelerations).max() > 1.0
    kind = "JointRevolute2D" if scene is slider_crank else "JointSpherical"
    joint = constraint_on(mbs, made["cables"][0]["nodes"][0], kind)
    on_cable = np.linalg.norm(np.array(mbs.GetObjectOutput(joint, FORCE))[:3])
    size = np.hypot(forces["tension"][0], np.linalg.norm(forces["shearForce"][0]))
    assert size == pytest.approx(on_cable, rel=5e-3)


@pytest.mark.parametrize("scene", SCENES)
def test_runs_go_on_from_their_restart_files_bit_for_bit(new_mbs, solve, tmp_path, scene):
    found = []
    for end, restarts in ((0.2, False), (0.1, True), (0.2, True)):
        mbs = new_mbs()
        _, sensors = built(mbs, scene)
        settings = quiet_settings(end, 1, 0.02)
        solve(mbs, settings=restarting(settings, tmp_path) if restarts else settings)
        rows = np.hstack([trajectory(mbs, sensor) for sensor in sensors])
        found.append((rows, mbs.systemData.GetODE2Coordinates()))
    (whole, end), _, (rest, end_of_rest) = found
    np.testing.assert_array_equal(end_of_rest, end)
    np.testing.assert_array_equal(rest, whole[-len(rest) :])
    assert len(rest) > 3


def test_a_net_at_rest_carries_its_weight_by_its_rods(mbs):
    made = net.build(mbs)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    total = 0.0
    for anchor, node in made["rods"]:
        place = np.array(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position))
        rod = constraint_on(mbs, node, "ConnectorDistance")
        upwards = (anchor[2] - place[2]) / np.linalg.norm(np.array(anchor) - place)
        total += upwards * abs(float(np.ravel(mbs.GetObjectOutput(rod, FORCE))[0]))
    weight = 6 * net.CABLE.massPerLength * net.SIDE * 9.81
    assert total == pytest.approx(weight, rel=1e-6)


@pytest.mark.filterwarnings("ignore:length = 800 m")
def test_section_forces_after_a_run_are_the_same_in_millimetres_and_tonnes(new_mbs, solve):
    found = []
    for m, kg in ((1.0, 1.0), (1e3, 1e-3)):
        mbs = new_mbs()
        section = {"massPerLength": 0.02 * kg / m, "bendingStiffness": 0.01 * m**2}
        ends = {"positionStart": [0, 0, 0], "positionEnd": [0.8 * m, 0, 0], "numberOfElements": 4}
        cable = CreateInextensibleCable(
            mbs,
            **ends,
            beamTemplate=InextensibleCable(**section),
            gravity=[0, -9.81 * m, 0],
            groundConstraintsStart=[True, True, False, False],
        )
        body = mbs.CreateRigidBody(
            inertia=InertiaCuboid(800 * kg / m**3, [0.05 * m] * 3),
            referencePosition=[0.83 * m, 0, 0],
            gravity=[0, -9.81 * m, 0],
            create2D=True,
        )
        AttachToBody(mbs, cable, "end", body, [-0.03 * m, 0, 0])
        mbs.Assemble()
        solve(mbs, 0.3, stepSize=1e-3)
        found.append(CableForces(mbs, cable, 5)["tension"])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-4)
