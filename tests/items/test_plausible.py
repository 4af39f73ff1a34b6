"""Cables whose numbers cannot be meant are warned of, with what follows from these; all others are not."""

import warnings

import exudyn
import numpy as np
import pytest

from exudyn_inext import CreateInextensibleCable, InextensibleCable


def create(length, stiffness, elements, mass=0.03477, gravity=9.81):
    mbs = exudyn.SystemContainer().AddSystem()
    section = InextensibleCable(massPerLength=mass, bendingStiffness=stiffness)
    CreateInextensibleCable(mbs, [0, 0, 0], [length, 0, 0], elements, section, gravity=[0, -gravity, 0])


@pytest.mark.parametrize("elements", [1, 10])
def test_stiffness_in_newton_square_millimetres_is_named(elements):
    """1.8 m of 2 mm: in mm and N mm^2, d = 4 sqrt(EI / rho_A) / 5 km/s = 1.3 m."""
    says = (
        r"length = 1800 m.*diameter of 1\.3 m, a slenderness of 1\.4e\+03.*period of .*less than that of air"
    )
    with pytest.warns(UserWarning, match=says):
        create(1800.0, 86650.0, elements)
    with pytest.warns(UserWarning, match=r"Check the units: m, kg and s, for EI N m\^2"):
        create(1.8, 86650.0, elements)


def test_the_period_is_that_of_a_free_beam():
    period = 2.0 * np.pi * 1.8**2 / (4.7300407**2 * np.sqrt(86650.0 / 0.03477))
    with pytest.warns(UserWarning, match=f"bending period of {period:.2g} s"):
        create(1.8, 86650.0, 10)


def test_lengths_in_millimetres_are_named():
    with pytest.warns(UserWarning, match=r"slenderness of 1\.4e\+06.*elements of 180 m"):
        create(1800.0, 0.08665, 10)


@pytest.mark.parametrize("gravity", [9810.0, 0.0])
def test_millimetres_tonnes_and_seconds_are_not_warned_of(gravity):
    """The rod of the paper: 1 kg/m = 1e-6 t/mm, 1 N m^2 = 1e6 N mm^2. And a string of a violin."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        create(1800.0, 86650.0, 10, mass=0.03477e-6, gravity=gravity)
        create(330.0, 1.0, 16, mass=0.7e-9, gravity=gravity)


@pytest.mark.parametrize("length, stiffness, mass", [(1.8, 86650.0, 0.03477), (1800.0, 86650.0, 0.03477)])
def test_without_gravity_mixed_units_are_named_all_the_same(length, stiffness, mass):
    with pytest.warns(UserWarning, match="Check the units"):
        create(length, stiffness, 10, mass, gravity=0.0)


REAL = {
    "rod of the paper": (1.8, 0.08665, 0.03477),
    "steel rope, 20 mm": (300.0, 50.0, 1.6),
    "overhead line": (400.0, 1500.0, 1.6),
    "submarine cable": (5000.0, 3000.0, 2.0),
    "rubber band": (0.3, 1e-6, 1e-3),
    "glass fibre": (1.0, 8e-7, 2.7e-5),
    "carbon tube": (1.0, 60.0, 0.05),
    "chain": (2.0, 1e-9, 1.0),
}


@pytest.mark.parametrize("cable", REAL)
def test_real_cables_are_not_warned_of(cable):
    length, stiffness, mass = REAL[cable]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        create(length, stiffness, 20, mass)
