"""The ways to enforce inextensibility agree with each other; what a solver cannot take is named."""

import math
import re

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    ObjectGenericODE2,
    SphericalJoint,
)

from exudyn_inext import (
    CableShape,
    CreatePrescribedMotion,
    ExplicitTrapWarning,
    InextensibleCable,
    InputError,
    PenaltyMass,
    ReplaceNativeCables,
    WarnOfExplicitTraps,
)
from exudyn_inext.items.cable_data import find_cable_item
from exudyn_inext.items.enforcement import ENFORCEMENTS, algebraic
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import load_node, native_cable, trajectory

SOLVER = exudyn.DynamicSolverType
SECTION = {"massPerLength": 0.0348, "bendingStiffness": 0.0866}
WAYS = sorted(ENFORCEMENTS)
EVERY_WAY = pytest.mark.parametrize("way", WAYS)
# way, native solver (None: SolveExplicit), step [s]
PROJECTION = ("projection", None, 2e-4)
NATIVE_RUNS = [
    ("penaltyMass", SOLVER.RK44, 1e-3),
    ("penaltyMass", SOLVER.DOPRI5, 1e-3),
    ("penaltyMass", SOLVER.ExplicitMidpoint, 1e-4),
    ("penaltyMass", SOLVER.VelocityVerlet, 1e-4),
    ("algebraic", SOLVER.GeneralizedAlpha, 5e-4),
    ("algebraic", SOLVER.TrapezoidalIndex2, 5e-4),
]
ONE_OF_EACH = [NATIVE_RUNS[0], NATIVE_RUNS[4]]


def run_native(mbs, solver, end_time, step):
    settings = quiet_settings(end_time, round(end_time / step))
    time = settings.timeIntegration
    time.generalizedAlpha.spectralRadius = 1.0
    time.newton.useModifiedNewton = True
    time.absoluteTolerance = time.relativeTolerance = 1e-4  # of DOPRI5: as long as the given steps
    with silence():
        mbs.SolveDynamic(settings, solverType=solver)


def largest_distance(found, expected):
    np.testing.assert_allclose(found[:, 0], expected[:, 0], atol=1e-9)
    return np.linalg.norm(found[:, 1:] - expected[:, 1:], axis=1).max()


@pytest.fixture
def motions(new_mbs, add_sensor, solve):
    """(add, end time, runs) -> stored positions of each run.   add: (mbs, enforcement) -> observed node."""

    def run(add, end_time, runs):
        found = []
        for way, solver, step in runs:
            mbs = new_mbs()
            sensor = add_sensor(mbs, add(mbs, way))
            mbs.Assemble()
            if solver is None:
                solve(mbs, end_time, stepSize=step)
            else:
                run_native(mbs, solver, end_time, step)
            found.append(trajectory(mbs, sensor))
        return found

    return run


def agree(found, motion, tolerance=1e-4):
    """All motions are within the tolerance [m] of the first one, which is as large as stated."""
    expected = found[0]
    assert np.linalg.norm(expected[-1, 1:] - expected[0, 1:]) > motion
    assert [x for x in (largest_distance(x, expected) for x in found) if not x < tolerance] == []


def test_all_ways_agree_on_the_planar_pendulum(motions, add_pendulum):
    def add(mbs, way):
        return add_pendulum(mbs, numberOfElements=4, enforcement=way)["nodes"][-1]

    agree(motions(add, 0.4, [PROJECTION, *NATIVE_RUNS]), motion=0.8)


def test_all_ways_agree_on_a_clamped_cable_away_from_the_origin(motions, add_cable):
    def add(mbs, way):
        line = {"positionStart": [0.3, -0.2], "positionEnd": [1.3, 0.8], "numberOfElements": 4}
        cable = add_cable(mbs, **line, enforcement=way, groundConstraintsEnd=[True] * 4)
        return cable["nodes"][0]

    agree(motions(add, 0.2, [PROJECTION, *ONE_OF_EACH]), motion=0.1)


def circle(mbs, add_cable, way, **changes):
    template = InextensibleCable(**SECTION, **changes)
    phi = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    normal = np.column_stack([np.cos(phi), np.sin(phi)])
    shape = CableShape(0.5 * normal, normal[:, ::-1] * [-1.0, 1.0], closed=True)
    pin = [True, True, False, False]
    return add_cable(mbs, shape=shape, beamTemplate=template, enforcement=way, groundConstraintsStart=pin)


