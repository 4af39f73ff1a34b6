"""What a changed parameter asks of a run."""

from collections.abc import Collection, Sequence
from enum import IntEnum
from typing import Any

import exudyn
from exudyn.exudynCPP import ObjectIndex

from ...items.parameters import Parameter
from ...run.coupled_run import CoupledRun
from ...run.run import Run

_JACOBIAN = exudyn.ComputeItemType.ConstraintJacobian
_PLACES = ("offset", "distance")


class Demand(IntEnum):
    """Nothing; an evaluation by Exudyn; joints that move; the scene read again; runs built again."""

    NOTHING = 0
    EVALUATE = 1
    MOVE = 2
    READ = 3
    BUILD = 4


def demand(mbs: Any, runs: Sequence[Run], own: Collection[int], key: Parameter) -> Demand:
    """What a change asks for, at least: what is read decides whether runs are built again.

    Exudyn evaluates whatever is not of a cable, so that loads and springs there act by themselves.

    Args:
        mbs: the system.   runs: of it.   own: objects that belong to a cable.   key: what has changed.
    """
    if key.kind == "Node":
        return Demand.NOTHING  # initial values
    coupled = [run for run in runs if isinstance(run, CoupledRun)]
    if not coupled:
        return Demand.READ
    if key.kind == "Load":
        return Demand.EVALUATE
    if key.kind == "Marker":
        return Demand.READ
    kind = mbs.GetObject(key.number)["objectType"]
    if kind == "Ground":
        return Demand.READ
    if _JACOBIAN in mbs.ComputeItem(ObjectIndex(key.number)):
        is_joint = key.name in _PLACES and not any(run.holds(key.number) for run in coupled)
        return Demand.BUILD if not is_joint else Demand.READ if key.number in own else Demand.MOVE
    is_connector = kind.startswith(("Connector", "Contact"))
    return Demand.EVALUATE if is_connector else Demand.BUILD
