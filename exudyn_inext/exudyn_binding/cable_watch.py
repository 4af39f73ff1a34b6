"""The watch over one cable during a run, and what it says."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..chain.border import all_links, motions_of
from ..chain.cable import Cable
from ..integrators.watch import (
    CONSTRAINTS,
    ENERGY,
    LARGEST_VIOLATION,
    LEAST_STEPS_WITH_POWER,
    STEPS_BETWEEN,
    STEPS_WITH_POWER,
    Watch,
    build_watch,
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
        self, scene_cable: CableInScene, loads: CableLoads, state: Any, energy_tolerance: float
    ) -> None:
        cable = scene_cable.cable
        self._names = scene_cable.item.node_names
        self._shape = cable.reference.shape
        self._round_off = _round_off(cable, loads.constant)
        moves = not all(motion.rests for motion in motions_of(all_links(cable)))
        has_power = moves or bool(cable.section.bending_damping) or cable.drag is not None
        every, least = (
            (STEPS_WITH_POWER, LEAST_STEPS_WITH_POWER) if has_power else (STEPS_BETWEEN, STEPS_BETWEEN)
        )
        self.watch = build_watch(state, every, energy_tolerance, loads.pattern, least)

    def open(self, system: Any, external: Array, state: Any) -> None:
        """Begin with a state that the integrator has just started from."""
        open_account(self.watch, system, external, state, self._round_off)

    @property
    def has_trouble(self) -> bool:
        """Whether the last steps went wrong."""
        return bool(self.watch.account[0].trouble)

    @property
    def steps(self) -> int:
        """That have been inspected and found well."""
        return int(self.watch.account[0].steps)

    def finding(self, state: Any) -> str:
        """What went wrong, by how much, and where.   state: the last good one."""
        left, right = self._fastest_element(state.a)
        return f"{finding(self.watch)}; its accelerations are largest between nodes {left} and {right}"

    def _fastest_element(self, a: Array) -> tuple[Any, Any]:
        """Nodes of the element with the largest accelerations."""
        sizes = np.linalg.norm(a.reshape(self._shape)[:, 0], axis=1)
        k = int(np.argmax(sizes[1:] + sizes[:-1]))
        return self._names[k], self._names[k + 1]


def figures(watch: Watch) -> dict[str, float]:
    """Extremes so far: 'energyGain', 'energyLoss' [-] and 'constraints' [-]; see `Watch`."""
    account = watch.account[0]
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
    account = watch.account[0]
    if account.trouble == CONSTRAINTS:
        return (
            f"inextensibility or another constraint is violated by {account.violation:.2g} "
            f"(limit {LARGEST_VIOLATION:g})"
        )
    if account.trouble == ENERGY:
        return (
            f"it has {account.error:.2%} more energy than the work done on it explains, of what its "
            f"motion turns over (limit {watch.tolerance:.2%})"
        )
    return "its coordinates are not finite any more"


def _round_off(cable: Cable, force: Array) -> float:
    """Of the energy [J]: forces between nodes as if they were not straight, times round-off of places."""
    lengths, q = cable.element_lengths, cable.reference
    extent = float(np.abs(q[:, 0]).max()) + cable.length
    stiff = 12.0 * cable.section.bending_stiffness * float((1.0 / lengths**2).sum())
    return ROUND_OFF * extent * (stiff + float(np.abs(force[: q.size]).sum()))
