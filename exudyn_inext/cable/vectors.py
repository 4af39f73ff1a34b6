"""Sums and products of arrays of coordinates, (n_dof,)."""

from ..compiled import called_kernel


@called_kernel
def combine(a, x, b, y, result):
    """result = a x + b y."""
    for i in range(len(x)):
        result[i] = a * x[i] + b * y[i]


@called_kernel
def inner(x, y):
    """Inner product."""
    total = 0.0
    for i in range(len(x)):
        total += x[i] * y[i]
    return total
