"""Scenes move alike wherever they are, as in coordinates of a map, which have millions of metres."""

import exudyn
import numpy as np
import pytest
from exudyn.utilities import MarkerBodyPosition, MarkerNodePosition, RevoluteJoint2D, SphericalJoint

from exudyn_inext import CreateInextensibleCable, InextensibleCable, SolveExplicit

ON_A_MAP = np.array([5e5, 5e6, 300.0])
ELEMENTS = 8  # of 0.125 m: differences of places have a round-off of 1e-8 of that


def placed(origin, dimension, stiffness, has_body):
    """(steps, (n, 3) places of the nodes beside the origin) of a cable that falls, perhaps with a body."""
    origin = origin * [1.0, 1.0, dimension == 3]
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=0.01, axialStiffness=stiffness)
    gravity, tip = [0.0, -9.81, 0.0], np.add(origin, [1.0, 0.0, 0.0])
    pinned = [True] * dimension + [False] * dimension
    cable = CreateInextensibleCable(
        mbs, list(origin), list(tip), ELEMENTS, section, gravity, pinned, dimension=dimension
    )
    if has_body:
        body = mbs.CreateMassPoint(
            referencePosition=list(tip), mass=0.2, gravity=gravity, create2D=dimension == 2
        )
        markers = [
            mbs.AddMarker(MarkerBodyPosition(bodyNumber=body)),
            mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1])),
        ]
        mbs.AddObject((RevoluteJoint2D if dimension == 2 else SphericalJoint)(markerNumbers=markers))
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = 0.5, 50
    settings.timeIntegration.verboseMode, settings.solution.file.write = 0, False
    report = SolveExplicit(mbs, settings)
    position = exudyn.OutputVariableType.Position
    return report["steps"], np.array([mbs.GetNodeOutput(n, position) - origin for n in cable["nodes"]])


@pytest.mark.parametrize("has_body", [False, True])
@pytest.mark.parametrize("stiffness", [None, 1e4])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_scene_on_a_map_moves_as_at_the_origin(dimension, stiffness, has_body):
    steps, places = placed(np.zeros(3), dimension, stiffness, has_body)
    own_steps, own_places = placed(ON_A_MAP, dimension, stiffness, has_body)
    assert own_steps == steps
    np.testing.assert_allclose(own_places, places, rtol=0, atol=1e-7)
