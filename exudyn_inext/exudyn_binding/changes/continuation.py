"""A run that goes on after its loads, or the places of its constraints, have changed."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ...integrators.integrator import Integrator
from ...run.cable_run import CableRun
from ...run.consistent_start import agree
from ...run.coupled_run import CoupledRun
from ...run.watch import KEPT, NOW, Watch


def go_on_with_cable(run: CableRun, time: float) -> None:
    """Begin again at `time` [s] with the present loads and motions."""
    with _account_kept(run.watch.watch), _history_kept(run.integrator, run.state):
        agree(run.system, run.loads.at(time), run.state)
        run.start(time)


def go_on_coupled(run: CoupledRun, time: float, end: float, has_changed: bool) -> None:
    """Begin again with the present motions, and joints that are fulfilled at `end` [s].

    has_changed: whether joints may have; if not, they rest.
    """
    run.watch.is_close = True
    with _account_kept(run.watch.watch), _history_kept(run.integrator, run.state):
        if has_changed:
            run.approach(time, end)
        else:
            run.rest_joints(time)
        run.start(time)


@contextmanager
def _account_kept(watch: Watch) -> Iterator[None]:
    """As `go_on` of a watch: what the change did to the energy is no error."""
    account = watch.account[NOW].copy()
    yield
    account.start = watch.account[NOW].start - account.work - account.surplus
    watch.account[NOW] = watch.account[KEPT] = account


@contextmanager
def _history_kept(integrator: Integrator, state: Any) -> Iterator[None]:
    """A multi-step scheme goes on with the rates of change that it knows: a force that jumps has none."""
    names = [name for name in integrator.carries if name != "a"]
    differences = {name: getattr(state, name) - state.a for name in names}
    yield
    for name, difference in differences.items():
        getattr(state, name)[:] = state.a + difference
