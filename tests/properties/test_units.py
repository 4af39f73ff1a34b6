"""The motion does not depend on the units of length, mass and time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exudyn_inext.integrators import INTEGRATORS
from tests.cables import with_section
from tests.moving import move
from tests.properties.moving_cables import (
    STEPS,
    ZETA,
    H,
    moving_cable,
    numbers,
    same_motion,
    seeds,
    supports_of_cables,
)

units = st.floats(0.01, 100.0)


def rescaled(state, length, mass, time):
    """The same cable and motion: one old metre, kilogram, second is `length`, `mass`, `time` new units."""
    of_coordinates = np.array([length, 1.0])[:, None]
    cable, section = state.cable, state.cable.section
    moment = mass * length**2 / time**2
    cable = replace(
        cable,
        reference=cable.reference * of_coordinates,
        element_lengths=cable.element_lengths * length,
        section=replace(
            section,
            mass_per_length=section.mass_per_length * mass / length,
            bending_stiffness=section.bending_stiffness * moment * length,
            bending_damping=section.bending_damping * moment * length * time,
        ),
    )
    return replace(
        state,
        cable=cable,
        q=state.q * of_coordinates,
        v=state.v * of_coordinates / time,
        external=state.external * moment / of_coordinates,
    )


@pytest.mark.parametrize("name", INTEGRATORS)
@given(seed=seeds, number=numbers, supports=supports_of_cables, length=units, mass=units, time=units)
def test_motion_is_the_same_in_all_units(name, seed, number, supports, length, mass, time):
    """Damping and mass scaling, theta h^2 [s^2], included."""
    state = with_section(moving_cable(seed, number, 2, supports), bending_damping=0.02)
    other = rescaled(state, length, mass, time)
    scaling = 0.3 * H**2
    found = move(other, H * time, STEPS, 10, name, ZETA / time, scaling * time**2)
    found[:, :, :, 0] /= length
    found[:, 1] *= time
    same_motion(found, move(state, H, STEPS, 10, name, ZETA, scaling))
