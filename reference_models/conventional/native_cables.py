"""Native elements in place of CreateInextensibleCable, for scripts that take what adds their cables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, get_args

from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    NodePoint2DSlope1,
    NodePointSlope1,
    ObjectANCFCable,
    ObjectANCFCable2D,
)

from exudyn_inext import CableShape
from exudyn_inext.items.shape import CheckedShape, check_shape

from .cable import Quadrature


@dataclass(frozen=True)
class NativeCables:
    """Adds cables of ObjectANCFCable2D or, in space, ObjectANCFCable.

    axial: stiffness [N].   quadrature: of the elastic forces.
    """

    axial: float
    quadrature: Quadrature = "lobatto"

    def __call__(
        self,
        mbs: Any,
        beamTemplate: Any,
        gravity: Sequence[float] = (0, 0, 0),
        shape: CableShape | None = None,
        dimension: int | None = None,
        **line: Any,
    ) -> dict[str, Any]:
        """Arguments and what is returned: as of CreateInextensibleCable, without supports."""
        checked = check_shape(shape or CableShape.Line(**line))
        flat = not (checked.q[:, :, 2].any() or checked.v[:, :, 2].any() or gravity[2])
        planar = dimension == 2 or (dimension is None and flat)
        nodes = _add_nodes(mbs, checked, planar)
        element = ObjectANCFCable2D if planar else ObjectANCFCable
        elements = []
        for k, length in enumerate(checked.lengths):
            cable = element(
                length=float(length),
                massPerLength=beamTemplate.massPerLength,
                bendingStiffness=beamTemplate.bendingStiffness,
                axialStiffness=self.axial,
                referenceAxialStrain=beamTemplate.referenceAxialStrain,
                nodeNumbers=nodes[k : k + 2],
                useReducedOrderIntegration=get_args(Quadrature).index(self.quadrature),
            )
            elements.append(mbs.AddObject(cable))
            marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=elements[-1]))
            mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=list(gravity)))
        return {"nodes": nodes, "elements": elements}


def _add_nodes(mbs: Any, shape: CheckedShape, planar: bool) -> list[Any]:
    node, dim = (NodePoint2DSlope1, 2) if planar else (NodePointSlope1, 3)
    states = [[x[:, :dim].ravel().tolist() for x in pair] for pair in zip(shape.q, shape.v, strict=True)]
    return [mbs.AddNode(node(referenceCoordinates=q, initialVelocities=v)) for q, v in states]
