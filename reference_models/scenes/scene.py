"""A scene: cable, supports, loads, how it starts, what is observed. Plain data in SI units."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np

from exudyn_inext.checks import require_positive
from exudyn_inext.errors import InputError

from ..trajectory import Array
from .checks import ZERO, Vector, require_fraction
from .load import PointForce
from .section import Round, Section
from .shape import Line, Shape
from .support import Clamp, Hanger, Pin, Support

HANGER_TOLERANCE = 1e-9
"""Gap between anchor and cable over the length of the hanger, minus 1 [-]."""


@dataclass(frozen=True)
class Cable:
    """length [m], section, initial shape, and what is free of stress.

    stress_free: "shape": the initial shape; "straight": the straight cable of that length.
    """

    length: float
    section: Section
    shape: Shape = field(default_factory=Line)
    stress_free: Literal["shape", "straight"] = "shape"

    def __post_init__(self) -> None:
        require_positive("Cable: length", self.length)
        self.shape.require_length(self.length)

    def nodes(self, elements: int) -> tuple[Array, Array]:
        """Positions (n + 1, 3) [m] and unit slopes (n + 1, 3) [-] at the ends of n equal elements.

        The last node of a closed cable is the first one again.
        """
        return self.shape.curve(np.linspace(0.0, 1.0, elements + 1), self.length)


@dataclass(frozen=True)
class Reference:
    """An independent trajectory of the first observed point.

    file: name inside reference_models/data.   source: what computed it.
    axes: the file's columns that are the scene's x, y, z; a leading minus turns the sign, "0" is zero.
    uncertainty: how far the true limit may be from it [m].
    """

    file: str
    axes: tuple[str, str, str]
    uncertainty: float
    source: str


@dataclass(frozen=True)
class Scene:
    """One benchmark.

    gravity [m/s^2]; end_time [s].
    observe: name -> fraction of the arc length; the first one is compared with the reference.
    end_velocity: velocity of the free end [m/s]; the initial field grows linearly from zero.
    loads: act during the motion.
    starts_from_equilibrium: at rest in static equilibrium under gravity, loads(t = 0) and start_loads;
        the cable's shape is then only where the search for it begins. Otherwise: from that shape.
    start_loads: act in that equilibrium only, and are gone at t = 0.
    """

    name: str
    cable: Cable
    supports: tuple[Support, ...]
    gravity: Vector
    end_time: float
    observe: Mapping[str, float]
    reference: Reference | None = None
    end_velocity: Vector = ZERO
    loads: tuple[PointForce, ...] = ()
    start_loads: tuple[PointForce, ...] = ()
    starts_from_equilibrium: bool = False

    def __post_init__(self) -> None:
        require_positive(f"Scene '{self.name}': end_time", self.end_time)
        if not self.observe:
            raise InputError(f"Scene '{self.name}' observes no point; give observe={{'tip': 1.0}}.")
        for point, fraction in self.observe.items():
            require_fraction(f"Scene '{self.name}', observe['{point}']", fraction)
        object.__setattr__(self, "observe", MappingProxyType(dict(self.observe)))
        self._require_consistent_start()

    def _require_consistent_start(self) -> None:
        owner = f"Scene '{self.name}'"
        if self.start_loads and not self.starts_from_equilibrium:
            raise InputError(f"{owner}: start_loads act in an equilibrium; set starts_from_equilibrium=True.")
        if self.end_velocity != ZERO and (self.starts_from_equilibrium or self.cable.shape.closed):
            raise InputError(
                f"{owner}: end_velocity = {self.end_velocity} needs a free end that starts in the given "
                "shape; leave it out."
            )
        for support in self.supports:
            if isinstance(support, Hanger):
                self._require_reach(support)

    def _require_reach(self, hanger: Hanger) -> None:
        positions, _ = self.cable.shape.curve(np.array([hanger.at]), self.cable.length)
        gap = math.dist(positions[0], hanger.anchor)
        if not abs(gap / hanger.length - 1.0) <= HANGER_TOLERANCE:
            raise InputError(
                f"Scene '{self.name}': hanger at {hanger.at!r} is {hanger.length!r} m long, but from its "
                f"anchor to the cable it is {gap!r} m; move the anchor or change the length."
            )

    @property
    def is_planar(self) -> bool:
        """Whether everything happens in the x-y plane."""
        forces = [load.force for load in (*self.loads, *self.start_loads)]
        anchors = [support.anchor for support in self.supports if isinstance(support, Hanger)]
        vectors = (self.gravity, self.end_velocity, *forces, *anchors)
        return self.cable.shape.is_planar and all(vector[2] == 0.0 for vector in vectors)

    @property
    def main_point(self) -> str:
        """Name of the point that is compared with the reference."""
        return next(iter(self.observe))


__all__ = ["ZERO", "Cable", "Clamp", "Line", "Pin", "Reference", "Round", "Scene", "Section", "Vector"]
