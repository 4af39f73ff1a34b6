"""The last steps before a run went wrong, taken again one by one: only what is wrong is lost.

Inspections are many steps apart. A violent divergence takes fewer, so that the state of the last inspection
would be older than need be.
"""

from typing import Any

import numpy as np

from ..arrays import Array
from ..integrators.watch import PATIENCE, record_watched
from .time_grid import TimeGrid


def retrace(run: Any, scheme: Any, grid: TimeGrid, step: int, history: Array, good: int) -> int:
    """Go on from the last inspection to the first step that is wrong; its state is left out.

    Args:
        run: `CableRun` that has been stopped.   scheme: of its integrator.   grid: of the run.
        step: of the integrator, that ended at the last inspection.
        history: see `CableRun.record`; rows from `good` on are set.   good: rows that went well.

    Returns:
        Number of rows that went well.
    """
    account = run.watch.watch.account[0]
    if account.suspect >= PATIENCE:  # slow growth: the last inspection is as good as any
        return good
    trouble, error, rows = account.trouble, account.error, len(history) - good
    first_row = step // grid.substeps
    last = min(step + run.watch.watch.every, (first_row + rows) * grid.substeps)
    run.go_on(grid.start + step * grid.h)
    each_step = run.watch.watch._replace(every=1, least=1)
    row = np.zeros((1, *history.shape[1:]))
    for next_step in range(step, last):
        loads = run.loads.sample(grid.start, grid.h, 1, run.stages, first=next_step)
        if not record_watched(scheme, run.system, loads, run.state, grid.h, 1, row, each_step):
            break
        if (next_step + 1) % grid.substeps == 0:
            history[good] = row[0]
            good += 1
    if not account.trouble:
        account.trouble, account.error = trouble, error
    return good
