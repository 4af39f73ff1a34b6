"""exudyn.artificialIntelligence, with stand-ins for what it imports where that is missing."""

import importlib
import importlib.util
import sys
from types import ModuleType, SimpleNamespace

import numpy as np


class Box:
    """As gymnasium.spaces.Box: arrays between two bounds."""

    def __init__(self, low, high, dtype=np.float32):
        self.low, self.high, self.dtype = np.asarray(low, dtype), np.asarray(high, dtype), dtype

    def contains(self, x):
        return bool(np.all(x >= self.low) and np.all(x <= self.high))

    def sample(self):
        return np.random.default_rng().uniform(self.low, self.high).astype(self.dtype)


def _stand_in(name, **contents):
    module = ModuleType(name)
    vars(module).update(contents)
    return module


def _stand_ins(warnings):
    warn = SimpleNamespace(warn=warnings.append)
    yield _stand_in("stable_baselines3", __version__="2.0.0")
    yield _stand_in("gymnasium", Env=type("Env", (), {}), spaces=SimpleNamespace(Box=Box), logger=warn)


def import_environments(monkeypatch):
    """Let exudyn.artificialIntelligence be imported; returns what a stand-in's logger warns of."""
    warnings = []
    for module in _stand_ins(warnings):
        if importlib.util.find_spec(module.__name__) is None:
            monkeypatch.setitem(sys.modules, module.__name__, module)
            monkeypatch.delitem(sys.modules, "exudyn.artificialIntelligence", raising=False)
    importlib.import_module("exudyn.artificialIntelligence")
    return warnings
