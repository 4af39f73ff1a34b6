"""Two free rigid bodies tumble, and spin about each other at the ends of a cable; no gravity."""

import exudyn as exu
import numpy as np
from exudyn.utilities import InertiaCuboid, MarkerBodyPosition, MarkerNodePosition, SphericalJoint

import exudyn_inext as inext
from outlines import box, follow
from picture import draw, paths, sense

LENGTH, ELEMENTS = 2.0, 8  # of the cable [m]
SPIN = 3.0  # of the whole about z [rad/s]
CABLE = inext.InextensibleCable(massPerLength=0.2, bendingStiffness=0.05)
SIDES = [0.2, 0.2, 0.1], [0.3, 0.15, 0.1]  # of the bodies [m]
INERTIAS = [InertiaCuboid(1000, sides) for sides in SIDES]
ANCHORS = [[0.1, 0.05, 0.0], [-0.15, 0.0, 0.05]]  # of the cable on the bodies [m]
TUMBLING = [[1.0, 0.5, SPIN], [0.0, -1.0, SPIN]]  # angular velocities of the bodies [rad/s]
SETTINGS = inext.ExplicitSettings(stepSize=2e-3, massScaling=0.3)


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS):
    """Add the scene; returns its cables, bodies, and joints: (body, point of the body, node)."""
    ends = np.array([[-LENGTH / 2, 0, 0], [LENGTH / 2, 0, 0]])
    velocities = np.cross([0, 0, SPIN], ends)
    line = inext.CableShape.Line(*ends, elements, velocityStart=velocities[0], velocityEnd=velocities[1])
    cable = addCable(mbs, shape=line, beamTemplate=CABLE, dimension=3)
    bodies, joints = [], []
    for k, node in enumerate((cable["nodes"][0], cable["nodes"][-1])):
        body = mbs.CreateRigidBody(
            referencePosition=ends[k] - ANCHORS[k],
            initialVelocity=velocities[k] - np.cross(TUMBLING[k], ANCHORS[k]),
            initialAngularVelocity=TUMBLING[k],
            inertia=INERTIAS[k],
        )
        onBody = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=ANCHORS[k]))
        onCable = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddObject(SphericalJoint(markerNumbers=[onBody, onCable]))
        bodies.append(body)
        joints.append((body, ANCHORS[k], node))
    return {"cables": [cable], "bodies": bodies, "joints": joints}


def main():
    scene = build(mbs := exu.SystemContainer().AddSystem())
    sensors = sense(mbs, scene["cables"][0]["nodes"])
    outlines = follow(mbs, scene["bodies"], *map(box, SIDES))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 2
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    curves, bodies = dict(zip("xyz", points[:, 0].T, strict=True)), [paths(mbs, one)[1] for one in outlines]
    draw("tethered_bodies", times, [points], "xy", curves, "end at the first body [m]", bodies)


if __name__ == "__main__":
    main()
