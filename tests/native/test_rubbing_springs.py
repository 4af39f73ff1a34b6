"""Springs with friction and stops move what cables hang at as Exudyn's implicit solver says."""

from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamperExt,
    LoadCoordinate,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericData,
    NodePointGround,
    SensorNode,
    SphericalJoint,
)

from exudyn_inext import RungeKutta4
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import either_cable, solve_native

END = 0.6  # [s]
SECTION = {"massPerLength": 0.3, "bendingStiffness": 0.02}
RUBS = {"dynamicFrictionForce": 2.0, "staticFrictionOffsetForce": 1.0, "exponentialDecayStatic": 0.1}
ALWAYS = RUBS | {"frictionProportionalZone": 0.01, "viscousFrictionFactor": 0.2}
STICKS = RUBS | {"stickingStiffness": 2e4, "stickingDamping": 20.0}
STOPS = {"useLimitStops": True, "limitStopsLower": -0.02, "limitStopsUpper": 0.06}
STOPS |= {"limitStopsStiffness": 1e4, "limitStopsDamping": 5.0}


class Trolley:
    """A mass point on a rail along x, with a spring to the ground that rubs or has stops.

    law: of the spring.   speed: at the start [m/s].
    """

    def __init__(self, mbs, law, speed=0.0):
        self.mbs = mbs
        way = {"mass": 0.5, "referencePosition": [0, 0, 0], "initialVelocity": [speed, 0, 0]}
        self.node = mbs.CreateMassPoint(**way, create2D=True, returnDict=True)["nodeNumber"]
        ground = self.coordinate(mbs.AddNode(NodePointGround()), 0)
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, self.coordinate(self.node, 1)]))
        if not law.get("frictionProportionalZone"):
            data = NodeGenericData(initialCoordinates=[0.0] * 3, numberOfDataCoordinates=3)
            law = law | {"nodeNumber": mbs.AddNode(data)}
        self.along = self.coordinate(self.node, 0)
        self.spring = mbs.AddObject(CoordinateSpringDamperExt(markerNumbers=[ground, self.along], **law))
        self.sensors = [self._sense(self.node)]

    def coordinate(self, node, which):
        return self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=which))

    def _sense(self, node):
        position = exudyn.OutputVariableType.Position
        sensor = SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=position)
        return self.mbs.AddSensor(sensor)

    def tow(self, native=False, force=8.0):
        """A cable hangs from it, and a force pushes it to and fro."""
        line = {"positionStart": [0, 0, 0], "positionEnd": [0, -0.8, 0], "gravity": [0, -9.81, 0]}
        nodes, _ = either_cable(self.mbs, native, 2, SECTION, 2e5, numberOfElements=8 + 4 * native, **line)
        pair = [self.mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (self.node, nodes[0])]
        self.mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
        push = {"load": 0.0, "loadUserFunction": lambda mbs, t, load: force * np.sin(14.0 * t)}
        self.mbs.AddLoad(LoadCoordinate(markerNumber=self.along, **push))
        self.sensors.append(self._sense(nodes[-1]))
        self.mbs.Assemble()
        return self

    def paths(self):
        return [np.array(self.mbs.GetSensorStoredData(sensor))[:, 1:3] for sensor in self.sensors]


@pytest.mark.parametrize("law", [ALWAYS, STICKS, STICKS | STOPS], ids=["rubs", "sticks", "stops"])
def test_it_moves_as_its_native_twin(new_mbs, solve, law):
    found = []
    for native in (True, False):
        trolley = Trolley(new_mbs(), law | {"stiffness": 20.0, "damping": 0.1}).tow(native)
        if native:
            solve_native(trolley.mbs, END, 2e-4)
        else:
            path = solve(trolley.mbs, settings=quiet_settings(END, 300))["path"]
        found.append(trolley.paths())
    assert "in one compiled call" in path
    for wanted, own in zip(*found, strict=True):
        error, size = np.sqrt(((own - wanted) ** 2).mean()), np.ptp(wanted, axis=0).max()
        assert error < 0.01 * size and size > 0.05


@pytest.mark.parametrize("scheme", [{}, {"integrator": RungeKutta4()}], ids=["RATTLE", "RK4"])
def test_it_breaks_loose_sticks_and_meets_stops_in_the_same_steps_as_evaluated(
    request, new_mbs, solve, scheme
):
    """As a user function sees them at the end of each step."""
    found = []
    for _ in range(2):
        rows, trolley = [], Trolley(new_mbs(), STICKS | STOPS | {"stiffness": 20.0}).tow()
        trolley.mbs.SetPostStepUserFunction(
            lambda mbs, t, rows=rows: rows.append(mbs.systemData.GetDataCoordinates()) or True
        )
        solve(trolley.mbs, settings=quiet_settings(0.5, 500), stepSize=5e-4, **scheme)
        found.append(np.array(rows))
        request.getfixturevalue("by_exudyn")
    np.testing.assert_allclose(*found, rtol=0, atol=1e-6)
    both_ways = {(0, 1), (0, -1), (1, 0), (-1, 0), (0, 0), (1, 1), (-1, -1)}
    for signs in np.sign(found[0][:, [0, 2]]).T.tolist():
        assert set(pairwise(signs)) == both_ways


def test_automatic_steps_are_short_while_a_hard_stop_acts(mbs, solve, add_pendulum):
    """It bounces with the speed that it came with."""
    trolley = Trolley(mbs, STOPS | {"limitStopsStiffness": 1e6, "limitStopsDamping": 0.0}, speed=1.0)
    add_pendulum(mbs, numberOfElements=2)
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(0.1, 100))
    speed = mbs.GetNodeOutput(trolley.node, exudyn.OutputVariableType.Velocity)[0]
    assert "in one compiled call" in report["path"]
    assert report["stepSize"] < 1e-4 < report["meanStepSize"] and speed == pytest.approx(-1.0, abs=3e-3)
