"""A run that its process may not survive: Zhai's pendulum over 0.3 s, restart files every 0.05 s."""

from pathlib import Path

import exudyn
import numpy as np
from exudyn.itemInterface import SensorNode

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, InextensibleCable, SolveExplicit
from reference_models.model import quiet_settings, silence


def run(folder):
    """Rows of the tip's sensor file in `folder`, and the report."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    cable = CreateInextensibleCable(
        mbs,
        positionStart=[0, 0, 0],
        positionEnd=[1.8, 0, 0],
        numberOfElements=5,
        beamTemplate=InextensibleCable(massPerLength=0.0348, bendingStiffness=0.0866),
        gravity=[0, -9.81, 0],
        groundConstraintsStart=[True, True, False, False],
    )
    file = str(Path(folder) / "tip.txt")
    kind = exudyn.OutputVariableType.Position
    mbs.AddSensor(SensorNode(nodeNumber=cable["nodes"][-1], fileName=file, outputVariableType=kind))
    mbs.Assemble()
    settings = quiet_settings(0.3, 1)
    restart = settings.solution.restart
    restart.name = str(Path(folder) / "run.restart")
    restart.write = restart.continueIfAvailable = True
    restart.writePeriod = 0.05
    with silence():
        report = SolveExplicit(mbs, settings, ExplicitSettings(integrator="Zhai", stepSize=1e-3))
    return np.loadtxt(file, comments="#", delimiter=","), report
