"""Crane: a driven trolley, and a rigid load that swings below it on a cable.

The trolley runs along x on a native prismatic joint; native spherical joints hold both ends of the cable.
"""

import exudyn as exu
import numpy as np
from exudyn.utilities import InertiaCuboid, MarkerBodyPosition, MarkerNodePosition, SphericalJoint

import exudyn_inext as inext
from outlines import box, follow
from picture import draw, paths, sense

GRAVITY = [0, 0, -9.81]
LENGTH, SIDE, ELEMENTS = 1.2, 0.2, 6  # of the cable [m], of the load, a cube [m], of the cable
SWAY = [0, 0.8, 0]  # initial velocity of the load, across the guide [m/s]
CABLE = inext.InextensibleCable(massPerLength=0.3, bendingStiffness=0.05)
SIDES = [0.4, 0.25, 0.1], [SIDE] * 3  # of trolley and load [m]
TROLLEY, LOAD = (InertiaCuboid(density=1000, sideLengths=sides) for sides in SIDES)
SETTINGS = inext.ExplicitSettings(stepSize=2e-3, massScaling=0.3)


def driving_force(mbs, t, loadVector):
    """Accelerates the trolley, then brakes it [N]."""
    return [100 * np.sin(np.pi * t / 0.4) if t < 0.8 else 0.0, 0, 0]


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS):
    """Add the scene; returns its cables, bodies, and joints: (body, point of the body, node)."""
    trolley = mbs.CreateRigidBody(inertia=TROLLEY, gravity=GRAVITY)
    mbs.CreatePrismaticJoint(itemNumbers=[mbs.CreateGround(), trolley], position=[0, 0, 0], axis=[1, 0, 0])
    mbs.CreateForce(itemNumber=trolley, loadVectorUserFunction=driving_force)
    below = [0, 0, -LENGTH - SIDE / 2]
    load = mbs.CreateRigidBody(referencePosition=below, initialVelocity=SWAY, inertia=LOAD, gravity=GRAVITY)
    line = inext.CableShape.Line([0, 0, 0], [0, 0, -LENGTH], elements, velocityEnd=SWAY)
    cable = addCable(mbs, shape=line, beamTemplate=CABLE, gravity=GRAVITY)
    joints = [(trolley, [0, 0, 0], cable["nodes"][0]), (load, [0, 0, SIDE / 2], cable["nodes"][-1])]
    for body, point, node in joints:
        onBody = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=point))
        onCable = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddObject(SphericalJoint(markerNumbers=[onBody, onCable]))
    return {"cables": [cable], "bodies": [trolley, load], "joints": joints}


def main():
    scene = build(mbs := exu.SystemContainer().AddSystem())
    sensors = sense(mbs, scene["cables"][0]["nodes"])
    outlines = follow(mbs, scene["bodies"], *map(box, SIDES))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 3
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    curves = {"trolley, x": points[:, 0, 0], "load, x": points[:, -1, 0], "load, y": points[:, -1, 1]}
    draw("crane", times, [points], "xz", curves, "position [m]", [paths(mbs, one)[1] for one in outlines])


if __name__ == "__main__":
    main()
