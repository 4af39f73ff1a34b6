"""Masses of compiled bodies that follow the configuration: Exudyn says them at each evaluation."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from .bodies import Body


class ChangingMass(NamedTuple):
    """record: number of the body's one.   body: that Exudyn evaluates.   block: (k, k) its mass there."""

    record: int
    body: Body
    block: Array


def weigh(mbs: Any, masses: Sequence[ChangingMass], memories: Sequence[Any]) -> None:
    """Give records of bodies the masses of mbs's configuration.   memories: records of bodies, to be set."""
    for record, body, block in masses:
        size = len(block)
        block[:] = body.mass(mbs)
        inverse = np.linalg.inv(block)
        for bodies in memories:
            bodies["mass"][record, :size, :size] = block
            bodies["inverse"][record, :size, :size] = inverse
