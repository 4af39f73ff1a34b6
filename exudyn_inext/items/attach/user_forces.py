"""Bending moments and axial forces of a cable by user functions of its native template.

Native elements without mass and stiffness on the nodes of the cable return what the functions differ by from
the linear moment EI (kappa - kappa_0) + D kappa_t, and the linear force EA (e - e_0) + D_a e_t, which
the cable has itself. D and D_a are those of the functions where nothing is strained: damping is implicit
then, and what is left of it, explicit, small.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
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
_RATE = 1e-3  # of curvature [1/(m s)] or strain [1/s], at which functions are asked for their damping
_AS_GIVEN = ("referenceCurvature", "referenceAxialStrain", "strainIsRelativeToReference")


def user_forces_of(
    mbs: Any, template: Any, section: InextensibleCable, dimension: int
) -> tuple[dict[str, Any], InextensibleCable]:
    """User functions of a native template, by their names, as those of elements without stiffness.

    Args:
        mbs: for functions.   template: beamTemplate as it was given.   section: what was taken from it.
        dimension: of the cable.

    Returns:
        The functions, and the section with their dampings.

    Raises:
        InputError: no function, a cable in space, or axial forces of a cable that does not stretch.
    """
    found: dict[str, Any] = {}
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
        if name == "bendingMomentUserFunction" or found:  # Exudyn calls the axial one beside it alone
            given = getattr(section, stiffness), getattr(section, damping)
            own = _damping_of(partial(function, mbs, 0.0, 0, 0.5), *given)
            changed: Any = {damping: own}
            section = replace(section, **changed)
            found[name] = _excess(function, given, own)
    return found, section


def _damping_of(function: Callable[..., float], stiffness: float, damping: float) -> float:
    """Of a function of strain and rate, where nothing is strained; `damping` if it cannot be asked there."""
    try:
        fast, slow = (function(0.0, rate, 0.0, stiffness, damping, 0.0, 0.0, 0.0) for rate in (_RATE, 0.0))
        found = (fast - slow) / _RATE
    except Exception:
        return damping
    return found if damping and 0.0 <= found < math.inf else damping


def _excess(
    function: Callable[..., float], given: tuple[float, float], damping: float
) -> Callable[..., float]:
    """What a function differs from the linear law by; strain stands for curvature, too.

    given: stiffness and damping of the template.   damping: of the linear law.
    """
    stiffness, _ = given

    def excess(mbs, t, element, x, strain, strain_t, strain_0, no_stiffness, no_damping, *rest):
        linear = stiffness * (strain - strain_0) + damping * strain_t
        return function(mbs, t, element, x, strain, strain_t, strain_0, *given, *rest) - linear

    return excess


def add_user_forces(mbs: Any, item: CableItem, section: InextensibleCable, functions: dict[str, Any]) -> None:
    """Add these elements, if there are functions; see `user_forces_of`.   section: as the template has it.

    Exudyn hands functions a rate of zero where an element has no damping, so these have that of the section.
    The functions replace it.
    """
    dampings = [_OF_SECTION[name][1] for name in functions]
    spans = zip(pairwise(item.node_names), item.cable.element_lengths, strict=True)
    for nodes, length in spans if functions else ():
        mbs.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=list(nodes),
                length=float(length),
                visualization=VObjectANCFCable2D(show=False),
                **{name: getattr(section, name) for name in (*_AS_GIVEN, *dampings)},
                **functions,
            )
        )
