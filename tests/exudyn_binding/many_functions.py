"""A scene with user functions of many kinds, to be built in several processes."""

import functools

import numpy as np
from scipy.interpolate import CubicSpline

from exudyn_inext import CreatePrescribedMotion
from tests.exudyn_binding.items import add_cable, load_node

NAMES = {"x", "y", "z", "up", "down"}
TABLE = {"times": [0.0, 1.0, 2.0], "forces": np.array([0.0, 0.1, 0.3])}


class Pull:
    """Keeps what has no meaning elsewhere."""

    def __init__(self, mbs, strength):
        self.mbs, self.strength, self.names = mbs, strength, NAMES

    def __call__(self, mbs, t, load):
        return [self.strength if "up" in self.names else 0.0, 0, 0]


def tabulated(mbs, t, load, axis=0):
    force = [0.0, 0.0, 0.0]
    force[axis] = float(np.interp(t, TABLE["times"], TABLE["forces"]))
    return force if axis in {0, 1, 2} and "x" in {"x", "y"} else load


def build(container):
    mbs = container.AddSystem()
    mbs.variables["container"] = id(container)
    nodes = add_cable(mbs)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], lambda t: [0.0, 0.1 * (1.0 - np.cos(5.0 * t))])
    spline = CubicSpline(TABLE["times"], TABLE["forces"])
    functions = [
        tabulated,
        functools.partial(tabulated, axis=1),
        Pull(mbs, 0.1),
        lambda mbs, t, load: [float(spline(t)), 0, 0],
    ]
    for node, function in zip(nodes[1:], functions, strict=False):
        load_node(mbs, node, [0, 0, 0], loadVectorUserFunction=function)
    mbs.SetPreStepUserFunction(lambda mbs, t: True)
    mbs.Assemble()
    return mbs