@pytest.mark.parametrize("n_bar", [None, 1])
def test_native_ways_agree_on_a_ring_that_hangs_from_one_node(motions, add_cable, n_bar):
    def add(mbs, way):
        return circle(mbs, add_cable, way, numberOfLengthConstraints=n_bar)["nodes"][4]

    agree(motions(add, 0.3, ONE_OF_EACH), motion=0.3)


def test_native_ways_agree_on_a_loaded_spatial_cable_with_the_product_measure(motions, add_cable):
    def add(mbs, way):
        cable = add_cable(
            mbs,
            numberOfElements=3,
            dimension=3,
            beamTemplate=InextensibleCable(**SECTION, curvatureMeasure="product"),
            enforcement=way,
            groundConstraintsStart=[True] * 3 + [False, True, True],
        )
        load_node(mbs, cable["nodes"][2], [0.0, 0.2, 0.3])
        return cable["nodes"][-1]

    agree(motions(add, 0.2, ONE_OF_EACH), motion=0.1)


def test_native_ways_agree_on_damping_and_natural_curvature(motions, add_pendulum):
    def add(mbs, way):
        template = InextensibleCable(**SECTION, bendingDamping=2e-3, referenceCurvature=0.5)
        cable = add_pendulum(mbs, numberOfElements=3, beamTemplate=template, enforcement=way)
        return cable["nodes"][-1]

    agree(motions(add, 0.2, [("penaltyMass", SOLVER.RK44, 2e-4), ONE_OF_EACH[1]]), motion=0.1)


def test_a_larger_penalty_is_closer_to_the_projection(motions, add_pendulum):
    errors = []
    for penalty in (1e2, 1e3):

        def add(mbs, way, penalty=penalty):
            way = PenaltyMass(penalty) if way == "penaltyMass" else way
            return add_pendulum(mbs, numberOfElements=3, enforcement=way)["nodes"][-1]

        expected, found = motions(add, 0.2, [PROJECTION, ONE_OF_EACH[0]])
        errors.append(largest_distance(found, expected))
    assert errors[0] > 5.0 * errors[1]


@EVERY_WAY
def test_the_same_cable_moves_alike_under_the_explicit_solver_whatever_its_way(twin, solve, way):
    plain, other = twin(), twin(enforcement=way)
    for pendulum in (plain, other):
        solve(pendulum.mbs, 0.1)
    np.testing.assert_array_equal(
        trajectory(plain.mbs, plain.tip),
        trajectory(other.mbs, other.tip),
    )


@EVERY_WAY
def test_the_object_of_a_cable_carries_its_data_whatever_its_way(mbs, add_pendulum, way):
    cable = add_pendulum(mbs, enforcement=way)
    number = cable["elements"][0]
    item = find_cable_item(mbs.GetObject(number))
    mbs.Assemble()
    assert find_cable_item(mbs.GetObject(number)) is item
    assert (item.enforcement, item.nodes) == (way, tuple(map(int, cable["nodes"])))
    mbs.SetObjectParameter(number, "forceUserFunction", 0)
    assert find_cable_item(mbs.GetObject(number)) is item


def test_an_object_of_somebody_else_is_no_cable(mbs, add_pendulum):
    nodes = add_pendulum(mbs)["nodes"]
    number = mbs.AddObject(ObjectGenericODE2(nodeNumbers=nodes[:1], massMatrix=np.eye(4)))
    assert find_cable_item(mbs.GetObject(number)) is None


# ------------------------------------------------------------------- bad input


@pytest.mark.parametrize("given", ["exact", "Projection", None, 1e4, PenaltyMass])
def test_an_unknown_enforcement_is_refused(mbs, add_cable, contents, given):
    before = contents(mbs)
    message = r"enforcement = .* is unknown: choose one of \['algebraic', 'penaltyMass', 'projection'\]"
    with pytest.raises(InputError, match=message):
        add_cable(mbs, enforcement=given)
    assert contents(mbs) == before


@pytest.mark.parametrize("penalty", [0.0, -1e4, 99.0, 1e7, math.nan, math.inf, "1e4", True])
def test_a_penalty_out_of_range_is_refused(penalty):
    with pytest.raises(InputError, match=rf"penalty = {penalty!r}: must be a number from 100 .* to 1e\+06"):
        PenaltyMass(penalty)


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan])
def test_a_stabilization_rate_out_of_range_is_refused(rate):
    with pytest.raises(InputError, match=rf"stabilizationRate = {rate!r}: must be a finite number > 0"):
        PenaltyMass(stabilizationRate=rate)


def refused(mbs, contents, message, run):
    before = contents(mbs)
    with silence(), pytest.raises(exudyn.ModelError, match=message):
        run()
    assert contents(mbs) == before


