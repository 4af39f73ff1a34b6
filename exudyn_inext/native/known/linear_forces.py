"""Stiffness, damping and constant forces of an ObjectGenericODE2 as records."""

from typing import Any

import numpy as np

from ...arrays import Array
from ...items.arguments import described
from ...multibody.linear_forces import LINEAR_FORCE
from ..coordinates import CoordinateMap
from .unknown import UnknownItemError, require_no_functions

OF_MATRICES = {"stiffnessMatrix", "dampingMatrix", "forceVector"}


def read_linear_forces(mbs: Any, number: int, coordinates: CoordinateMap) -> Any:
    """(E,) records of the forces of an object; UnknownItemError if a user function takes part."""
    data = mbs.GetObject(number)
    require_no_functions(data, described(data, number))
    places = coordinates.all_places(mbs.systemData.GetObjectLTGODE2(number))
    if (places < 0).any():
        raise UnknownItemError(f"{described(data, number)}, whose coordinates are held")
    size = len(places)
    stiffness, damping = (_matrix(data[name], size) for name in ("stiffnessMatrix", "dampingMatrix"))
    constant = np.zeros((size, size))
    constant[np.diag_indices(size)] = np.resize(data["forceVector"], size)
    constant += stiffness * coordinates.reference[places]  # Exudyn's coordinates are displacements
    rows, columns = np.nonzero((stiffness != 0.0) | (damping != 0.0) | (constant != 0.0))
    entries = np.zeros(len(rows), LINEAR_FORCE)
    entries["row"], entries["column"] = places[rows], places[columns]
    for field, matrix in (("stiffness", stiffness), ("damping", damping), ("constant", constant)):
        entries[field] = matrix[rows, columns]
    return entries


def _matrix(given: Any, size: int) -> Array:
    matrix: Array = np.asarray(given.Convert2DenseMatrix())
    return matrix if matrix.size else np.zeros((size, size))
