"""Point masses and drag: against native cables, closed forms, and on every path of the solver."""

import numpy as np
import pytest
from exudyn.itemInterface import LoadForceVector, MarkerBodyPosition, MarkerNodePosition, SphericalJoint

from exudyn_inext import (
    AddMarkerOnCable,
    AddPointMass,
    CableDrag,
    CableForces,
    CableShape,
    ExplicitSettings,
    InputError,
    SceneError,
    SetCableDrag,
    SolveEnsemble,
    SolveEquilibrium,
    SolveExplicit,
)
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import SECTION, native_cable, solve_native, trajectory

DENSITY = SECTION["massPerLength"]
WATER = CableDrag(normalCoefficient=1.2, tangentialCoefficient=0.5, diameter=0.01, fluidDensity=2.0)
NORMAL = 0.5 * 2.0 * 0.01 * 1.2  # c_n, c_t [kg/m^2]
TANGENTIAL = 0.5 * 2.0 * 0.01 * np.pi * 0.5
MASSES = [(0.63, 0.02), (1.8, 0.01)]


def in_flow(*velocity):
    return CableDrag(1.2, 0.5, 0.01, 2.0, flowVelocity=velocity)


def drifting(velocity, elements=5):
    return CableShape.Line([0, 0, 0], [1.8, 0, 0], elements, velocity, velocity)


def test_pendulum_with_point_masses_moves_as_a_native_one(new_mbs, add_pendulum, add_sensor, solve):
    ours, native = new_mbs(), new_mbs()
    cable = add_pendulum(ours, numberOfElements=10)
    for arc_length, mass in MASSES:
        AddPointMass(ours, cable, arc_length, mass)
    found = add_sensor(ours, cable["nodes"][-1])
    ours.Assemble()
    assert "in one compiled call" in solve(ours, 0.6)["path"]
    held = {"groundConstraintsStart": [True, True, False, False]}
    twin = native_cable(native, 2, 40, section=SECTION, **held)
    for arc_length, mass in MASSES:
        point = native.CreateMassPoint(
            mass=mass, referencePosition=[arc_length, 0, 0], gravity=[0, -9.81, 0], create2D=True
        )
        body = native.AddMarker(MarkerBodyPosition(bodyNumber=point))
        node = native.AddMarker(MarkerNodePosition(nodeNumber=twin["nodes"][round(arc_length / 0.045)]))
        native.AddObject(SphericalJoint(markerNumbers=[body, node], constrainedAxes=[1, 1, 0]))
    expected = add_sensor(native, twin["nodes"][-1])
    native.Assemble()
    solve_native(native, 0.6)
    found, expected = trajectory(ours, found)[:, 1:], trajectory(native, expected)[:, 1:]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.ptp(expected[:, 1]))


def test_hanging_cable_carries_its_point_masses(mbs, add_pendulum):
    """N(x) = (rho_A (L - x) + masses below) g, by CableForces at equilibrium."""
    down = CableShape.Line([0, 0, 0], [0, -1.8, 0], 5)
    cable = add_pendulum(mbs, shape=down)
    for arc_length, mass in MASSES:
        AddPointMass(mbs, cable, arc_length, mass)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    forces = CableForces(mbs, cable, [0.0, 0.2, 0.6, 0.66, 1.0, 1.79])
    x = forces["arcLength"]
    expected = DENSITY * (1.8 - x) + sum(mass * (x < at) for at, mass in MASSES)
    np.testing.assert_allclose(forces["tension"], 9.81 * expected, rtol=1e-8)


def test_natural_frequency_at_equilibrium_knows_the_point_mass(mbs, add_pendulum):
    """A heavy bob: the square of the lowest frequency of a pendulum of length L, within mass ratios."""
    cable = add_pendulum(mbs, shape=CableShape.Line([0, 0, 0], [0, -1.8, 0], 5))
    AddPointMass(mbs, cable, 1.8, 20.0)
    mbs.Assemble()
    assert SolveEquilibrium(mbs)["smallestEigenvalue"] == pytest.approx(9.81 / 1.8, rel=5e-3)


def test_falling_cable_reaches_its_terminal_velocity(mbs, add_cable, solve):
    """v = v_t tanh(g t / v_t), c_n v_t^2 = rho_A g: all of the straight, level cable falls alike."""
    cable = add_cable(mbs)
    SetCableDrag(mbs, cable, WATER)
    mbs.Assemble()
    solve(mbs, 1.5)
    terminal = np.sqrt(DENSITY * 9.81 / NORMAL)
    velocity = np.reshape(mbs.systemData.GetODE2Coordinates_t(), (-1, 2, 2))
    expected = terminal * np.tanh(9.81 * 1.5 / terminal)
    np.testing.assert_allclose(velocity[:, 0, 1], -expected, rtol=1e-4)
    assert np.abs(velocity[:, 0, 0]).max() < 1e-8


@pytest.mark.parametrize(
    ("velocity", "coefficient"), [([4, 0, 0], TANGENTIAL), ([0, 4, 0], NORMAL)], ids=["along", "across"]
)
@pytest.mark.parametrize("flow", [False, True], ids=["moving cable", "moving fluid"])
def test_free_cable_slows_down_towards_the_speed_of_the_fluid(
    mbs, add_cable, solve, velocity, coefficient, flow
):
    """w = w_0 / (1 + c w_0 t / rho_A) for the speed w relative to the fluid."""
    cable = add_cable(mbs, gravity=[0, 0, 0], shape=drifting([0, 0, 0] if flow else velocity))
    SetCableDrag(mbs, cable, in_flow(*velocity) if flow else WATER)
    mbs.Assemble()
    solve(mbs, 1.0)
    factor = 1.0 / (1.0 + coefficient * 4.0 / DENSITY)
    expected = np.array(velocity[:2]) * (1.0 - factor if flow else factor)
    found = np.reshape(mbs.systemData.GetODE2Coordinates_t(), (-1, 2, 2))[:, 0]
    np.testing.assert_allclose(found, np.tile(expected, (6, 1)), atol=1e-4 * 4.0)


