"""Closure: the last node of a closed cable is the first one."""

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..cable.border import CLOSURE, closure_links
from ..cable.cable import Cable
from ..cable.link import Link
from .links import LinkConstraint


def of_cable(cable: Cable) -> LinkConstraint:
    """The closure of `cable`; slopes coincide transverse to the first one of the reference."""
    if not cable.closed:
        return LinkConstraint(CLOSURE, ())
    transverse = np.linalg.svd(cable.reference[0, 1][None, :])[2][1:]
    links = tuple(_with_constant_normal(link, transverse) for link in closure_links(cable))
    return LinkConstraint(CLOSURE, links)


def _with_constant_normal(link: Link, transverse: Array) -> Link:
    return link if link.follows < 0 else replace(link, normal=transverse[link.follows])
