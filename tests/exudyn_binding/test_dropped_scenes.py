"""A scene that nobody holds any more is freed, whichever way its run took."""

import gc
import weakref

import exudyn
import pytest
from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

from exudyn_inext import CreateCableForceSensor


@pytest.mark.parametrize("contents", ["cable", "cable and mass point", "mass point"])
def test_a_dropped_scene_is_freed(add_pendulum, solve, contents, quick_collections):
    def run():
        container = exudyn.SystemContainer()
        mbs = container.AddSystem()

        def force(mbs, t, load):
            return [0, 0.1, 0]

        if "cable" in contents:
            cable = add_pendulum(mbs, numberOfElements=2)
            CreateCableForceSensor(mbs, cable, 0.9)
            node = cable["nodes"][-1]
        if "mass point" in contents:
            point = mbs.CreateMassPoint(mass=1.0, referencePosition=[0, 0, 0], returnDict=True)
            node = point["nodeNumber"]
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=force))
        mbs.Assemble()
        solve(mbs, 0.02, stepSize=1e-3)
        return weakref.ref(force)

    reference = run()
    gc.collect()
    assert reference() is None
