"""Square nets of cables that meet in knots, inextensible or native: scenes to be timed."""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    MarkerBodyPosition,
    MarkerNodePosition,
    ObjectANCFCable,
    SensorNode,
    SphericalJoint,
)

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    SolveExplicit,
)
from exudyn_inext.arrays import Array
from reference_models.conventional.settings import Implicit, simulation_settings
from reference_models.model import quiet_settings, silence

from .memory import peak_memory
from .store import Row

GRAVITY = [0.0, 0.0, -9.81]
SECTION = {"massPerLength": 0.2, "bendingStiffness": 2e-3}
SIDE, SAG = 0.25, 0.15  # of a mesh [m], of the net over its size
PERIOD = 0.01  # of outputs [s]
STEP, STEPS = 5e-4, (4, 104)  # of large nets [s]; of the short and the long run
LARGE_ELEMENTS = 6


@dataclass(frozen=True)
class Net:
    """Meshes along each side; the net hangs from its corners, and is released in the shape of a bowl."""

    meshes: int

    @property
    def cables(self) -> int:
        return 2 * self.meshes * (self.meshes + 1)

    def place(self, i: int, j: int) -> list[float]:
        """Of a knot [m]."""
        x, y = i / self.meshes, j / self.meshes
        return [SIDE * i, SIDE * j, -4.0 * SAG * self.meshes * SIDE * (x * (1 - x) + y * (1 - y))]


@dataclass(frozen=True)
class Inextensible:
    """elements: of each cable.   step: [s]; None: default settings."""

    elements: int
    step: float | None = None

    def __str__(self) -> str:
        return "default settings" if self.step is None else f"h = {self.step:g} s, scaled"

    def add(self, mbs: Any, start: list[float], end: list[float]) -> list[Any]:
        """Nodes of a cable."""
        line = CableShape.Line(start, end, self.elements)
        template = InextensibleCable(**SECTION)
        return list(CreateInextensibleCable(mbs, shape=line, beamTemplate=template, gravity=GRAVITY)["nodes"])

    def solve(self, mbs: Any, end_time: float) -> None:
        explicit = ExplicitSettings()
        if self.step is not None:
            explicit = ExplicitSettings(stepSize=self.step, massScaling=0.3)
        SolveExplicit(mbs, quiet_settings(end_time, max(1, round(end_time / PERIOD)), PERIOD), explicit)


@dataclass(frozen=True)
class Native:
    """elements: of each cable.   step: [s].   axial: stiffness [N].   newton, linear: see `Implicit`."""

    elements: int
    step: float
    axial: float = 1e5
    newton: Any = "modified"
    linear: Any = "sparse"

    def __str__(self) -> str:
        return f"h = {self.step:g} s, EA = {self.axial:g} N, {self.newton}, {self.linear}"

    def add(self, mbs: Any, start: list[float], end: list[float]) -> list[Any]:
        """Nodes of a cable."""
        template = ObjectANCFCable(**SECTION, axialStiffness=self.axial)
        line = {"positionStart": start, "positionEnd": end, "numberOfElements": self.elements}
        return list(
            GenerateBeamElementsAlongLine(mbs, beamTemplate=template, gravity=GRAVITY, **line)["nodes"]
        )

    def solve(self, mbs: Any, end_time: float) -> None:
        solver = Implicit(self.step, self.newton, self.linear, spectral_radius=0.8)
        settings = simulation_settings(solver, end_time)
        settings.solution.sensors.writePeriod = PERIOD
        mbs.SolveDynamic(settings)


Candidate = Inextensible | Native


def prepare(net: Net, candidate: Candidate, end_time: float) -> Callable[[], tuple[float, Array]]:
    """A run; it returns its CPU time [s], set-up included, and the knots' paths (T, knots, 3)."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    ends: dict[tuple[int, int], list[Any]] = {}
    for i, j in np.ndindex(net.meshes + 1, net.meshes + 1):
        for other in ((i + 1, j), (i, j + 1)):
            if max(other) <= net.meshes:
                nodes = candidate.add(mbs, net.place(i, j), net.place(*other))
                ends.setdefault((i, j), []).append(nodes[0])
                ends.setdefault(other, []).append(nodes[-1])
    ground, sensors = mbs.CreateGround(), []
    for knot, nodes in ends.items():
        markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes]
        if set(knot) <= {0, net.meshes}:
            anchor = MarkerBodyPosition(bodyNumber=ground, localPosition=net.place(*knot))
            mbs.AddObject(SphericalJoint(markerNumbers=[mbs.AddMarker(anchor), markers[0]]))
        for marker in markers[1:]:
            mbs.AddObject(SphericalJoint(markerNumbers=[markers[0], marker]))
        kind = exudyn.OutputVariableType.Position
        sensors.append(
            mbs.AddSensor(SensorNode(nodeNumber=nodes[0], storeInternal=True, outputVariableType=kind))
        )
    mbs.Assemble()

    def run(kept: Any = container) -> tuple[float, Array]:
        with silence():
            start = time.process_time()
            candidate.solve(mbs, end_time)
            seconds = time.process_time() - start
        paths = [np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:4] for sensor in sensors]
        return seconds, np.stack(paths, axis=1)

    return run


def steps_of_large_net(formulation: str, meshes: int) -> Row:
    """Start, step and memory of this process."""
    is_ours = formulation == "inextensible"
    candidate = Inextensible(LARGE_ELEMENTS, STEP) if is_ours else Native(LARGE_ELEMENTS, STEP)
    prepare(Net(2), candidate, STEPS[0] * STEP)()  # kernels
    short, long = (prepare(Net(meshes), candidate, steps * STEP)()[0] for steps in STEPS)
    step = (long - short) / (STEPS[1] - STEPS[0])
    return {
        "startSeconds": max(0.0, short - STEPS[0] * step),
        "stepMilliseconds": 1e3 * step,
        "megabytes": peak_memory() / 1e6,
    }


if __name__ == "__main__":
    json.dump(steps_of_large_net(sys.argv[1], int(sys.argv[2])), sys.stdout)
