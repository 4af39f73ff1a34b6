"""Sums and products of arrays of the shape of the coordinates, (n, 2, dim)."""

from ..compiled import called_kernel


@called_kernel
def combine(a, x, b, y, result):
    """result = a x + b y for arrays of the shape (n, 2, dim)."""
    for k in range(len(x)):
        for i in range(x.shape[2]):
            result[k, 0, i] = a * x[k, 0, i] + b * y[k, 0, i]
            result[k, 1, i] = a * x[k, 1, i] + b * y[k, 1, i]


@called_kernel
def inner(x, y):
    """Inner product of arrays of the shape (n, 2, dim)."""
    total = 0.0
    for k in range(len(x)):
        for i in range(x.shape[2]):
            total += x[k, 0, i] * y[k, 0, i] + x[k, 1, i] * y[k, 1, i]
    return total
