"""Vibrations about an equilibrium, against closed forms, native cables, and runs that vibrate so."""

import exudyn
import numpy as np
import pytest
import scipy
from exudyn.itemInterface import (
    GenericJoint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodePosition,
    MarkerNodeRigid,
    ObjectANCFCable,
    ObjectANCFCable2D,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CableShape,
    ComputeEigenvalues,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    SceneError,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.statics import vibrations
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_cable, add_pendulum, native_cable

INITIAL = exudyn.ConfigurationType.Initial
PINNED, SLIDING = [True, True, False, False], [False, True, False, False]


def frequencies(mbs, number):
    """Of mbs, which comes to rest before [Hz]."""
    mbs.Assemble()
    SolveEquilibrium(mbs)
    return ComputeEigenvalues(mbs, numberOfEigenvalues=number)["frequencies"]


def test_a_hanging_chain(mbs, known_answer):
    """Zeros of the Bessel function J_0."""
    length, chain = 2.0, InextensibleCable(massPerLength=0.5, bendingStiffness=1e-5)
    add_pendulum(mbs, positionEnd=[0, -length, 0], numberOfElements=40, beamTemplate=chain)
    expected = scipy.special.jn_zeros(0, 4) * np.sqrt(9.81 / length) / (4.0 * np.pi)
    error = np.abs(frequencies(mbs, 4) / expected - 1.0).max()
    known_answer("frequencies of a hanging chain", error)
    assert error < 1e-3


@pytest.mark.parametrize("few", [0, 10_000], ids=["Lanczos", "all at once"])
def test_a_string_under_tension_that_stretches(mbs, few, monkeypatch, known_answer):
    monkeypatch.setattr(vibrations, "FEW", few)
    length, tension, density, bending, axial = 1.5, 80.0, 0.01, 0.002, 1e5
    section = InextensibleCable(density, bending, axialStiffness=axial)
    ends = {"groundConstraintsStart": PINNED, "groundConstraintsEnd": SLIDING, "gravity": [0, 0, 0]}
    string = add_cable(mbs, positionEnd=[length, 0, 0], numberOfElements=20, beamTemplate=section, **ends)
    end = mbs.AddMarker(MarkerNodePosition(nodeNumber=string["nodes"][-1]))
    mbs.AddLoad(LoadForceVector(markerNumber=end, loadVector=[tension, 0, 0]))
    k, stretch = np.arange(1, 7), 1.0 + tension / axial
    bent = np.sqrt(1.0 + (k * np.pi) ** 2 * bending / (tension * length**2))
    expected = k / (2.0 * length) * np.sqrt(tension / (density * stretch)) * bent
    error = np.abs(frequencies(mbs, 6) / expected - 1.0).max()
    known_answer("frequencies of a string under tension", error)
    assert error < 5e-4


def test_a_free_ring(mbs, known_answer):
    """A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 4th ed., 1927, section 293."""
    radius, density, stiffness = 0.5, 0.3, 0.8
    section = InextensibleCable(density, stiffness, referenceCurvature=1.0 / radius)
    add_cable(mbs, shape=CableShape.Circle([0, 0], radius, 32), beamTemplate=section, gravity=[0, 0, 0])
    mbs.Assemble()
    found = ComputeEigenvalues(mbs, numberOfEigenvalues=9)["frequencies"]
    n = np.repeat([2, 3, 4], 2)
    squares = (n * (n**2 - 1)) ** 2 / (n**2 + 1) * stiffness / (density * radius**4)
    error = np.abs(2.0 * np.pi * found[3:] / np.sqrt(squares) - 1.0).max()
    known_answer("frequencies of a free ring", error)
    assert error < 5e-4 and np.abs(found[:3]).max() < 1e-3


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cantilever_bent_by_its_weight_and_a_force(new_mbs, dimension):
    clamped, force = [True] * 2 * dimension, [20.0, 0.0, 3.0 if dimension == 3 else 0.0]
    values = {"massPerLength": 0.5, "bendingStiffness": 3.0}

    def loaded(mbs, node):
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=force))
        mbs.Assemble()
        return mbs

    template = (ObjectANCFCable2D if dimension == 2 else ObjectANCFCable)(axialStiffness=1e6, **values)
    found = []
    for elements in (8, 16):  # natively, from the other equilibrium: statics do not find it from afar
        ours, native = new_mbs(), new_mbs()
        line = {"positionEnd": [2, 0, 0], "groundConstraintsStart": clamped}
        mesh = {"numberOfElements": elements, "beamTemplate": template, "extensible": True}
        cable = add_cable(ours, **mesh, **line)
        nodes = native_cable(native, dimension, elements, values, 1e6, **line)["nodes"]
        found.append(frequencies(loaded(ours, cable["nodes"][-1]), 6))
    start = ours.systemData.GetODE2Coordinates()
    loaded(native, nodes[-1]).systemData.SetODE2Coordinates(start, INITIAL)
    settings = exudyn.SimulationSettings()
    with silence():
        native.SolveStatic(settings, updateInitialValues=True)
    squares, _ = native.ComputeODE2Eigenvalues(numberOfEigenvalues=6)
    expected = np.sqrt(squares) / (2.0 * np.pi)
    assert np.abs(found[1] / expected - 1.0).max() < 5e-3
    assert np.abs(found[1] / expected - 1.0)[:2].max() < 1e-3


