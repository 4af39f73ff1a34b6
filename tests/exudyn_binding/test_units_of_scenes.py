"""Scenes among bodies do not depend on the unit of length: neither their form nor their motion does."""

import math

import exudyn
import numpy as np
import pytest
from exudyn.utilities import (
    CartesianSpringDamper,
    CoordinateConstraint,
    DistanceConstraint,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    RevoluteJoint2D,
)

from exudyn_inext import CableShape, CreateInextensibleCable, InextensibleCable, InputError, SolveExplicit
from reference_models.conventional.native_cables import NativeCables
from reference_models.model import quiet_settings, silence


@pytest.mark.parametrize("unit", [1e-2, 1e3])
def test_scenes_have_the_same_form_and_motion_in_any_unit_of_length(unit):
    """A rod at the end of a cable whose start is moved; a unit of 100 m makes the rod 3.5 mm long."""

    def solve(unit):
        mbs = exudyn.SystemContainer().AddSystem()
        section = InextensibleCable(massPerLength=0.1 / unit, bendingStiffness=0.01 * unit**3)
        gravity = [0, -9.81 * unit, 0]
        cable = CreateInextensibleCable(mbs, [0, 0, 0], [unit, 0, 0], 4, section, gravity=gravity)
        nodes = cable["nodes"]
        carriage = mbs.CreateMassPoint(mass=0.5, create2D=True, gravity=gravity)
        held, bob = (
            mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
            for body in (
                carriage,
                mbs.CreateMassPoint(
                    referencePosition=[1.35 * unit, 0, 0], mass=0.05, create2D=True, gravity=gravity
                ),
            )
        )
        start, tip = (mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[k])) for k in (0, -1))
        mbs.AddObject(RevoluteJoint2D(markerNumbers=[held, start]))
        mbs.AddObject(DistanceConstraint(markerNumbers=[tip, bob], distance=0.35 * unit))
        fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        node = mbs.GetObject(carriage)["nodeNumber"]
        lift = {"offsetUserFunction": lambda mbs, t, item, offset: 0.02 * unit * (1.0 - math.cos(40.0 * t))}
        for k, function in ((0, {}), (1, lift)):
            own = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
            mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, own], **function))
        mbs.Assemble()
        settings = exudyn.SimulationSettings()
        settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = 0.3, 30
        settings.timeIntegration.verboseMode, settings.solution.file.write = 0, False
        report = SolveExplicit(mbs, settings)
        assert "in one compiled call" in report["path"]
        return report["steps"], mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position) / unit

    (steps, place), (own_steps, own_place) = solve(1.0), solve(unit)
    assert own_steps == steps
    np.testing.assert_allclose(own_place, place, rtol=0, atol=1e-9)


@pytest.mark.parametrize("second", [1e-3, 1e3])
def test_steps_are_the_same_in_any_unit_of_time(second):
    """A cable on a mass on a spring, whose errors of the phase decide; 1 s is 1000 ms."""

    def solve(second):
        mbs = exudyn.SystemContainer().AddSystem()
        section = InextensibleCable(massPerLength=0.1, bendingStiffness=0.01 / second**2)
        gravity = [0, -9.81 / second**2, 0]
        nodes = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, gravity=gravity)["nodes"]
        body = mbs.CreateMassPoint(mass=0.1, create2D=True, gravity=gravity)
        start = mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[0]))
        held, fixed = (
            mbs.AddMarker(MarkerBodyPosition(bodyNumber=one)) for one in (body, mbs.CreateGround())
        )
        mbs.AddObject(RevoluteJoint2D(markerNumbers=[held, start]))
        mbs.AddObject(CartesianSpringDamper(markerNumbers=[fixed, held], stiffness=[1e3 / second**2] * 3))
        mbs.Assemble()
        steps = SolveExplicit(mbs, quiet_settings(second, 10))["steps"]
        return steps, mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position)

    (steps, place), (own_steps, own_place) = solve(1.0), solve(second)
    assert own_steps == steps
    np.testing.assert_allclose(own_place, place, rtol=0, atol=1e-9)


@pytest.mark.parametrize("on_carriage", [False, True])
def test_a_fast_motion_that_begins_smoothly_is_not_warned_of_in_millimetres(on_carriage):
    """10 cm within 0.06 s: differences find 2e-6 mm/s at rest, where it begins."""
    mbs = exudyn.SystemContainer().AddSystem()
    section, gravity = InextensibleCable(massPerLength=4e-9, bendingStiffness=4e3), [0, -9810, 0]
    node = CreateInextensibleCable(mbs, [0, 0, 0], [300, 0, 0], 4, section, gravity=gravity)["nodes"][0]

    def lift(mbs, t, item, offset):
        x = min(max(t / 0.06, 0.0), 1.0)
        return 100.0 * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)

    if on_carriage:
        carriage = mbs.CreateMassPoint(mass=1e-3, create2D=True, returnDict=True)
        joined = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        node = carriage["nodeNumber"]
        held = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddObject(RevoluteJoint2D(markerNumbers=[held, joined]))
    fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for k, function in ((0, {}), (1, {"offsetUserFunction": lift})):
        own = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, own], **function))
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(0.01, 10))


def test_a_support_that_vibrates_at_1_kHz_needs_milliseconds():
    """20 periods of 0.1 mm; refused in seconds, and as a native run in the unit that the message names."""

    def shaken(second, add=CreateInextensibleCable):
        """mbs, and the tip of its cable.   second: in units of the time."""
        mbs = exudyn.SystemContainer().AddSystem()
        section = InextensibleCable(massPerLength=1e-3, bendingStiffness=1e-3 / second**2)
        shape = CableShape.Line([0, 0], [0.1, 0], numberOfElements=8)
        gravity, w = [0, -9.81 / second**2, 0], 2e3 * math.pi / second
        nodes = add(mbs, beamTemplate=section, gravity=gravity, shape=shape)["nodes"]

        def offset(mbs, t, item, constant):
            x = min(1e3 * t / second, 1.0)
            return 1e-4 * (1.0 - math.cos(w * t)) * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)

        fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for axis, function in ((0, {}), (1, {"offsetUserFunction": offset})):
            own = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=axis))
            mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, own], **function))
        mbs.Assemble()
        return mbs, nodes[-1]

    def tip(mbs, node):
        return mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position)

    with pytest.raises(InputError, match="milliseconds as the unit of time"):
        SolveExplicit(shaken(1.0)[0], quiet_settings(0.02, 200))
    native = shaken(1e3, NativeCables(axial=1e-2))
    with silence():
        native[0].SolveDynamic(quiet_settings(20.0, 2000))
    own = shaken(1e3)
    SolveExplicit(own[0], quiet_settings(20.0, 200))
    np.testing.assert_allclose(tip(*own), tip(*native), rtol=0, atol=1e-5)
