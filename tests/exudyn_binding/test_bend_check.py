"""What is said of cables that bend more sharply than their elements resolve."""

import warnings
from dataclasses import replace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import Torque

from exudyn_inext import (
    AddMarkerOnCable,
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    SolveEnsemble,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.exudyn_binding import solver
from reference_models.model import quiet_settings
from studies.robust.scenes import build, lone_rope

END, PERIOD = 1.5, 0.01  # [s]
FALLS_THROUGH_ITS_LOOP = lone_rope(28)  # a stiff rope of 1 m, upright at first, with a heavy end


def run(elements):
    """Path of the free end (T, 3) [m], and what was said."""
    _container, mbs, sensor = build(replace(FALLS_THROUGH_ITS_LOOP, elements=elements))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        SolveExplicit(mbs, quiet_settings(END, 1, PERIOD))
    return np.array(mbs.GetSensorStoredData(sensor))[:, 1:4], [str(one.message) for one in said]


def test_the_warning_comes_where_the_mesh_errs_and_goes_with_more_elements():
    (coarse, said), (fine, nothing), (reference, _) = map(run, (8, 16, 32))
    size = np.linalg.norm(np.ptp(reference, axis=0))
    assert np.abs(coarse - reference).max() > 0.03 * size
    assert np.abs(fine - reference).max() < 0.01 * size
    assert not nothing
    (said,) = said
    for words in ("between nodes", "an element of 0.125 m (limit 2.5 rad)", "Take shorter elements"):
        assert words in said


def ring(elements):
    mbs = exudyn.SystemContainer().AddSystem()
    shape = CableShape.Circle([0, 0, 0], 1.0, elements)
    section = InextensibleCable(1.0, 1.0, referenceCurvature=1.0)
    CreateInextensibleCable(mbs, shape=shape, beamTemplate=section)
    mbs.Assemble()
    return mbs


@pytest.mark.parametrize("elements", [8, 20])
def test_the_turn_of_a_ring_is_its_share_of_the_circle(elements, monkeypatch):
    found = []
    monkeypatch.setattr(solver, "warn_of_turns", found.extend)
    SolveExplicit(ring(elements), quiet_settings(1e-3, 2), ExplicitSettings(stepSize=5e-4))
    ((turn, _),) = found
    assert turn == pytest.approx(2 * np.pi / elements, rel=1e-3)


def test_the_member_of_an_ensemble_is_named():
    systems = [build(replace(FALLS_THROUGH_ITS_LOOP, elements=8, tip_mass=mass))[1] for mass in (0.0, 2.0)]
    with pytest.warns(UserWarning, match="member 1 of the ensemble: cable .* turns by"):
        SolveEnsemble(systems, quiet_settings(END, round(END / PERIOD)))


@pytest.mark.parametrize(("elements", "is_warned"), [(2, True), (8, False)])
def test_a_cantilever_that_two_elements_roll_up_is_warned_of(elements, is_warned):
    """By an end moment of 2 pi EI / L: the tip is at the clamp."""
    mbs = exudyn.SystemContainer().AddSystem()
    section, held = InextensibleCable(1.0, 1.0), [True] * 4
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], elements, section, groundConstraintsStart=held)
    end = AddMarkerOnCable(mbs, cable, 1.0, hasFrame=True)
    mbs.AddLoad(Torque(markerNumber=end, loadVector=[0, 0, 2 * np.pi]))
    mbs.Assemble()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        SolveEquilibrium(mbs)
    tip = mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position)
    assert (np.linalg.norm(tip) > 0.1) == is_warned
    assert [("its mesh does not resolve" in str(one.message)) for one in said] == [True] * is_warned
