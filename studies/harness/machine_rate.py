"""Multiply-adds a second that the processor does in one thread: one by one, and in vectors."""

from exudyn_inext.compiled import kernel
from exudyn_inext.lowered import local_array

SCALARS, LENGTH, DEPTH = 12, 64, 8


@kernel
def scalar_multiply_adds(times, x, y):
    """12 independent chains of multiply-adds, `times` long: enough to fill the pipelines."""
    a, b, c, d, e, f = y, y + 1.0, y + 2.0, y + 3.0, y + 4.0, y + 5.0
    g, h, i, j, k, m = y + 6.0, y + 7.0, y + 8.0, y + 9.0, y + 10.0, y + 11.0
    for _ in range(times):
        a = a * x + y
        b = b * x + y
        c = c * x + y
        d = d * x + y
        e = e * x + y
        f = f * x + y
        g = g * x + y
        h = h * x + y
        i = i * x + y
        j = j * x + y
        k = k * x + y
        m = m * x + y
    return a + b + c + d + e + f + g + h + i + j + k + m


@kernel
def vector_multiply_adds(times, x, y):
    """`times` times 8 multiply-adds on each of 64 numbers in the nearest cache."""
    z = local_array(64, 1)
    for n in range(64):
        z[n, 0] = y + n
    for _ in range(times):
        for n in range(64):
            value = z[n, 0]
            for _ in range(8):
                value = value * x + y
            z[n, 0] = value
    total = 0.0
    for n in range(64):
        total += z[n, 0]
    return total


def scalar_task(times: int) -> None:
    """For `seconds_per_time`; see MULTIPLY_ADDS."""
    scalar_multiply_adds(1000 * times, 0.999, 1e-3)


def vector_task(times: int) -> None:
    """For `seconds_per_time`; see MULTIPLY_ADDS."""
    vector_multiply_adds(100 * times, 0.999, 1e-3)


TASKS = {"scalar multiply-adds": scalar_task, "vector multiply-adds": vector_task}
MULTIPLY_ADDS = {
    "scalar multiply-adds": 1000 * SCALARS,
    "vector multiply-adds": 100 * LENGTH * DEPTH,
}
