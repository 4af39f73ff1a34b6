"""A run of a scene with cables: inextensible under explicit steps, or native under implicit ones."""

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import SensorBody, SensorNode

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, SolveEquilibrium, SolveExplicit
from exudyn_inext.arrays import Array
from reference_models.conventional.cable import Quadrature
from reference_models.conventional.equilibrium import set_axial_stiffness
from reference_models.conventional.native_cables import NativeCables
from reference_models.conventional.settings import Implicit, LinearSolver, Newton, simulation_settings
from reference_models.model import quiet_settings, silence

from .cases import THETA, step_by_rule
from .coupled_scenes import CoupledScene, net_of_squares
from .memory import peak_memory
from .ratios import DEFAULT, ONE_SETTING, TUNED
from .store import Row

INITIAL = exudyn.ConfigurationType.Initial
PERIOD = 0.02  # of outputs [s]
RADII = (0.6, 0.95)  # other spectral radii of generalized-alpha
LEAST_STEP = 1 / 64  # of a native step that fails and is halved
SOFT = 0.1  # axial stiffness over that of the cable, from whose equilibrium statics begins: stiff ones fail
AT_ONCE = 1e-9  # of the load steps of statics [s]: loads that depend on time are those at the start


@dataclass(frozen=True)
class Inextensible:
    """elements: see the scene.   step: [s]; None: default settings.   theta: mass scaling.

    choice: DEFAULT, ONE_SETTING or TUNED.
    """

    elements: int
    step: float | None = None
    theta: float = THETA
    integrator: str = "RATTLE"
    choice: str = TUNED

    def __str__(self) -> str:
        return f"{self.integrator}, h = {self.step:g} s, theta = {self.theta:g}" if self.step else DEFAULT

    @property
    def add_cable(self) -> Callable[..., dict[str, Any]]:
        return CreateInextensibleCable

    @property
    def at_rest(self) -> "Inextensible":
        """What its equilibrium depends on."""
        return Inextensible(self.elements)

    def settle(self, mbs: Any) -> None:
        SolveEquilibrium(mbs)

    def solve(self, mbs: Any, end_time: float) -> None:
        explicit = ExplicitSettings()
        if self.step:
            explicit = ExplicitSettings(self.integrator, stepSize=self.step, massScaling=self.theta)
        SolveExplicit(mbs, quiet_settings(end_time, max(1, round(end_time / PERIOD)), PERIOD), explicit)

    def variants(self, scene: CoupledScene) -> "list[Inextensible]":
        """Other schemes on the same mesh, with the same step."""
        others = [replace(self, theta=0.0), replace(self, integrator="Zhai")]
        return others if self.choice == TUNED else []


def by_rule(scene: CoupledScene, elements: int) -> Inextensible:
    """The one setting for all scenes."""
    _container, mbs, _ = _build(scene, Inextensible(elements))
    mbs.Assemble()
    return Inextensible(elements, step_by_rule(mbs), THETA, "Zhai", ONE_SETTING)


@dataclass(frozen=True)
class Native:
    """elements: see the scene.   step: [s].   axial: stiffness [N].   radius, others: see `Implicit`."""

    elements: int
    step: float
    axial: float
    quadrature: Quadrature = "lobatto"
    newton: Newton = "modified"
    linear: LinearSolver = "sparse"
    tolerance: float = 1e-6
    radius: float = 0.8

    def __str__(self) -> str:
        axial, solver = f"EA = {self.axial:g} N, {self.quadrature}", f"{self.newton}, {self.linear}"
        return f"h = {self.step:g} s, {axial}, {solver}, {self.tolerance:g}, rho_inf = {self.radius:g}"

    @property
    def add_cable(self) -> Callable[..., dict[str, Any]]:
        return NativeCables(self.axial, self.quadrature)

    @property
    def at_rest(self) -> "Native":
        """What its equilibrium depends on."""
        return Native(self.elements, PERIOD, self.axial, self.quadrature)

    def settle(self, mbs: Any) -> None:
        settings = self._settings(PERIOD)
        settings.staticSolver.verboseMode = 0
        settings.staticSolver.loadStepDuration = AT_ONCE
        settings.staticSolver.newton.maxIterations = 100
        for share in (SOFT, 1.0):
            set_axial_stiffness(mbs, share * self.axial)
            mbs.SolveStatic(settings, updateInitialValues=True)

    def solve(self, mbs: Any, end_time: float) -> None:
        mbs.SolveDynamic(self._settings(end_time))

    def _settings(self, end_time: float) -> Any:
        solver = Implicit(self.step, self.newton, self.linear, self.tolerance, self.radius)
        settings = simulation_settings(solver, end_time)
        settings.timeIntegration.minimumStepSize = LEAST_STEP * self.step
        settings.solution.sensors.writePeriod = PERIOD
        return settings

    def variants(self, scene: CoupledScene) -> "list[Native]":
        """Other ways to solve the same equations."""
        newton: tuple[Newton, ...] = ("full", "modified", "modifiedEachStep")
        linear: tuple[LinearSolver, ...] = ("sparse", "dense") if scene.is_small else ("sparse",)
        options = product(newton, linear, (1e-6, 1e-4))
        others = [replace(self, newton=one, linear=two, tolerance=three) for one, two, three in options]
        return others + [replace(self, radius=radius) for radius in RADII]


