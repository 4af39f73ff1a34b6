"""A drone takes off with a prescribed acceleration, and a rigid load swings below it on a cable."""

import exudyn as exu
import numpy as np
from exudyn.utilities import InertiaCuboid, MarkerBodyPosition, MarkerNodePosition, SphericalJoint

import exudyn_inext as inext
from outlines import box, carried, follow
from picture import draw, paths, sense

GRAVITY = [0, 0, -9.81]
ACCELERATION = np.array([3.0, 1.0, 1.0])  # of the drone [m/s^2]
LENGTH, ELEMENTS, SIDES = 1.5, 6, [0.2, 0.2, 0.1]  # of the cable [m], and of the load [m]
CABLE = inext.InextensibleCable(massPerLength=0.05, bendingStiffness=0.02)
LOAD = InertiaCuboid(density=800, sideLengths=SIDES)
SETTINGS = inext.ExplicitSettings(stepSize=2e-3, massScaling=0.3)


def drone_position(t):
    return 0.5 * ACCELERATION * t**2


def drone_velocity(t):
    return ACCELERATION * t


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS):
    """Add the scene; returns its cables, bodies, and joints: (body, point of the body, node)."""
    line = inext.CableShape.Line([0, 0, 0], [0, 0, -LENGTH], elements)
    cable = addCable(mbs, shape=line, beamTemplate=CABLE, gravity=GRAVITY)
    drone, hook = cable["nodes"][0], cable["nodes"][-1]
    inext.CreatePrescribedMotion(mbs, drone, drone_position, drone_velocity, lambda t: ACCELERATION)
    point = [0, 0, SIDES[2] / 2]
    load = mbs.CreateRigidBody(referencePosition=[0, 0, -LENGTH - point[2]], inertia=LOAD, gravity=GRAVITY)
    onLoad = mbs.AddMarker(MarkerBodyPosition(bodyNumber=load, localPosition=point))
    onCable = mbs.AddMarker(MarkerNodePosition(nodeNumber=hook))
    mbs.AddObject(SphericalJoint(markerNumbers=[onLoad, onCable]))
    return {"cables": [cable], "bodies": [load], "joints": [(load, point, hook)]}


def main():
    scene = build(mbs := exu.SystemContainer().AddSystem())
    sensors = sense(mbs, scene["cables"][0]["nodes"])
    load = follow(mbs, scene["bodies"], box(SIDES))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 1.5
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    x, y, z = (points[:, -1] - points[:, 0]).T
    angles = {"cable": np.degrees(np.arctan2(np.hypot(x, y), -z))}
    bodies = [carried(points[:, 0], box([0.4, 0.4, 0.08])), paths(mbs, *load)[1]]
    draw("drone", times, [points], "xz", angles, "angle to the vertical [deg]", bodies)


if __name__ == "__main__":
    main()
