"""Start, step and memory of a large net, in a process of its own: python -m ... FORMULATION MESHES."""

import json
import sys

from .coupled_runs import Inextensible, Native, prepare
from .coupled_scenes import net_of_squares
from .memory import peak_memory
from .store import Row

ELEMENTS = 6
STEP, STEPS = 5e-4, (4, 104)  # [s]; of the short and the long run


def measure(formulation: str, meshes: int) -> Row:
    """Both sides take the same steps; natives with modified Newton, the cheapest one."""
    is_ours = formulation == "inextensible"
    candidate = Inextensible(ELEMENTS, STEP) if is_ours else Native(ELEMENTS, STEP, axial=1e5)
    prepare(net_of_squares(2), candidate, STEPS[0] * STEP)()  # kernels
    large = net_of_squares(meshes)
    short, long = (prepare(large, candidate, steps * STEP)()[0] for steps in STEPS)
    step = (long - short) / (STEPS[1] - STEPS[0])
    return {
        "startSeconds": max(0.0, short - STEPS[0] * step),
        "stepMilliseconds": 1e3 * step,
        "megabytes": peak_memory() / 1e6,
    }


if __name__ == "__main__":
    json.dump(measure(sys.argv[1], int(sys.argv[2])), sys.stdout)