def hanging_body(mbs, dimension, axial_stiffness):
    """On a cable, beside its centre of mass, and on springs."""
    section = InextensibleCable(0.3, 0.5, axialStiffness=axial_stiffness)
    pinned, gravity = [True] * dimension + [False] * dimension, {"gravity": [0, -9.81, 0]}
    cable = CreateInextensibleCable(
        mbs, [0, 0, 0], [1, 0, 0], 6, section, groundConstraintsStart=pinned, dimension=dimension, **gravity
    )
    inertia, in_space = InertiaCuboid(1000, [0.1, 0.2, 0.15]), dimension == 3
    if in_space:
        inertia = inertia.Translated([0.02, 0, 0])
    place = {"referencePosition": [1, -0.1, 0], "create2D": not in_space}
    body = mbs.CreateRigidBody(inertia=inertia, **place, **gravity)
    ends = [
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[-0.03, 0.1, 0])),
        mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1])),
    ]
    mbs.AddObject(SphericalJoint(markerNumbers=ends, constrainedAxes=[1, 1, int(in_space)]))
    mbs.CreateCartesianSpringDamper(
        itemNumbers=[body, mbs.CreateGround()],
        localPosition0=[0.05, 0, 0],
        localPosition1=[0.8, -0.7, 0.1 * in_space],
        stiffness=[60, 30, 40 * in_space],
    )
    mbs.Assemble()
    SolveEquilibrium(mbs)


@pytest.mark.parametrize("axial_stiffness", [None, 1e4])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_scene_that_starts_in_a_mode_vibrates_in_it(new_mbs, dimension, axial_stiffness):
    mbs, size = new_mbs(), 1e-4
    hanging_body(mbs, dimension, axial_stiffness)
    rest = np.array(mbs.systemData.GetODE2Coordinates(INITIAL))
    found = ComputeEigenvalues(mbs, numberOfEigenvalues=4)
    assert np.array_equal(rest, mbs.systemData.GetODE2Coordinates(INITIAL))
    for frequency, mode in zip(found["frequencies"], found["eigenvectors"].T, strict=True):
        moved, end = size / np.abs(mode).max() * mode, 0.5 / frequency
        mbs.systemData.SetODE2Coordinates((rest + moved).tolist(), INITIAL)
        explicit = ExplicitSettings(stepSize=end / 1000, massScaling=0.3, startTolerance=1e-3)
        SolveExplicit(mbs, quiet_settings(end, 1), explicit)
        way = np.array(mbs.systemData.GetODE2Coordinates()) - rest
        assert np.abs(way + moved).max() < 0.01 * size


def test_the_lowest_of_cables_among_nothing_else_and_their_modal_mass(mbs):
    """A short and a long chain: modes of one leave the other alone."""
    chain = InextensibleCable(massPerLength=0.5, bendingStiffness=1e-4)
    for x, length in ((0, 0.5), (1, 2.0)):
        ends = {"positionStart": [x, 0, 0], "positionEnd": [x, -length, 0]}
        add_pendulum(mbs, **ends, numberOfElements=20, beamTemplate=chain)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    found = ComputeEigenvalues(mbs, numberOfEigenvalues=3)
    zeros = scipy.special.jn_zeros(0, 2) * np.sqrt(9.81) / (4.0 * np.pi)
    expected = [zeros[0] / np.sqrt(2.0), zeros[0] / np.sqrt(0.5), zeros[1] / np.sqrt(2.0)]
    np.testing.assert_allclose(found["frequencies"], expected, rtol=3e-3)
    short, long = np.split(np.abs(found["eigenvectors"]).T, 2, axis=1)
    assert not short[[0, 2]].any() and not long[1].any()
    assert "Hz" in str(found)


