"""A net of three by three cables that hangs with its corners on rods, is stretched out flat, and is dropped.

Native spherical joints tie the cables where they cross; native distance constraints are the rods.
"""

import exudyn as exu
from exudyn.utilities import MarkerNodePosition, SphericalJoint

import exudyn_inext as inext
from picture import draw, paths, sense

GRAVITY = [0, 0, -9.81]
SIDE, ROD, ELEMENTS = 1.0, 0.6, 8  # of the net [m], length of the rods [m], of each cable
CABLE = inext.InextensibleCable(massPerLength=0.2, bendingStiffness=0.02)
SETTINGS = inext.ExplicitSettings(stepSize=1e-3, massScaling=0.3)
LINES = (0.0, 0.5, 1.0)  # where cables run, and cross, over the side


def build(mbs, addCable=inext.CreateInextensibleCable, elements=ELEMENTS):
    """Add the scene; returns its cables, knots: pairs of nodes, and rods: (anchor, node)."""

    def add(start, end):
        line = inext.CableShape.Line(start, end, elements)
        return addCable(mbs, shape=line, beamTemplate=CABLE, gravity=GRAVITY)

    along_x = [add([0, SIDE * y, 0], [SIDE, SIDE * y, 0]) for y in LINES]
    along_y = [add([SIDE * x, 0, 0], [SIDE * x, SIDE, 0]) for x in LINES]
    ground, knots, rods = mbs.CreateGround(), [], []
    for y, first in zip(LINES, along_x, strict=True):
        for x, second in zip(LINES, along_y, strict=True):
            pair = first["nodes"][round(x * elements)], second["nodes"][round(y * elements)]
            markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in pair]
            mbs.AddObject(SphericalJoint(markerNumbers=markers))
            knots.append(pair)
            if x in (0, 1) and y in (0, 1):
                anchor = [SIDE * x, SIDE * y, ROD]
                mbs.CreateDistanceConstraint(itemNumbers=[ground, pair[0]], localPosition0=anchor)
                rods.append((anchor, pair[0]))
    return {"cables": along_x + along_y, "bodies": [], "knots": knots, "rods": rods}


def main():
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    sensors = [sense(mbs, cable["nodes"]) for cable in build(mbs)["cables"]]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 1
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    points = [paths(mbs, cable)[1] for cable in sensors]
    curves = {"centre": points[1][:, ELEMENTS // 2, 2], "edge": points[0][:, ELEMENTS // 2, 2]}
    times = paths(mbs, sensors[0])[0]
    draw("net", times, points[:3], "xz", curves | {"corner": points[0][:, 0, 2]}, "height z [m]")


if __name__ == "__main__":
    main()
