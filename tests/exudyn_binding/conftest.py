"""Scenes to start from: fresh systems, the pendulum's cable, quiet runs, contents of a system."""

import gc
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import SensorNode

from exudyn_inext import ExplicitSettings, SolveExplicit
from exudyn_inext.run import step_control
from reference_models.model import quiet_settings, silence
from tests import scene_contents
from tests.exudyn_binding import items


@pytest.fixture
def new_mbs():
    """() -> empty MainSystem; the containers live as long as the test."""
    containers = []

    def new():
        containers.append(exudyn.SystemContainer())
        return containers[-1].AddSystem()

    return new


@pytest.fixture
def mbs(new_mbs):
    return new_mbs()


@pytest.fixture
def add_cable():
    return items.add_cable


@pytest.fixture
def add_pendulum():
    return items.add_pendulum


@pytest.fixture
def solve():
    """Runs an mbs quietly; returns the report."""

    def run(mbs, end_time=0.1, settings=None, steps=1, **explicit):
        settings = settings or quiet_settings(end_time, steps)
        with silence():
            return SolveExplicit(mbs, settings, ExplicitSettings(**explicit))

    return run


@pytest.fixture(scope="module")
def quick_collections():
    """Garbage is looked for among objects of this module's tests; there are millions of older ones."""
    gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.fixture
def without_smaller_steps(monkeypatch):
    """Steps that go wrong are not taken again: what would need the smallest ones ends a run at once."""
    monkeypatch.setattr(step_control, "QUARTERS", 0)


@pytest.fixture
def add_sensor():
    """(mbs, node, output) -> number of a sensor with internal storage."""

    def add(mbs, node, output="Position"):
        kind = getattr(exudyn.OutputVariableType, output)
        return mbs.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind))

    return add


@pytest.fixture
def contents():
    """mbs -> everything that a refused call must leave as it was."""
    return scene_contents.contents


@pytest.fixture
def centre_of_mass():
    """(q (n, 2, dim), element length) -> (dim,) centre of mass of the Hermite curve [m]."""

    def centre(q, length):
        r, slope = q[:, 0], q[:, 1]
        integrals = 0.5 * (r[1:] + r[:-1]) + length / 12.0 * (slope[:-1] - slope[1:])
        return integrals.mean(axis=0)

    return centre


@pytest.fixture
def coordinates():
    """(mbs, nodes) -> (n, 2, dim) total coordinates in the current state."""

    def read(mbs, nodes):
        rows = [
            np.add(
                mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates),
                mbs.GetNodeParameter(node, "referenceCoordinates"),
            )
            for node in nodes
        ]
        return np.reshape(rows, (len(nodes), 2, -1))

    return read


@pytest.fixture
def twin(new_mbs, add_pendulum, add_sensor):
    """() -> fresh assembled pendulum: mbs, cable, tip sensor."""

    def build(**changes):
        mbs = new_mbs()
        cable = add_pendulum(mbs, **changes)
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return SimpleNamespace(mbs=mbs, cable=cable, tip=tip)

    return build
