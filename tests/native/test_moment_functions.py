"""Bending moments by user functions: native elements beside a cable, against native cables with them."""

from itertools import pairwise
from math import atan

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import ObjectANCFCable2D

from exudyn_inext import CableForces, CreateInextensibleCable, InputError, SceneError, SolveEquilibrium
from reference_models.model import quiet_settings, silence
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


def softer_in_time(mbs, t, element, x, strain, strain_t, strain_0, stiffness, damping, *rest):
    """Of a section whose axial stiffness falls with time [N]."""
    return (1.5 - t) * stiffness * (strain - strain_0) + damping * strain_t


def of_section(mbs, t, element, x, kappa, kappa_t, kappa_0, stiffness, damping, *rest):
    """As `moment`, of a section with damping [N m]."""
    return stiffness * atan(kappa - kappa_0) + damping * kappa_t


def tips_by(new_mbs, solve, **functions):
    """(2, 3) places of the tip of a cable of this package and of a native one [m]."""
    template = ObjectANCFCable2D(
        **SECTION,
        bendingDamping=20.0,
        axialStiffness=1e5,
        axialDamping=5e3,
        referenceCurvature=-0.2,
        **functions,
    )
    line = [[0, 0, 0], [LENGTH, 0, 0], 16, template, [0, -9.81, 0], [True, True, False, True]]
    ours, native = new_mbs(), new_mbs()
    nodes = CreateInextensibleCable(ours, *line, extensible=True)["nodes"]
    ours.Assemble()
    solve(ours, END, steps=100)
    others = GenerateBeamElementsAlongLine(native, *line)["nodes"]
    native.Assemble()
    solve_native(native, END, 2e-3)
    places = [
        mbs.GetNodeOutput(numbers[-1], exudyn.OutputVariableType.Position)
        for mbs, numbers in ((ours, nodes), (native, others))
    ]
    return ours, places


def test_a_template_with_functions_moves_as_a_native_cable(new_mbs, solve):
    """Of moments and axial forces, with damping and natural curvature."""
    functions = {"bendingMomentUserFunction": of_section, "axialForceUserFunction": softer_in_time}
    ours, tips = tips_by(new_mbs, solve, **functions)
    np.testing.assert_allclose(*tips, atol=2e-4 * LENGTH)
    with pytest.raises(
        SceneError, match="by user functions, of which its section forces and energies know nothing"
    ):
        CableForces(ours, 0)


@pytest.mark.parametrize("damping", [5.0, 400.0])
def test_damping_is_that_of_the_function_not_of_the_template(new_mbs, solve, damping):
    def damped(mbs, t, element, x, kappa, kappa_t, kappa_0, stiffness, *rest):
        return stiffness * (kappa - kappa_0) + damping * kappa_t

    def stretched(mbs, t, element, x, strain, strain_t, strain_0, stiffness, *rest):
        return stiffness * (strain - strain_0) + 10.0 * damping * strain_t

    _, tips = tips_by(new_mbs, solve, bendingMomentUserFunction=damped, axialForceUserFunction=stretched)
    np.testing.assert_allclose(*tips, atol=2e-4 * LENGTH)


def much_softer(mbs, t, element, x, kappa, kappa_t, kappa_0, stiffness, *rest):
    """Of a section that hardly resists more than a curvature of 0.1 / m [N m]."""
    return 0.1 * stiffness * atan(10.0 * (kappa - kappa_0))


def test_it_comes_to_rest_where_a_native_cable_does(new_mbs):
    template = ObjectANCFCable2D(
        massPerLength=7.8, bendingStiffness=2000.0, axialStiffness=1e5, bendingMomentUserFunction=much_softer
    )
    line = [[0, 0, 0], [LENGTH, 0, 0], 16, template, [0, -9.81, 0], [True, True, False, True]]
    ours, native = new_mbs(), new_mbs()
    tip = CreateInextensibleCable(ours, *line, extensible=True)["nodes"][-1]
    other = GenerateBeamElementsAlongLine(native, *line)["nodes"][-1]
    ours.Assemble()
    native.Assemble()
    with silence():
        report = SolveEquilibrium(ours)
        native.SolveStatic(quiet_settings(1.0, 1))
    kind = exudyn.OutputVariableType.Position
    places = [ours.GetNodeOutput(tip, kind), native.GetNodeOutput(other, kind)]
    np.testing.assert_allclose(*places, atol=1e-5)
    assert places[0][1] < -0.08 and report["iterations"] < 20  # as the Hessian knows of the function


@pytest.mark.parametrize(
    ("function", "given", "said"),
    [
        ("bendingMomentUserFunction", {"dimension": 3}, "only planar cables"),
        ("axialForceUserFunction", {}, "give extensible=True"),
    ],
)
def test_a_function_that_the_cable_cannot_have_is_refused(mbs, function, given, said):
    template = ObjectANCFCable2D(**SECTION, axialStiffness=1e7, **{function: moment})
    with pytest.raises(InputError, match=f"{function}.*{said}"):
        CreateInextensibleCable(mbs, [0, 0, 0], [LENGTH, 0, 0], 8, template, **given)
    assert mbs.systemData.NumberOfNodes() == 0
