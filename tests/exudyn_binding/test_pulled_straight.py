"""A cable that is longer than its supports are apart, until one of them moves too far."""

import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SphericalJoint,
)

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    DivergenceError,
    ExplicitSettings,
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
@pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")  # by 0.5 % of its motion
def test_the_error_names_it_and_its_remedy_works(new_mbs, on_body):
    said = r"diverged before t = 0\.4 .* cable 'object0' cannot stretch, .* axialStiffness"
    with pytest.raises(DivergenceError, match=said) as error:
        pulled(new_mbs(), on_body)
    assert "has to be smaller" not in str(error.value)  # no step would help
    assert pulled(new_mbs(), on_body, axialStiffness=1e4)["success"]


def rubbed(mbs, friction, **explicit):
    """A mass at the end of a straight cable, with a friction of v that is larger than what lets it fall."""
    cable = CreateInextensibleCable(
        mbs,
        [0, 0, 0],
        [1, 0, 0],
        8,
        InextensibleCable(**SECTION),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True, True, False, False],
    )
    body = mbs.CreateMassPoint(
        mass=0.5, referencePosition=[1, 0, 0], gravity=[0, -9.81, 0], create2D=True, returnDict=True
    )
    nodes = cable["nodes"][-1], body["nodeNumber"]
    pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes]
    mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
    places = (mbs.AddNode(NodePointGround()), 0), (body["nodeNumber"], 1)
    rails = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=k)) for n, k in places]

    def force(mbs, t, number, u, v, stiffness, damping, offset):
        return friction(v)

    mbs.AddObject(CoordinateSpringDamper(markerNumbers=rails, springForceUserFunction=force))
    mbs.Assemble()
    return SolveExplicit(mbs, quiet_settings(0.05, 5), ExplicitSettings(**explicit))


@pytest.mark.filterwarnings("ignore:damping of")
def test_a_force_that_jumps_is_named_before_a_cable_that_happens_to_be_straight(new_mbs):
    def jumping(v):
        return 20.0 * float(np.sign(v))

    with pytest.raises(DivergenceError, match=r"a force that jumps, as friction by sign\(v\)"):
        rubbed(new_mbs(), jumping)
    assert rubbed(new_mbs(), lambda v: 20.0 * float(np.tanh(v / 1e-3)))["success"]
    assert rubbed(new_mbs(), jumping, energyTolerance=10.0)["success"]
