"""A step limit that cannot be found is never none: it is found in another way, or the run is refused."""

import numpy as np
import pytest
from exudyn.itemInterface import LoadCoordinate, MarkerNodeCoordinate

from exudyn_inext import SceneError
from exudyn_inext.integrators import INTEGRATORS
from tests.exudyn_binding.items import that_remembers, trajectory


@pytest.fixture
def beside_a_cable(new_mbs, add_pendulum, add_sensor, solve):
    """(add(mbs, point), beside, end, settings) -> report and path of a mass point of 2 kg."""

    def run(add, end=0.02, beside=True, start=(0, 0, 0), **explicit):
        mbs = new_mbs()
        if beside:
            add_pendulum(mbs)
        point = mbs.CreateMassPoint(
            mass=2.0, referencePosition=[0, 5, 0], initialVelocity=list(start), returnDict=True
        )
        add(mbs, point)
        sensor = add_sensor(mbs, point["nodeNumber"], "Velocity")
        mbs.Assemble()
        return solve(mbs, end, **explicit), trajectory(mbs, sensor)

    return run


def tied(mbs, point, stiffness=0.0, damping=0.0, **functions):
    ground = mbs.CreateGround(referencePosition=[0, 5, 0])
    return mbs.CreateCartesianSpringDamper(
        itemNumbers=[ground, point["bodyNumber"]],
        stiffness=[stiffness] * 3,
        damping=[damping] * 3,
        **functions,
    )


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_limit_of_a_coupled_scene_is_that_of_its_stiffest_spring(beside_a_cable, integrator):
    """Under RATTLE a spring is implicit, unless Exudyn evaluates it."""

    def force(mbs, t, number, stretch, speed, stiffness, damping, offset):
        return [k * x for k, x in zip(stiffness, stretch, strict=True)]

    law = {"springForceUserFunction": that_remembers(force)} if integrator == "RATTLE" else {}
    found, _ = beside_a_cable(lambda *of: tied(*of, 1e7, **law), integrator=integrator)
    assert found["bounds"].largest_frequency == pytest.approx(np.sqrt(1e7 / 2.0), rel=2e-3)


@pytest.mark.parametrize("beside", [True, False], ids=["beside a cable", "alone"])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_dashpot_without_spring_bounds_the_step(beside_a_cable, beside, integrator):
    """v = exp(-d t / m), of which explicit steps above some 2 m / d make an explosion.

    Under RATTLE a dashpot is implicit, unless Exudyn evaluates it.
    """
    rate = 1e5

    def force(mbs, t, number, stretch, speed, stiffness, damping, offset):
        return [d * v for d, v in zip(damping, speed, strict=True)]

    law = {"springForceUserFunction": that_remembers(force)} if integrator == "RATTLE" else {}
    with pytest.warns(UserWarning, match=r"damping of 1e\+05 1/s .* bounds the step"):
        report, path = beside_a_cable(
            lambda mbs, point: tied(mbs, point, damping=2.0 * rate, **law),
            end=2e-3,
            beside=beside,
            start=(1, 0, 0),
            integrator=integrator,
        )
    assert report["stepSize"] * rate < 3.0
    assert np.abs(path[-1, 1:]).max() < 1e-3
    if not beside:
        assert report["decidedBy"] == "bending"


def test_a_native_point_that_nothing_holds_has_no_limit(beside_a_cable):
    report, path = beside_a_cable(lambda *_: None, 0.1, beside=False, start=(1, 2, 0))
    assert report["bounds"].bending == np.inf
    np.testing.assert_allclose(path[-1, 1:], [1, 2, 0])


def nowhere(mbs, point):
    marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=point["nodeNumber"], coordinate=0))
    mbs.AddLoad(
        LoadCoordinate(markerNumber=marker, load=1.0, loadUserFunction=lambda mbs, t, load: float("nan"))
    )


def no_spring(mbs, point):
    """A force that is no number."""
    tied(mbs, point, springForceUserFunction=that_remembers(lambda *_: [float("nan")] * 3))


def no_stiffness(mbs, point):
    tied(mbs, point, float("nan"))


@pytest.mark.parametrize("size", [None, 1e-4], ids=["automatic", "given"])
@pytest.mark.parametrize(
    ("add", "said"),
    [
        (nowhere, r"the user function of load 0 .* returned nan at t = 0 s"),
        (no_spring, r"largest frequency of .* nan rad/s.*check the .*no step is known"),
        (no_stiffness, r"stiffness of object .* must be finite"),
    ],
)
def test_forces_that_are_not_finite_are_no_licence_for_any_step(beside_a_cable, add, said, size, fault):
    with pytest.raises(SceneError, match=said):
        beside_a_cable(add, stepSize=size)
    fault("forces that are not finite at the start", "refused, no step is known to be stable")


def test_native_items_of_forces_that_are_not_finite_are_refused(beside_a_cable):
    with pytest.raises(SceneError, match=r"largest frequency of native items .* nan rad/s"):
        beside_a_cable(no_spring, beside=False)
