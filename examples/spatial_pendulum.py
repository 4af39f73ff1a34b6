"""Spatial flexible pendulum (section 4.3 of the paper): the same cable falls while it turns about its pin."""

import exudyn as exu

import exudyn_inext as inext
from picture import draw, paths, sense

LENGTH, ELEMENTS, END_TIME = 1.8, 10, 5  # [m], [-], [s]
PUSH = [0, 3, 0]  # initial velocity of the tip, horizontal and across the cable [m/s]
CABLE = inext.InextensibleCable(massPerLength=0.0347681, bendingStiffness=0.0866451)  # radius 2 mm
SETTINGS = inext.ExplicitSettings(stepSize=1.67e-3, massScaling=0.25)


def build(mbs, elements=ELEMENTS):
    """Add the scene; returns its cables."""
    cable = inext.CreateInextensibleCable(
        mbs,
        shape=inext.CableShape.Line([0, 0, 0], [LENGTH, 0, 0], elements, velocityEnd=PUSH),
        beamTemplate=CABLE,
        gravity=[0, 0, -9.81],
        groundConstraintsStart=[True, True, True, False, False, False],
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
    tip = {axis: points[:, -1, "xyz".index(axis)] for axis in "xyz"}
    show("spatial_pendulum", times, [points], "xz", tip, "position of the tip [m]")


if __name__ == "__main__":
    main()
