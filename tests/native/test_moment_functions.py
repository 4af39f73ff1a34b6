"""Bending moments by user functions: native elements beside a cable, against native cables with them."""

from itertools import pairwise
from math import atan

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import ObjectANCFCable2D

from exudyn_inext import CreateInextensibleCable, InputError
from tests.exudyn_binding.items import either_cable, solve_native

SECTION = {"massPerLength": 78.0, "bendingStiffness": 2000.0}
LENGTH, END = 2.0, 0.5  # [m], [s]


def moment(mbs, t, element, x, kappa, kappa_t, kappa_0, *rest):
    """That of a section that becomes softer [N m]."""
    return 2000.0 * atan(kappa - kappa_0)


def excess(mbs, t, element, x, kappa, kappa_t, kappa_0, *rest):
    """Over that of the section's bending stiffness [N m]."""
    return moment(mbs, t, element, x, kappa, kappa_t, kappa_0) - 2000.0 * (kappa - kappa_0)


def tip(mbs, native, solve):
    line = {"positionStart": [0, 0, 0], "positionEnd": [LENGTH, 0, 0], "gravity": [0, -9.81, 0]}
    line |= {"numberOfElements": 16 if native else 8}
    held = [True, True, False, True] if native else [True] * 4
    section = SECTION | ({"bendingMomentUserFunction": moment} if native else {})
    nodes, _ = either_cable(mbs, native, 2, section, 1e7, groundConstraintsStart=held, **line)
    for pair in () if native else pairwise(nodes):
        nothing = {"massPerLength": 0.0, "bendingStiffness": 0.0, "axialStiffness": 0.0}
        length = LENGTH / line["numberOfElements"]
        mbs.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=list(pair), length=length, bendingMomentUserFunction=excess, **nothing
            )
        )
    mbs.Assemble()
    if native:
        solve_native(mbs, END, 2e-3)
    else:
        solve(mbs, END, steps=100)
    return mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position)


def test_elements_without_mass_bend_a_cable_by_their_function(new_mbs, solve):
    ours, native = (tip(new_mbs(), is_native, solve) for is_native in (False, True))
    np.testing.assert_allclose(ours, native, atol=2e-3 * LENGTH)


def test_the_refusal_of_a_template_with_a_function_names_these_elements(mbs):
    template = ObjectANCFCable2D(**SECTION, axialStiffness=1e7, bendingMomentUserFunction=moment)
    with pytest.raises(InputError, match="to ObjectANCFCable2D elements without mass and stiffness"):
        CreateInextensibleCable(mbs, [0, 0, 0], [LENGTH, 0, 0], 8, template)
