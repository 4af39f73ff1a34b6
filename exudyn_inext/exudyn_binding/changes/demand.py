"""What a changed parameter asks of a run, and whether runs can go on with a scene that was read again."""

from collections.abc import Collection, Sequence
from dataclasses import fields, is_dataclass
from enum import IntEnum
from typing import Any

import exudyn
import numpy as np
from exudyn.exudynCPP import ObjectIndex

from ...cable.link import Motion
from ...items.attach.inert import is_inert_cable
from ...items.functions_of_time import drive_of
from ...items.parameters import Parameter, markers_placed_by, objects_at
from ...native.known.linear_forces import OF_MATRICES
from ...native.known.trees import ACTING, ON_LINKS
from ...run.coupled_run import CoupledRun, Run
from ...scene.model import Scene

_JACOBIAN = exudyn.ComputeItemType.ConstraintJacobian
_PLACES = ("offset", "distance", "offsetUserFunctionParameters")
# parameters of objects with mass that change their forces alone
_FORCES = {"GenericODE2": OF_MATRICES, "KinematicTree": ACTING | ON_LINKS}


class Demand(IntEnum):
    """What a run has to do, the more the larger it is.

    EVALUATE, BEGIN: evaluate, with other masses.   DRIVE, MOVE: joints have other velocities, places.
    READ, BUILD: read the scene again, build other runs.
    WEIGH: kernels of cables evaluate these weights, which are read with the scene.
    """

    NOTHING = 0
    EVALUATE = 1
    BEGIN = 2
    DRIVE = 3
    MOVE = 4
    WEIGH = 5
    READ = 6
    BUILD = 7


def demand(mbs: Any, runs: Sequence[Run], own: Collection[int], key: Parameter) -> Demand:
    """What a change asks for, at least: what is read decides whether runs are built again.

    Exudyn evaluates whatever is not of a cable, so that loads and springs there act by themselves.

    Args:
        mbs: the system.   runs: of it.   own: objects that belong to a cable.   key: what has changed.
    """
    if key.kind == "Node" and key.name != "referenceCoordinates":
        return Demand.NOTHING  # initial values
    coupled = [run for run in runs if isinstance(run, CoupledRun)]
    if not coupled:
        return Demand.READ
    if key.kind == "Load":
        return Demand.WEIGH if _is_weight_of_cable(mbs, key.number) else Demand.EVALUATE
    data = mbs.GetObject(key.number) if key.kind == "Object" else {}
    kind = data.get("objectType", "")
    if kind in ("", "Ground"):
        return _demand_of_place(mbs, coupled, own, key)
    if key.is_mass and all(run.mover.numbers.can_weigh(key) for run in coupled):
        return Demand.BEGIN
    if _JACOBIAN in mbs.ComputeItem(ObjectIndex(key.number)):
        return _demand_of_joint(coupled, own, key, data)
    is_force = "markerNumbers" in data  # of a connector, or contact
    if key.name in _FORCES.get(kind, ()):
        is_force = all(run.mover.numbers.has_same_entries(key.number) for run in coupled)
    return Demand.EVALUATE if is_force else Demand.BUILD


def _demand_of_joint(
    coupled: Sequence[CoupledRun], own: Collection[int], key: Parameter, data: dict[str, Any]
) -> Demand:
    if key.name not in _PLACES or any(run.holds(key.number) for run in coupled):
        return Demand.BUILD
    has_velocity = drive_of(data.get("offsetUserFunction")) is not None
    if key.number in own and not has_velocity:
        return Demand.READ
    if not data["activeConnector"]:
        return Demand.NOTHING
    if has_velocity:
        return Demand.DRIVE
    return Demand.MOVE if all(run.mover.numbers.can_move(key.number) for run in coupled) else Demand.BUILD


def _is_weight_of_cable(mbs: Any, number: int) -> bool:
    """Whether kernels of cables evaluate a load: a weight on a companion."""
    load = mbs.GetLoad(number)
    if load["loadType"] != "MassProportional":
        return False
    return is_inert_cable(mbs.GetObject(int(mbs.GetMarkerParameter(load["markerNumber"], "bodyNumber"))))


def _demand_of_place(mbs: Any, coupled: Sequence[CoupledRun], own: Collection[int], key: Parameter) -> Demand:
    """Of a marker, or a ground, that is moved: joints there have to be built as such that are."""
    markers = markers_placed_by(mbs, key)
    if markers is None:
        return Demand.READ
    users = {number for marker in markers for number in objects_at(mbs, marker)}
    others = users.difference(own)
    if users == others and all(run.mover.numbers.moves_springs_alone(markers, users) for run in coupled):
        return Demand.EVALUATE
    missing = [run.mover.numbers.joints_to_move(markers, others) for run in coupled]
    if None in missing:
        return Demand.READ
    return Demand.BUILD if users != others or any(missing) else Demand.MOVE


def same_cables(one: Scene, other: Scene) -> bool:
    """Whether cables, their supports and links are of the same structure."""
    cables = ([cable.cable for cable in scene.cables] for scene in (one, other))
    return one.own_constraints == other.own_constraints and _same(*cables)


def _same(one: Any, other: Any) -> bool:
    """Whether two parts of cables are equal; what moves must be the same object."""
    if one is other:
        return True
    if isinstance(one, Motion):
        return one.rests and other.rests and np.array_equal(one.at(0.0), other.at(0.0))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if is_dataclass(one):
        return type(one) is type(other) and all(
            _same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    return bool(np.array_equal(one, other))
