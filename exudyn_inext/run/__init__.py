"""A run: what moves, the steps that it takes, who watches them, and restart files."""
