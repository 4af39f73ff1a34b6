"""The scenes to start from are those of the binding."""

from tests.exudyn_binding.conftest import (  # noqa: F401
    add_cable,
    add_pendulum,
    add_sensor,
    centre_of_mass,
    contents,
    coordinates,
    mbs,
    new_mbs,
    solve,
    twin,
    without_smaller_steps,
)
