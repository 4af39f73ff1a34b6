"""Properties are tried on the same examples in every run, without a time limit; failures are not stored.

Known answers and faults are recorded as properties of their tests, for the table of `tests.verification`.
"""

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, max_examples=20, deadline=None, database=None)
settings.load_profile("repeatable")


@pytest.fixture
def known_answer(record_property):
    """(what, relative error, observed order): an answer that was known, and how well it was found."""

    def record(what, error, order=None):
        record_property("known answer", f"{what}|{error:.1e}|{'' if order is None else f'{order:.2f}'}")

    return record


@pytest.fixture
def fault(record_property):
    """(what, what came of it): something that went wrong, and was survived."""
    return lambda what, outcome: record_property("fault", f"{what}|{outcome}")
