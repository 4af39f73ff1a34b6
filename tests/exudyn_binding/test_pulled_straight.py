"""A cable that is longer than its supports are apart, until one of them moves too far."""

import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SphericalJoint,
)

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    DivergenceError,
    InextensibleCable,
    SolveExplicit,
)
from reference_models.model import quiet_settings

SECTION = {"massPerLength": 0.3, "bendingStiffness": 0.02}


def way_at(speed):
    def way(mbs, t, number, offset):
        return speed * t

    return way


def pulled(mbs, on_body, **stretch):
    """Its end, or a mass there, leaves with 0.5 m/s and has pulled it straight after 0.4 s."""
    cable = CreateInextensibleCable(
        mbs,
        shape=CableShape.Catenary([0, 0], [0.8, 0], length=1.0, numberOfElements=8),
        beamTemplate=InextensibleCable(**SECTION, **stretch),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True, True, False, False],
    )
    moved = cable["nodes"][-1]
    if on_body:
        body = mbs.CreateMassPoint(mass=0.3, referencePosition=[0.8, 0, 0], create2D=True, returnDict=True)
        pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (moved, body["nodeNumber"])]
        mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
        moved = body["nodeNumber"]
    ground = mbs.AddNode(NodePointGround())
    for axis, speed in enumerate((0.5, 0.0)):
        places = (ground, 0), (moved, axis)
        pair = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=k)) for n, k in places]
        mbs.AddObject(CoordinateConstraint(markerNumbers=pair, offsetUserFunction=way_at(speed)))
    mbs.Assemble()
    return SolveExplicit(mbs, quiet_settings(0.45, 450, 0.01))


@pytest.mark.parametrize("on_body", [False, True], ids=["its end", "a mass"])
@pytest.mark.filterwarnings("ignore:.*initial velocities")
def test_the_error_names_it_and_its_remedy_works(new_mbs, on_body):
    said = r"diverged before t = 0\.4 .* cable 'object0' cannot stretch, .* axialStiffness"
    with pytest.raises(DivergenceError, match=said) as error:
        pulled(new_mbs(), on_body)
    assert "has to be smaller" not in str(error.value)  # no step would help
    assert pulled(new_mbs(), on_body, axialStiffness=1e4)["success"]
