"""Slider-crank in the plane whose connecting rod is a cable, kept taut by the weight of the slider.

A flywheel turns freely about the origin; native planar joints connect crank pin, cable, slider and guide.
"""

import exudyn as exu
import exudyn.utilities as eu

import exudyn_inext as inext
from outlines import box, disc, follow
from picture import draw, paths, sense

GRAVITY = [0, -9.81, 0]
LENGTH, ELEMENTS = 0.5, 6  # of the cable [m]
CRANK, SPEED = 0.1, 6.0  # radius of the crank [m], its initial speed [rad/s]
CABLE = inext.InextensibleCable(massPerLength=0.1, bendingStiffness=0.01)
FLYWHEEL = eu.InertiaCylinder(density=2000, length=0.04, outerRadius=0.25, axis=2)
SLIDER = eu.InertiaCuboid(density=1000, sideLengths=[0.1, 0.1, 0.1])
SETTINGS = inext.ExplicitSettings(stepSize=2e-3, massScaling=0.3)


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS):
    """Add the scene; returns its cables, bodies, and joints: (body, point of the body, node)."""
    ground, below = mbs.CreateGround(), [0, CRANK - LENGTH - 0.05, 0]
    flywheel = mbs.CreateRigidBody(inertia=FLYWHEEL, initialAngularVelocity=[0, 0, SPEED], create2D=True)
    slider = mbs.CreateRigidBody(referencePosition=below, inertia=SLIDER, gravity=GRAVITY, create2D=True)
    ends = [0, CRANK], [0, CRANK - LENGTH]
    line = inext.CableShape.Line(*ends, elements, velocityStart=[-SPEED * CRANK, 0, 0])
    cable = addCable(mbs, shape=line, beamTemplate=CABLE, gravity=GRAVITY)

    def on(body, point=(0, 0, 0), marker=eu.MarkerBodyPosition):
        return mbs.AddMarker(marker(bodyNumber=body, localPosition=point))

    mbs.AddObject(eu.RevoluteJoint2D(markerNumbers=[on(ground), on(flywheel)]))
    guide = [on(ground, marker=eu.MarkerBodyRigid), on(slider, marker=eu.MarkerBodyRigid)]
    mbs.AddObject(eu.PrismaticJoint2D(markerNumbers=guide, axisMarker0=[0, 1, 0], normalMarker1=[1, 0, 0]))
    joints = [(flywheel, [0, CRANK, 0], cable["nodes"][0]), (slider, [0, 0.05, 0], cable["nodes"][-1])]
    for body, point, node in joints:
        end = mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=node))
        mbs.AddObject(eu.RevoluteJoint2D(markerNumbers=[on(body, point), end]))
    return {"cables": [cable], "bodies": [flywheel, slider], "joints": joints}


def main():
    scene = build(mbs := exu.SystemContainer().AddSystem())
    sensors = sense(mbs, scene["cables"][0]["nodes"])
    outlines = follow(mbs, scene["bodies"], disc(0.25), box([0.1, 0.1, 0]))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 1.3
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    curves = {"pin, x": points[:, 0, 0], "pin, y": points[:, 0, 1], "slider, y": points[:, -1, 1] + LENGTH}
    bodies = [paths(mbs, one)[1] for one in outlines]
    draw("slider_crank", times, [points], "xy", curves, "position [m]", bodies)


if __name__ == "__main__":
    main()