@pytest.mark.parametrize("solver", [SOLVER.GeneralizedAlpha, SOLVER.TrapezoidalIndex2, SOLVER.RK44])
def test_a_native_solver_on_the_default_is_told_what_to_choose(twin, contents, solver):
    mbs = twin().mbs
    message = (
        r"cable of object 0 has enforcement = 'projection'(?s:.*)SolveExplicit(?s:.*)"
        r"enforcement='algebraic' for native implicit(?s:.*)enforcement='penaltyMass' for native explicit"
    )
    refused(mbs, contents, message, lambda: run_native(mbs, solver, 0.1, 1e-3))


def test_a_native_solver_on_a_cable_that_stretches_is_sent_to_native_elements(mbs, add_pendulum):
    """Other ways of enforcement refuse such a cable."""
    section = InextensibleCable(massPerLength=0.1, bendingStiffness=0.1, axialStiffness=1e4)
    add_pendulum(mbs, beamTemplate=section)
    mbs.Assemble()
    with silence(), pytest.raises(exudyn.ModelError, match="take GenerateBeamElementsAlongLine") as caught:
        run_native(mbs, SOLVER.GeneralizedAlpha, 0.1, 1e-3)
    assert "enforcement=" not in str(caught.value)
    with pytest.warns(ExplicitTrapWarning, match="take native elements, or use SolveExplicit"):
        WarnOfExplicitTraps(mbs)


def test_the_native_static_solver_on_the_default_is_told_what_to_choose(twin):
    mbs = twin().mbs
    message = r"SolveEquilibrium\(mbs\) for statics"
    with silence(), pytest.raises(exudyn.ModelError, match=message):
        mbs.SolveStatic(quiet_settings(1.0, 1))


def test_degrees_of_freedom_are_counted_of_algebraic_cables_alone(twin, contents):
    mbs = twin().mbs
    refused(mbs, contents, "'algebraic' for .* degrees of freedom", mbs.ComputeSystemDegreeOfFreedom)
    cable = twin(enforcement="algebraic")
    nodes = len(cable.cable["nodes"])
    lengths, pins = 2 * nodes - 1, 2
    free = cable.mbs.ComputeSystemDegreeOfFreedom()["degreeOfFreedom"]
    assert free == 4 * nodes - lengths - pins


def test_algebraic_cables_in_native_explicit_solvers_are_refused(twin, contents):
    mbs = twin(enforcement="algebraic").mbs
    message = "constraints that cannot be solved"
    refused(mbs, contents, message, lambda: run_native(mbs, SOLVER.RK44, 0.1, 1e-3))


# ------------------------------------------------------------------- traps of native explicit solvers


@pytest.mark.parametrize("way", ["projection", "algebraic"])
def test_a_cable_that_no_explicit_solver_can_move_is_named(twin, way):
    with pytest.warns(ExplicitTrapWarning, match=rf"enforcement = '{way}'.*enforcement='penaltyMass'"):
        assert len(WarnOfExplicitTraps(twin(enforcement=way).mbs)) == 1


@pytest.mark.parametrize("dim", [2, 3])
def test_a_coordinate_constraint_on_a_native_cable_is_named(mbs, dim):
    pin = [True] * dim + [False] * dim
    native_cable(mbs, dim, 2, groundConstraintsStart=pin)
    message = r"CoordinateConstraint '.*' holds coordinate \d of node 0 of the ANCF cable .*wrong.*Hold"
    with pytest.warns(ExplicitTrapWarning) as caught:
        messages = WarnOfExplicitTraps(mbs)
    assert [str(warning.message) for warning in caught] == messages
    assert len([text for text in messages if re.match(rf"the {message}", text)]) == dim


def test_elements_that_a_cable_replaced_are_no_trap_of_their_own(mbs):
    native_cable(mbs, 2, 2, groundConstraintsStart=[True, True, False, False])
    ReplaceNativeCables(mbs)
    with pytest.warns(ExplicitTrapWarning, match="enforcement = 'projection'.*take native elements"):
        assert len(WarnOfExplicitTraps(mbs)) == 1


def test_constraints_that_are_switched_off_are_named_as_native_explicit_solvers_hold_them(mbs):
    tip = native_cable(mbs, 2, 2)["nodes"][-1]
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    height = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=tip, coordinate=1))
    mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, height], name="stop", activeConnector=False))
    mbs.Assemble()
    with pytest.warns(ExplicitTrapWarning, match=r"'stop' is switched off, .* all the same.*leave it out"):
        assert len(WarnOfExplicitTraps(mbs)) == 1
    with silence():
        mbs.SolveDynamic(quiet_settings(0.01, 1000), solverType=exudyn.DynamicSolverType.RK44)
    assert mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Displacement)[1] == 0.0


