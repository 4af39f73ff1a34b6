"""Whatever a public function is given: it succeeds, or raises an error of the package and changes nothing.

More examples, each target in a process of its own: python -m tests.bad_input.fuzz --examples 5000
"""

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from .fuzz import try_call
from .targets import TARGETS
from .values import calls


@pytest.mark.parametrize("name", TARGETS)
def test_valid_values_are_taken(name):
    target = TARGETS[name]
    arguments = {argument: values[0] for argument, values in target.valid.items()}
    assert try_call(target, arguments) == "succeeded"


@pytest.mark.parametrize("name", TARGETS)
@settings(
    max_examples=12,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(data=st.data())
def test_any_value_is_taken_or_refused(name, data):
    target = TARGETS[name]
    assert try_call(target, data.draw(calls(target.valid))) in ("succeeded", "refused")
