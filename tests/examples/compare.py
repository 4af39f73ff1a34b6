"""Figures of examples/README.md: python -m tests.examples.compare

Agreement with the native twin, how far the twin itself is converged, joints, energy; and the CPU time
of both solvers alone, best of three runs after a warm-up: as in the tests, and with the largest step that
keeps either of them within 1 % of the converged twin, both with the elements of the example.
"""

import dataclasses
import importlib
import sys
import time

import exudyn

from exudyn_inext import InextensibleError, SolveExplicit
from reference_models.conventional.settings import number_of_steps
from reference_models.model import quiet_settings, silence
from tests.examples.measures import gaps
from tests.examples.twins import disagreement, run_inextensible, run_native

NAMES = ("crane", "tethered_bodies", "net", "capstan", "drone", "slider_crank")
STEPS = (1e-2, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4, 2e-4)  # from which the largest one within the bound is taken [s]
BOUND = 1e-2
REPETITIONS = 3


def solver_time(example, arguments, solve):
    """CPU time [s] of solve(mbs), best of some."""
    times = []
    for _ in range(REPETITIONS + 1):
        container = exudyn.SystemContainer()
        mbs = container.AddSystem()
        example.build(mbs, **arguments)
        mbs.Assemble()
        with silence():
            start = time.process_time()
            solve(mbs)
            times.append(time.process_time() - start)
    return min(times[1:])


def inextensible_time(example, end_time, step):
    settings = quiet_settings(end_time, number_of_steps(step, end_time))
    explicit = dataclasses.replace(example.SETTINGS, stepSize=step)
    return solver_time(example, {}, lambda mbs: SolveExplicit(mbs, settings, explicit))


def native_time(example, twin):
    return solver_time(example, twin.arguments(example), lambda mbs: mbs.SolveDynamic(twin.settings()))


def largest_step(run, converged):
    """(step, error) of run(step) that stays within the bound."""
    for step in STEPS:
        try:
            error = disagreement(run(step), converged)
        except (exudyn.ExudynError, InextensibleError, AssertionError):
            continue  # did not converge, unstable, or Exudyn halved its steps
        if error < BOUND:
            return step, error
    raise AssertionError("no step is small enough")


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
    step = example.SETTINGS.stepSize
    yield f"CPU, test: inextensible, h = {step:g}: {inextensible_time(example, end_time, step):.3f} s"
    yield f"native, h = {twin.step:g}: {native_time(example, twin):.3f} s"
    step, error = largest_step(lambda h: run_inextensible(example, end_time, h), native)
    yield f"CPU, cheapest: inextensible, h = {step:g}: {inextensible_time(example, end_time, step):.3f} s"
    yield f"error {error:.1e}"
    step, error = largest_step(
        lambda h: run_native(example, dataclasses.replace(twin, step=h, refinement=1)), native
    )
    coarse = dataclasses.replace(twin, step=step, refinement=1)
    yield f"native, same elements, h = {step:g}, {error:.1e}: {native_time(example, coarse):.3f} s"


if __name__ == "__main__":
    for name in sys.argv[1:] or NAMES:
        print("\n    ".join(compare(name)), flush=True)
