"""Overhead contact line: the force of a pantograph runs along the contact wire.

Droppers, which are rods, hang it from the messenger wire; constant forces at the ends tension both.
"""

import exudyn as exu
import exudyn.utilities as eu
import numpy as np

import exudyn_inext as inext
from overhead_parts import add_moving_force, parabolas
from picture import draw, paths, sense

GRAVITY, TENSION = [0, -9.81, 0], 16e3  # [m/s^2], of each wire [N]
SPAN, DROPPERS, ELEMENTS, DEPTH = 50.0, 10, 2, 1.2  # [m], in a span, between two droppers, of the line [m]
FORCE, SPEED = 150.0, 40.0  # of the pantograph [N], [m/s]
MESSENGER = inext.InextensibleCable(massPerLength=1.1, bendingStiffness=130)
CONTACT = inext.InextensibleCable(massPerLength=1.35, bendingStiffness=200)
BEND = 9.81 * (MESSENGER.massPerLength + CONTACT.massPerLength) / (2 * TENSION)  # it carries both [1/m]


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS, spans=1):
    """Add the scene, near its equilibrium; returns its cables and bodies."""
    x = np.linspace(0, spans * SPAN, spans * (DROPPERS + 1) * elements + 1)
    shapes = parabolas(x, SPAN, DEPTH, BEND), inext.CableShape.Line([0, 0], [x[-1], 0], len(x) - 1)
    messenger = addCable(mbs, shape=shapes[0], beamTemplate=MESSENGER, gravity=GRAVITY)
    contact = addCable(mbs, shape=shapes[1], beamTemplate=CONTACT, gravity=GRAVITY)
    zero = mbs.AddMarker(eu.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(eu.NodePointGround()), coordinate=0))
    masts = range(0, len(x), elements * (DROPPERS + 1))
    for nodes, held in ((messenger["nodes"], masts), (contact["nodes"], (0, masts[-1]))):
        for node, axis in [(nodes[0], 0)] + [(nodes[k], 1) for k in held]:
            on_wire = mbs.AddMarker(eu.MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
            mbs.AddObject(eu.CoordinateConstraint(markerNumbers=[zero, on_wire]))
        end = mbs.AddMarker(eu.MarkerNodeCoordinate(nodeNumber=nodes[-1], coordinate=0))
        mbs.AddLoad(eu.LoadCoordinate(markerNumber=end, load=TENSION))
    for k in set(range(0, len(x), elements)) - set(masts):
        mbs.CreateDistanceConstraint(itemNumbers=[messenger["nodes"][k], contact["nodes"][k]])
    add_moving_force(mbs, contact["nodes"], x[1], FORCE, SPEED)
    return {"cables": [messenger, contact], "bodies": []}


def main():
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    wires = [sense(mbs, wire["nodes"]) for wire in build(mbs)["cables"]]
    mbs.Assemble()
    inext.SolveEquilibrium(mbs)
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = SPAN / SPEED
    print(inext.SolveExplicit(mbs, settings)["path"])
    (times, messenger), (_, contact) = (paths(mbs, sensors) for sensors in wires)
    uplift = {f"dropper {k}": 1e3 * (contact - contact[0])[:, k * ELEMENTS, 1] for k in (3, 5, 8)}
    draw("overhead_line", times, [messenger, contact], "xy", uplift, "uplift [mm]")


if __name__ == "__main__":
    main()
