"""The examples with the step that the solver chooses, without mass scaling."""

import importlib

import pytest

from examples import crane, tethered_bodies
from exudyn_inext import ExplicitSettings
from tests.examples.measures import gaps
from tests.examples.twins import run_inextensible


@pytest.mark.parametrize("name", ["crane", "net", "drone", "slider_crank", "capstan"])
def test_joints_hold_to_a_micrometre(name):
    example = importlib.import_module(f"examples.{name}")
    run = run_inextensible(example, 0.3, settings=ExplicitSettings())
    assert max(gaps(run)) < 1e-6


def test_the_margin_allows_for_the_tension_that_swinging_causes():
    """The crane's tension doubles; with 0.95 of the limit at the start it would diverge at 0.8 s."""
    run = run_inextensible(crane, 1.2, settings=ExplicitSettings())
    assert max(gaps(run)) < 1e-6


def test_the_step_allows_for_the_tension_that_spinning_causes():
    """At rest, the limit would be 30 % higher, and the run would diverge before 0.1 s."""
    run = run_inextensible(tethered_bodies, 1.0, settings=ExplicitSettings())
    assert max(gaps(run)) < 1e-6
    assert run[0]["report"]["bounds"].bending < 4e-3
