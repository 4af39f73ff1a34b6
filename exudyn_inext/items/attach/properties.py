"""Point masses on a cable, and drag of the fluid around it: properties that its own solve includes."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...cable.attached import Drag, PointMass
from ...checks import require_not_negative, require_positive, require_vector
from ...errors import InputError
from ..cable_data import point_on_cable, require_cable


@dataclass(frozen=True)
class CableDrag:
    """Quasi-static drag of a round cable: force per length -rho d/2 (C_n |v_n| v_n + pi C_t |v_t| v_t).

    v_n and v_t are the parts across and along the cable of its velocity relative to the fluid. A cable that
    stretches keeps its diameter, and the force acts on its present length.

    Args:
        normalCoefficient: C_n [-], about 1.2 for a round cable.
        tangentialCoefficient: C_t [-], about 0.01, of the circumference.
        diameter: d [m].
        fluidDensity: rho [kg/m^3].
        flowVelocity: of the fluid, uniform and constant [m/s].

    Example:
        CableDrag(1.2, 0.01, diameter=0.02, fluidDensity=1.2, flowVelocity=[8, 0, 0])
    """

    normalCoefficient: float
    tangentialCoefficient: float
    diameter: float
    fluidDensity: float
    flowVelocity: Any = (0, 0, 0)

    def of_cable(self, dimension: int) -> Drag:
        """The checked law for a cable in that many dimensions.

        Raises:
            InputError: a number out of range.
        """
        pressure = 0.5 * require_positive("diameter", self.diameter)
        pressure *= require_positive("fluidDensity", self.fluidDensity)
        normal = require_not_negative("normalCoefficient", self.normalCoefficient)
        tangential = require_not_negative("tangentialCoefficient", self.tangentialCoefficient)
        flow = require_vector("flowVelocity", self.flowVelocity, " [m/s]")
        if flow[dimension:].any():
            raise InputError(
                f"flowVelocity = {flow.tolist()} has a z component [m/s], but the cable is planar: create "
                "the cable with dimension=3."
            )
        return Drag(pressure * normal, np.pi * pressure * tangential, tuple(flow[:dimension].tolist()))


def SetCableDrag(mbs: Any, cable: Any, drag: CableDrag | None) -> None:
    """Let a cable move in a fluid; replaces what was set before.

    Args:
        mbs: the system, assembled or not.
        cable: what CreateInextensibleCable returned, or the number of its object.
        drag: coefficients and flow; None: no drag.

    Raises:
        InputError: not a cable, or a number out of range, or a cable with native enforcement; mbs is
            unchanged then.

    Example:
        SetCableDrag(mbs, cable, CableDrag(1.2, 0.01, diameter=0.02, fluidDensity=1000))
    """
    _, item = require_cable(mbs, cable)
    if drag is not None and not isinstance(drag, CableDrag):
        raise InputError(f"drag = {drag!r}: must be a CableDrag or None.")
    law = None if drag is None else drag.of_cable(item.cable.dimension)
    item.change(drag=law)


def AddPointMass(mbs: Any, cable: Any, arcLength: float, mass: float) -> None:
    """Fix a point mass to a cable, at any arc length; it feels the cable's gravity.

    Its inertia m S S^T is part of the cable's own mass matrix: it costs nothing in a run.

    Args:
        mbs: the system, assembled or not.
        cable: what CreateInextensibleCable returned, or the number of its object.
        arcLength: where, 0 to the cable's length [m].
        mass: m [kg].

    Raises:
        InputError: not a cable, a point that is not on it, no mass, or a cable with native enforcement; mbs
            is unchanged then.

    Example:
        AddPointMass(mbs, cable, arcLength=0.9, mass=0.02)
    """
    _, item = require_cable(mbs, cable)
    point = PointMass(point_on_cable(arcLength, item.cable.length), require_positive("mass", mass))
    item.change(point_masses=(*item.cable.point_masses, point))
