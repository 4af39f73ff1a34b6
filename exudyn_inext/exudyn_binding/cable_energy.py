"""Kinetic and elastic energy of a cable of an mbs, as a sensor."""

from typing import Any

from ..items.cable_data import require_cable
from .cable_forces import add_sensor_of_cable


def CreateCableEnergySensor(mbs: Any, cable: Any, storeInternal: bool = True, fileName: str = "") -> int:
    """Sensor of the kinetic and elastic energy of a cable [J].

    It takes the place of sensors of KineticEnergy and PotentialEnergy of native elements, summed over them.
    As there, the elastic energy is that of bending and stretch, without gravity. The kinetic one is with
    point masses on the cable.

    Args:
        mbs: the system where the sensor is added.
        cable: what CreateInextensibleCable returned, or the number of its object.
        storeInternal, fileName: as in native sensors; an empty name writes no file.

    Returns:
        sensor number; its values are [kinetic energy, elastic energy].

    Raises:
        InputError: not a cable; mbs is unchanged then.
    """
    number, _ = require_cable(mbs, cable)
    return add_sensor_of_cable(
        mbs, number, lambda evaluator, mbs: list(evaluator.energies(mbs)), storeInternal, fileName
    )
