"""Bad input is refused with value, limit and remedy, and leaves the mbs as it was."""

import math

import pytest
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D, ObjectMassPoint

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    InputError,
)
from reference_models.model import quiet_settings

NAN, INF = math.nan, math.inf
LINE = {"positions": [[0, 0], [0.5, 0], [1, 0]], "slopes": [[1, 0]] * 3}
NATIVE = {"massPerLength": 1.0, "bendingStiffness": 1.0}


def template(**changes):
    return {"beamTemplate": InextensibleCable(**(NATIVE | changes))}


def shape(**changes):
    return {"shape": CableShape(**(LINE | changes))}


NUMBERS = [0.0, -1.5, NAN, INF, "heavy", None]
BAD_CABLES = [
    *[
        (template(**{name: value}), rf"{name} = {value!r}: must be a finite number > 0")
        for name in ("massPerLength", "bendingStiffness")
        for value in NUMBERS
    ],
    *[
        ({"numberOfElements": n}, rf"numberOfElements = {n!r}: must be an integer of at least 1")
        for n in (0, -1, 2.5, True, None, "5")
    ],
    ({"positionEnd": [0, 0, 0]}, r"length = 0 m: .*\[0.0, 0.0, 0.0\]; give two different points"),
    ({"positionEnd": [NAN, 0, 0]}, r"positionEnd = \[nan, 0.0, 0.0\]: .* finite"),
    ({"positionStart": [0, INF, 0]}, r"positionStart = \[0.0, inf, 0.0\]: .* finite"),
    ({"positionStart": [0]}, r"positionStart .*\(1,\).* 2 or 3 components"),
    ({"positionEnd": [1, 0, 0, 0]}, r"positionEnd .*\(4,\).* 2 or 3 components"),
    ({"positionEnd": 1.8}, r"positionEnd .* 2 or 3 components"),
    ({"positionStart": [[0, 0, 0], [1, 1, 1]]}, r"positionStart .*\(2, 3\)"),
    ({"positionStart": "here"}, r"positionStart = 'here': must be numbers"),
    ({"positionStart": None}, r"positionStart"),
    ({"gravity": [0, -9.81]}, r"gravity = \[0, -9.81\]: .* 3 numbers"),
    ({"gravity": [0, NAN, 0]}, r"gravity = \[0.0, nan, 0.0\]: .* finite"),
    ({"gravity": -9.81}, r"gravity = -9.81: .* 3 numbers"),
    ({"dimension": 4}, r"dimension = 4: must be 2, 3 or None"),
    ({"dimension": 2.0}, r"dimension = 2.0: must be 2, 3 or None"),
    ({"dimension": 2, "gravity": [0, 0, -9.81]}, r"dimension = 2, but .* dimension = 3"),
    ({"dimension": 2, "positionEnd": [1, 0, 1]}, r"dimension = 2, but .* z .* dimension = 3"),
    ({"groundConstraintsStart": [True] * 3}, r"groundConstraintsStart = .* has 3 entries: needs 4"),
    ({"groundConstraintsEnd": [True] * 6}, r"groundConstraintsEnd = .* has 6 entries: needs 4"),
    ({"groundConstraintsStart": True}, r"groundConstraintsStart"),
    (
        {"groundConstraintsStart": [True, False, True, False]},
        r"groundConstraintsStart .*\[\[1, 0\], \[1, 0\]\].* hold all or no slopes",
    ),
    (
        {"groundConstraintsEnd": [True, True, True, False]},
        r"groundConstraintsEnd .*\[\[1, 1\], \[1, 0\]\].* hold all or no slopes",
    ),
    (template(curvatureMeasure="exact"), r"curvatureMeasure = 'exact' .*secondDerivative.*product"),
    *[
        (template(numberOfLengthConstraints=n), rf"numberOfLengthConstraints = {n!r}: .* 0 .* 5")
        for n in (-1, 6, 2.5, True)
    ],
    ({"beamTemplate": None}, r"beamTemplate = None: must be an InextensibleCable"),
    ({"beamTemplate": ObjectMassPoint()}, r"beamTemplate = .*: must be an InextensibleCable"),
    *[
        ({"beamTemplate": native(**NATIVE, bendingDamping=-0.1)}, r"bendingDamping = -0.1: .*> 0")
        for native in (ObjectANCFCable, ObjectANCFCable2D)
    ],
    *[
        ({"beamTemplate": native(**NATIVE, referenceAxialStrain=0.1)}, r"referenceAxialStrain = 0.1: .* zero")
        for native in (ObjectANCFCable, ObjectANCFCable2D)
    ],
    (
        {"beamTemplate": ObjectANCFCable2D(**NATIVE, referenceCurvature=2.0), "dimension": 3},
        r"referenceCurvature = 2.0 in 3D: .*dimension=2",
    ),
    (template(referenceCurvature=float("nan")), r"referenceCurvature = nan: .*finite"),
    (template(bendingDamping=float("inf")), r"bendingDamping = inf: .*finite"),
    ({"beamTemplate": ObjectANCFCable2D(bendingStiffness=1.0)}, r"massPerLength = 0.*> 0"),
    (shape(slopes=[[1, 0], [0.6, 0.6], [1, 0]]), r"slopes\[1\] = .*0\.848.* unit .*divide"),
    (shape(slopes=[[1, 0]] * 2), r"slopes has 2 rows: needs 3"),
    (shape(slopes=[[1, 0], [NAN, 0], [1, 0]]), r"slopes = .*nan.* finite"),
    (shape(velocities=[[0, 0]] * 4), r"velocities has 4 rows: needs 3"),
    (shape(velocities=[[0, INF]] * 3), r"velocities = .*inf.* finite"),
    (shape(slopeVelocities=[0, 0]), r"slopeVelocities .*\(\d,\)"),
    (shape(positions=[[0, 0]], slopes=[[1, 0]]), r"positions has 1 point\(s\): .* at least 2"),
    (shape(positions=[[0, 0], [0, 0], [1, 0]]), r"element 0, .* = 0.0: .*> 0"),
    (shape(elementLengths=0.4), r"0\.5 m apart.* 0\.4 m long.*lengthen the element"),
    (shape(elementLengths=0.6), r"mean square stretch of 0\.7 .* 0\.6 m.*correct elementLengths"),
    (shape(elementLengths=[0.5, -0.5]), r"element 1, .* = -0.5: .*> 0"),
    (shape(elementLengths=[0.5] * 3), r"elementLengths .*3.* 2 elements"),
    (shape(slopes=[[-1, 0]] * 3), r"slope"),
    ({"shape": [[0, 0], [1, 0]]}, r"shape = .*CableShape"),
]