Candidate = Inextensible | Native


def prepare(scene: CoupledScene, candidate: Candidate, end_time: float) -> Callable[[], tuple[float, Array]]:
    """A run; it returns its CPU time [s], set-up included, and times and paths of what is watched.

    Times [s] and positions [m] are (T, n, 4).
    """
    container, mbs, parts = _build(scene, candidate)
    sensors = _sensors(mbs, parts, candidate.elements // math.gcd(*scene.meshes))
    mbs.Assemble()
    if scene.settles:
        mbs.systemData.SetODE2Coordinates(_equilibrium(scene, candidate.at_rest), INITIAL)

    def run(kept: Any = container) -> tuple[float, Array]:
        with silence(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            start = time.process_time()
            candidate.solve(mbs, end_time)
            seconds = time.process_time() - start
        return seconds, np.stack([mbs.GetSensorStoredData(sensor) for sensor in sensors], axis=1)

    return run


def _build(scene: CoupledScene, candidate: Candidate) -> tuple[Any, Any, dict[str, Any]]:
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    return container, mbs, scene.build(mbs, addCable=candidate.add_cable, elements=candidate.elements)


@cache
def _equilibrium(scene: CoupledScene, candidate: Candidate) -> list[float]:
    """Coordinates of a scene at rest; native statics begin at the equilibrium of the other side."""
    _container, mbs, _ = _build(scene, candidate)
    mbs.Assemble()
    if isinstance(candidate, Native):
        guess = _equilibrium(scene, Inextensible(candidate.elements))
        mbs.systemData.SetODE2Coordinates(guess, INITIAL)
    with silence():
        candidate.settle(mbs)
    return list(mbs.systemData.GetODE2Coordinates(INITIAL))


def _sensors(mbs: Any, parts: dict[str, Any], stride: int) -> list[Any]:
    """Positions of nodes and bodies."""
    kept = {"storeInternal": True, "outputVariableType": exudyn.OutputVariableType.Position}
    nodes = [node for cable in parts["cables"] for node in cable["nodes"][::stride]]
    found = [SensorNode(nodeNumber=node, **kept) for node in nodes]
    found += [SensorBody(bodyNumber=body, **kept) for body in parts["bodies"]]
    return [mbs.AddSensor(sensor) for sensor in found]


def distance(paths: Array, reference: Array) -> float | None:
    """Root mean square of the distances of all points at all times, over the largest displacement [-].

    paths, reference: (T, n, 4), as of `prepare`.   None: at other times, as steps were halved, or not finite.
    """
    if paths.shape != reference.shape or not np.allclose(paths[..., 0], reference[..., 0], atol=1e-6):
        return None
    moved, expected = (some[..., 1:] - some[0, :, 1:] for some in (paths, reference))
    largest = np.linalg.norm(expected, axis=2).max()
    error = float(np.sqrt(((moved - expected) ** 2).sum(axis=2).mean()) / largest)
    return error if math.isfinite(error) else None


LARGE_ELEMENTS = 6  # of a cable of a large net
LARGE_STEP, LARGE_STEPS = 5e-4, (4, 104)  # [s]; of the short and the long run
LARGE_RUNS = 3  # of each: starts vary by as much as some steps cost


def large_net(formulation: str, meshes: int, runs: int) -> Row:
    """Start, step and memory of a large net, of this process; natives with modified Newton, the cheapest.

    runs: short and long ones, the fastest of which count.
    """
    is_ours = formulation == "inextensible"
    number, h = LARGE_ELEMENTS, LARGE_STEP
    candidate = Inextensible(number, h) if is_ours else Native(number, h, axial=1e5)
    few, many = LARGE_STEPS
    prepare(net_of_squares(2), candidate, few * h)()  # kernels
    short, long = (
        min(prepare(net_of_squares(meshes), candidate, steps * h)()[0] for _ in range(runs))
        for steps in LARGE_STEPS
    )
    step = (long - short) / (many - few)
    start = max(0.0, short - few * step)
    return {"startSeconds": start, "stepMilliseconds": 1e3 * step, "megabytes": peak_memory() / 1e6}
