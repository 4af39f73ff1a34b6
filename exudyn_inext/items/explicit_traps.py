"""What native explicit solvers do wrongly, or cannot do, with ANCF cables: named before it costs a result."""

import warnings
from typing import Any

from ..errors import ExplicitTrapWarning
from .arguments import require_system
from .attach.inert import is_inert_cable
from .cable_data import belongs_to_a_cable, find_cable_item
from .on_ground import markers_of

_WRONG_COUPLING = (
    "native explicit solvers solve for all accelerations and then set the held ones to zero, which is wrong "
    "for the coupled mass matrix of ANCF cables (2 cm tip error after 0.5 s on a pendulum, without a message)"
)


def WarnOfExplicitTraps(mbs: Any) -> list[str]:
    """Warn of what goes wrong when a native explicit solver (RK44, VelocityVerlet, ...) is used on mbs.

    The traps that no solver reports: a CoordinateConstraint that holds a node of an ANCF cable, native or
    inextensible, gives a wrong motion, and one that is switched off holds its coordinate all the same.
    Joints, and inextensible cables that native explicit solvers cannot move, are named as well; there, the
    solvers stop by themselves. Cables with enforcement='penaltyMass' call this themselves as such a solver
    starts; scenes with native cables alone have to be checked by this function.

    Args:
        mbs: the system, assembled or not; unchanged.

    Returns:
        the messages, each of which has been given as ExplicitTrapWarning; empty if there is none.

    Example:
        if not WarnOfExplicitTraps(mbs):
            mbs.SolveDynamic(simulationSettings, solverType=exu.DynamicSolverType.RK44)
    """
    require_system(mbs)
    messages = explicit_traps(mbs)
    for message in messages:
        warnings.warn(message, ExplicitTrapWarning, stacklevel=2)
    return messages


def explicit_traps(mbs: Any) -> list[str]:
    """Messages of all traps in mbs."""
    objects = [mbs.GetObject(number) for number in range(mbs.systemData.NumberOfObjects())]
    owners: dict[int, str] = {}
    messages = []
    for data in objects:
        item = find_cable_item(data)
        if item is not None and item.enforcement != "penaltyMass":
            has_stretch = item.cable.stretches
            remedy = "take native elements" if has_stretch else "create it with enforcement='penaltyMass'"
            messages.append(
                f"the cable '{data['name']}' has enforcement = '{item.enforcement}', which native explicit "
                f"solvers cannot move: {remedy}, or use SolveExplicit."
            )
        elif item is not None:
            owners |= dict.fromkeys(item.nodes, data["name"])
        elif "ANCFCable" in data["objectType"] and not is_inert_cable(data):
            owners |= dict.fromkeys(map(int, data["nodeNumbers"]), data["name"])
        elif _is_joint(data):
            messages.append(
                f"'{data['name']}' ({data['objectType']}) is a joint, which native explicit solvers do not "
                "take: use SolveExplicit, an implicit solver, or a stiff spring in its place."
            )
    return messages + [message for data in objects for message in _held_nodes(mbs, data, owners)]


def _is_joint(data: dict[str, Any]) -> bool:
    """Whether an object constrains others, but for single coordinates; native solvers ask no more."""
    kind = data["objectType"]
    constrains = kind.startswith("Joint") or kind in ("ConnectorDistance", "ConnectorCoordinateVector")
    return constrains and not belongs_to_a_cable(data)


def _held_nodes(mbs: Any, data: dict[str, Any], owners: dict[int, str]) -> list[str]:
    """The trap, if `data` is a CoordinateConstraint on a node of a cable, or one that is switched off.

    owners: node -> cable.
    """
    if data["objectType"] != "ConnectorCoordinate":
        return []
    if not data["activeConnector"]:
        return [
            f"the CoordinateConstraint '{data['name']}' is switched off, and native explicit solvers hold "
            "its coordinate all the same, without a message: leave it out, or use an implicit solver or "
            "SolveExplicit."
        ]
    return [
        f"the CoordinateConstraint '{data['name']}' holds coordinate {marker['coordinate']} of node "
        f"{int(marker['nodeNumber'])} of the ANCF cable '{owners[int(marker['nodeNumber'])]}': "
        f"{_WRONG_COUPLING}. Hold the node by a stiff spring (CartesianSpringDamper, 1e5 N/m), by "
        "groundConstraintsStart/End of a cable with enforcement='penaltyMass', or use an implicit solver or "
        "SolveExplicit."
        for marker in markers_of(mbs, data)
        if marker["markerType"] == "NodeCoordinate" and int(marker["nodeNumber"]) in owners
    ]
