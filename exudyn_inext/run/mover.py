"""What both ways to move a coupled scene share: by compiled kernels, or with evaluations of Exudyn."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..compiled import plain
from .cable_run import CableRun
from .joined_scene import EvaluatedScene, JoinedScene

FULFILLED = 1e-9  # violation of a joint [m, -] that needs no motion to be removed


class Mover:
    """Who takes the steps of a coupled scene; see `MovedByKernels` and `MovedByExudyn`.

    Args:
        scene: all of it.   runs: of its cables.   state, scheme: of the integrator.

    system: that takes the steps.
    given: (n,) forces besides those of the items, which others may set, or None: there are none.
    """

    given: Array | None = None

    def __init__(self, scene: JoinedScene, runs: Sequence[CableRun], state: Any, scheme: Any) -> None:
        self._scene, self._runs, self._state, self._scheme = scene, runs, state, scheme

    @property
    def system(self) -> Any:
        raise NotImplementedError

    def external_at(self, time: float) -> Array:
        """External force that the system is given at `time` [s]."""
        raise NotImplementedError

    @property
    def cables(self) -> list[Cable]:
        """Models of the inextensible cables."""
        return [run.scene_cable.cable for run in self._runs]

    def begin_by(self, function: Callable[..., None], time: float) -> None:
        """Begin with a function of the integrator, of (system, external, state)."""
        plain(function)(self._quick_system, self.external_at(time), self._state)

    @property
    def _quick_system(self) -> Any:
        """The system, for single evaluations."""
        return self.system

    def mass_as_it_is(self) -> AbstractContextManager[None]:
        """Nothing of the cables' bending is in the matrix on the left."""
        return together([run.mass_as_it_is() for run in self._runs])

    def put_reactions(self, evaluated: EvaluatedScene, t: float, state: Any, multipliers: Array) -> None:
        """Of the cables' own supports; `evaluated` is so at t [s].   state: q, v, ... of all parts."""
        supported = [cable for cable, run in enumerate(self._runs) if run.has_reactions]
        forces = evaluated.joined_forces() if supported else np.zeros(0)
        for cable in supported:
            run, dofs = self._runs[cable], self._scene.map.slices[cable]
            external = run.loads.at(t).copy()
            external[: dofs.stop - dofs.start] += forces[dofs]
            run.put_reactions(external, state[0][dofs], state[1][dofs], multipliers)


@contextmanager
def together(contexts: Sequence[AbstractContextManager[None]]) -> Iterator[None]:
    """Enter all of them."""
    with ExitStack() as stack:
        for context in contexts:
            stack.enter_context(context)
        yield
