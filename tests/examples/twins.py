"""The same scene with native ANCF cables and the implicit solver."""

import dataclasses
from dataclasses import dataclass

import exudyn
import numpy as np

from exudyn_inext import SolveExplicit
from reference_models.conventional.native_cables import NativeCables
from reference_models.conventional.settings import Implicit, number_of_steps, simulation_settings
from reference_models.model import quiet_settings, silence
from tests.examples.measures import record

LOOP_STEP = 0.01  # of Exudyn's time loop at most, where the solver chooses its own step [s]


@dataclass(frozen=True)
class Twin:
    """How the twin of an example is solved, and for how long: fine enough to be converged.

    end_time, step: [s].   axial: stiffness [N].   refinement: elements for each one of the example.
    """

    end_time: float
    step: float
    axial: float
    refinement: int = 2

    def arguments(self, example):
        """Of the example's build."""
        return {"addCable": NativeCables(self.axial), "elements": self.refinement * example.ELEMENTS}

    def settings(self):
        """Of Exudyn's implicit solver."""
        solver = Implicit(self.step, "modified", "sparse", spectral_radius=0.6)
        return simulation_settings(solver, self.end_time)


def run_inextensible(example, end_time, step=None, settings=None, **build):
    """(scene, history) of an example with its own settings, or another step [s], or other settings."""
    scene, history, mbs, _container = _build(example, build)
    explicit = settings or example.SETTINGS
    explicit = dataclasses.replace(explicit, stepSize=step or explicit.stepSize)
    loop = quiet_settings(end_time, number_of_steps(explicit.stepSize or LOOP_STEP, end_time))
    with silence():
        scene["report"] = SolveExplicit(mbs, loop, explicit)
    return scene, history.stacked()


def run_native(example, twin):
    """(scene, history) of the twin."""
    scene, history, mbs, _container = _build(example, twin.arguments(example))
    with silence():
        mbs.SolveDynamic(twin.settings())
    return scene, history.stacked()


def _build(example, build):
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    scene = example.build(mbs, **build) | {"elements": example.ELEMENTS}
    return scene, record(mbs, scene), mbs, container


def disagreement(inextensible, native):
    """Largest distance of the twins' points over the largest displacement: nodes of all cables, and bodies.

    inextensible, native: (scene, history); the nodes of the first are among those of the second.
    """
    one, other = (_points(*run) for run in (inextensible, native))
    times, a, b = _at_common_times(inextensible[1].t, native[1].t, one, other)
    assert len(times) > 20
    distances = [np.linalg.norm(x - y, axis=-1).max() for x, y in zip(a, b, strict=True)]
    displacements = [np.linalg.norm(y - y[0], axis=-1).max() for y in b]
    return float(max(distances) / max(displacements))


def _points(scene, history):
    """Paths (n, k, dim) of all nodes that the coarse cables have, and of all bodies."""
    paths = []
    for cable, (q, _) in zip(scene["cables"], history.cables, strict=True):
        stride = (len(cable["nodes"]) - 1) // scene["elements"]
        paths.append(q[:, ::stride, 0])
    return paths + [body.position[:, None] for body in history.bodies]


def _at_common_times(t_one, t_other, one, other):
    times, a, b = np.intersect1d(np.round(t_one, 9), np.round(t_other, 9), return_indices=True)
    return times, [x[a] for x in one], [x[b] for x in other]
