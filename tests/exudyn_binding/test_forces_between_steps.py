"""Section forces that step functions read are those of the last step, and found once for all who ask."""

import numpy as np
import pytest
from exudyn import OutputVariableType
from exudyn.utilities import (
    InertiaCuboid,
    MarkerBodyPosition,
    MarkerNodePosition,
    ObjectANCFCable2D,
    RevoluteJoint2D,
    SensorNode,
    SensorObject,
)

from exudyn_inext import CreateCableForceSensor, CreateInextensibleCable
from exudyn_inext.exudyn_binding import cable_forces
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import load_node

WEIGHT = [0, -9.81, 0]


def hanging_cable(mbs, stretches, with_body):
    """A pinned cable that begins horizontally, with a block at its end or not."""
    template = ObjectANCFCable2D(massPerLength=0.2, bendingStiffness=0.05, axialStiffness=2e4)
    cable = CreateInextensibleCable(
        mbs,
        positionStart=[0, 0, 0],
        positionEnd=[1, 0, 0],
        numberOfElements=4,
        beamTemplate=template,
        gravity=WEIGHT,
        extensible=stretches,
        groundConstraintsStart=[True, True, False, False],
    )
    if with_body:
        block = InertiaCuboid(800, [0.1, 0.1, 0.1])
        body = mbs.CreateRigidBody(
            inertia=block, referencePosition=[1.05, 0, 0], gravity=WEIGHT, create2D=True
        )
        end = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        corner = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[-0.05, 0, 0]))
        mbs.AddObject(RevoluteJoint2D(markerNumbers=[end, corner]))
    return cable


def seen_before_and_after_steps(mbs, solve, times_asked):
    """What step functions read of a sensor, which they ask several times: (50, 2) and (51, 2).

    The one after steps is also called at the start.
    """
    before, after = [], []

    def look(values):
        def function(mbs, t):
            values.append([mbs.GetSensorValues(0) for _ in range(times_asked)][-1])
            return True

        return function

    mbs.SetPreStepUserFunction(look(before))
    mbs.SetPostStepUserFunction(look(after))
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.1, 50, 0.002))
    return np.array(before), np.array(after)


@pytest.mark.parametrize("stretches", [True, False])
@pytest.mark.parametrize("with_body", [True, False])
def test_functions_before_a_step_read_what_those_after_the_last_one_did(mbs, solve, stretches, with_body):
    CreateCableForceSensor(mbs, hanging_cable(mbs, stretches, with_body), 0.6)
    before, after = seen_before_and_after_steps(mbs, solve, 1)
    written, round_off = mbs.GetSensorStoredData(0)[1:, 1:], 1e-10 * np.abs(after).max()
    np.testing.assert_allclose(before[1:], after[1:-1], rtol=0.0, atol=round_off)
    np.testing.assert_allclose(written, after[1:], rtol=0.0, atol=round_off)
    assert np.ptp(after[:, 0]) > 0.1


@pytest.mark.parametrize("first", [0, 1, 2])
def test_forces_do_not_depend_on_who_asks_first(new_mbs, solve, first):
    """Of a joint, a support of the cable, and a section."""
    found = []
    for order in ([1, 0, 2], [first, *{0, 1, 2}.difference([first])]):
        mbs, seen = new_mbs(), []
        cable = hanging_cable(mbs, True, True)
        force = {"outputVariableType": OutputVariableType.Force, "storeInternal": True}
        joint = mbs.systemData.NumberOfObjects() - 1
        support = next(k for k in range(joint) if "Coordinate" in mbs.GetObject(k)["objectType"])
        for number in (joint, support):
            mbs.AddSensor(SensorObject(objectNumber=number, **force))
        CreateCableForceSensor(mbs, cable, 0.6)
        load = load_node(mbs, cable["nodes"][2], [0, 0, 0])

        def look(mbs, t, order=order, seen=seen, load=load):
            mbs.SetLoadParameter(load, "loadVector", [0, -t, 0])  # so that steps are taken one by one
            values = {number: np.ravel(mbs.GetSensorValues(number)) for number in order}
            seen.append(np.concatenate([values[number] for number in range(3)]))
            return True

        mbs.SetPreStepUserFunction(look)
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.05, 25, 0.05))
        found.append(np.array(seen))
    np.testing.assert_allclose(*found, rtol=1e-10, atol=1e-10)
    assert len(np.unique(found[0][:, :4], axis=0)) == 25 and np.abs(found[0][1:, 3]).min() > 1e-6


def test_who_asks_again_gets_the_same_and_nothing_is_read_again(new_mbs, solve, monkeypatch):
    found, read = [], []
    read_scene = cable_forces.read_scene
    monkeypatch.setattr(cable_forces, "read_scene", lambda *given: read.append(1) or read_scene(*given))
    for times_asked in (1, 3):
        mbs = new_mbs()
        CreateCableForceSensor(mbs, hanging_cable(mbs, False, False), 0.6)
        found.append(seen_before_and_after_steps(mbs, solve, times_asked))
    for once, again in zip(*found, strict=True):
        np.testing.assert_array_equal(once, again)
    assert len(read) < 20  # of 100 steps


def test_sections_feel_how_step_functions_move_supports(mbs, solve):
    """At the end of the cable, the tension is the force of the support along the slope."""
    cable = hanging_cable(mbs, False, False)
    objects = range(mbs.systemData.NumberOfObjects())
    held = [k for k in objects if "Coordinate" in mbs.GetObject(k)["objectType"]][:2]
    force = {"outputVariableType": OutputVariableType.Force, "storeInternal": True}
    shape = {"outputVariableType": OutputVariableType.Coordinates, "storeInternal": True}
    of_supports = [mbs.AddSensor(SensorObject(objectNumber=k, **force)) for k in held]
    of_node = mbs.AddSensor(SensorNode(nodeNumber=cable["nodes"][0], **shape))
    of_section = CreateCableForceSensor(mbs, cable, 0.0)

    def lift(mbs, t):
        mbs.SetObjectParameter(held[1], "offset", 0.05 * np.sin(6.0 * t) ** 2)
        return True

    mbs.SetPreStepUserFunction(lift)
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.1, 50, 0.01))
    x, y = (mbs.GetSensorStoredData(k)[1:, 1] for k in of_supports)
    slope = mbs.GetSensorStoredData(of_node)[1:, 3:5] + [1.0, 0.0]
    tension = mbs.GetSensorStoredData(of_section)[1:, 1]
    along = x * slope[:, 0] + y * slope[:, 1]
    np.testing.assert_allclose(np.abs(along), np.abs(tension), rtol=0.0, atol=1e-8 * np.abs(along).max())