def test_tension_of_a_cable_held_in_an_axial_flow(mbs, add_pendulum):
    """N = c_t u^2 (L - x)."""
    cable = add_pendulum(mbs, gravity=[0, 0, 0])
    SetCableDrag(mbs, cable, in_flow(6, 0, 0))
    mbs.Assemble()
    forces = CableForces(mbs, cable, 19)
    expected = TANGENTIAL * 36.0 * (1.8 - forces["arcLength"])
    np.testing.assert_allclose(forces["tension"], expected, atol=1e-10)
    np.testing.assert_allclose(forces["shearForce"], 0.0, atol=1e-10)


def test_every_path_knows_masses_and_drag(new_mbs, add_pendulum, coordinates, solve):
    """Compiled, and coupled with other items: here by a load without force."""

    def build(coupled):
        mbs = new_mbs()
        cable = add_pendulum(mbs)
        if coupled:
            mbs.AddLoad(LoadForceVector(markerNumber=AddMarkerOnCable(mbs, cable, 0.5), loadVector=[0, 0, 0]))
        mbs.Assemble()
        AddPointMass(mbs, cable, 0.63, 0.02)
        SetCableDrag(mbs, cable, in_flow(2, 0, 0))
        return mbs, cable["nodes"]

    systems = [build(coupled) for coupled in (False, True, False)]
    for mbs, _ in systems[:2]:
        solve(mbs, 0.3, stepSize=1e-3)
    compiled, coupled, before = (coordinates(*system) for system in systems)
    assert np.abs(compiled - before).max() > 0.1
    np.testing.assert_allclose(coupled, compiled, atol=1e-9)


def test_drag_is_taken_off_again(new_mbs, add_pendulum, coordinates, solve):
    found = []
    for drags in ([], [WATER, None]):
        mbs = new_mbs()
        cable = add_pendulum(mbs)
        for drag in drags:
            SetCableDrag(mbs, cable, drag)
        mbs.Assemble()
        solve(mbs, 0.1)
        found.append(coordinates(mbs, cable["nodes"]))
    np.testing.assert_array_equal(*found)


def test_some_members_of_an_ensemble_have_drag(new_mbs, add_pendulum):
    systems, explicit, alone = [], ExplicitSettings(stepSize=1e-3), []
    for drag in (None, WATER):
        mbs = new_mbs()
        cable = add_pendulum(mbs)
        SetCableDrag(mbs, cable, drag)
        mbs.Assemble()
        systems.append(mbs)
    found = SolveEnsemble(systems, quiet_settings(0.1, 1), explicit)["coordinates"][:, -1]
    for mbs in systems:
        SolveExplicit(mbs, quiet_settings(0.1, 1), explicit)
        alone.append(mbs.systemData.GetODE2Coordinates())
    np.testing.assert_array_equal(found, alone)
    assert np.abs(np.subtract(*found)).max() > 1e-4


@pytest.mark.parametrize("enforcement", ["algebraic", "penaltyMass"])
def test_native_enforcement_refuses_what_its_items_do_not_know(mbs, add_pendulum, enforcement):
    cable = add_pendulum(mbs, enforcement=enforcement)
    for add in (lambda: AddPointMass(mbs, cable, 1.0, 0.1), lambda: SetCableDrag(mbs, cable, WATER)):
        with pytest.raises(InputError, match=f"enforcement = '{enforcement}': its native items do not know"):
            add()


def test_equilibrium_in_a_flow_is_refused(mbs, add_pendulum):
    cable = add_pendulum(mbs)
    SetCableDrag(mbs, cable, in_flow(2, 0, 0))
    mbs.Assemble()
    with pytest.raises(SceneError, match="whose drag has no potential: set flowVelocity to zero"):
        SolveEquilibrium(mbs)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"arcLength": 2.0, "mass": 1.0}, "arcLength = 2.0 m is not on the cable: it runs from 0 to 1.8 m"),
        ({"arcLength": 1.0, "mass": 0.0}, "mass = 0.0: must be a finite number > 0"),
    ],
)
def test_point_mass_out_of_range_is_refused(mbs, add_pendulum, arguments, message):
    with pytest.raises(InputError, match=message):
        AddPointMass(mbs, add_pendulum(mbs), **arguments)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"diameter": -1.0}, "diameter = -1.0: must be a finite number > 0"),
        ({"fluidDensity": "water"}, "fluidDensity = 'water': must be a finite number > 0"),
        ({"normalCoefficient": -0.1}, "normalCoefficient = -0.1: must be a finite number >= 0"),
        ({"flowVelocity": [1, 0]}, r"flowVelocity = \[1, 0\]: must be a vector of 3 numbers"),
        ({"flowVelocity": [1, 0, 2]}, "z component .* planar: create the cable with dimension=3"),
    ],
)
def test_drag_out_of_range_is_refused(mbs, add_pendulum, changes, message):
    given = {"normalCoefficient": 1.2, "tangentialCoefficient": 0.1, "diameter": 0.01, "fluidDensity": 1.0}
    with pytest.raises(InputError, match=message):
        SetCableDrag(mbs, add_pendulum(mbs), CableDrag(**(given | changes)))
