"""Vibrating ring, section 4.1 of the paper: a free ring, driven by a pair of opposite forces.

The forces are dead loads, +F0 sin(w t) along +x at N1 and the opposite at N2. The paper prints
only their magnitude, Eq. (39); outwards first is what the reference computes. The circle is free
of stress there. On a closed planar ring the natural curvature does not matter: it adds
EI k0 int theta' dx to the energy, and the cable always turns by 2 pi. Native elements, bent from straight,
miss the circle as an equilibrium by their error of discretisation: with 20 elements and Lobatto
quadrature, 2.4e-3 m from the reference instead of 7.6e-4 m; with full quadrature there is no difference.
Nothing holds the ring; the two forces balance. The reference is sampled every 1e-3 s.
"""

import math

from .load import PointForce, Sine
from .scene import Cable, Reference, Scene
from .section import Round
from .shape import Circle

_RING = Circle(radius=0.5)
_FORCE = 10.0  # F0 [N]
_DRIVE = Sine(angular_frequency=10.0 * math.pi)

SCENE = Scene(
    name="vibrating_ring",
    cable=Cable(
        length=_RING.circumference,
        section=Round(radius=5e-3, density=2700.0, youngs_modulus=7.0e9),
        shape=_RING,
    ),
    supports=(),
    gravity=(0.0, 0.0, 0.0),
    end_time=2.0,
    observe={"N1": 0.0, "N2": 0.5},
    reference=Reference(
        file="vibrating_ring_limit.csv",
        axes=("N1_x", "N1_y", "0"),
        uncertainty=5e-5,
        source="MBDyn 1.7.3, estimate of the inextensible, unshearable limit",
    ),
    loads=(
        PointForce(at=0.0, force=(_FORCE, 0.0, 0.0), history=_DRIVE),
        PointForce(at=0.5, force=(-_FORCE, 0.0, 0.0), history=_DRIVE),
    ),
)
