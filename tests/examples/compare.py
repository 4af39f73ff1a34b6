"""Figures of examples/README.md: python -m tests.examples.compare

Agreement with the native twin, how far the twin itself is converged, joints, energy; and the CPU time
of both, set-up included, best of three: the cheapest settings within 1 % and within 0.1 % of
the converged twin, with the elements of the example or twice as many. The native solver is tuned over step,
Newton's method and linear solver.
"""

import dataclasses
import importlib
import itertools
import sys
import time

import exudyn

from exudyn_inext import InextensibleError, SolveExplicit
from reference_models.conventional.settings import number_of_steps
from reference_models.model import quiet_settings, silence
from tests.examples.measures import gaps
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

NAMES = ("crane", "tethered_bodies", "net", "capstan", "drone", "slider_crank")
STEPS = (2e-2, 1e-2, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4, 2e-4)  # [s]
BOUNDS = (1e-2, 1e-3)
NEWTON, LINEAR, MESHES = ("full", "modified", "modifiedEachStep"), ("dense", "sparse"), (1, 2)
REPETITIONS = 3
PROMISING = 2.0  # times the cheapest first run: what is timed again


def solver_time(example, arguments, solve, repetitions):
    """CPU time [s] of solve(mbs), best of some."""
    times = []
    for _ in range(repetitions):
        container = exudyn.SystemContainer()
        mbs = container.AddSystem()
        example.build(mbs, **arguments)
        mbs.Assemble()
        with silence():
            start = time.process_time()
            solve(mbs)
            times.append(time.process_time() - start)
    return min(times)


@dataclasses.dataclass(frozen=True)
class Ours:
    """SolveExplicit with a step [s], and so many elements for each one of the example."""

    step: float
    refinement: int

    def __str__(self):
        return f"h = {self.step:g} s, {self.refinement} x"

    def run(self, example, end_time):
        elements = self.refinement * example.ELEMENTS
        return run_inextensible(example, end_time, self.step, elements=elements)

    def time(self, example, end_time, repetitions):
        settings = quiet_settings(end_time, number_of_steps(self.step, end_time))
        explicit = dataclasses.replace(example.SETTINGS, stepSize=self.step)
        build = {"elements": self.refinement * example.ELEMENTS}
        return solver_time(example, build, lambda mbs: SolveExplicit(mbs, settings, explicit), repetitions)


@dataclasses.dataclass(frozen=True)
class Native:
    """The twin, tuned."""

    twin: Twin

    @property
    def step(self):
        return self.twin.step

    def __str__(self):
        twin = self.twin
        return f"h = {twin.step:g} s, {twin.refinement} x, {twin.newton}, {twin.linear_solver}"

    def run(self, example, end_time):
        return run_native(example, self.twin)

    def time(self, example, end_time, repetitions):
        twin = self.twin
        solve = lambda mbs: mbs.SolveDynamic(twin.settings())  # noqa: E731
        return solver_time(example, twin.arguments(example), solve, repetitions)


def cheapest(candidates, example, converged, end_time):
    """For each bound: (CPU time, error, which) of the cheapest candidate within it."""
    found, enough = [], 0.0
    for candidate in candidates:
        if candidate.step < enough:
            continue
        try:
            error = disagreement(candidate.run(example, end_time), converged)
            if error < max(BOUNDS):
                found.append((candidate.time(example, end_time, 1), error, candidate))
            if error < min(BOUNDS):
                enough = max(enough, candidate.step / 2)  # less than half of it costs too much
        except (exudyn.ExudynError, InextensibleError, AssertionError):
            continue  # did not converge, unstable, or Exudyn halved its steps
    best = []
    for bound in BOUNDS:
        within = [one for one in found if one[1] < bound]
        least = min(seconds for seconds, _, _ in within)
        again = [one for one in within if one[0] < PROMISING * least]
        timed = [(c.time(example, end_time, REPETITIONS), error, c) for _, error, c in again]
        best.append(min(timed, key=lambda one: one[0]))
    return best


def compare(name):
    """Sentences about one example."""
    example = importlib.import_module(f"examples.{name}")
    test = importlib.import_module(f"tests.examples.test_{name}")
    twin, end_time = test.TWIN, test.TWIN.end_time
    run, native = run_inextensible(example, end_time), run_native(example, twin)
    halved = disagreement(run_native(example, dataclasses.replace(twin, step=twin.step / 2)), native)
    refined = disagreement(native, run_native(example, dataclasses.replace(twin, refinement=4)))
    yield f"{name}, {end_time:g} s: agreement {disagreement(run, native):.1e}"
    yield f"twin with half the step {halved:.1e}, with twice the elements {refined:.1e}"
    yield f"joints {max(gaps(run)):.1e} m"
    if hasattr(test, "energy_error"):
        yield f"energy {test.energy_error(run):.1e}"
    mine = [Ours(step, mesh) for step in STEPS for mesh in MESHES]
    options = itertools.product(STEPS, MESHES, NEWTON, LINEAR)
    theirs = [
        Native(dataclasses.replace(twin, step=h, refinement=n, newton=newton, linear_solver=linear))
        for h, n, newton, linear in options
    ]
    both = (cheapest(those, example, native, end_time) for those in (mine, theirs))
    for bound, ours, their in zip(BOUNDS, *both, strict=True):
        for who, (seconds, error, which) in (("inextensible", ours), ("native", their)):
            yield f"within {bound:g}, {who}: {seconds:.4f} s, error {error:.1e} ({which})"
        yield f"within {bound:g}: native over inextensible {their[0] / ours[0]:.2f}"


if __name__ == "__main__":
    for name in sys.argv[1:] or NAMES:
        print("\n    ".join(compare(name)), flush=True)
