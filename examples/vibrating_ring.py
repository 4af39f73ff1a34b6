"""Vibrating ring (section 4.1 of the paper): two opposite forces drive a free ring."""

import exudyn as exu
import numpy as np
from exudyn.utilities import LoadForceVector, MarkerNodePosition

import exudyn_inext as inext
from picture import draw, paths, sense

RADIUS, ELEMENTS, END_TIME = 0.5, 20, 2  # [m], [-], [s]
FORCE, FREQUENCY = 10.0, 10 * np.pi  # [N], [rad/s]
RING = inext.InextensibleCable(massPerLength=0.212058, bendingStiffness=3.436117)  # round, radius 5 mm
SETTINGS = inext.ExplicitSettings(stepSize=1e-3, massScaling=0.26)


def outwards(mbs, t, loadVector):
    """Force on the first node [N]: x is away from the centre there."""
    return [FORCE * np.sin(FREQUENCY * t), 0, 0]


def opposite(mbs, t, loadVector):
    return [-FORCE * np.sin(FREQUENCY * t), 0, 0]


def build(mbs, elements=ELEMENTS):
    """Add the scene; returns its cables."""
    circle = inext.CableShape.Circle(center=[0, 0], radius=RADIUS, numberOfElements=elements)
    ring = inext.CreateInextensibleCable(mbs, shape=circle, beamTemplate=RING)
    for node, force in ((ring["nodes"][0], outwards), (ring["nodes"][elements // 2], opposite)):
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=force))
    return {"cables": [ring]}


def main(show=draw):
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    nodes = build(mbs)["cables"][0]["nodes"]
    sensors = sense(mbs, [*nodes, nodes[0]])
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END_TIME
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    curves = {"driven node, x": points[:, 0, 0], "a quarter further, y": points[:, ELEMENTS // 4, 1]}
    show("vibrating_ring", times, [points], "xy", curves, "coordinate [m]")


if __name__ == "__main__":
    main()
