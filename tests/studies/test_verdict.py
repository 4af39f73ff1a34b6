"""A verdict is given where the measurement carries it, and only there."""

import math

import pytest

from studies.harness.table import UNDECIDED, at_most, verdict


@pytest.mark.parametrize(
    ("value", "noise", "found"),
    [
        (0.3, 1.5, "kept"), (0.4, 1.5, UNDECIDED), (0.6, 1.5, UNDECIDED), (0.8, 1.5, "MISSED"),
        (0.5, 1.0, "kept"), (0.501, 1.0, "MISSED"), (math.nan, 1.5, "MISSED"), (-1.0, 1.5, "kept"),
    ],
)  # fmt: skip
def test_only_what_noise_cannot_turn_is_decided(value, noise, found):
    assert verdict(at_most(value, 0.5, noise)) == found
