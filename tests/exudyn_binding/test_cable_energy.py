"""CreateCableEnergySensor against closed forms, and against the energies of native elements."""

import numpy as np
import pytest
from exudyn import OutputVariableType
from exudyn.itemInterface import MarkerBodyPosition, MarkerNodePosition, SensorBody, SphericalJoint
from exudyn.utilities import InertiaCuboid

from exudyn_inext import AddPointMass, CableShape, CreateCableEnergySensor, InextensibleCable
from tests.exudyn_binding.items import SECTION, native_cable, solve_native, trajectory

LENGTH, NATURAL = 1.8, 0.8
DAMPED = {"massPerLength": 0.5, "bendingStiffness": 1.2, "bendingDamping": 0.01, "axialDamping": 100.0}


def first_row(mbs, solve, sensor):
    mbs.Assemble()
    solve(mbs, 0.01)
    return trajectory(mbs, sensor)[0, 1:]


def test_kinetic_energy_is_that_of_a_line_that_turns_with_the_mass_at_its_end(mbs, add_pendulum, solve):
    shape = CableShape.Line([0, 0], [LENGTH, 0], 5, velocityStart=[0, 0], velocityEnd=[0, 3.0])
    cable = add_pendulum(mbs, shape=shape, gravity=[0, 0, 0])
    AddPointMass(mbs, cable, LENGTH, 0.1)
    found = first_row(mbs, solve, CreateCableEnergySensor(mbs, cable))
    mass = SECTION["massPerLength"] * LENGTH / 3 + 0.1
    np.testing.assert_allclose(found, [0.5 * mass * 9.0, 0.0], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("axial", [{}, {"axialStiffness": 8e4}])
def test_elastic_energy_of_a_straight_cable_is_that_of_its_natural_curvature(mbs, add_pendulum, solve, axial):
    template = InextensibleCable(**SECTION, **axial, referenceCurvature=NATURAL)
    found = first_row(mbs, solve, CreateCableEnergySensor(mbs, add_pendulum(mbs, beamTemplate=template)))
    np.testing.assert_allclose(found, [0.0, 0.5 * 0.0866 * NATURAL**2 * LENGTH], rtol=1e-9, atol=1e-12)


def sum_over_elements(mbs, elements):
    """A function that gives both energies of native elements at the present state."""
    kinds = OutputVariableType.KineticEnergy, OutputVariableType.PotentialEnergy
    sensors = [
        [mbs.AddSensor(SensorBody(bodyNumber=e, outputVariableType=k)) for e in elements] for k in kinds
    ]
    return lambda: [sum(map(float, map(mbs.GetSensorValues, of_kind))) for of_kind in sensors]


def hang_body(mbs, node):
    inertia = InertiaCuboid(density=200, sideLengths=[0.2, 0.1, 0.05])
    body = mbs.CreateRigidBody(
        referencePosition=[LENGTH + 0.1, 0, 0], inertia=inertia, gravity=[0, -9.81, 0], create2D=True
    )
    markers = [
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[-0.1, 0, 0])),
        mbs.AddMarker(MarkerNodePosition(nodeNumber=node)),
    ]
    mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0]))


@pytest.mark.parametrize(
    ("dimension", "curvature", "has_body"),
    [(2, {"referenceCurvature": NATURAL}, False), (2, {}, True), (3, {}, False)],
)
def test_energies_are_those_of_native_elements(new_mbs, add_pendulum, solve, dimension, curvature, has_body):
    ours, native, end = new_mbs(), new_mbs(), 0.3
    pin = [True] * dimension + [False] * dimension
    template = InextensibleCable(**DAMPED, **curvature, axialStiffness=8e4)
    cable = add_pendulum(
        ours, beamTemplate=template, dimension=dimension, groundConstraintsStart=pin, numberOfElements=8
    )
    theirs = native_cable(native, dimension, 16, DAMPED | curvature, groundConstraintsStart=pin)
    if has_body:
        hang_body(ours, cable["nodes"][-1])
        hang_body(native, theirs["nodes"][-1])
    sensor = CreateCableEnergySensor(ours, cable)
    energies = sum_over_elements(native, theirs["elements"])
    for mbs in (ours, native):
        mbs.Assemble()
    solve(ours, end)
    solve_native(native, end)
    found, expected = trajectory(ours, sensor), energies()
    assert expected[0] > 0.05 and expected[1] > 1e-3
    np.testing.assert_allclose(found[-1, 1:], expected, rtol=2e-3)
