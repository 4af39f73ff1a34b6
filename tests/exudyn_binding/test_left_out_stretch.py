"""Cables of native templates, taken as inextensible, whose stretch matters."""

from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    CoordinateSpringDamper,
    LoadCoordinate,
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePoint2DSlope1,
    NodePointGround,
    ObjectANCFCable2D,
    SphericalJoint,
)

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    DivergenceError,
    ExplicitSettings,
    SolveEnsemble,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.run.coupled_run import CoupledRun
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import that_remembers

GRAVITY, PINNED = [0, -9.81, 0], [True, True, False, False]
ROPE = {"massPerLength": 1.0, "bendingStiffness": 1.0}
LENGTH, ELEMENTS, LOAD = 30.0, 8, 500.0


def _on(mbs, node, coordinate):
    return mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))


def _load(mbs, node):
    mbs.AddLoad(LoadCoordinate(markerNumber=_on(mbs, node, 1), load=-LOAD))


def cable_car(stiffness, span, **given):
    """A rope between two pins, with a load in the middle; and its nodes."""
    mbs = exudyn.SystemContainer().AddSystem()
    nodes = CreateInextensibleCable(
        mbs,
        beamTemplate=ObjectANCFCable2D(**ROPE, axialStiffness=stiffness),
        shape=CableShape.Catenary([0, 0, 0], [span, 0, 0], LENGTH, ELEMENTS),
        gravity=GRAVITY,
        groundConstraintsStart=PINNED,
        groundConstraintsEnd=PINNED,
        **given,
    )["nodes"]
    _load(mbs, nodes[ELEMENTS // 2])
    mbs.Assemble()
    return mbs, nodes


def native_cable_car(stiffness, span):
    """The same of native elements."""
    twin, nodes = cable_car(stiffness, span)
    places = [twin.GetNodeParameter(node, "referenceCoordinates") for node in nodes]
    mbs = exudyn.SystemContainer().AddSystem()
    nodes = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=place)) for place in places]
    for pair in pairwise(nodes):
        element = {"length": LENGTH / ELEMENTS, "nodeNumbers": list(pair), "axialStiffness": stiffness}
        body = mbs.AddObject(ObjectANCFCable2D(**ROPE, **element))
        mass = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(LoadMassProportional(markerNumber=mass, loadVector=GRAVITY))
    ground = _on(mbs, mbs.AddNode(NodePointGround()), 0)
    for node in (nodes[0], nodes[-1]):
        for axis in (0, 1):
            mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, _on(mbs, node, axis)]))
    _load(mbs, nodes[ELEMENTS // 2])
    mbs.Assemble()
    return mbs, nodes


def sag(mbs, nodes):
    return -mbs.GetNodeOutput(nodes[ELEMENTS // 2], exudyn.OutputVariableType.Position)[1]


def test_a_taut_rope_that_sags_by_its_stretch_is_warned_of_until_the_remedy_is_followed():
    """A strain of 1.2 % lowers the load by 0.92 m."""
    mbs, nodes = cable_car(1e6, 29.99)
    said = (
        r"template has axialStiffness = 1e\+06 N: .* of its extent \(limit 0\.5%\)\. Give .*extensible=True"
    )
    with pytest.warns(UserWarning, match=said):
        SolveEquilibrium(mbs)
    stiff = sag(mbs, nodes)
    mbs, nodes = cable_car(1e6, 29.99, extensible=True)
    SolveEquilibrium(mbs)
    native, of_native = native_cable_car(1e6, 29.99)
    native.SolveStatic(quiet_settings(1.0, 1))
    assert sag(mbs, nodes) == pytest.approx(sag(native, of_native), rel=2e-3)
    assert sag(mbs, nodes) - stiff > 0.9


@pytest.mark.parametrize(("stiffness", "span"), [(1e8, 29.99), (1e6, 24.0), (0.0, 29.99)])
def test_nothing_is_said_where_stretch_does_not_matter_or_is_not_known(stiffness, span):
    """Of 30 m, it moves the load by 57 mm and 13 mm; a stiffness of zero is that of no rope."""
    SolveEquilibrium(cable_car(stiffness, span)[0])


def hung_mass(mbs, node, place, mass):
    """A point of that mass [kg] at the end of a rope, joined to this node of it; its node and marker."""
    number = mbs.CreateMassPoint(
        referencePosition=place, mass=mass, gravity=GRAVITY, create2D=True, returnDict=True
    )["nodeNumber"]
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=one)) for one in (node, number)]
    mbs.AddObject(SphericalJoint(markerNumbers=ends, constrainedAxes=[1, 1, 0]))
    return number, ends[1]


def test_a_motion_that_is_wrong_by_half_is_warned_of_though_the_rope_is_long():
    """The load falls to 80 % on a rope of 30 m, and rises by 13 mm, or 26 mm with stretch."""

    def rise(**given):
        mbs, nodes = cable_car(1e6, 29.5, **given)
        SolveEquilibrium(mbs)
        before = sag(mbs, nodes)
        mbs.SetLoadParameter(mbs.systemData.NumberOfLoads() - 1, "load", -0.8 * LOAD)
        SolveExplicit(mbs, quiet_settings(0.4, 40))
        return before - sag(mbs, nodes)

    with pytest.warns(UserWarning, match=r"stretch would move it by some 0\.1.* m, while it moves by 0\.04"):
        stiff = rise()
    assert rise(extensible=True) > 1.8 * stiff


def hanging_load(stiffness, **given):
    """3 kg on a rope of 2 m that hangs straight down; mbs, and the node of the mass."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = ObjectANCFCable2D(massPerLength=0.1, bendingStiffness=0.01, axialStiffness=stiffness)
    rope = CreateInextensibleCable(mbs, [0, 0, 0], [0, -2, 0], ELEMENTS, section, GRAVITY, PINNED, **given)[
        "nodes"
    ]
    mass, _ = hung_mass(mbs, rope[-1], [0, -2, 0], 3.0)
    mbs.Assemble()
    return mbs, mass


def test_a_load_that_bounces_as_its_rope_begins_unstretched_is_warned_of():
    """By 2 m g L / EA within half a period pi (m L / EA)^(1/2); one that begins in equilibrium does not."""
    stiffness, half = 4e4, np.pi * np.sqrt(3.0 * 2.0 / 4e4)
    with pytest.warns(UserWarning, match=r"strain of 0\.0007.* begins unstretched \(limit 0\.0005\)"):
        SolveExplicit(hanging_load(stiffness)[0], quiet_settings(half, 20))
    mbs, mass = hanging_load(stiffness, extensible=True)
    SolveExplicit(mbs, quiet_settings(half, 20))
    fall = -2.0 - mbs.GetNodeOutput(mass, exudyn.OutputVariableType.Position)[1]
    assert fall == pytest.approx(2.0 * 3.0 * 9.81 * 2.0 / stiffness, rel=0.05)
    mbs, _ = hanging_load(stiffness)
    SolveEquilibrium(mbs)
    SolveExplicit(mbs, quiet_settings(half, 20))


def hammer(stiffness, **given):
    """A mass of 3 kg on a rope of 2 m, which falls against a wall: a spring with a user function."""
    mbs = exudyn.SystemContainer().AddSystem()
    nodes = CreateInextensibleCable(
        mbs,
        [0, 0, 0],
        [2, 0, 0],
        ELEMENTS,
        ObjectANCFCable2D(massPerLength=0.1, bendingStiffness=0.01, axialStiffness=stiffness),
        gravity=GRAVITY,
        groundConstraintsStart=PINNED,
        **given,
    )["nodes"]
    mass, _ = hung_mass(mbs, nodes[-1], [2, 0, 0], 3.0)
    pair = [_on(mbs, mbs.AddNode(NodePointGround()), 0), _on(mbs, mass, 0)]

    def push(mbs, t, item, u, v, stiffness, damping, offset):
        return stiffness * min(u + 2.0, 0.0)

    spring = CoordinateSpringDamper(
        markerNumbers=pair, stiffness=1e5, springForceUserFunction=that_remembers(push)
    )
    mbs.AddObject(spring)
    mbs.Assemble()
    return mbs, mass


def test_a_run_in_which_stretch_matters_is_warned_of():
    mbs, _ = hammer(1e4)
    with pytest.warns(UserWarning, match=r"axialStiffness = 10000 N: .* a strain of 0\.0"):
        SolveExplicit(mbs, quiet_settings(1.0, 100))


def test_cables_of_one_kind_are_warned_of_as_well():
    """Two ropes of 2 m share records; 3 kg at each swing through below, and pull by more than 3 m g."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = ObjectANCFCable2D(massPerLength=0.1, bendingStiffness=0.01, axialStiffness=1e4)
    for x in (0, 5):
        rope = CreateInextensibleCable(mbs, [x, 0, 0], [x + 2, 0, 0], ELEMENTS, section, GRAVITY, PINNED)
        hung_mass(mbs, rope["nodes"][-1], [x + 2, 0, 0], 3.0)
    mbs.Assemble()
    with pytest.warns(UserWarning, match=r"the tension reaches 1\d\d N, .* 1 other cables matters, too"):
        SolveExplicit(mbs, quiet_settings(0.9, 90))


def test_an_ensemble_warns_of_its_first_member():
    with pytest.warns(UserWarning, match=r"axialStiffness = 1e\+06 N: .* while it moves by"):
        SolveEnsemble([cable_car(1e6, 29.99)[0]], quiet_settings(0.05, 10))


def reference_of_hammer():
    """Where the mass ends, by steps of which half are 0.01 mm apart."""
    mbs, mass = hammer(1e4, extensible=True)
    SolveExplicit(mbs, quiet_settings(1.0, 100), ExplicitSettings(stepSize=1e-4))
    return mbs.GetNodeOutput(mass, exudyn.OutputVariableType.Position)


@pytest.mark.parametrize("is_seen", [False, True])
def test_a_blow_is_followed_where_a_user_function_is_asked_in_each_step(is_seen):
    """It ended in a DivergenceError where a step function saw the steps."""
    mbs, mass = hammer(1e4, extensible=True)
    if is_seen:
        mbs.SetPreStepUserFunction(lambda mbs, t: True)
    report = SolveExplicit(mbs, quiet_settings(1.0, 100))
    end = mbs.GetNodeOutput(mass, exudyn.OutputVariableType.Position)
    assert report["steps"] < 2000
    assert np.abs(end - reference_of_hammer()).max() < 0.01


def tendon(is_seen):
    """A rope of 0.2 m, with a light mass at its end that a force pulls at once; the report."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = ObjectANCFCable2D(
        massPerLength=0.004, bendingStiffness=2e-6, axialStiffness=2e3, axialDamping=0.02
    )
    nodes = CreateInextensibleCable(
        mbs, [0, 0, 0], [0.2, 0, 0], 8, section, GRAVITY, PINNED, extensible=True
    )["nodes"]
    _, marker = hung_mass(mbs, nodes[-1], [0.2, 0, 0], 0.005)
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0.5, 0, 0]))
    if is_seen:
        mbs.SetPreStepUserFunction(lambda mbs, t: True)
    mbs.Assemble()
    return SolveExplicit(mbs, quiet_settings(0.5, 500))


def test_steps_for_waves_last_and_are_those_of_a_run_that_nobody_sees():
    """A run that begins again remembers what its tension asks for; a rehearsal is no beginning."""
    seen, unseen = tendon(True), tendon(False)
    assert seen["steps"] == unseen["steps"] == round(0.5 / seen["stepSize"])


@pytest.fixture
def waves_are_not_watched(monkeypatch):
    """Steps do not follow the tension, what they hide is not left out, and none are taken again."""
    monkeypatch.setattr(CoupledRun, "asks_ahead", False)
    monkeypatch.setattr(CoupledRun, "outruns_limit", lambda *_: False)
    monkeypatch.setattr(CoupledRun, "_leave_out_waves", lambda *_: None)


@pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")
def test_a_run_that_a_blow_spoils_begins_again(waves_are_not_watched):
    mbs, mass = hammer(1e4, extensible=True)
    report = SolveExplicit(mbs, quiet_settings(1.0, 100))
    end = mbs.GetNodeOutput(mass, exudyn.OutputVariableType.Position)
    assert report["decidedBy"] == "axial vibrations"
    assert report["steps"] < 2000
    assert np.abs(end - reference_of_hammer()).max() < 0.01


def test_a_run_does_not_begin_again_where_a_step_function_has_seen_it(waves_are_not_watched):
    mbs, _ = hammer(1e4, extensible=True)
    mbs.SetPreStepUserFunction(lambda mbs, t: True)
    with pytest.raises(DivergenceError, match="axial vibrations, which the steps did not resolve"):
        SolveExplicit(mbs, quiet_settings(1.0, 100))


def led_rope(sets_offset):
    """A rope that hangs from a pin; a mass at its end, which a controller leads smoothly by a spring."""
    mbs = exudyn.SystemContainer().AddSystem()
    section = ObjectANCFCable2D(massPerLength=0.2, bendingStiffness=0.05, axialStiffness=4e5)
    held = {"gravity": GRAVITY, "groundConstraintsStart": PINNED}
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [0, -2.0, 0], 8, section, **held)
    mass = mbs.CreateMassPoint(
        referencePosition=[0, -2.0, 0], mass=0.3, gravity=GRAVITY, create2D=True, returnDict=True
    )
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[0, -2.0, 0]))
    end, hook = (
        mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        for node in (mass["nodeNumber"], cable["nodes"][-1])
    )
    mbs.AddObject(SphericalJoint(markerNumbers=[hook, end], constrainedAxes=[1, 1, 0]))
    mbs.variables["offset"] = 0.0

    def force(mbs, t, item, way, velocity, *rest):
        return [2e4 * (way[0] - mbs.variables["offset"]) + 100.0 * velocity[0], 0.0, 0.0]

    spring = {"stiffness": [2e4, 0, 0], "damping": [100.0, 0, 0]} if sets_offset else {}
    spring |= {} if sets_offset else {"springForceUserFunction": force}
    leader = mbs.AddObject(CartesianSpringDamper(markerNumbers=[ground, end], **spring))

    def lead(mbs, t):
        mbs.variables["offset"] = 0.4 * t**3
        if sets_offset:
            mbs.SetObjectParameter(leader, "offset", [0.4 * t**3, 0, 0])
        return True

    mbs.SetPreStepUserFunction(lead)
    mbs.Assemble()
    return mbs


@pytest.mark.parametrize("sets_offset", [True, False])
def test_earlier_states_are_not_judged_by_what_acts_at_the_end(sets_offset):
    """A warning would fail."""
    SolveExplicit(led_rope(sets_offset), quiet_settings(1.0, 200))
