"""The watch over one cable during a run, and what it says."""

from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.axial import SHORTEST
from ..cable.cable import Cable
from ..cable.links import all_links, motions_of
from ..cable.sparse_forms import mass_entries
from ..compiled import placed
from ..integrators.integrator import FACTOR, PROJECTION
from ..scene.model import CableInScene
from ..system import KINETIC, report_energy
from .cable_loads import CableLoads
from .flight import Flight, flight_of, is_tied
from .run_watch import RunWatch
from .watch import (
    FAILED,
    LEAST_STEPS,
    NOW,
    SMALL,
    STEPS_BETWEEN,
    STEPS_WITH_POWER,
    VIOLENT,
    build_watch,
    go_on,
    open_account,
)

ROUND_OFF = 1e3 * np.finfo(float).eps
FIRST_STEPS = 1  # before the first inspection, and between two where the power of a support trembles
SUDDEN = 2.0  # times its strain at rest under a load is that of a cable whose load begins at once


class CableWatch(RunWatch):
    """Keeps the account of one cable.

    watch: of `record_watched`.   round_off: of the energy, and that of stretch too small to count [J].
    """

    _placed: tuple[Any, Any] = (None, None)  # the watch, and the same one `placed`

    def __init__(
        self,
        scene_cable: CableInScene,
        loads: CableLoads,
        state: Any,
        energy_tolerance: float,
        gains_energy: bool,
    ) -> None:
        cable = scene_cable.cable
        self._cable = cable
        self.stretches = cable.stretches
        self._names = scene_cable.item.node_names
        self._shape = cable.reference.shape
        self.round_off = _round_off(cable, loads.constant) + _of_small_stretch(cable, loads.constant)
        moves = not all(motion.rests for motion in motions_of(all_links(cable)))
        is_damped = bool(cable.section.bending_damping or cable.section.axial_damping)
        self._has_power = moves or is_damped or cable.drag is not None
        every = STEPS_WITH_POWER if self._has_power else STEPS_BETWEEN
        most = VIOLENT * energy_tolerance if gains_energy else np.inf
        least = FIRST_STEPS if moves else LEAST_STEPS
        self._is_tied = is_tied(cable) or len(loads.pattern) > 0
        self.watch = build_watch(state, every, energy_tolerance, loads.pattern, least, most)

    @cached_property
    def flight(self) -> Flight:
        """How it may fly along."""
        dim = 0 if self._is_tied else self._cable.dimension
        ways = np.zeros((dim, *self._shape))
        ways[range(dim), :, 0, range(dim)] = 1.0
        return flight_of(ways.reshape(dim, self._cable.reference.size), mass_entries(self._cable))

    @property
    def placed(self) -> Any:
        """The watch, for `record_watched`."""
        if self._placed[0] is not self.watch:
            self._placed = self.watch, placed(self.watch)
        return self._placed[1]

    def open(self, system: Any, external: Array, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        self._report(system, external, state)
        self.watch.flight[:] = speeds, momenta = self.flight.along(state.v)
        seen = float(self.watch.present_report[KINETIC] - momenta @ (state.v - 0.5 * speeds))
        of_flight = ROUND_OFF * 0.5 * float(momenta @ speeds)
        open_account(self.watch, state, self.round_off + of_flight, seen)
        if self._has_power and self.stretches:  # it may set in at once, where supports begin to move
            self.watch.account["ahead"][NOW] = FIRST_STEPS

    def _report(self, system: Any, external: Array, state: Any) -> None:
        """Of the energy at present."""
        watch = self.watch
        report_energy(system, external, state.q, state.v, state.a, watch.force, watch.present_report)

    def go_on(self, system: Any, external: Array, state: Any) -> None:
        """With another step, from a state that the integrator has just started from."""
        self._report(system, external, state)
        go_on(self.watch, state)

    def begin_work(self) -> None:
        """Of forces that may have jumped: they are known from the first step on."""
        self.watch.work[:, FACTOR] = np.inf

    def keep(self, state: Any) -> None:
        """Return to this state after steps that go wrong: it begins with other forces than the one before."""
        for kept, now in zip(self.watch.kept, state, strict=True):
            kept[:] = now

    def count_ramp(self, loads: CableLoads, time: float, state: Any) -> None:
        """Count the work of what is missing of loads from a state at `time` [s] on, see `CableLoads.ramp`."""
        size, missing = len(state.q), loads.missing(time)
        known = loads.pattern[-1, :size].dot(state.q), missing, 0, size - 1
        for work in self.watch.work, self.watch.kept_work:
            work[-1, PROJECTION:] = known

    def _shorten_interval(self) -> bool:
        return bool(self.watch.account["ahead"][FAILED] > LEAST_STEPS)

    @property
    def steps(self) -> int:
        """That have been inspected and found well."""
        return int(self.watch.account["steps"][NOW])

    def finding(self, state: Any) -> str:
        """What went wrong, by how much, and where.   state: the last good one."""
        stretch, names = self._shortest_element(self.watch.kept.q)
        if self._cable.stretches and stretch < SHORTEST:
            return (
                f"its element between nodes {names[0]} and {names[1]} is compressed to {stretch:.1%} of its "
                "length, and about to turn inside out: use a larger axialStiffness, or compress it less"
            )
        left, right = self._fastest_element(state.a)
        return f"{self.found}; its accelerations are largest between nodes {left} and {right}"

    def _shortest_element(self, q: Array) -> tuple[float, tuple[Any, Any]]:
        """|r_x| where it is smallest, at a node or on average over an element, and nodes of that element."""
        nodal = q.reshape(self._shape)
        chords = np.linalg.norm(np.diff(nodal[:, 0], axis=0), axis=1) / self._cable.element_lengths
        slopes = np.linalg.norm(nodal[:, 1], axis=1)
        stretches = np.minimum(chords, np.minimum(slopes[:-1], slopes[1:]))
        k = int(np.argmin(stretches))
        return float(stretches[k]), (self._names[k], self._names[k + 1])

    def _fastest_element(self, a: Array) -> tuple[Any, Any]:
        """Nodes of the element with the largest accelerations."""
        sizes = np.linalg.norm(a.reshape(self._shape)[:, 0], axis=1)
        k = int(np.argmax(sizes[1:] + sizes[:-1]))
        return self._names[k], self._names[k + 1]


def _of_small_stretch(cable: Cable, force: Array) -> float:
    """Energy of a stretch too small to count [J], at most that of loads which begin at once.

    Axial vibrations that the step does not resolve hide energy, and set it free.
    """
    stiffness = cable.section.axial_stiffness
    if stiffness is None:
        return 0.0
    load = float(np.abs(force[: cable.reference.size]).sum())
    strain = min(SMALL, SUDDEN * load / stiffness)
    return 0.5 * stiffness * cable.length * strain**2


def _round_off(cable: Cable, force: Array) -> float:
    """Of the energy [J]: forces between nodes as if they were not straight, times round-off of places."""
    lengths, q = cable.element_lengths, cable.reference
    extent = float(np.abs(q[:, 0]).max()) + cable.length
    stiff = 12.0 * cable.section.bending_stiffness * float((1.0 / lengths**2).sum())
    return ROUND_OFF * extent * (stiff + float(np.abs(force[: q.size]).sum()))
