"""Settings of explicit runs."""

from dataclasses import replace

from exudyn_inext import ExplicitSettings, Zhai


def test_an_integrator_is_said_once_with_its_parameters():
    once = ExplicitSettings(integrator=Zhai(corrector=True))
    assert once == ExplicitSettings(integrator="Zhai", scheme=Zhai(corrector=True))
    assert once.integrator == "Zhai" and once.method[1].corrector
    assert replace(once, stepSize=1e-3).method[1].corrector
    assert ExplicitSettings(integrator=Zhai()).method == ExplicitSettings(integrator="Zhai").method


def test_a_run_with_it_is_that_of_the_scheme(mbs, add_pendulum, solve):
    add_pendulum(mbs)
    mbs.Assemble()
    ends = []
    for given in ({"integrator": "Zhai"}, {"integrator": Zhai()}, {"integrator": Zhai(projected_rate=False)}):
        report = solve(mbs, 0.2, stepSize=5e-4, **given)
        assert report["integrator"] == "Zhai"
        ends.append(mbs.systemData.GetODE2Coordinates())
    assert (ends[0] == ends[1]).all() and (ends[0] != ends[2]).any()
