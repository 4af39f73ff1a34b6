"""The watch over one cable during a run, and what it says."""

import math
from typing import Any

import numpy as np

from ..arrays import Array
from ..chain.border import all_links, motions_of
from ..chain.cable import Cable
from ..integrators.watch import (
    CONSTRAINTS,
    ENERGY,
    FAILED,
    JUMP,
    LARGEST_JUMP,
    LARGEST_VIOLATION,
    LEAST_STEPS,
    NOW,
    STEPS_BETWEEN,
    STEPS_WITH_POWER,
    TOO_FAST,
    VIOLENT,
    Watch,
    build_watch,
    go_on,
    open_account,
)
from .cable_loads import CableLoads
from .scene import CableInScene

ROUND_OFF = 1e3 * np.finfo(float).eps


class CableWatch:
    """Keeps the account of one cable.

    watch: for `record_watched`.
    """

    def __init__(
        self,
        scene_cable: CableInScene,
        loads: CableLoads,
        state: Any,
        energy_tolerance: float,
        gains_energy: bool,
    ) -> None:
        cable = scene_cable.cable
        self._names = scene_cable.item.node_names
        self._shape = cable.reference.shape
        self._round_off = _round_off(cable, loads.constant)
        moves = not all(motion.rests for motion in motions_of(all_links(cable)))
        has_power = moves or bool(cable.section.bending_damping) or cable.drag is not None
        every = STEPS_WITH_POWER if has_power else STEPS_BETWEEN
        most = VIOLENT * energy_tolerance if gains_energy else np.inf
        self.watch = build_watch(state, every, energy_tolerance, loads.pattern, LEAST_STEPS, most)

    def limit_phase(self, duration: float, phase: float) -> None:
        """Let it find steps that are too long for the motion; arguments: see `Watch`."""
        self.watch = self.watch._replace(duration=duration, phase=phase)

    def open(self, system: Any, external: Array, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        open_account(self.watch, system, external, state, self._round_off)

    def go_on(self, system: Any, external: Array, state: Any) -> None:
        """With another step, from a state that the integrator has just started from."""
        go_on(self.watch, system, external, state)

    @property
    def has_trouble(self) -> bool:
        """Whether the last steps went wrong."""
        return bool(self.watch.account[NOW].trouble)

    @property
    def steps_to_halve(self) -> int:
        """How often the step must be halved for the motion; 0 if it is short enough."""
        return steps_to_halve(self.watch)

    @property
    def gains_too_much(self) -> bool:
        """Whether the energy has grown so much altogether that smaller steps do not help."""
        return bool(self.watch.account[NOW].trouble == ENERGY)

    @property
    def steps(self) -> int:
        """That have been inspected and found well."""
        return int(self.watch.account[NOW].steps)

    def finding(self, state: Any) -> str:
        """What went wrong, by how much, and where.   state: the last good one."""
        left, right = self._fastest_element(state.a)
        return f"{finding(self.watch)}; its accelerations are largest between nodes {left} and {right}"

    def _fastest_element(self, a: Array) -> tuple[Any, Any]:
        """Nodes of the element with the largest accelerations."""
        sizes = np.linalg.norm(a.reshape(self._shape)[:, 0], axis=1)
        k = int(np.argmax(sizes[1:] + sizes[:-1]))
        return self._names[k], self._names[k + 1]


def steps_to_halve(watch: Watch) -> int:
    """How often the step must be halved for the motion; 0 if it is short enough."""
    if watch.account[NOW].trouble != TOO_FAST:
        return 0
    excess = watch.account[FAILED].phase / watch.phase
    return max(1, math.ceil(0.5 * math.log2(max(excess, 1.0))))


def figures(watch: Watch) -> dict[str, float]:
    """Extremes so far: 'energyGain', 'energyLoss' [-] and 'constraints' [-]; see `Watch`."""
    account = watch.account[NOW]
    return {
        "energyGain": float(account.gain),
        "energyLoss": -float(account.loss),
        "constraints": float(account.violation),
    }


def memory_of(watch: Watch) -> dict[str, Any]:
    """Arrays that its next inspections depend on, by names."""
    names = ("account", "position", "work", "gauges")
    return {name: getattr(watch, name) for name in names} | {"kept": watch.kept._asdict()}


def finding(watch: Watch) -> str:
    """What went wrong, and by how much."""
    account = watch.account[FAILED]
    if account.trouble == CONSTRAINTS:
        return (
            f"inextensibility or another constraint is violated by {account.violation:.2g} "
            f"(limit {LARGEST_VIOLATION:g})"
        )
    if account.trouble == ENERGY:
        return (
            f"it has {account.error:.2%} more energy than the work done on it explains, of what its "
            f"motion turns over (limit {watch.most:.2%})"
        )
    if account.trouble == JUMP:
        return (
            f"its energy jumps by more than {LARGEST_JUMP * watch.tolerance:.2%} of what its motion turns "
            "over within a few steps"
        )
    return "its coordinates are not finite any more"


def _round_off(cable: Cable, force: Array) -> float:
    """Of the energy [J]: forces between nodes as if they were not straight, times round-off of places."""
    lengths, q = cable.element_lengths, cable.reference
    extent = float(np.abs(q[:, 0]).max()) + cable.length
    stiff = 12.0 * cable.section.bending_stiffness * float((1.0 / lengths**2).sum())
    return ROUND_OFF * extent * (stiff + float(np.abs(force[: q.size]).sum()))
