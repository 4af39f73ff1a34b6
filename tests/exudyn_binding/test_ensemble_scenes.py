"""Ensembles of cables among bodies, springs and joints."""

import exudyn
import numpy as np
import pytest

from examples import crane, net, slider_crank, tethered_bodies
from exudyn_inext import (
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    InputError,
    SceneError,
    SolveEnsemble,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_pendulum, that_remembers

END = 0.2
DERIVATIVES = ("coordinates", "velocities", "accelerations")


def add_members_cable(mbs, build, stiffness):
    """A scene of examples with cables of that bending stiffness, assembled."""

    def add_cable(mbs, beamTemplate, **arguments):
        template = InextensibleCable(beamTemplate.massPerLength, stiffness)
        return CreateInextensibleCable(mbs, beamTemplate=template, **arguments)

    build(mbs, add_cable)
    mbs.Assemble()


def of_stiffness(build):
    """f(EI) -> a scene of examples with cables of that bending stiffness."""

    def build_member(stiffness):
        mbs = exudyn.SystemContainer().AddSystem()
        add_members_cable(mbs, build, stiffness)
        return mbs

    return build_member


def last_state(mbs, **explicit):
    with silence():
        report = SolveExplicit(mbs, quiet_settings(END, 10, 0.02), ExplicitSettings(**explicit))
    data = mbs.systemData
    found = data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()
    return report, np.array(found)


def solve(build, parameters, threads=1, **explicit):
    settings = quiet_settings(END, 10, 0.02)
    return SolveEnsemble(build, settings, ExplicitSettings(**explicit), parameters, 2, threads)


@pytest.mark.parametrize(
    ("build", "explicit"),
    [
        (crane.build, {}),
        (crane.build, {"stepSize": 2e-3, "massScaling": 0.3}),
        (tethered_bodies.build, {}),
        (slider_crank.build, {}),
        (net.build, {"integrator": "Zhai"}),
    ],
)
def test_every_member_moves_as_it_does_alone(build, explicit):
    build_member, stiffnesses = of_stiffness(build), [0.03, 0.05]
    result = solve(build_member, stiffnesses, **explicit)
    assert result["status"] == ["ok", "ok"]
    for number, stiffness in enumerate(stiffnesses):
        report, alone = last_state(build_member(stiffness), **explicit)
        found = [result[name][number, -1] for name in DERIVATIVES]
        for member, expected in zip(found, alone, strict=True):
            np.testing.assert_allclose(member, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        assert result["stepSize"][number] == report["stepSize"]
        assert result["steps"][number] == report["steps"]
    assert np.abs(np.diff(result["coordinates"], axis=0)).max() > 1e-6
    mbs = build_member(0.03)
    reference = mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Reference)  # of bodies, too
    np.testing.assert_array_equal(result["referenceCoordinates"][0], reference)


def test_threads_change_no_bit_and_builders_may_return_the_same_system():
    build = of_stiffness(crane.build)
    several = solve(build, [0.03, 0.04, 0.05], threads=2)
    mbs = exudyn.SystemContainer().AddSystem()

    def rebuild(stiffness):
        mbs.Reset()
        add_members_cable(mbs, crane.build, stiffness)
        return mbs

    one = solve(rebuild, [0.03, 0.04, 0.05])
    for name in DERIVATIVES:
        np.testing.assert_array_equal(one[name], several[name])


def test_the_systems_stay_as_they_are(contents):
    mbs = of_stiffness(crane.build)(0.05)
    before = contents(mbs)
    solve(lambda _: mbs, [0])
    assert contents(mbs) == before


def test_what_only_exudyn_can_evaluate_is_refused_by_name():
    def build(_):
        mbs = of_stiffness(crane.build)(0.05)
        body = mbs.CreateMassPoint(mass=1.0, gravity=[0, 0, -9.81])

        def spring(mbs, t, number, u, v, k, d, force):
            return 10.0 * u**3

        mbs.CreateSpringDamper(
            itemNumbers=[mbs.CreateGround(), body],
            localPosition0=[0, 0, 1],
            stiffness=1.0,
            springForceUserFunction=that_remembers(spring),
        )
        mbs.Assemble()
        return mbs

    said = r"member 0 of the ensemble: SolveEnsemble needs compiled forms.*object \d+.*use SolveExplicit"
    with pytest.raises(SceneError, match=said):
        solve(build, [0])
    assert last_state(build(0))[0]["success"]


def test_initial_velocities_that_are_projected_name_the_member():
    systems = [exudyn.SystemContainer().AddSystem() for _ in range(2)]
    nodes = [add_pendulum(mbs)["nodes"] for mbs in systems]
    systems[1].SetNodeParameter(nodes[1][0], "initialVelocities", [0.0, 0.5, 0.0, 0.0])
    for mbs in systems:
        mbs.Assemble()
    said = r"^member 1 of the ensemble: the initial velocities of cable 'object0' violate the pin .* by 0\.5"
    with pytest.warns(UserWarning, match=said):
        SolveEnsemble(systems, quiet_settings(0.01, 1))


def test_members_with_other_bodies_are_refused():
    def build(bodies):
        mbs = exudyn.SystemContainer().AddSystem()
        add_pendulum(mbs)
        for _ in range(bodies):
            mbs.CreateMassPoint(mass=1.0)
        mbs.Assemble()
        return mbs

    with pytest.raises(InputError, match=r"member 1 .*number of coordinates = 27, that of member 0 is 24"):
        solve(build, [0, 1])
