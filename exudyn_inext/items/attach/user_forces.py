"""Bending moments and axial forces of a cable by user functions of its native template.

Native elements without mass and stiffness on the nodes of the cable return what the functions differ by from
the linear moment EI (kappa - kappa_0) + D kappa_t, and the linear force EA (e - e_0) + D_a e_t, which
the cable has itself.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

from exudyn.itemInterface import ObjectANCFCable2D, VObjectANCFCable2D

from ...errors import InputError
from ...scene.model import CableItem
from ..template import InextensibleCable

_OF_SECTION = {
    "bendingMomentUserFunction": ("bendingStiffness", "bendingDamping"),
    "axialForceUserFunction": ("axialStiffness", "axialDamping"),
}
_AS_GIVEN = ("referenceCurvature", "referenceAxialStrain", "strainIsRelativeToReference")


def user_forces_of(template: Any, section: InextensibleCable, dimension: int) -> dict[str, Any]:
    """User functions of a native template, by their names, as those of elements without stiffness.

    Args:
        template: beamTemplate as it was given.   section: what was taken from it.   dimension: of the cable.

    Raises:
        InputError: no function, a cable in space, or axial forces of a cable that does not stretch.
    """
    found = {}
    for name, (stiffness, damping) in _OF_SECTION.items():
        function = getattr(template, name, 0)
        if isinstance(function, int) and function == 0:
            continue
        if not callable(function):
            raise InputError(f"beamTemplate.{name} = {function!r}: must be a function, or zero.")
        if dimension != 2:
            raise InputError(f"beamTemplate.{name} with dimension = 3: only planar cables have it.")
        if getattr(section, stiffness) is None:
            raise InputError(
                f"beamTemplate.{name}: only cables that stretch have it; give extensible=True, or set it to "
                "zero."
            )
        found[name] = _excess(function, getattr(section, stiffness), getattr(section, damping))
    return found


def _excess(function: Callable[..., float], stiffness: float, damping: float) -> Callable[..., float]:
    """What a function differs from the linear law by; strain stands for curvature, too."""

    def excess(mbs, t, element, x, strain, strain_t, strain_0, no_stiffness, no_damping, *rest):
        linear = stiffness * (strain - strain_0) + damping * strain_t
        return function(mbs, t, element, x, strain, strain_t, strain_0, stiffness, damping, *rest) - linear

    return excess


def add_user_forces(mbs: Any, item: CableItem, section: InextensibleCable, functions: dict[str, Any]) -> None:
    """Add these elements, if there are functions; see `user_forces_of`."""
    spans = zip(pairwise(item.node_names), item.cable.element_lengths, strict=True)
    for nodes, length in spans if functions else ():
        mbs.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=list(nodes),
                length=float(length),
                visualization=VObjectANCFCable2D(show=False),
                **{name: getattr(section, name) for name in _AS_GIVEN},
                **functions,
            )
        )
