"""What both ways to move a coupled scene share: by compiled kernels, or with evaluations of Exudyn."""

from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from types import MappingProxyType
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..compiled import plain
from ..integrators.integrator import Integrator
from .cable_run import CableRun
from .coupled_watch import EvaluatedScene
from .step_control import ROUND_OFF

FULFILLED = 1e-9  # violation of a joint [m, -] that needs no motion to be removed
LEFT = 1e-6  # violation of joints [m, -] that integrators leave which do not solve for positions


class Mover:
    """Who takes the steps of a coupled scene; see `MovedByKernels` and `MovedByExudyn`.

    Args:
        scene: all of it.   runs: of its cables.   state: of the integrator.   method: it, and its scheme.

    system: that takes the steps.   evaluated: the scene, by whom evaluates it.
    given: (n,) forces besides those of the items, which others may set.
    implicit_contacts, fastest_rubbing_contact: their rates [1/s], see `multibody.implicit_contacts`.
    rate_of_drag: see `multibody.general_contacts`, at the last evaluation [1/s].
    jump: violation of joints [m, -] between two steps, beyond what the integrator leaves.
    asks: which load depends on the state, where compiled code asks its function.
    elsewhere: see `PacedRun`.
    takes_impulses: whether joints that move on may, see `Jumps`.
    """

    evaluated: EvaluatedScene
    given: Array
    asks = ""
    elsewhere: Any = None
    takes_impulses = False
    implicit_contacts: Mapping[int, float] = MappingProxyType({})
    fastest_rubbing_contact = 0.0
    rate_of_drag = 0.0
    _joined: tuple[list[float], Array] | None = None  # k times [s], (k, n) forces of items and joints there
    _settled: tuple[Array, Array] | None = None  # (D,), (2, D) what contacts are said to remember, and do

    def __init__(
        self, scene: Any, runs: Sequence[CableRun], state: Any, method: tuple[Integrator, Any]
    ) -> None:
        self._scene, self._runs, self._state = scene, runs, state
        self._integrator, self._scheme = method
        self.jump = LEFT if self._integrator.stabilised else FULFILLED

    @property
    def system(self) -> Any:
        raise NotImplementedError

    @property
    def approaches(self) -> bool:
        """Whether joints have moved through the last step, as they were changed."""
        raise NotImplementedError

    @property
    def followed_system(self) -> Any:
        """The same, or a slower one whose loads follow each state that it is given."""
        return self.system

    def external_at(self, time: float) -> Array:
        """External force that the system is given in the present state, at `time` [s]."""
        raise NotImplementedError

    @property
    def cables(self) -> list[Cable]:
        """Models of the inextensible cables."""
        return [run.scene_cable.cable for run in self._runs]

    def settle(self, time: float) -> None:
        """Let what contact and friction remember agree with the state at the start of a run.

        A contact that is said to be closed, and is open, would pull. Exudyn's loop begins with what is said.
        """
        given = self._scene.native_items.remembered
        self._settled = (given, self._settled_data(time)) if given.size else None

    def _settled_data(self, time: float) -> Array:
        """(2, D) what contacts remember in the present state."""
        raise NotImplementedError

    def _put_settled(self) -> None:
        """Before the first steps: into mbs, unless something has been set there since."""
        if self._settled and np.array_equal(self._scene.native_items.remembered, self._settled[0]):
            self._scene.remember(self._settled[1])
        self._settled = None

    def begin_by(self, function: Callable[..., None], time: float) -> None:
        """Begin with a function of the integrator, of (system, external, state)."""
        plain(function)(self.quick_system, self.external_at(time), self._state)

    @property
    def quick_system(self) -> Any:
        """The system, for single evaluations."""
        return self.system

    def loads_kept(self, time: float) -> AbstractContextManager[None]:
        """Loads at `time` [s], and motions, are not asked for again meanwhile."""
        return nullcontext()

    def take_constants(self) -> None:
        """Constant loads on cables, which have been changed."""
        self._scene.native_items.take_constants()

    def set_step(self, h: float) -> None:
        """Prepare the cables, and contact with them, for steps of h [s]."""
        for run in self._runs:
            run.set_step(h)

    @property
    def places(self) -> dict[str, Array]:
        """Where what slides is looked for, and how offsets are set, by names; of compiled joints."""
        return {}

    @property
    def contacts(self) -> dict[str, Array]:
        """What compiled contact remembers, and how it is in the matrices of the cables, by names."""
        return {}

    def implicit_damping_left_out(self, time: float) -> AbstractContextManager[None]:
        """Contact of cables, and springs, without what is implicit in them in the state at `time` [s]."""
        return nullcontext()

    has_springs = False  # that can be implicit

    def springs_left_out(self, time: float) -> AbstractContextManager[None]:
        """Springs that can be implicit pull as in the state at `time` [s], and do not damp."""
        return nullcontext()

    @property
    def damps_implicitly(self) -> bool:
        """Whether dashpots of springs are implicit."""
        return False

    def damp_implicitly(self, limit: float) -> bool:
        """Let springs be implicit from now on; whether there are any that can be.

        limit: of steps in which they are explicit, but for their dashpots [s].
        """
        return False

    def mass_as_it_is(self) -> AbstractContextManager[None]:
        """Nothing of the cables' bending is in the matrix on the left."""
        return together([run.mass_as_it_is() for run in self._runs])

    def put_reactions(
        self, times: Array, steps: Array, q: Array, v: Array, forces: Array, multipliers: Array
    ) -> None:
        """Of the cables' own supports, into the multipliers (k, m) of all algebraic equations.

        times, steps: (k,) of the states, rising, and before them [s].   q, v: (k, n) of all parts.
        forces: (k, n) of items and joints.
        """
        self._joined = times.tolist(), forces
        for run, dofs in zip(self._runs, self._scene.map.slices, strict=False):
            if run.has_reactions:
                run.put_reactions(times, forces[:, dofs], q[:, dofs], v[:, dofs], steps, multipliers)

    def joined_forces(self, time: float) -> Array | None:
        """(n,) of items and joints in the state at `time` [s]; None: nobody has asked for its reactions."""
        if self._joined is None:
            return None
        (times, forces), near = self._joined, ROUND_OFF * max(abs(time), 1.0)
        last = bisect_left(times, time + near) - 1
        return forces[last] if last >= 0 and abs(times[last] - time) <= near else None


@contextmanager
def together(contexts: Sequence[AbstractContextManager[None]]) -> Iterator[None]:
    """Enter all of them."""
    with ExitStack() as stack:
        for context in contexts:
            stack.enter_context(context)
        yield
