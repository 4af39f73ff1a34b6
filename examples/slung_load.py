"""A drone carries a rigid load on a cable to another place; its controller damps the swing.

The thrust changes fifty times a second; `ExplicitSolver`, driven as Exudyn's solvers are, steps in between.
"""

import exudyn as exu
import numpy as np
from exudyn.utilities import InertiaCuboid, MarkerNodePosition, SphericalJoint

import exudyn_inext as inext
from flight import Controller, drive, settings_of_period
from outlines import box, carried
from picture import draw, paths, sense

GRAVITY, MASS, LENGTH, ELEMENTS = np.array([0, 0, -9.81]), 4.0, 1.5, 6  # [m/s^2], of the drone [kg], [m]
CABLE = inext.InextensibleCable(massPerLength=0.05, bendingStiffness=0.02)
LOAD = InertiaCuboid(density=500, sideLengths=[0.2, 0.2, 0.1])
GOAL, DURATION, END, PERIOD = np.array([3.0, 0.0, 1.0]), 2.5, 8.0, 0.02  # [m], [s]
WEIGHT = (MASS + LOAD.Mass() + CABLE.massPerLength * LENGTH) * GRAVITY
SETTINGS = inext.ExplicitSettings(stepSize=2e-3, massScaling=0.3)


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS):
    """Add the scene; returns the nodes of drone and load, those of the cable, and the thrust."""
    line = inext.CableShape.Line([0, 0, 0], [0, 0, -LENGTH], elements)
    nodes = addCable(mbs, shape=line, beamTemplate=CABLE, gravity=GRAVITY.tolist())["nodes"]
    drone = mbs.CreateMassPoint(mass=MASS, gravity=GRAVITY, returnDict=True)
    place = {"referencePosition": [0, 0, -LENGTH], "gravity": GRAVITY, "returnDict": True}
    load = mbs.CreateRigidBody(inertia=LOAD.Translated([0, 0, -0.05]), **place)
    for body, node in ((drone, nodes[0]), (load, nodes[-1])):
        markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (body["nodeNumber"], node)]
        mbs.AddObject(SphericalJoint(markerNumbers=markers))
    return [drone["nodeNumber"], load["nodeNumber"]], nodes, mbs.CreateForce(itemNumber=drone["bodyNumber"])


def fly(solver, settings, swingDamping=9.0, **options):
    """Times (T,) [s] and paths (T, k, 3) [m] of the nodes of the cable.   options: of `build`."""
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    bodies, nodes, force = build(mbs, **options)
    sensors, controller = sense(mbs, nodes), Controller(GOAL, DURATION, WEIGHT, swingDamping=swingDamping)
    mbs.Assemble()
    steer = lambda t: mbs.SetLoadParameter(force, "loadVector", controller.thrust(mbs, bodies, t))  # noqa: E731
    print(drive(solver, mbs, settings, PERIOD, END, steer))
    return paths(mbs, sensors)


def main():
    angles = {}
    for label, swingDamping in (("swing damping off", 0.0), ("on", 9.0)):
        times, points = fly(inext.ExplicitSolver(SETTINGS), settings_of_period(), swingDamping)
        x, _, z = (points[:, -1] - points[:, 0]).T
        angles[label] = np.degrees(np.arctan2(x, -z))
    bodies = carried(points[:, 0], box([0.4, 0.4, 0.08])), carried(points[:, -1], box([0.2, 0.2, 0.1]))
    draw("slung_load", times, [points], "xz", angles, "angle to the vertical [deg]", bodies)


if __name__ == "__main__":
    main()
