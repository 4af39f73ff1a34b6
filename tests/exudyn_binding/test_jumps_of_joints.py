"""Offset functions that jump where Exudyn evaluates the scene, and of joints that step functions steer."""

import re

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    MarkerNodeCoordinate,
    NodePointGround,
)

from exudyn_inext import CreateInextensibleCable, DivergenceError, InextensibleCable, SolveExplicit
from reference_models.model import quiet_settings

pytestmark = pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")

AT, SIZE, END = 0.1, 0.05, 0.2


def moved_rope(axial_stiffness, is_evaluated, is_steered, duration=0.0):
    """A rope, one end of which an offset function lifts: at once, or in a duration [s]."""
    mbs = exudyn.SystemContainer().AddSystem()
    damping = 1e-3 * (axial_stiffness or 0.0)
    section = InextensibleCable(0.1, 0.01, axialStiffness=axial_stiffness, axialDamping=damping)
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, gravity=[0, -9.81, 0])
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    ends = [(cable["nodes"][0], 0), (cable["nodes"][0], 1), (cable["nodes"][-1], 1)]
    pairs = [
        [ground, mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))] for node, axis in ends
    ]
    mbs.variables["size"] = SIZE

    def lift(mbs, t, number, offset):
        share = min(max(t - AT, 0.0) / duration, 1.0) if duration else float(t > AT)
        size = mbs.variables["size"] if is_steered else SIZE
        return size * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)

    mbs.AddObject(CoordinateConstraint(markerNumbers=pairs[0]))
    mbs.AddObject(CoordinateConstraint(markerNumbers=pairs[1], offsetUserFunction=lift))
    if is_evaluated:
        spring = {"springForceUserFunction": lambda mbs, t, number, u, v, k, d, offset: 0.5 * u}
        mbs.AddObject(CoordinateSpringDamper(markerNumbers=pairs[2], stiffness=1.0, **spring))
    if is_steered:
        mbs.SetPreStepUserFunction(lambda mbs, t: True)
    mbs.Assemble()
    return mbs, cable["nodes"][0]


@pytest.mark.parametrize(
    ("is_evaluated", "is_steered"), [(True, False), (False, True), (True, True)], ids=str
)
@pytest.mark.parametrize("axial_stiffness", [None, 2e4])
def test_a_jump_is_named_before_steps_go_over_it_and_its_remedy_works(
    axial_stiffness, is_evaluated, is_steered
):
    """Six of twelve such runs went over it, up to 30 000 steps and millions of times the motion off."""
    given, settings = (axial_stiffness, is_evaluated, is_steered), quiet_settings(END, 40)
    with pytest.raises(DivergenceError, match=rf"moves by {SIZE} m .* at once at t = {AT} s") as caught:
        SolveExplicit(moved_rope(*given)[0], settings)
    duration = float(re.search(r"ramp of ([\d.e-]+) s", str(caught.value))[1])
    mbs, node = moved_rope(*given, duration)
    report = SolveExplicit(mbs, settings)
    assert report["rejections"] <= 2
    place = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position)
    assert np.abs(place - [0, SIZE, 0]).max() < 1e-6


@pytest.mark.parametrize("is_steered", [False, True])
def test_a_ramp_may_end_with_the_run(is_steered):
    """Differences of one side were compared with others: an error spoke of an item that had changed."""
    duration = 0.05
    mbs, node = moved_rope(None, False, is_steered, duration)
    SolveExplicit(mbs, quiet_settings(0.15, 40))
    assert mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position)[1] == pytest.approx(SIZE, abs=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_of_several_supports_the_one_that_jumps_is_named(dimension):
    mbs = exudyn.SystemContainer().AddSystem()
    line = {"gravity": [0, -9.81, 0], "dimension": dimension}
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, InextensibleCable(0.1, 0.01), **line)
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    functions = [
        lambda mbs, t, number, offset: 0.01 * t**3,
        lambda mbs, t, number, offset: SIZE * (t > AT),
    ]
    ends = cable["nodes"][0], cable["nodes"][-1]
    for node, function in zip(ends, functions, strict=True):
        held = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, held], offsetUserFunction=function))
    mbs.Assemble()
    with pytest.raises(DivergenceError, match=rf"Cause: .* at node {ends[1]} of cable .* moves by {SIZE} m"):
        SolveExplicit(mbs, quiet_settings(END, 40))
