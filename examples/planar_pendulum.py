"""Planar flexible pendulum (section 4.2 of the paper): a pinned cable falls from the horizontal."""

import exudyn as exu

import exudyn_inext as inext
from picture import draw, paths, sense

LENGTH, ELEMENTS, END_TIME = 1.8, 10, 5  # [m], [-], [s]
CABLE = inext.InextensibleCable(massPerLength=0.0347681, bendingStiffness=0.0866451)  # radius 2 mm
SETTINGS = inext.ExplicitSettings()  # RATTLE, with the largest safe step


def build(mbs, elements=ELEMENTS):
    """Add the scene; returns its cables."""
    cable = inext.CreateInextensibleCable(
        mbs,
        positionStart=[0, 0, 0],
        positionEnd=[LENGTH, 0, 0],
        numberOfElements=elements,
        beamTemplate=CABLE,
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True, True, False, False],
    )
    return {"cables": [cable]}


def main(show=draw):
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    sensors = sense(mbs, build(mbs)["cables"][0]["nodes"])
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END_TIME
    print(inext.SolveExplicit(mbs, settings, SETTINGS)["path"])
    times, points = paths(mbs, sensors)
    tip = {"x": points[:, -1, 0], "y": points[:, -1, 1]}
    show("planar_pendulum", times, [points], "xy", tip, "position of the tip [m]")


if __name__ == "__main__":
    main()
