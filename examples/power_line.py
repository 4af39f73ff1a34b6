"""Power line after ice shedding (section 4.4 of the paper): two spans at rest, then the ice is gone."""

import exudyn as exu
import numpy as np
from exudyn.utilities import LoadForceVector, MarkerNodePosition

import exudyn_inext as inext
from picture import draw, paths, sense

SPAN, LENGTH, ELEMENTS, END_TIME = 3.322, 6.7036, 20, 5  # [m], [m], [-], [s]
ROD, ICE = 0.1, [0, -1.162, 0]  # the middle hangs on a rod [m]; weight of the ice amid the first span [N]
BEND = np.sqrt(3 * (LENGTH - 2 * SPAN) / SPAN**3)  # y = BEND x (x - SPAN) is about as long as a span [1/m]
LINE = inext.InextensibleCable(massPerLength=9.26e-2, bendingStiffness=2.1113)
SETTINGS = inext.ExplicitSettings(stepSize=2e-3, massScaling=0.3)


def parabolas(elements):
    """Where the search for the equilibrium begins; nodes at equal arc lengths, horizontal in the middle."""
    x = np.linspace(0, SPAN, 1001)
    arc = np.append(0, np.cumsum(np.hypot(np.diff(x), BEND * np.diff(x * (x - SPAN)))))
    x = np.interp(np.linspace(0, arc[-1], elements // 2 + 1), arc, x)
    y, angle = BEND * x * (x - SPAN), np.arctan(BEND * (2 * x - SPAN))
    angle = np.concatenate([angle[:-1], [0], -angle[-2::-1]])
    positions = np.column_stack([np.append(x, SPAN + x[1:]), np.append(y, y[1:])])
    slopes = np.column_stack([np.cos(angle), np.sin(angle)])
    return inext.CableShape(positions, slopes, LENGTH / elements, lengthReference="straight")


def build(mbs, elements=ELEMENTS):
    """Add the scene with the ice on; returns its cables, and the load."""
    pins = {f"groundConstraints{end}": [True, True, False, False] for end in ("Start", "End")}
    line = inext.CreateInextensibleCable(
        mbs, shape=parabolas(elements), beamTemplate=LINE, gravity=[0, -9.81, 0], **pins
    )
    middle, iced = line["nodes"][elements // 2], line["nodes"][elements // 4]
    mbs.CreateDistanceConstraint(itemNumbers=[mbs.CreateGround(), middle], localPosition0=[SPAN, ROD, 0])
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=iced))
    return {"cables": [line], "ice": mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=ICE))}


def main(show=draw):
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    scene = build(mbs)
    sensors = sense(mbs, scene["cables"][0]["nodes"])
    mbs.Assemble()
    inext.SolveEquilibrium(mbs)
    mbs.SetLoadParameter(scene["ice"], "loadVector", [0, 0, 0])
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END_TIME
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    heights = {"ice was here": points[:, ELEMENTS // 4, 1], "other span": points[:, 3 * ELEMENTS // 4, 1]}
    show("power_line", times, [points], "xy", heights, "height y [m]")


if __name__ == "__main__":
    main()
