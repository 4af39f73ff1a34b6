"""Cables that stretch and are compressed fold in half waves, which elements must resolve."""

import math
import re

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import SensorNode

from exudyn_inext import CreateInextensibleCable, InextensibleCable, SolveEquilibrium, SolveExplicit
from reference_models.model import quiet_settings

LENGTH = 1.0
SAYS = "how it folds depends on its elements"


def released_rope(elements):
    """A rope that is pinned at one end and begins 5 % longer than it wants to be; sensor of its end."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(0.1, 0.1, axialStiffness=1e3, axialDamping=0.1, referenceAxialStrain=-0.05)
    supports = {"gravity": [0, -9.81, 0], "groundConstraintsStart": [True, True, False, False]}
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [LENGTH, 0, 0], elements, section, **supports)
    sensor = mbs.AddSensor(
        SensorNode(
            nodeNumber=cable["nodes"][-1],
            outputVariableType=exudyn.OutputVariableType.Position,
            storeInternal=True,
        )
    )
    mbs.Assemble()
    return mbs, sensor


def way_of_end(elements):
    mbs, sensor = released_rope(elements)
    SolveExplicit(mbs, quiet_settings(0.2, 100))
    return np.array(mbs.GetSensorStoredData(sensor))[:, 1:]


def test_too_few_elements_are_warned_of_and_those_that_the_message_asks_for_are_enough():
    with pytest.warns(UserWarning, match=SAYS) as caught:
        coarse = way_of_end(4)
    said = next(str(one.message) for one in caught if SAYS in str(one.message))
    longest = float(re.search(r"at most ([\d.e-]+\d) m", said)[1])
    advised, finest = way_of_end(math.ceil(LENGTH / longest)), way_of_end(48)
    motion = np.linalg.norm(finest - finest[0], axis=1).max()
    assert np.linalg.norm(coarse - finest, axis=1).max() > 0.1 * motion
    assert np.linalg.norm(advised - finest, axis=1).max() < 0.01 * motion


def test_what_starts_from_its_equilibrium_is_not_compressed():
    mbs, _ = released_rope(4)
    SolveEquilibrium(mbs)
    SolveExplicit(mbs, quiet_settings(0.2, 100))
