"""Agreement, joints and energy in examples/README.md: python -m tests.examples.compare

What both sides cost is measured by `python -m studies run coupled`.
"""

import dataclasses
import importlib
import sys

from tests.examples.measures import gaps
from tests.examples.twins import disagreement, run_inextensible, run_native

NAMES = ("crane", "tethered_bodies", "net", "capstan", "drone", "slider_crank")


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


if __name__ == "__main__":
    for name in sys.argv[1:] or NAMES:
        print("\n    ".join(compare(name)), flush=True)
