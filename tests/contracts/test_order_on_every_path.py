"""The declared order of every scheme, however a run is computed, under loads and motions in time.

A scheme that evaluates a load or a support at the wrong time inside a step falls to first order.
"""

from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadCoordinate,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SphericalJoint,
)

from exudyn_inext import (
    CreateInextensibleCable,
    CreatePrescribedMotion,
    ExplicitSettings,
    InextensibleCable,
    SolveExplicit,
)
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.zhai import Zhai
from reference_models.model import quiet_settings, silence

LENGTH, END = 1.0, 0.2
SECTION = InextensibleCable(massPerLength=0.05, bendingStiffness=2e-3)
CORRECTED = Zhai(psi=0.0, phi=0.0, corrector=True)
ALL_SCHEMES = [*(integrator.scheme() for integrator in INTEGRATORS.values()), CORRECTED]


def push(mbs, marker, size=0.3):
    """A force [N] that turns with 9 rad/s."""
    turning = lambda mbs, t, load: [size * np.sin(9 * t), size * np.cos(9 * t), 0]  # noqa: E731
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[1, 1, 0], loadVectorUserFunction=turning))


def add_cable(mbs, **changes):
    arguments = {"positionStart": [0, 0, 0], "positionEnd": [LENGTH, 0, 0], "numberOfElements": 4}
    arguments |= {"beamTemplate": SECTION, "gravity": [0, -9.81, 0]} | changes
    cable = CreateInextensibleCable(mbs, **arguments)
    push(mbs, mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1])))
    return cable


def lone_cable(mbs):
    add_cable(mbs, groundConstraintsStart=[True, True, False, False])
    return "cable"


def cable_with_a_moving_support(mbs):
    def shaken(t):
        return [0.02 * np.sin(9 * t) - 0.18 * t, 0.02 * (1 - np.cos(9 * t))]

    def rate(t):
        return [0.18 * (np.cos(9 * t) - 1), 0.18 * np.sin(9 * t)]

    def acceleration(t):
        return [-1.62 * np.sin(9 * t), 1.62 * np.cos(9 * t)]

    CreatePrescribedMotion(mbs, add_cable(mbs)["nodes"][0], shaken, rate, acceleration)
    return "cable"


def add_point(mbs, position):
    point = mbs.CreateMassPoint(
        mass=0.2, referencePosition=position, gravity=[0, -9.81, 0], create2D=True, returnDict=True
    )
    return SimpleNamespace(body=point["bodyNumber"], node=point["nodeNumber"])


def cable_among_bodies(mbs):
    """A cable whose ends hang on a point that is pushed, and on one that is moved."""
    cable = add_cable(mbs)
    driven, free = add_point(mbs, [0, 0, 0]), add_point(mbs, [LENGTH, 0, 0])
    for node, point in ((cable["nodes"][0], driven), (cable["nodes"][-1], free)):
        pair = MarkerNodePosition(nodeNumber=node), MarkerBodyPosition(bodyNumber=point.body)
        mbs.AddObject(SphericalJoint(markerNumbers=list(map(mbs.AddMarker, pair)), constrainedAxes=[1, 1, 0]))
    push(mbs, mbs.AddMarker(MarkerNodePosition(nodeNumber=free.node)))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for coordinate in (0, 1):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=driven.node, coordinate=coordinate))
        constraint = CoordinateConstraint(markerNumbers=[ground, marker])
        if coordinate == 1:
            constraint.offsetUserFunction = lambda mbs, t, number, offset: 0.02 * (1 - np.cos(9 * t))
            constraint.offsetUserFunction_t = lambda mbs, t, number, offset: 0.18 * np.sin(9 * t)
        mbs.AddObject(constraint)
    return "joint"


def native_items(mbs):
    """Two points on springs, of which one moves along a line."""
    ground = mbs.CreateGround()
    points = [add_point(mbs, [x, 0, 0]) for x in (0.5, 1.0)]
    for point, other in zip(points, (ground, points[0].body), strict=True):
        mbs.CreateSpringDamper(itemNumbers=[other, point.body], stiffness=30.0, damping=0.1)
    push(mbs, mbs.AddMarker(MarkerNodePosition(nodeNumber=points[1].node)))
    marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=points[0].node, coordinate=1))
    fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, marker]))
    along = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=points[0].node, coordinate=0))
    swelling = lambda mbs, t, load: np.cos(9 * t)  # noqa: E731
    mbs.AddLoad(LoadCoordinate(markerNumber=along, load=1, loadUserFunction=swelling))
    return "native items"


PATHS = {
    lone_cable: {"RATTLE": 100, "Zhai": 100, "RK4": 50},
    cable_with_a_moving_support: {"RATTLE": 200, "Zhai": 100, "RK4": 50},
    cable_among_bodies: {"RATTLE": 100, "Zhai": 200, "RK4": 100},
    native_items: {"RATTLE": 50, "Zhai": 50, "RK4": 25},
}


def end_of_run(build, scheme, steps):
    """Coordinates [m, -] after `steps` equal steps."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    kind = build(mbs)
    mbs.Assemble()
    explicit = ExplicitSettings(scheme, stepSize=END / steps, energyTolerance=np.inf)
    with silence():
        report = SolveExplicit(mbs, quiet_settings(END, 1), explicit)
    assert kind in report["path"] and report["steps"] == steps
    return np.array(mbs.systemData.GetODE2Coordinates())


@pytest.mark.parametrize("scheme", ALL_SCHEMES, ids=str)
@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.__name__)
def test_observed_order_under_loads_and_motions_in_time_is_the_declared_one(path, scheme):
    (integrator,) = [i for i in INTEGRATORS.values() if i.scheme is type(scheme)]
    first = PATHS[path][integrator.name]
    ends = [end_of_run(path, scheme, first * 2**k) for k in range(4)]
    gaps = np.abs(np.diff(ends, axis=0)).max(axis=1)
    np.testing.assert_allclose(np.log2(gaps[:-1] / gaps[1:]), integrator.order, atol=0.2)