def test_all_there_are(mbs):
    add_pendulum(mbs, positionEnd=[0, -1.8, 0], numberOfElements=2)
    mbs.Assemble()
    found = ComputeEigenvalues(mbs, numberOfEigenvalues=50)
    assert found["eigenvectors"].shape == (12, 5)  # 12 coordinates, 2 of them held, 5 lengths


def test_what_hangs_upside_down_has_negative_eigenvalues(mbs):
    add_pendulum(mbs, positionEnd=[0, 1.8, 0])
    mbs.Assemble()
    found = ComputeEigenvalues(mbs, numberOfEigenvalues=1)
    assert found["eigenvalues"][0] < 0.0 and found["frequencies"][0] < 0.0


def test_a_scene_that_is_not_at_rest_is_refused_with_a_remedy_that_works(mbs):
    add_pendulum(mbs)
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"does not rest .* N is not balanced .* Call SolveEquilibrium"):
        ComputeEigenvalues(mbs)
    SolveEquilibrium(mbs)
    assert ComputeEigenvalues(mbs)["eigenvalues"][0] > 0.0


@pytest.mark.parametrize("elements", [1, 2, 8, 60])
def test_a_straight_cable_between_pins_has_an_unknown_tension(new_mbs, elements):
    """Stretch tells it: the closed form of a beam on two pins."""
    ends = {"groundConstraintsStart": PINNED, "groundConstraintsEnd": PINNED, "gravity": [0, 0, 0]}

    def found(axial_stiffness):
        mbs, section = new_mbs(), InextensibleCable(0.1, 0.1, axialStiffness=axial_stiffness)
        add_cable(mbs, positionEnd=[1, 0, 0], numberOfElements=elements, beamTemplate=section, **ends)
        mbs.Assemble()
        return ComputeEigenvalues(mbs, numberOfEigenvalues=1)["frequencies"]

    with pytest.raises(SceneError, match=r"redundant constraints.*axialStiffness"):
        found(None)
    assert elements == 1 or found(1e4) == pytest.approx([0.5 * np.pi], rel=5e-3)


def test_redundant_joints_are_refused(mbs):
    """Two joints that do the same."""
    cable = add_pendulum(mbs, positionEnd=[0, -1.8, 0])
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.1] * 3), referencePosition=[0, -1.9, 0], create2D=True
    )
    ground = mbs.AddMarker(MarkerBodyRigid(bodyNumber=mbs.CreateGround(referencePosition=[0, -1.9, 0])))
    ends = [ground, mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))]
    for _ in range(2):
        mbs.AddObject(GenericJoint(markerNumbers=ends, constrainedAxes=[1, 1, 0, 0, 0, 1]))
    assert cable["nodes"]
    mbs.Assemble()
    with pytest.raises(SceneError, match="redundant"):
        ComputeEigenvalues(mbs)


@pytest.mark.parametrize("kind", ["bodyFixed", "function"])
def test_loads_without_a_potential_are_refused_with_a_remedy_that_works(new_mbs, kind):
    """A column that a force presses along its end; a force in the middle that the place of the end tells."""

    def column(follows):
        mbs, section = new_mbs(), InextensibleCable(0.2, 0.05, axialStiffness=2e4)
        cable = add_cable(
            mbs,
            positionEnd=[1, 0, 0],
            numberOfElements=8,
            beamTemplate=section,
            gravity=[0, 0, 0],
            groundConstraintsStart=[True] * 4,
        )
        at = {"bodyFixed": 8, "function": 4}[kind]
        marker, tip = mbs.AddMarker(MarkerNodeRigid(nodeNumber=cable["nodes"][at])), cable["nodes"][8]
        load = {"loadVector": [-0.1, 0, 0], "bodyFixed": follows}
        if kind == "function":
            position = exudyn.OutputVariableType.Position
            load = {"loadVector": [0, 0, 0]}
            if follows:
                load["loadVectorUserFunction"] = lambda m, t, v: [0, -m.GetNodeOutput(tip, position)[1], 0]
        mbs.AddLoad(LoadForceVector(markerNumber=marker, **load))
        mbs.Assemble()
        SolveEquilibrium(mbs)
        return mbs

    mbs = column(follows=True)
    with pytest.raises(
        SceneError, match=r"node \d.* no potential has it, which is .* \(limit .*bodyFixed=False"
    ):
        ComputeEigenvalues(mbs, numberOfEigenvalues=1)
    assert ComputeEigenvalues(column(follows=False), numberOfEigenvalues=1)["eigenvalues"][0] > 0.0
