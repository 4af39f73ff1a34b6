"""Properties are tried on the same examples in every run, without a time limit; failures are not stored."""

from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, max_examples=20, deadline=None, database=None)
settings.load_profile("repeatable")
