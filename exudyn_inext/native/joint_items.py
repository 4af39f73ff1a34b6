"""Native constraints of an mbs as joints: their values, Jacobians and second derivatives, from Exudyn."""

from collections.abc import Collection
from typing import Any

import exudyn
import numpy as np
from exudyn.exudynCPP import ObjectIndex

from ..errors import SceneError
from ..items.arguments import described
from .joint_item import JACOBIAN, JointItem
from .sliding_joints import read_sliding_joint
from .tilted_angles import MOST_TILT

_LINEAR = {"JointSpherical", "ConnectorCoordinate"}
_WITHOUT_ROTATION = {"Ground", "MassPoint", "MassPoint2D", "Mass1D"}
_SLIDING = {"JointSliding", "JointSliding2D"}


def read_joints(mbs: Any, elsewhere: Collection[int]) -> list[JointItem]:
    """All constraints but those that are dealt with elsewhere.

    Args:
        mbs: assembled, in the configuration from which a run starts.
        elsewhere: object numbers of constraints that belong to a cable.

    Raises:
        SceneError: a constraint on velocities (see `velocity_level`), or one with unknowns of its own.
    """
    joints = []
    for number in range(mbs.systemData.NumberOfObjects()):
        if number in elsewhere or JACOBIAN not in mbs.ComputeItem(ObjectIndex(number)):
            continue
        data = mbs.GetObject(number)
        name = described(data, number)
        if not data.get("activeConnector", True):
            continue
        if data.get("velocityLevel"):
            raise SceneError(
                f"{name} constrains velocities, which only CoordinateConstraints and rolling discs may, in "
                "explicit steps: set velocityLevel=False, with the offset of the places."
            )
        if data["objectType"] == "JointALEMoving2D":
            raise SceneError(
                f"{name} brings algebraic unknowns of its own, the place on the cable among them, which "
                "explicit steps support for sliding joints only: keep the joint and create the cable with "
                "enforcement='algebraic' for mbs.SolveDynamic, or hold the body at a point of "
                "the cable, by AddMarkerOnCable and a joint or a spring."
            )
        read = read_sliding_joint if data["objectType"] in _SLIDING else _joint
        joints.append(read(mbs, number, data, name))
    return [joint for joint in joints if len(joint.rows)]


def _joint(mbs: Any, number: int, data: dict[str, Any], name: str) -> JointItem:
    rows = np.array(mbs.systemData.GetObjectLTGAE(number), dtype=int)
    try:
        jacobian = np.asarray(mbs.ComputeItem(ObjectIndex(number), JACOBIAN))
    except exudyn.InternalError as error:
        raise SceneError(f"{name} cannot be evaluated in the initial configuration: {error}") from None
    active = np.flatnonzero(np.abs(jacobian).max(axis=1, initial=0.0) > 0.0)
    released = len(rows) - np.count_nonzero(data.get("constrainedAxes", np.ones(len(rows))))
    released += not data.get("constrainRotation", True)  # of a planar prismatic joint
    if len(rows) - len(active) > released:
        raise SceneError(
            f"{name} has an equation that does not depend on any coordinate in the initial configuration (a "
            "singular position, an axis across the plane of a planar cable, or both markers at rest): move "
            "its markers apart, free that axis, as by constrainedAxes=[1, 1, 0] (CreateGenericJoint in place "
            "of joints without them), between planar bodies take an ObjectJointRevolute2D or "
            "ObjectJointPrismatic2D, or remove it."
        )
    of_markers = np.array(mbs.systemData.GetObjectLTGODE2(number), dtype=int)
    coordinates, columns = of_markers, None
    if len(set(of_markers.tolist())) < len(of_markers):
        coordinates, places = np.unique(of_markers, return_inverse=True)
        columns = np.eye(len(coordinates))[places]
    return JointItem(
        number=number,
        rows=rows[active],
        active=active,
        coordinates=coordinates,
        columns=columns,
        name=name,
        follows_time=any("UserFunction" in key and isinstance(value, dict) for key, value in data.items()),
        is_linear=data["objectType"] in _LINEAR
        and all(_is_translation(mbs, n) for n in data["markerNumbers"]),
        period=_period(data.get("offsetUserFunction")),
        is_angular=_constrains_angles(mbs, data, name),
        is_rolling=data["objectType"] == "JointRollingDisc",
        scale=data.get("distance", np.inf),
    )


def _period(offset: Any) -> float:
    """Of what follows this user function, see `velocity_level`."""
    return getattr(offset["function"], "period", np.inf) if offset else np.inf


def _constrains_angles(mbs: Any, data: dict[str, Any], name: str) -> bool:
    """SceneError where an angle does not change by the angular velocity about its axis, as Exudyn has it."""
    markers = [mbs.GetMarker(number) for number in data["markerNumbers"]]
    angles = [one for one in markers if one["markerType"] == "NodeRotationCoordinate"]
    for one in angles:
        axis, kind = one["rotationCoordinate"], exudyn.OutputVariableType.RotationMatrix
        frame = np.reshape(mbs.GetNodeOutput(one["nodeNumber"], kind), (3, 3))
        tilt = float(np.arccos(min(1.0, frame[axis, axis])))
        if tilt > MOST_TILT:
            raise SceneError(
                f"{name} constrains an angle of node {one['nodeNumber']}, whose axis {'xyz'[axis]} is tilted "
                f"by {tilt:.3g} rad at the start. Explicit steps support {MOST_TILT:g} rad at most, as "
                "MarkerNodeRotationCoordinate acts about the global axis: turn the scene so that the body "
                "turns about this axis, or use a spring-damper."
            )
    return len(angles) > 0


def _is_translation(mbs: Any, number: int) -> bool:
    """Whether the position of a marker is linear in the coordinates."""
    marker = mbs.GetMarker(number)
    if "bodyNumber" in marker:
        return mbs.GetObject(marker["bodyNumber"])["objectType"] in _WITHOUT_ROTATION
    return marker["markerType"] in ("NodePosition", "NodeCoordinate")
