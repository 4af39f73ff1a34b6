"""A tethered net is thrown at a ball that floats freely, and closes around it.

Native spherical joints tie the cables in knots, and hold masses at the corners. Contact is Exudyn's own.
"""

import exudyn as exu
import exudyn.utilities as eu
import numpy as np

import exudyn_inext as inext
from bodies import record
from meshes import Net, half_circle, tie

SIZE = {"meshes": 6, "mesh": 0.2, "speed": 4.0}  # of the net: meshes along a side, [m], [m/s]
RADIUS, MASS, CENTRE = 0.25, 1.5, [0.05, 0.03, 0.55]  # of the ball [m], [kg], [m]
CORNER, ELEMENTS = 0.2, 2  # masses at the corners [kg]; elements of each side of a mesh
CABLE = inext.InextensibleCable(massPerLength=0.02, bendingStiffness=1e-4, bendingDamping=1e-5)
TETHER = inext.InextensibleCable(massPerLength=0.04, bendingStiffness=5e-4, bendingDamping=5e-5)
ANCHOR, THICKNESS = [-0.9, 0, 0], 0.01  # of the tether [m]; radius of the spheres at the knots [m]
CONTACT = {"contactStiffness": 2e3, "contactDamping": 1.0, "frictionMaterialIndex": 0}  # [N/m], [N s/m]
SETTINGS = inext.ExplicitSettings(stepSize=5e-4, massScaling=0.3)


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS, tethered=True):
    """Add the scene; returns its cables, and its bodies: ball and corners."""
    net, contact = Net(**SIZE, elements=elements), mbs.AddGeneralContact()
    cables, knots = net.add(mbs, addCable, CABLE)
    ball = mbs.CreateRigidBody(referencePosition=CENTRE, inertia=eu.InertiaSphere(MASS, RADIUS))
    start = {"initialVelocity": [0, 0, net.speed], "mass": CORNER}
    corners = {knot: mbs.CreateMassPoint(referencePosition=net.place(knot), **start) for knot in net.corners}
    contact.SetFrictionPairings(np.zeros((1, 1)))
    contact.SetSearchTreeBox(pMin=[-1, -1, -1], pMax=[1, 1, 4])
    contact.SetSearchTreeCellSize(numberOfCells=[10, 10, 25])
    contact.AddSphereWithMarker(mbs.AddMarker(eu.MarkerBodyRigid(bodyNumber=ball)), radius=RADIUS, **CONTACT)
    if tethered:
        shape = half_circle(-ANCHOR[0], 12, net.speed)
        cables.append(addCable(mbs, shape=shape, beamTemplate=TETHER))
        tie(mbs, [mbs.CreateGround(referencePosition=ANCHOR)], cables[-1]["nodes"][:1])
        knots[net.middle].append(cables[-1]["nodes"][-1])
    for knot, nodes in knots.items():
        marker = tie(mbs, [corners[knot]] if knot in corners else [], nodes)
        contact.AddSphereWithMarker(marker, radius=THICKNESS, **CONTACT)
    return {"cables": cables, "bodies": [ball, *corners.values()]}


def run(endTime=0.8, tethered=True):
    """The motion of cables and ball."""
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    return record(mbs, build(mbs, tethered=tethered), RADIUS, endTime, SETTINGS)


def main():
    run().snapshots("thrown_net", (0.0, 0.15, 0.3, 0.45, 0.6, 0.8))


if __name__ == "__main__":
    main()
