"""Exudyn's items that have compiled forms: read into the records of `multibody`."""
