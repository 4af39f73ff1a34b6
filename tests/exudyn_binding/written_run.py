"""A run over 0.3 s that its process may not survive: files of two sensors and of the solution."""

import os
import signal
from pathlib import Path

import exudyn
from exudyn.itemInterface import SensorNode, SensorUserFunction
from exudyn.utilities import InertiaCuboid

from exudyn_inext import AttachToBody, ExplicitSettings, SolveExplicit
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_pendulum

FILES = ("first.txt", "second.txt", "solution.txt")


def build(folder, kind, die_at):
    """A pendulum, with a body at its end if `kind` is 'coupled'; sensors of its tip.

    While the row at `die_at` [s] is written, the process is killed: one sensor has written, one has not.
    """
    mbs = exudyn.SystemContainer().AddSystem()
    cable = add_pendulum(mbs)
    if kind == "coupled":
        body = mbs.CreateRigidBody(
            inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]),
            referencePosition=[1.85, 0, 0],
            gravity=[0, -9.81, 0],
            returnDict=True,
        )
        AttachToBody(mbs, cable, "end", body["bodyNumber"], [-0.05, 0, 0])

    def die(mbs, t, sensors, factors, configuration):
        if t > die_at:
            os.kill(os.getpid(), signal.SIGKILL)
        return [0.0]

    def add_sensor(name, output):
        kind_of_output = getattr(exudyn.OutputVariableType, output)
        file = str(Path(folder) / f"{name}.txt")
        mbs.AddSensor(
            SensorNode(nodeNumber=cable["nodes"][-1], fileName=file, outputVariableType=kind_of_output)
        )

    add_sensor("first", "Position")
    mbs.AddSensor(SensorUserFunction(sensorUserFunction=die, storeInternal=True))
    add_sensor("second", "Acceleration")
    return mbs


def run(folder, kind, end_time=0.3, die_at=1.0, times=None, integrator="RATTLE", **changes):
    """Runs, or continues, with files in `folder`; returns the report.

    kind: see `build`; with 'user', a step function notes its times [s] in `times`.
    changes: of simulationSettings.solution, as {"file.binary": True}.
    """
    mbs = build(folder, kind, die_at)
    times = [] if times is None else times

    def note(mbs, t):
        times.append(t)
        return True

    if kind == "user":
        mbs.SetPreStepUserFunction(note)
    mbs.Assemble()
    settings = quiet_settings(end_time, round(end_time / 0.005))
    settings.solution.sensors.writePeriod = 0.005
    settings.solution.file.write = True
    settings.solution.file.writePeriod = 0.02
    settings.solution.file.name = str(Path(folder) / "solution")
    settings.solution.precision = 17
    restart = settings.solution.restart
    restart.name = str(Path(folder) / "run.restart")
    restart.write = restart.continueIfAvailable = True
    restart.writePeriod = 0.05
    for name, value in changes.items():
        part, field = name.split(".")
        setattr(getattr(settings.solution, part), field, value)
    with silence():
        return SolveExplicit(mbs, settings, ExplicitSettings(integrator, stepSize=1e-3))