@pytest.mark.parametrize(("changes", "message"), BAD_CABLES)
def test_a_bad_cable_is_refused(mbs, add_cable, contents, changes, message):
    before = contents(mbs)
    with pytest.raises(InputError, match=message):
        add_cable(mbs, **changes)
    assert contents(mbs) == before


def test_a_bad_cable_leaves_those_that_are_there(mbs, add_cable, contents):
    add_cable(mbs)
    before = contents(mbs)
    with pytest.raises(InputError):
        add_cable(mbs, numberOfElements=0)
    assert contents(mbs) == before
    mbs.Assemble()


@pytest.mark.parametrize("name", ["positionStart", "positionEnd", "numberOfElements"])
def test_a_shape_and_a_line_together_are_refused(mbs, contents, name):
    line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": 2}
    before = contents(mbs)
    with pytest.raises(InputError, match="shape is given together with positionStart"):
        CreateInextensibleCable(
            mbs, **{name: line[name]}, beamTemplate=InextensibleCable(1.0, 1.0), **shape()
        )
    assert contents(mbs) == before


@pytest.mark.parametrize("velocity", [[0, NAN, 0], [0], "fast", [[0, 0, 0], [0, 1, 0]]])
def test_a_line_with_a_bad_velocity_is_refused(velocity):
    with pytest.raises(InputError, match="velocityEnd"):
        CableShape.Line([0, 0, 0], [1, 0, 0], 2, velocityEnd=velocity)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"integrator": "Euler"}, r"integrator = 'Euler' is unknown: .*'Zhai'"),
        ({"scheme": (0.5, 0.5)}, r"scheme = \(0.5, 0.5\): .*Rattle\(...\)"),
        *[
            ({name: value}, rf"{name} = {value!r}: must be a finite number > 0")
            for name in ("stepSize", "stabilizationRate", "stepConstant", "stepSafety")
            for value in (-1e-3, 0.0, NAN, INF, "1e-3")
        ],
    ],
)
def test_bad_settings_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        ExplicitSettings(**arguments)


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.0), (1.0, 0.5)])
def test_a_run_that_ends_before_it_starts_is_refused(twin, solve, contents, start, end):
    mbs, settings = twin().mbs, quiet_settings(1.0, 1)
    settings.timeIntegration.startTime = start
    settings.timeIntegration.endTime = end
    before, settings_before = contents(mbs), repr(settings.GetDictionary())
    with pytest.raises(InputError, match=rf"endTime - startTime = {end - start} s: must be .*> 0"):
        solve(mbs, settings=settings)
    assert contents(mbs) == before
    assert repr(settings.GetDictionary()) == settings_before
