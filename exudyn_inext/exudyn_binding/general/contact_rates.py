"""How fast a cable vibrates on what it may touch: contact that is open at the start of a run is not felt.

Where an element of a companion touches a circle with all its segments, its contact springs k act on its
mass alone at the worst: w^2 <= lambda_max(M_e^-1 sum k S S^T), and the dashpots likewise.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.linalg import eigh

from ...chain.attached import mass_of_points
from ...chain.cable import Cable
from ...coupling.small_vibrations import FastestRates
from ...element.inertia import mass_matrix
from ...element.shape_functions import shape_functions
from ..cable_run import CableRun

_NORMAL = ("contactStiffness", "contactDamping")
_TANGENTIAL = ("frictionStiffness", "frictionVelocityPenalty")
_CONTACTS = {"ContactFrictionCircleCable2D", "ContactCircleCable2D"}


def contact_rates(mbs: Any, runs: Sequence[CableRun]) -> FastestRates:
    """Bounds of frequency [rad/s] and damping [1/s] over all contacts of cables with circles."""
    elements = {
        frozenset(pair): (run.scene_cable.cable, k)
        for run in runs
        for k, pair in enumerate(pairwise(run.scene_cable.item.node_names))
    }
    squared: dict[Any, float] = {}
    damping: dict[Any, float] = {}
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        if data["objectType"] not in _CONTACTS or not data["activeConnector"]:
            continue
        body = mbs.GetObject(mbs.GetMarker(data["markerNumbers"][1])["bodyNumber"])
        key = frozenset(map(int, body["nodeNumbers"]))
        if key not in elements:
            continue
        share = _per_unit(*elements[key], int(data["numberOfContactSegments"]))
        stiffness, rate = (
            max(data.get(normal, 0.0), data.get(tangential, 0.0))
            for normal, tangential in zip(_NORMAL, _TANGENTIAL, strict=True)
        )
        squared[key] = squared.get(key, 0.0) + share * stiffness
        damping[key] = damping.get(key, 0.0) + share * rate
    return FastestRates(
        float(np.sqrt(max(squared.values(), default=0.0))), max(damping.values(), default=0.0)
    )


def with_contact(rates: FastestRates, contact: FastestRates) -> FastestRates:
    """Bounds of both together."""
    return FastestRates(float(np.hypot(rates.frequency, contact.frequency)), rates.damping + contact.damping)


def _per_unit(cable: Cable, k: int, segments: int) -> float:
    """Largest eigenvalue of M_e^-1 sum S S^T, each segment in touch at its middle [1/kg]."""
    length = float(cable.element_lengths[k])
    shapes = shape_functions((np.arange(segments) + 0.5) / segments, length)
    mass = cable.section.mass_per_length * mass_matrix(length)
    mass = mass + mass_of_points(cable.point_masses, cable.element_lengths)[k]
    return float(eigh(shapes @ shapes.T, mass, eigvals_only=True)[-1])
