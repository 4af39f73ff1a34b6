"""Parameters and states that are no numbers, as after a division by zero: refused by name."""

import math

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import CoordinateSpringDamperExt, MarkerNodeCoordinate, NodeGenericData

from exudyn_inext import DivergenceError, SceneError, SolveEquilibrium
from tests.exudyn_binding.items import load_node

ZERO_DIVIDED = "divided by zero"


@pytest.fixture
def scene(new_mbs, add_pendulum):
    """(**spring) -> assembled mbs, its load and a spring from a fixed point to the tip of a cable."""

    def build(**spring):
        mbs = new_mbs()
        cable = add_pendulum(mbs)
        load = load_node(mbs, cable["nodes"][3], [0.1, 0, 0])
        ends = [mbs.CreateGround(referencePosition=[2, 0, 0]), mbs.CreateMassPoint(mass=0.1)]
        number = mbs.CreateSpringDamper(itemNumbers=ends, stiffness=20.0, damping=0.1, **spring)
        mbs.Assemble()
        return mbs, load, number

    return build


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("moves", [True, False])
def test_a_load_is_named(scene, solve, contents, value, moves):
    mbs, load, _ = scene()
    mbs.SetLoadParameter(load, "loadVector", [0, value, 0])
    before = contents(mbs)
    with pytest.raises(
        SceneError, match=rf"loadVector of load {load} .* = \[0.0, {value}, 0.0\].*{ZERO_DIVIDED}"
    ):
        solve(mbs) if moves else SolveEquilibrium(mbs)
    assert contents(mbs) == before


def test_an_object_is_named(scene, solve):
    mbs, _, spring = scene()
    mbs.SetObjectParameter(spring, "force", math.nan)
    with pytest.raises(SceneError, match=rf"force of object {spring} .* = nan.*{ZERO_DIVIDED}"):
        solve(mbs)


@pytest.mark.parametrize("above", [-0.01, math.inf])
def test_stops_may_be_infinite(mbs, add_pendulum, solve, above):
    """They were, in the comparison with Exudyn: a warning of NumPy, and Exudyn evaluated the scene."""
    cable = add_pendulum(mbs)
    tip = [MarkerNodeCoordinate(nodeNumber=cable["nodes"][-1], coordinate=axis) for axis in (0, 1)]
    mbs.AddObject(
        CoordinateSpringDamperExt(
            markerNumbers=[mbs.AddMarker(marker) for marker in tip],
            nodeNumber=mbs.AddNode(NodeGenericData(numberOfDataCoordinates=3, initialCoordinates=[0] * 3)),
            useLimitStops=True,
            limitStopsLower=-math.inf,
            limitStopsUpper=above,
            limitStopsStiffness=1.0,
        )
    )
    mbs.Assemble()
    assert "Exudyn evaluates" not in solve(mbs, 1e-3)["path"]


@pytest.mark.parametrize("what", ["load", "spring", "velocities"])
def test_what_a_step_function_sets_is_named(scene, solve, what):
    mbs, load, spring = scene()
    velocities = [math.nan] * mbs.systemData.ODE2Size()
    act, message = {
        "load": (
            lambda: mbs.SetLoadParameter(load, "loadVector", [0, math.nan, 0]),
            rf"'loadVector' of load {load}",
        ),
        "spring": (lambda: mbs.SetObjectParameter(spring, "force", math.nan), rf"'force' of object {spring}"),
        "velocities": (lambda: mbs.systemData.SetODE2Coordinates_t(velocities), "coordinates or velocities"),
    }[what]
    mbs.SetPreStepUserFunction(lambda mbs, t: act() is None if t > 0.05 else True)
    with pytest.raises(SceneError, match=rf"step to t = 0\.06 s, {message} .*{ZERO_DIVIDED}"):
        solve(mbs, 0.1, steps=10)
    for get in ("GetODE2Coordinates", "GetODE2Coordinates_t"):
        assert np.isfinite(getattr(mbs.systemData, get)(exudyn.ConfigurationType.Current)).all()


def test_a_function_of_a_spring_is_the_likely_cause(scene, solve):
    def force(mbs, t, number, stretch, rate, stiffness, damping, offset):
        return stiffness * stretch if t < 0.05 else math.nan

    mbs, *_ = scene(springForceUserFunction=force)
    with pytest.raises(DivergenceError, match=r"Likely cause: a user function that returns no number"):
        solve(mbs, 0.1, steps=10)
