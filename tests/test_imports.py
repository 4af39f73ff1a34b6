"""What a run imports where its kernels are in the cache: nothing that takes longer than they do."""

import subprocess
import sys

import numba
import pytest

from tests.test_readme import NEEDLESS

SCENE = """
import exudyn
import numpy as np
from exudyn.itemInterface import MarkerBodyRigid, MarkerNodePosition, Node1D
from exudyn.itemInterface import ObjectGenericODE2, SphericalJoint
from exudyn.rigidBodyUtilities import InertiaSphere
from exudyn_inext import CreateInextensibleCable, InextensibleCable, SolveExplicit

mbs = exudyn.SystemContainer().AddSystem()
section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.05)
cable = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, gravity=[0, -9.81, 0], dimension=3)
at = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
for place in (1.0, 1.1, 1.2):
    body = mbs.CreateRigidBody(inertia=InertiaSphere(0.1, 0.05), referencePosition=[place, 0, 0])
    own = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))
    mbs.AddObject(SphericalJoint(markerNumbers=[at, own]))
    at = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[0.1, 0, 0]))
nodes = [mbs.AddNode(Node1D(referenceCoordinates=[0])) for _ in range(2)]
mbs.AddObject(ObjectGenericODE2(nodeNumbers=nodes, massMatrix=np.eye(2), forceVector=[1, 0]))
mbs.Assemble()
settings = exudyn.SimulationSettings()
settings.timeIntegration.endTime = 0.01
settings.timeIntegration.numberOfSteps = 10
settings.timeIntegration.verboseMode = 0
settings.solution.file.write = False
path = SolveExplicit(mbs, settings)["path"]
"""


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is kept")
def test_a_run_with_joints_bodies_and_matrices_imports_nothing_needless():
    found = {}
    exec(SCENE, found)  # compiles what is not in the cache
    assert "compiled" in found["path"]
    asked = f"{SCENE}\nimport sys; print([name for name in {NEEDLESS} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, timeout=300)
    assert run.stdout == "[]\n", run.stdout + run.stderr
