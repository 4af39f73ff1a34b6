"""Settings of explicit runs."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext import ExplicitSettings, Zhai
from tests.exudyn_binding.items import load_node


def test_an_integrator_is_said_once_with_its_parameters():
    once = ExplicitSettings(integrator=Zhai(corrector=True))
    assert once.integratorName == "Zhai" and once.method[1].corrector
    assert replace(once, stepSize=1e-3).method[1].corrector
    assert ExplicitSettings(integrator=Zhai()).method == ExplicitSettings(integrator="Zhai").method


def test_a_scheme_beside_the_name_of_its_integrator_is_deprecated():
    with pytest.warns(DeprecationWarning, match=r"integrator=Zhai\(.*corrector=True") as said:
        twice = ExplicitSettings("Zhai", Zhai(corrector=True), stepSize=1e-3)
    assert said[0].filename == __file__
    assert twice == ExplicitSettings(Zhai(corrector=True), stepSize=1e-3)


def user_function(new_mbs, add_pendulum, solve, said):
    """Path and end of a run with a load whose user function cannot be seen to depend on the time alone."""
    mbs, calls = new_mbs(), []
    cable = add_pendulum(mbs)

    def force(mbs, t, load):
        calls.append(t)
        return [0, 0.2 * np.sin(9 * t), 0]

    load_node(mbs, cable["nodes"][-1], [0, 0, 0], loadVectorUserFunction=force)
    mbs.Assemble()
    report = solve(mbs, 0.1, stepSize=1e-3, dependsOnTimeOnly=[force] if said else None)
    return report["path"], mbs.systemData.GetODE2Coordinates(), calls


def test_functions_that_are_said_to_depend_on_the_time_alone_are_asked_ahead(new_mbs, add_pendulum, solve):
    path, end, calls = user_function(new_mbs, add_pendulum, solve, said=True)
    watched, expected, _ = user_function(new_mbs, add_pendulum, solve, said=False)
    assert "all loads are known" in path and "dependsOnTimeOnly=[function]" in watched
    np.testing.assert_allclose(end, expected, atol=1e-12)
    assert len(calls) >= 100


def test_a_run_with_it_is_that_of_the_scheme(mbs, add_pendulum, solve):
    add_pendulum(mbs)
    mbs.Assemble()
    ends = []
    for given in ({"integrator": "Zhai"}, {"integrator": Zhai()}, {"integrator": Zhai(projected_rate=False)}):
        report = solve(mbs, 0.2, stepSize=5e-4, **given)
        assert report["integrator"] == "Zhai"
        ends.append(mbs.systemData.GetODE2Coordinates())
    assert (ends[0] == ends[1]).all() and (ends[0] != ends[2]).any()