@pytest.mark.parametrize("active", [True, False])
def test_a_joint_in_a_native_explicit_solver_is_named(mbs, add_cable, active):
    """Exudyn refuses it, too, on or off, but does not say what takes its place."""
    cable = add_cable(mbs, numberOfElements=2, enforcement="penaltyMass")
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround()))
    start = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][0]))
    axes = {"constrainedAxes": [1, 1, 0], "activeConnector": active}
    mbs.AddObject(SphericalJoint(markerNumbers=[ground, start], name="hook", **axes))
    mbs.Assemble()
    with pytest.warns(ExplicitTrapWarning, match=r"'hook' \(JointSpherical\) is a joint.*use SolveExplicit"):
        WarnOfExplicitTraps(mbs)
    with silence(), pytest.raises(exudyn.ModelError):
        mbs.SolveDynamic(quiet_settings(0.01, 10), solverType=exudyn.DynamicSolverType.RK44)


def test_scenes_without_traps_are_not_warned_of(mbs, add_pendulum):
    add_pendulum(mbs, enforcement="penaltyMass")
    native_cable(mbs, 2, 2)
    assert WarnOfExplicitTraps(mbs) == []


def pin_by_constraints(mbs, node):
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for coordinate in range(2):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))


def test_a_penalised_cable_warns_of_a_constraint_that_falsifies_its_motion(
    new_mbs, add_cable, add_sensor, solve
):
    def build():
        mbs = new_mbs()
        cable = add_cable(mbs, numberOfElements=3, enforcement="penaltyMass")
        pin_by_constraints(mbs, cable["nodes"][0])
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return mbs, tip

    mbs, tip = build()
    with pytest.warns(ExplicitTrapWarning, match="CoordinateConstraint .* groundConstraintsStart") as caught:
        run_native(mbs, SOLVER.RK44, 0.2, 1e-3)
    assert len(caught) == 2
    true, true_tip = build()
    solve(true, 0.2)
    assert largest_distance(trajectory(mbs, tip), trajectory(true, true_tip)) > 1e-3


def test_a_prescribed_motion_of_a_penalised_cable_is_the_same_trap(mbs, add_cable):
    cable = add_cable(mbs, numberOfElements=2, enforcement="penaltyMass")
    CreatePrescribedMotion(mbs, cable["nodes"][0], lambda t: [0.1 * (1.0 - np.cos(t)), 0.0])
    mbs.Assemble()
    with pytest.warns(ExplicitTrapWarning, match="CoordinateConstraint"):
        run_native(mbs, SOLVER.RK44, 2e-3, 1e-3)


def test_implicit_solvers_may_constrain_a_penalised_cable(mbs, add_cable):
    cable = add_cable(mbs, numberOfElements=2, enforcement="penaltyMass")
    pin_by_constraints(mbs, cable["nodes"][0])
    mbs.Assemble()
    run_native(mbs, SOLVER.GeneralizedAlpha, 2e-3, 1e-3)


@pytest.mark.parametrize("section", [{}, {"curvatureMeasure": "product"}, {"bendingDamping": 1e-3}], ids=str)
def test_full_newton_asks_an_algebraic_cable_no_more_often_for_more_elements(
    new_mbs, add_pendulum, section, monkeypatch
):
    """Its Jacobian is known, and need not be found by differences in all coordinates."""
    asked = []
    force = algebraic.unconstrained_force
    monkeypatch.setattr(algebraic, "unconstrained_force", lambda *a: asked.append(1) or force(*a))
    counts, tips = [], []
    for elements, modified in ((8, False), (24, False), (24, True)):
        mbs = new_mbs()
        template = InextensibleCable(**SECTION, **section)
        cable = add_pendulum(mbs, numberOfElements=elements, beamTemplate=template, enforcement="algebraic")
        mbs.Assemble()
        settings = quiet_settings(0.1, 50)
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
        settings.timeIntegration.newton.useModifiedNewton = modified
        asked.clear()
        with silence():
            mbs.SolveDynamic(settings)
        counts.append(len(asked))
        tips.append(mbs.GetNodeOutput(cable["nodes"][-1], exudyn.OutputVariableType.Position))
    assert counts[1] <= 1.3 * counts[0]
    np.testing.assert_allclose(tips[1], tips[2], rtol=0, atol=1e-7)
