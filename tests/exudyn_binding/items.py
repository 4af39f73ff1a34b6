"""The cable of most tests, native items beside it, and runs with Exudyn's own solvers."""

import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    DistanceConstraint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodePosition,
    ObjectANCFCable,
    ObjectANCFCable2D,
)

from exudyn_inext import CreateInextensibleCable, InextensibleCable
from reference_models.model import quiet_settings, silence

SECTION = {"massPerLength": 0.0348, "bendingStiffness": 0.0866}
PINNED = [True, True, False, False]
COARSE = pytest.mark.filterwarnings("ignore:.*cable .* turns by")  # what is compared has one mesh


def add_cable(mbs, **changes):
    """A straight cable of 1.8 m, 5 elements, under gravity; keywords replace arguments."""
    line = {"positionStart": [0, 0, 0], "positionEnd": [1.8, 0, 0], "numberOfElements": 5}
    arguments = line | {"beamTemplate": InextensibleCable(**SECTION), "gravity": [0, -9.81, 0]} | changes
    if arguments.get("shape") is not None:
        arguments = {name: arguments[name] for name in arguments if name not in line}
    return CreateInextensibleCable(mbs, **arguments)


def add_pendulum(mbs, **changes):
    """The cable of `add_cable`, pinned at its first node."""
    return add_cable(mbs, **({"groundConstraintsStart": PINNED} | changes))


def restarting_settings(path, end, period):
    """Of a run in outputs of that period [s], which writes restart files there, and goes on from them."""
    settings = quiet_settings(end, round(end / period))
    restart = settings.solution.restart
    restart.name, restart.writePeriod = str(path), period
    restart.write = restart.continueIfAvailable = True
    return settings


def trajectory(mbs, sensor):
    return np.asarray(mbs.GetSensorStoredData(sensor))


def hang(mbs, node, anchor, length):
    """A rigid rod from a point to a node."""
    ground = mbs.CreateGround(referencePosition=[0.5 * x for x in anchor])
    markers = [
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=[0.5 * x for x in anchor])),
        mbs.AddMarker(MarkerNodePosition(nodeNumber=node)),
    ]
    return mbs.AddObject(DistanceConstraint(markerNumbers=markers, distance=length))


def load_node(mbs, node, force, **function):
    """A force on a node; `function`: loadVectorUserFunction."""
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    return mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=force, **function))


def that_remembers(function):
    """The same user function of an object, which stores something: Exudyn has to ask it."""
    last = {}

    def asked(mbs, t, *others):
        last["time"] = t
        return function(mbs, t, *others)

    return asked


def native_cable(mbs, dim, elements, section=SECTION, axial_stiffness=8e4, **line):
    """Nodes of a native cable of 1.8 m along x under gravity; `line` replaces arguments."""
    template = ObjectANCFCable2D if dim == 2 else ObjectANCFCable
    arguments = {
        "positionStart": [0, 0, 0],
        "positionEnd": [1.8, 0, 0],
        "beamTemplate": template(**section, axialStiffness=axial_stiffness),
        "gravity": [0, -9.81, 0],
    }
    return GenerateBeamElementsAlongLine(mbs, numberOfElements=elements, **(arguments | line))


def either_cable(mbs, native, dimension, section, axial_stiffness, **line):
    """Nodes of an inextensible cable, or of its native twin.   line: arguments that both take."""
    if native:
        with silence():
            made = native_cable(
                mbs, dimension, line.pop("numberOfElements"), section, axial_stiffness, **line
            )
    else:
        template = InextensibleCable(**section)
        made = CreateInextensibleCable(mbs, beamTemplate=template, dimension=dimension, **line)
    return [int(node) for node in made["nodes"]], made


def solve_native(mbs, end_time, step=1e-3):
    settings = quiet_settings(end_time, round(end_time / step))
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    with silence():
        mbs.SolveDynamic(settings)
