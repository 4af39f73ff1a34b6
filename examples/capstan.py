"""A cable over a fixed cylinder, with friction: the heavier mass pulls the lighter one up."""

import exudyn as exu
import exudyn.utilities as eu
import numpy as np

import exudyn_inext as inext
from contact import Surface, add_circle_contact
from outlines import box, carried, disc
from picture import draw, paths, sense

GRAVITY = [0, -9.81, 0]
RADIUS, ELEMENTS = 0.2, 40  # of the cylinder [m], of the cable
LENGTH, SIDE = 2.5 * np.pi * RADIUS, 0.75 * np.pi * RADIUS  # of the cable, of what hangs on each side [m]
MASSES, FRICTION = (2.0, 8.0), 0.2  # left and right [kg], coefficient [-]
INDENTATION = 2e-4  # of the cylinder at the start, as much as the cable needs [m]
CABLE = inext.InextensibleCable(massPerLength=0.1, bendingStiffness=2e-4)
SETTINGS = inext.ExplicitSettings(stepSize=2e-4, massScaling=0.3)


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS, friction=FRICTION):
    """Add the scene; returns its cables, bodies, and joints: (body, point of the body, node)."""
    s = np.linspace(0, LENGTH, elements + 1)
    angle = np.clip((s - SIDE) / RADIUS, 0, np.pi)
    tangents = np.column_stack([np.sin(angle), np.cos(angle)])
    arc = RADIUS * np.column_stack([-np.cos(angle), np.sin(angle)])
    shape = inext.CableShape(arc + (s - SIDE - RADIUS * angle)[:, None] * tangents, tangents)
    cable = addCable(mbs, shape=shape, beamTemplate=CABLE, gravity=GRAVITY)
    nodes = cable["nodes"]
    surface = Surface(RADIUS + INDENTATION, friction, stiffness=8e5, damping=300, adhesion=1e6, viscosity=300)
    add_circle_contact(mbs, nodes, LENGTH, surface, touches=lambda s: SIDE <= s <= LENGTH - SIDE)
    joints = []
    for mass, x, node in zip(MASSES, (-RADIUS, RADIUS), (nodes[0], nodes[-1]), strict=True):
        hung = mbs.CreateMassPoint(mass=mass, referencePosition=[x, -SIDE, 0], gravity=GRAVITY, create2D=True)
        ends = eu.MarkerBodyPosition(bodyNumber=hung), eu.MarkerNodePosition(nodeNumber=node)
        mbs.AddObject(eu.RevoluteJoint2D(markerNumbers=[mbs.AddMarker(end) for end in ends]))
        joints.append((hung, [0, 0, 0], node))
    return {"cables": [cable], "bodies": [body for body, *_ in joints], "joints": joints}


def main():
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    sensors = sense(mbs, build(mbs)["cables"][0]["nodes"])
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 0.45
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    heights = {"lighter mass": points[:, 0, 1], "heavier mass": points[:, -1, 1]}
    weights = [carried(points[:, end], box([0.06, 0.06, 0])) for end in (0, -1)]
    cylinder = carried(np.zeros((len(times), 3)), disc(RADIUS))
    draw("capstan", times, [points], "xy", heights, "height [m]", [cylinder, *weights])


if __name__ == "__main__":
    main()
