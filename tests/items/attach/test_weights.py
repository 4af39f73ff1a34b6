"""Gravity element by element: LoadMassProportional on companions, as scripts with native cables give it."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodePosition,
    ObjectANCFCable2D,
    SphericalJoint,
)

from exudyn_inext import (
    AddPointMass,
    CableDrag,
    CableForces,
    CreateCompanionCables,
    ExplicitSettings,
    SceneError,
    SetCableDrag,
    SolveEnsemble,
    SolveEquilibrium,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import native_cable, solve_native, trajectory

G = [0.0, -9.81, 0.0]
PINS = {2: [True, True, False, False], 3: [True] * 3 + [False] * 3}


def weigh(mbs, bodies, vector=G, function=0):
    """The load of each body, as scripts write it; returns the load numbers."""
    numbers = []
    for body in bodies:
        marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        load = LoadMassProportional(markerNumber=marker, loadVector=list(vector))
        load.loadVectorUserFunction = function
        numbers.append(mbs.AddLoad(load))
    return numbers


def swelling(mbs, t, vector):
    """Half of it, and a wave of 9 rad/s."""
    return [x * (0.5 + np.sin(9 * t)) for x in vector]


@pytest.fixture
def swing(new_mbs, add_pendulum, add_sensor, solve):
    """(weigh(mbs, cable), end, **cable) -> trajectory of the tip of a pendulum, and the report."""

    def run(load, end=0.4, dim=2, among_bodies=False, run=solve, explicit=None, **changes):
        mbs = new_mbs()
        held = {"groundConstraintsStart": PINS[dim], "dimension": dim}
        cable = add_pendulum(mbs, **(held | {"gravity": [0, 0, 0]} | changes))
        load(mbs, cable)
        if among_bodies:
            hang_a_point(mbs, cable["nodes"][-1], 0.01, dim)
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        report = run(mbs, end, **(explicit or {}))
        return trajectory(mbs, sensor)[:, 1:], report

    return run


def hang_a_point(mbs, node, mass, dim):
    """A mass point without weight on a node at (1.8, 0, 0): the scene is one of bodies and joints then."""
    point = mbs.CreateMassPoint(mass=mass, referencePosition=[1.8, 0, 0], create2D=dim == 2)
    pair = MarkerNodePosition(nodeNumber=node), MarkerBodyPosition(bodyNumber=point)
    axes = [1, 1, int(dim == 3)]
    return mbs.AddObject(SphericalJoint(markerNumbers=list(map(mbs.AddMarker, pair)), constrainedAxes=axes))


def on_companions(vector=G, function=0, places=slice(None)):
    return lambda mbs, cable: weigh(mbs, CreateCompanionCables(mbs, cable)[places], vector, function)


def nothing(mbs, cable):
    pass


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("among_bodies", [False, True], ids=["alone", "among bodies"])
def test_weight_on_all_companions_is_the_gravity_of_the_cable(swing, dim, among_bodies):
    places = {"dim": dim, "among_bodies": among_bodies}
    expected, _ = swing(nothing, gravity=G, **places)
    found, _ = swing(on_companions(), **places)
    assert np.ptp(expected[:, 1]) > 0.3
    np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.mark.parametrize("dim", [2, 3])
def test_gravity_of_the_cable_and_of_its_elements_add_up(swing, dim):
    expected, _ = swing(nothing, gravity=G, dim=dim)
    found, _ = swing(on_companions([0, -9.0, 0]), gravity=[0, -0.81, 0], dim=dim)
    np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.fixture
def native_swing(new_mbs, add_sensor):
    """(weigh(mbs, elements), tip mass, dim) -> tip of the same pendulum of native elements."""

    def run(load, end=0.4, dim=2, mass=0.0, elements=20):
        mbs = new_mbs()
        held = {"groundConstraintsStart": PINS[dim], "gravity": [0, 0, 0]}
        cable = native_cable(mbs, dim, elements, axial_stiffness=2e5, **held)
        load(mbs, cable["elements"])
        if mass:
            hang_a_point(mbs, cable["nodes"][-1], mass, dim)
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        solve_native(mbs, end)
        return trajectory(mbs, sensor)[:, 1:]

    return run


WEIGHTS = {
    "constant": (G, 0, slice(None)),
    "in time": (G, swelling, slice(None)),
    "of the outer half": (G, 0, slice(10, None)),
    "of the inner half in time": (G, swelling, slice(10)),
}


@pytest.mark.parametrize(  # pairs of kind and surroundings, of kind and dimension
    ("among_bodies", "dim", "kind"),
    [
        (place % 2 == 1, 2 + (place + turn) % 2, kind)
        for turn, kind in enumerate(WEIGHTS)
        for place in range(2)
    ],
)
def test_weights_act_as_on_the_elements_of_a_native_cable(swing, native_swing, kind, among_bodies, dim):
    vector, function, places = WEIGHTS[kind]
    if dim == 3:
        vector = [0.0, -8.0, 4.0]

    def load(mbs, elements):
        weigh(mbs, elements[places], vector, function)

    expected = native_swing(load, dim=dim, mass=0.01 * among_bodies)
    finer = {"numberOfElements": 20, "dim": dim, "among_bodies": among_bodies}
    found, _ = swing(on_companions(vector, function, places), **finer)
    motion = np.linalg.norm(np.ptp(expected, axis=0))
    assert motion > 0.05
    assert np.linalg.norm(found - expected, axis=1).max() < 0.01 * motion


def test_each_element_may_have_its_own_gravity(swing, native_swing):
    vectors = np.outer(np.linspace(0.0, 2.0, 20), G)

    def load(mbs, elements):
        for element, vector in zip(elements, vectors, strict=True):
            weigh(mbs, [element], vector)

    expected = native_swing(load)
    found, _ = swing(lambda mbs, cable: load(mbs, CreateCompanionCables(mbs, cable)), numberOfElements=20)
    motion = np.linalg.norm(np.ptp(expected, axis=0))
    assert np.linalg.norm(found - expected, axis=1).max() < 0.01 * motion


@pytest.mark.parametrize("among_bodies", [False, True], ids=["alone", "among bodies"])
def test_point_masses_weigh_with_the_element_that_they_are_on(swing, among_bodies):
    def with_mass(load):
        def add(mbs, cable):
            AddPointMass(mbs, cable, 0.9, 0.05)
            load(mbs, cable)

        return add

    expected, _ = swing(with_mass(nothing), gravity=G, among_bodies=among_bodies)
    found, _ = swing(with_mass(on_companions()), among_bodies=among_bodies)
    np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
def test_energy_of_a_weight_in_time_is_accounted_for_among_bodies(swing, integrator):
    step = {"integrator": integrator, "stepSize": 2e-4}
    _, report = swing(on_companions(G, swelling), 0.25, among_bodies=True, explicit=step)
    assert report["drift"]["energyGain"] < 1e-3 and report["drift"]["energyLoss"] < 1e-3


def test_a_weight_of_the_time_alone_is_sampled_ahead(swing):
    def known(mbs, t, vector):
        return swelling(None, t, vector)

    def unknown(mbs, t, vector):
        mbs.systemData.GetTime()
        return swelling(mbs, t, vector)

    found, report = swing(on_companions(G, known), explicit={"stepSize": 5e-4})
    expected, watched = swing(on_companions(G, unknown), explicit={"stepSize": 5e-4})
    assert "all loads are known" in report["path"]
    assert "dependsOnTimeOnly" in watched["path"]
    np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.mark.parametrize("among_bodies", [False, True], ids=["alone", "among bodies"])
def test_section_forces_know_the_weights(new_mbs, add_pendulum, among_bodies):
    """Hanging straight down, the tension is the weight below of the elements that have one."""
    mbs = new_mbs()
    cable = add_pendulum(mbs, positionEnd=[0, -1.8, 0], gravity=[0, 0, 0])
    AddPointMass(mbs, cable, 0.4, 3.0)
    AddPointMass(mbs, cable, 1.0, 0.02)
    weigh(mbs, CreateCompanionCables(mbs, cable)[2:])
    if among_bodies:
        mbs.CreateMassPoint(mass=1.0, referencePosition=[5, 0, 0])
    mbs.Assemble()
    forces = CableForces(mbs, cable, [0.0, 0.36, 0.71, 0.99, 1.01, 1.44, 1.79999])
    expected = 0.0348 * np.minimum(1.08, 1.8 - forces["arcLength"]) + 0.02 * (forces["arcLength"] < 1.0)
    expected *= 9.81
    np.testing.assert_allclose(forces["tension"], expected, atol=1e-9)


def test_equilibrium_knows_the_weights(new_mbs, add_pendulum, coordinates):
    found = []
    for gravity in (G, [0, 0, 0]):
        mbs = new_mbs()
        cable = add_pendulum(mbs, gravity=gravity)
        if not any(gravity):
            weigh(mbs, CreateCompanionCables(mbs, cable))
        mbs.Assemble()
        with silence():
            SolveEquilibrium(mbs)
        mbs.systemData.SetODE2Coordinates(mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Initial))
        found.append(coordinates(mbs, cable["nodes"]))
    np.testing.assert_allclose(found[1], found[0], atol=1e-10)
    assert found[0][-1, 0, 1] < -1.7


def test_drag_that_a_weight_causes_bounds_the_step(swing):
    def dragged(load):
        def add(mbs, cable):
            SetCableDrag(mbs, cable, CableDrag(1.2, 0.0, 0.05, 1000.0))
            load(mbs, cable)

        return add

    own, companions, nobodys = (
        swing(dragged(load), end=0.05, gravity=gravity, explicit={"massScaling": 0.0})[1]["bounds"].bending
        for load, gravity in ((nothing, G), (on_companions(), [0, 0, 0]), (nothing, [0, 0, 0]))
    )
    assert companions == pytest.approx(own, rel=1e-9)
    assert companions < 0.99 * nobodys


def no_element(mbs, cable):
    """An inert native cable that skips a node."""
    empty = {"massPerLength": 0, "bendingStiffness": 0, "axialStiffness": 0, "length": 0.72}
    return mbs.AddObject(ObjectANCFCable2D(nodeNumbers=cable["nodes"][:3:2], name="shortcut", **empty))


def no_companion(mbs, cable):
    """Stiffness alone, on the nodes of an element."""
    stiff = {"massPerLength": 0, "bendingStiffness": 0.01, "axialStiffness": 0, "length": 0.36}
    return mbs.AddObject(ObjectANCFCable2D(nodeNumbers=cable["nodes"][:2], name="stiffener", **stiff))


@pytest.mark.parametrize("add", [no_element, no_companion])
def test_weight_of_what_has_no_mass_is_refused_by_name(mbs, add_pendulum, solve, contents, add):
    cable = add_pendulum(mbs)
    name = mbs.GetObject(body := add(mbs, cable))["name"]
    weigh(mbs, [body])
    mbs.Assemble()
    before = contents(mbs)
    with pytest.raises(SceneError, match=rf"load 0 .*'{name}' .*has no mass.*CreateCompanionCables"):
        solve(mbs)
    assert contents(mbs) == before


def test_weight_of_the_ground_is_nothing(mbs, add_pendulum, solve):
    add_pendulum(mbs)
    weigh(mbs, [mbs.CreateGround()])
    mbs.Assemble()
    assert solve(mbs, 0.01)["success"]


def test_weight_out_of_the_plane_of_a_planar_cable_is_refused(mbs, add_pendulum, solve):
    cable = add_pendulum(mbs)
    weigh(mbs, CreateCompanionCables(mbs, cable), [0, 0, -9.81])
    mbs.Assemble()
    with pytest.raises(SceneError, match=r"element 0 of object 0 .* -9\.81 m/s\^2.*dimension=3"):
        solve(mbs)


def test_the_gravity_function_of_an_ensemble_is_asked_only_if_it_may_be(new_mbs, add_pendulum):
    def build():
        mbs = new_mbs()
        cable = add_pendulum(mbs, gravity=[0, 0, 0])
        weigh(mbs, CreateCompanionCables(mbs, cable), G, lambda mbs, t, g: mbs and swelling(mbs, t, g))
        mbs.Assemble()
        return mbs

    with pytest.raises(SceneError, match=r"load on element 0 of object \d.* may depend on the state"):
        SolveEnsemble([build()], quiet_settings(0.01, 1), ExplicitSettings())


@pytest.mark.parametrize("bad", [lambda mbs, t, g: [0.0, np.nan, 0.0], lambda mbs, t, g: 9.81])
def test_a_gravity_function_that_returns_no_vector_is_named(mbs, add_pendulum, solve, bad):
    cable = add_pendulum(mbs)
    weigh(mbs, CreateCompanionCables(mbs, cable)[3:], G, bad)
    mbs.Assemble()
    with pytest.raises(
        SceneError, match=r"user function of the load on element 3 of object .*3 finite number"
    ):
        solve(mbs)


@pytest.mark.parametrize("enforcement", ["penaltyMass", "algebraic"])
def test_native_solvers_refuse_weights_that_they_would_not_feel(mbs, add_pendulum, enforcement):
    cable = add_pendulum(mbs, enforcement=enforcement)
    weigh(mbs, CreateCompanionCables(mbs, cable))
    mbs.Assemble()
    kind = "RK44" if enforcement == "penaltyMass" else "GeneralizedAlpha"
    solver = getattr(exudyn.DynamicSolverType, kind)
    with silence(), pytest.raises(Exception, match=r"load 0 .* has no mass under native solvers.*gravity="):
        mbs.SolveDynamic(quiet_settings(0.01, 100), solverType=solver)
