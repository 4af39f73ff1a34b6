"""User functions of the state on a lone cable act as native items that do the same."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
)

from exudyn_inext import CreateCompanionCables, ExplicitSettings, SceneError, SolveEquilibrium, SolveExplicit
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import native_cable, solve_native
from tests.items.attach.test_weights import weigh

STIFFNESS, DAMPING = 20.0, 0.05
END = 0.3  # [s]


def pulled_by_a_function(mbs, cable):
    """A spring and a dashpot from the tip to where it begins."""
    tip = cable["nodes"][-1]

    def pull(mbs, t, load):
        u = np.array(mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Displacement))
        v = np.array(mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Velocity))
        return (-STIFFNESS * u - DAMPING * v).tolist()

    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=tip))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=pull))


def pulled_by_a_spring(mbs, cable):
    ground = MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[1.8, 0, 0])
    markers = [mbs.AddMarker(ground), mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))]
    mbs.AddObject(
        CartesianSpringDamper(markerNumbers=markers, stiffness=[STIFFNESS] * 3, damping=[DAMPING] * 3)
    )


def tip_of(mbs, add_pendulum, add, loop_steps, integrator="RATTLE"):
    """(3,) at the end, and the path that the steps took."""
    cable = add_pendulum(mbs)
    add(mbs, cable)
    mbs.Assemble()
    explicit = ExplicitSettings(integrator, stepSize=1e-3 if integrator == "RATTLE" else 2e-4)
    with silence():
        report = SolveExplicit(mbs, quiet_settings(END, loop_steps), explicit)
    place = mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position)
    return np.array(place), report["path"]


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
def test_a_spring_by_a_user_function_is_a_spring(new_mbs, add_pendulum, integrator):
    expected, path = tip_of(new_mbs(), add_pendulum, pulled_by_a_spring, 5, integrator)
    assert "in one compiled call" in path
    free, _ = tip_of(new_mbs(), add_pendulum, lambda *_: None, 5, integrator)
    assert np.linalg.norm(expected - free) > 0.1
    for loop_steps in (1, 50):
        found, path = tip_of(new_mbs(), add_pendulum, pulled_by_a_function, loop_steps, integrator)
        assert "may depend on the state" in path
        np.testing.assert_allclose(found, expected, atol=1e-8)


def test_a_support_that_follows_the_state_does_so_at_each_evaluation(new_mbs, add_pendulum):
    """The function asks mbs for the time, which has to be that of the evaluation."""

    def moved(mbs, cable):
        tip = cable["nodes"][-1]

        def height(mbs, t, itemNumber, offset):
            return 0.1 * (1.0 - np.cos(5.0 * mbs.systemData.GetTime()))

        ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=tip, coordinate=1))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker], offsetUserFunction=height))

    for loop_steps in (1, 20):
        found, _ = tip_of(new_mbs(), add_pendulum, moved, loop_steps)
        assert found[1] == pytest.approx(0.1 * (1.0 - np.cos(5.0 * END)), abs=1e-9)


def braked(mbs, elements, tip):
    """Weight that brakes the tip."""

    def gravity(mbs, t, vector):
        v = np.array(mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Velocity))
        return (vector - 3.0 * v).tolist()

    weigh(mbs, elements, function=gravity)


def braked_pendulum(mbs, cable):
    braked(mbs, CreateCompanionCables(mbs, cable), cable["nodes"][-1])


def test_weight_that_follows_the_state_acts_as_on_a_native_cable(new_mbs, add_pendulum):
    mbs = new_mbs()
    held = {"groundConstraintsStart": [True, True, False, False], "gravity": [0, 0, 0]}
    native = native_cable(mbs, 2, 20, axial_stiffness=2e5, **held)
    tip = native["nodes"][-1]
    braked(mbs, native["elements"], tip)
    mbs.Assemble()
    solve_native(mbs, END)
    expected = np.array(mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Position))

    def pendulum(mbs):
        return add_pendulum(mbs, gravity=[0, 0, 0], numberOfElements=8)

    for loop_steps in (1, 50):
        found, path = tip_of(new_mbs(), pendulum, braked_pendulum, loop_steps)
        assert "load 0 'load0' (MassProportional)" in path
        np.testing.assert_allclose(found, expected, atol=2e-3)


def test_equilibrium_under_a_weight_that_follows_the_state_is_refused(mbs, add_pendulum):
    braked_pendulum(mbs, add_pendulum(mbs))
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"load on element 0 of object \d.*dependsOnTimeOnly="):
        SolveEquilibrium(mbs)
