"""What a changed parameter asks of a run."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import exudyn
from exudyn.exudynCPP import ObjectIndex

from ..general.coupled_run import CoupledRun
from ..native_run import NativeRun
from ..time_loop import Run
from .log import Parameter

_JACOBIAN = exudyn.ComputeItemType.ConstraintJacobian
_OF_STIFFNESS = ("stiffness", "damping")


class Demand(IntEnum):
    """Nothing; an evaluation by Exudyn; the scene read again; runs built again."""

    NOTHING = 0
    EVALUATE = 1
    READ = 2
    BUILD = 3


def demand(mbs: Any, runs: Sequence[Run], key: Parameter) -> Demand:
    """What a change asks for, at least: what is read decides whether runs are built again.

    Exudyn evaluates whatever is not of a cable, so that loads and springs there act by themselves.
    """
    if key.kind == "Node":
        return Demand.NOTHING  # initial values
    if not any(isinstance(run, CoupledRun | NativeRun) for run in runs):
        return Demand.READ
    if key.kind == "Load":
        return Demand.EVALUATE
    if key.kind == "Marker":
        return Demand.READ
    return _of_object(mbs, key, any(isinstance(run, CoupledRun) for run in runs))


def _of_object(mbs: Any, key: Parameter, has_joints: bool) -> Demand:
    """has_joints: whether constraints are joints that can move."""
    kind = mbs.GetObject(key.number)["objectType"]
    if kind == "Ground":
        return Demand.READ
    is_constraint = _JACOBIAN in mbs.ComputeItem(ObjectIndex(key.number))
    if is_constraint:
        return Demand.READ if has_joints and key.name in ("offset", "distance") else Demand.BUILD
    is_connector = kind.startswith(("Connector", "Contact"))
    return Demand.EVALUATE if is_connector else Demand.BUILD


def changes_stiffness(key: Parameter) -> bool:
    """Whether the stability limit may follow a parameter of a connector."""
    name = key.name.lower()
    return key.kind == "Object" and (name == "activeconnector" or any(word in name for word in _OF_STIFFNESS))
