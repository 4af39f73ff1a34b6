"""Exudyn's own ParameterVariation: cantilevers of rising bending stiffness, let go under their weight.

`simulate` is a function of the module, so that Exudyn's worker processes can import it, and each call builds
its own system. The script uses all cores.
"""

import exudyn as exu
import numpy as np
from exudyn.processing import ParameterVariation

import exudyn_inext as inext
from picture import draw, paths, sense

LENGTH, DENSITY, GRAVITY = 1.0, 0.1, [0, -1, 0]  # [m], [kg/m], [m/s^2]
STIFFNESSES = [1.0, 2.0, 4.0, 8.0]  # EI [N m^2]


def simulate(parameters):
    """One cantilever: time between crossings of the mean deflection [s], solver's path, times, positions.

    parameters: {"bendingStiffness": EI [N m^2]}.
    """
    SC = exu.SystemContainer()
    mbs = SC.AddSystem()
    beam = inext.InextensibleCable(DENSITY, parameters["bendingStiffness"])
    clamp = [True] * 4
    cable = inext.CreateInextensibleCable(
        mbs, [0, 0, 0], [LENGTH, 0, 0], 8, beam, gravity=GRAVITY, groundConstraintsStart=clamp
    )
    sensors = sense(mbs, cable["nodes"])
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = 2
    settings.timeIntegration.numberOfSteps = 500
    settings.solution.sensors.writePeriod = 4e-3
    report = inext.SolveExplicit(mbs, settings)
    times, points = paths(mbs, sensors)
    swing = points[:, -1, 1] - points[:, -1, 1].mean()
    before = np.flatnonzero((swing[:-1] > 0) & (swing[1:] <= 0))
    crossings = times[before] + np.diff(times)[before] * swing[before] / (swing[before] - swing[before + 1])
    return float(np.diff(crossings).mean()), report["path"], times, points


def main(useMultiProcessing=False):
    varied = {"bendingStiffness": STIFFNESSES}
    _, found = ParameterVariation(simulate, varied, useMultiProcessing=useMultiProcessing)
    periods, reports, (times, *_), motions = zip(*found, strict=True)
    for stiffness, period in zip(STIFFNESSES, periods, strict=True):
        print(f"EI = {stiffness:g} N m^2: period {period:.4f} s")
    print(reports[0])
    curves = {f"EI = {EI:g}": points[:, -1, 1] for EI, points in zip(STIFFNESSES, motions, strict=True)}
    draw("parameter_variation", times, motions[:1], "xy", curves, "height of the tip y [m]")


if __name__ == "__main__":
    main(useMultiProcessing=True)
