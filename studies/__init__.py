"""Measured comparisons: one file a study, `python -m studies list` shows them."""
