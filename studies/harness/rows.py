"""From measurements to the rows that are stored."""

import math

from reference_models.trajectory import Trajectory

from .error import Distance, distance_to_reference
from .study import Row
from .timing import OK, Measurement


def make_row(measurement: Measurement, reference: Trajectory) -> Row:
    """One row; times and errors of a failed case are None."""
    case = measurement.case
    error = _error(measurement, reference)
    return {
        "label": case.label,
        "formulation": case.formulation,
        "integrator": case.integrator,
        "elements": case.elements,
        "stepSize": case.step_size,
        "steps": case.steps,
        "cpuSeconds": measurement.median,
        "cpuSecondsMin": measurement.minimum,
        "repeats": len(measurement.cpu_seconds),
        "errorMax": error.maximum if error else None,
        "errorRms": error.rms if error else None,
        "status": measurement.status,
        **case.details,
    }


def _error(measurement: Measurement, reference: Trajectory) -> Distance | None:
    if measurement.status != OK or measurement.trajectory is None:
        return None
    error = distance_to_reference(measurement.trajectory, reference)
    return error if math.isfinite(error.maximum) else None
