"""What users add to an mbs, and how it is found there again: cables, supports, loads, companions."""
