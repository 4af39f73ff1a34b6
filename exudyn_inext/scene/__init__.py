"""Cables, bodies and joints as one system: each part keeps its own solve, joints couple them."""
