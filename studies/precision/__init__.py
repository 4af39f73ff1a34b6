"""What `work_precision` runs on each scene."""
